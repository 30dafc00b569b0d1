/** Both vehicles from above: the bar that turns between them, the members that crush. Lengths in metres, forward to the right. */
import { memo } from "preact/compat";
import type { Curves } from "../types";
import { digits } from "../units";
import { colour } from "./colours";
import { nearest } from "./plot";

const FRONT = 1.0, CABIN = 3.2, BUMPER = 0.09; // m: how a car is drawn, not how it is computed

export const TopView = memo(function TopView({ curves, time }: { curves: Curves; time: number }) {
  const at = nearest(curves.time, time);
  const value = (channel: string) => {
    const row = curves.channels.indexOf(channel);
    return row < 0 ? 0 : curves.values[row]![at] ?? 0;
  };
  const { geometry } = curves;
  if (geometry.kind === "network") return <NetworkView curves={curves} value={value} />;

  const [l1, l2, l3, l4] = geometry.arms ?? [0.55, 0.55, 0.55, 0.55];
  const width = geometry.width ?? 1.8;
  const two = geometry.kind === "crash";
  const bar = two ? value("bar.displacement") : 0;
  const tangent = two ? Math.tan(value("bar.rotation")) : 0;
  const barAt = (y: number) => bar - y * tangent; // eqs 7-8
  const half = Math.max(l1, l2, l3, l4) + 0.25;
  const top = Math.max(half, Math.abs(l1 - l2) / 2 + width / 2) + 0.25;
  const reach = two ? [-FRONT - CABIN - 0.4, FRONT + CABIN + 0.4] : [-FRONT - CABIN - 0.4, geometry.kind === "sled" ? 3.2 : 1.2];
  const degrees = (value("bar.rotation") * 180) / Math.PI;

  return (
    <svg class="scene" viewBox={`${reach[0]} ${-top} ${reach[1]! - reach[0]!} ${2 * top}`} role="img"
      aria-label={`From above at ${digits(1e3 * time, 3)} ms: vehicle 1 has moved ${digits(1e3 * value("vehicle1.displacement"), 3)} mm`
        + (two ? `, vehicle 2 ${digits(1e3 * value("vehicle2.displacement"), 3)} mm; the bar has turned ${digits(degrees, 2)} degrees.` : ".")}>
      <Ground from={reach[0]!} to={reach[1]!} y={top - 0.02} />
      {geometry.kind === "wall" && <Wall top={top} />}
      <Car name="vehicle1" direction={1} front={value("vehicle1.displacement") - FRONT} middle={(l1 - l2) / 2} width={width}
        index={0} occupants={curves} value={value} />
      {geometry.kind !== "sled" && <>
        <MemberShape from={value("vehicle1.displacement") - FRONT} to={barAt(-l2)} y={-l2} index={0} crush={value("vehicle1.right.deflection")} />
        <MemberShape from={value("vehicle1.displacement") - FRONT} to={barAt(l1)} y={l1} index={0} crush={value("vehicle1.left.deflection")} />
      </>}
      {two && <>
        <Car name="vehicle2" direction={-1} front={FRONT - value("vehicle2.displacement")} middle={(l3 - l4) / 2} width={width}
          index={1} occupants={curves} value={value} />
        <MemberShape from={FRONT - value("vehicle2.displacement")} to={barAt(l3)} y={l3} index={1} crush={value("vehicle2.right.deflection")} />
        <MemberShape from={FRONT - value("vehicle2.displacement")} to={barAt(-l4)} y={-l4} index={1} crush={value("vehicle2.left.deflection")} />
        <line class="bar" x1={barAt(half)} y1={-half} x2={barAt(-half)} y2={half} stroke-width={BUMPER} />
      </>}
    </svg>
  );
});

function Ground({ from, to, y }: { from: number; to: number; y: number }) {
  const ticks = Array.from({ length: Math.floor(to) - Math.ceil(from) + 1 }, (_, i) => Math.ceil(from) + i);
  return <g class="ground">{ticks.map((x) => <line key={x} x1={x} x2={x} y1={y - 0.12} y2={y} />)}</g>;
}

function Wall({ top }: { top: number }) {
  return <g class="wall"><rect x={0} y={-top} width={0.5} height={2 * top} /></g>;
}

interface CarProps {
  name: string; direction: 1 | -1; front: number; middle: number; width: number; index: number;
  occupants: Curves; value: (channel: string) => number;
}

