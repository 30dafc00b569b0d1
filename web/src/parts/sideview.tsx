/** One occupant from the side, against belt, bag and whatever else holds it. Lengths in metres, forward to the right. */
import { memo } from "preact/compat";
import type { Curves, OccupantShape, RestraintShape } from "../types";
import { digits } from "../units";
import { colour } from "./colours";
import { nearest } from "./plot";

// Where the parts of a seated adult are drawn, from the hip: x forward, y up. A drawing, not the model, which is along x.
const HEAD = { x: -0.16, y: 0.72 }, CHEST = { x: -0.12, y: 0.38 }, PELVIS = { x: 0, y: 0 }, KNEE = { x: 0.46, y: 0.08 };
const FOOT = { x: 0.72, y: -0.36 };
const CHEST_DEEP = 0.13, HEAD_DEEP = 0.11;
const FULL_FORCE = 12e3; // N: the longest arrow

export const SideView = memo(function SideView({ curves, who, time }: { curves: Curves; who: string; time: number }) {
  const occupant = curves.geometry.occupants.find((one) => one.name === who);
  if (!occupant) return null;
  const at = nearest(curves.time, time);
  const value = (channel: string) => {
    const row = curves.channels.indexOf(channel);
    return row < 0 ? 0 : curves.values[row]![at] ?? 0;
  };
  const size = occupant.kind === "child" ? 0.62 : 1;
  const shift = (part: string) => {
    const body = occupant.bodies.find((one) => one.name === part);
    return value(body ? `${body.channel}.excursion` : `${who}.excursion`) / size;
  };
  const moved = { head: shift("head"), chest: shift("chest"), pelvis: shift("pelvis") };
  const seat = occupant.kind === "child" ? value(`${who}.seat.excursion`) / size : 0;
  const paint = colour(2 + curves.geometry.occupants.indexOf(occupant));
  const part = (at: { x: number; y: number }, by: number) => ({ x: at.x + by, y: -at.y });
  const head = part(HEAD, moved.head), chest = part(CHEST, moved.chest), pelvis = part(PELVIS, moved.pelvis);
  const knee = part(KNEE, moved.pelvis), foot = { x: FOOT.x, y: -FOOT.y };
  const forces = occupant.restraints.map((one) => `${one.name.replace(`${who}.`, "")} ${digits(value(`${one.name}.force`) / 1e3, 3)} kN`);

  return (
    <svg class="scene" viewBox="-0.75 -1.05 2.1 1.6" role="img"
      aria-label={`${who} from the side at ${digits(1e3 * time, 3)} ms: moved ${digits(1e3 * value(`${who}.excursion`), 3)} mm in the vehicle; ${forces.join(", ")}.`}>
      <Seat by={seat} child={occupant.kind === "child"} />
      {occupant.restraints.map((one) => <Surface key={one.name} one={one} occupant={occupant} time={time} size={size} />)}
      <g stroke={paint} class="figure">
        <polyline points={`${foot.x},${foot.y} ${knee.x},${knee.y} ${pelvis.x},${pelvis.y} ${chest.x},${chest.y} ${head.x - 0.02},${head.y + 0.1}`} />
        <polyline class="arm" points={`${chest.x + 0.02},${chest.y - 0.1} ${chest.x + 0.24},${chest.y + 0.14} ${chest.x + 0.46},${chest.y + 0.04}`} />
        <circle cx={head.x} cy={head.y} r={HEAD_DEEP} fill={paint} />
        <ellipse cx={chest.x} cy={chest.y} rx={CHEST_DEEP} ry={0.2} fill={paint} />
        <circle cx={pelvis.x} cy={pelvis.y} r={0.13} fill={paint} />
      </g>
      {occupant.restraints.map((one) => (
        <Belt key={one.name} one={one} chest={chest} pelvis={pelvis} seat={seat} force={value(`${one.name}.force`)} />
      ))}
      <Arrows occupant={occupant} parts={{ head, chest, pelvis }} value={value} />
    </svg>
  );
});

type Point = { x: number; y: number };

function Seat({ by, child }: { by: number; child: boolean }) {
  return (
    <g class="seat-side" transform={`translate(${by} 0)`}>
      <path d={child ? "M-0.4,-0.85 L-0.3,0.16 L0.36,0.2 M-0.38,-0.85 q0.1,-0.06 0.16,0.05" : "M-0.42,-0.78 L-0.24,0.16 L0.42,0.2 M-0.44,-1.0 L-0.4,-0.84"} />
    </g>
  );
}