/** A car: its cabin, which does not crush, and who sits in it. y up is to the left of vehicle 1. */
function Car({ name, direction, front, middle, width, index, occupants, value }: CarProps) {
  const number = Number(name.at(-1));
  const seated = occupants.geometry.occupants.filter((one) => one.vehicle === number);
  const rear = front - direction * CABIN;
  const y = -middle - width / 2;
  const paint = colour(index);
  return (
    <g>
      <rect class="cabin" x={Math.min(front, rear)} y={y} width={CABIN} height={width} rx={0.28} stroke={paint} fill={paint} />
      <rect class="glass" x={Math.min(front - direction * 0.35, front - direction * 0.75)} y={y + 0.16} width={0.4} height={width - 0.32} rx={0.1} />
      {seated.map((one, i) => {
        const forward = value(one.bodies.length ? `${one.name}.excursion` : `${one.name}.excursion`);
        const row = one.kind === "child" ? 2.05 : 1.25 + (i > 1 ? 0.8 : 0);
        const side = (i % 2 === 0 ? -1 : 1) * direction * 0.22 * width;
        const x = front - direction * (row - forward);
        return (
          <g key={one.name}>
            <rect class="seat" x={front - direction * (row + 0.05) - 0.22} y={-middle + side - 0.24} width={0.44} height={0.48} rx={0.08} />
            <circle class="person" cx={x} cy={-middle + side} r={one.kind === "child" ? 0.14 : 0.19} fill={colour(2 + occupants.geometry.occupants.indexOf(one))} />
          </g>
        );
      })}
      <text class="scene-label" x={(front + rear) / 2 - direction * 0.9} y={-middle} text-anchor="middle" dominant-baseline="central">{number}</text>
    </g>
  );
}

/** A member between cabin and bar, folding as it gets shorter. */
function MemberShape({ from, to, y, index, crush }: { from: number; to: number; y: number; index: number; crush: number }) {
  const folds = 8, length = Math.abs(to - from);
  const deep = Math.min(0.14, 0.03 + 0.22 * Math.max(0, crush));
  const points = Array.from({ length: folds + 1 }, (_, i) => {
    const x = from + ((to - from) * i) / folds;
    const off = i === 0 || i === folds ? 0 : (i % 2 ? 1 : -1) * deep;
    return `${x},${-y + off}`;
  });
  return <polyline class="member" points={points.join(" ")} stroke={colour(index)} stroke-opacity={length > 0 ? 1 : 0.5} />;
}

/** Masses of a network on a line, towards the wall. */
function NetworkView({ curves, value }: { curves: Curves; value: (channel: string) => number }) {
  const masses = curves.geometry.masses as { name: string; mass: number }[];
  const gap = 0.9;
  const x = (i: number) => -0.6 - i * gap + Math.max(-0.6, Math.min(0.75, value(`${masses[i]!.name}.displacement`)));
  const place = (name: string) => (name === "wall" ? 0 : x(masses.findIndex((one) => one.name === name)));
  const elements = curves.geometry.elements ?? [];
  const high = 0.5 + 0.16 * elements.length;
  return (
    <svg class="scene" viewBox={`${-0.9 - masses.length * gap} ${-0.6} ${1.9 + masses.length * gap} ${high + 0.7}`} role="img"
      aria-label={`Masses: ${masses.map((one) => `${one.name} has moved ${digits(1e3 * value(`${one.name}.displacement`), 3)} mm`).join(", ")}.`}>
      <g class="wall"><rect x={0} y={-0.6} width={0.3} height={high + 0.7} /></g>
      {elements.map((one, i) => (
        <line key={one.name} class="tie" x1={place(one.between[0]!)} x2={place(one.between[1]!)} y1={0.42 + 0.16 * i} y2={0.42 + 0.16 * i} />
      ))}
      {masses.map((one, i) => (
        <g key={one.name}>
          <rect class="cabin" x={x(i) - 0.24} y={-0.3} width={0.48} height={0.56} rx={0.06} fill={colour(i)} stroke={colour(i)} />
          <line class="drop" x1={x(i)} x2={x(i)} y1={0.26} y2={high} />
          <text class="scene-label small" x={x(i)} y={0} text-anchor="middle" dominant-baseline="central">{one.name}</text>
        </g>
      ))}
    </svg>
  );
}