function onWhich(one: RestraintShape, occupant: OccupantShape): "head" | "chest" | "pelvis" {
  if (one.on === "head" || one.on === "pelvis") return one.on;
  if (one.kind === "knee_bolster" && occupant.bodies.length === 0) return "pelvis";
  return "chest";
}

/** What stands in the vehicle and is met: bag, bolster, wheel, dashboard, wall, seat back. */
function Surface({ one, occupant, time, size }: { one: RestraintShape; occupant: OccupantShape; time: number; size: number }) {
  const gap = (one.gap ?? 0) / size;
  if (one.kind === "airbag") {
    const full = Math.min(1, Math.max(0, (time - one.fire_time!) / one.fill_time!));
    const head = onWhich(one, occupant) === "head";
    const radius = (head ? 0.17 : 0.24) * Math.sqrt(full);
    const touch = (head ? HEAD.x + HEAD_DEEP : CHEST.x + CHEST_DEEP) + gap, deepest = (head ? 0.17 : 0.24) * 2;
    const x = touch + deepest - radius, y = -(head ? HEAD.y : CHEST.y);
    return <g class="bag"><path d={`M${touch + deepest},${y} l0.12,0.12`} class="column" /><circle cx={x} cy={y} r={radius} /></g>;
  }
  const at: Record<string, [number, number, number]> = {
    knee_bolster: [KNEE.x + 0.06 + gap, -0.2, 0.26],
    dashboard: [CHEST.x + CHEST_DEEP + gap, -0.5, 0.3],
    wheel: [CHEST.x + CHEST_DEEP + gap, -0.56, 0.36],
    wall: [CHEST.x + CHEST_DEEP + gap, -0.9, 1.1],
  };
  const place = at[one.kind];
  return place ? <rect class="surface" x={place[0]} y={place[1]} width={0.07} height={place[2]} rx={0.02} /> : null;
}

/** A belt over the chest or the lap; thicker as it pulls. */
function Belt({ one, chest, pelvis, seat, force }: { one: RestraintShape; chest: Point; pelvis: Point; seat: number; force: number }) {
  if (one.kind !== "belt" && one.kind !== "lumped") return null;
  if (one.name.endsWith(".seat.restraint")) return null; // the seat's own mounting
  const width = 0.022 + 0.04 * Math.min(1, Math.max(0, force) / FULL_FORCE);
  const taut = force > 0 ? "belt taut" : "belt";
  const lap = one.on === "pelvis";
  const path = lap
    ? `M${-0.2 + seat},0.14 Q${pelvis.x + 0.1},${pelvis.y - 0.1} ${pelvis.x + 0.13},${pelvis.y + 0.03} L${pelvis.x + 0.02},0.16`
    : `M${-0.34 + seat},-0.74 L${chest.x + 0.03},${chest.y - 0.17} Q${chest.x + CHEST_DEEP + 0.03},${chest.y} ${pelvis.x + 0.12},${pelvis.y - 0.08} L${-0.16 + seat},0.14`;
  return <path class={taut} d={path} stroke-width={width} />;
}

/** How hard each restraint pushes or pulls, as an arrow to the rear, or to the front from a seat back. */
function Arrows({ occupant, parts, value }: { occupant: OccupantShape; parts: Record<"head" | "chest" | "pelvis", Point>; value: (c: string) => number }) {
  const used: Record<string, number> = {};
  return (
    <g class="forces">
      {occupant.restraints.map((one) => {
        const force = value(`${one.name}.force`);
        if (Math.abs(force) < 20) return null;
        const which = onWhich(one, occupant), from = parts[which];
        const level = (used[which] = (used[which] ?? -1) + 1);
        const sense = one.kind === "seat_back" ? 1 : -1;
        const length = Math.min(1, Math.abs(force) / FULL_FORCE) * 0.55 + 0.06;
        const y = from.y + 0.09 * level - 0.05, end = from.x + sense * length;
        return (
          <g key={one.name}>
            <line x1={from.x} x2={end} y1={y} y2={y} />
            <polygon points={`${end + sense * 0.05},${y} ${end},${y - 0.03} ${end},${y + 0.03}`} />
          </g>
        );
      })}
    </g>
  );
}
