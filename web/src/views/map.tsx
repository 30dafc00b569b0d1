/** The map: ten thousand crashes over two parameters, as colours and contours, with the limit and the point where we are. */
import { useCallback, useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { ViewProps } from "../app";
import { type BoundOf, BoundPanel, useBoundHere, useBoundMap } from "../parts/bound";
import { isDark, variable } from "../parts/colours";
import { contours, joined, niceSteps } from "../parts/contours";
import { RequestRefused } from "../socket";
import { useScenario } from "../run";
import type { BoundMap, CrashMap, OutcomeInfo, SliderInfo } from "../types";
import { digits, show, shownUnit, typed } from "../units";
import { asked } from "../url";

const LEFT = 70, BOTTOM = 48, TOP = 12, RIGHT = 14;

export function MapView({ live, state, change, theme }: ViewProps) {
  const { run } = state;
  const [scenario, unreadable] = useScenario(live, run);
  const [map, setMap] = useState<CrashMap | null>(null);
  const [trouble, setTrouble] = useState("");
  const choice = useMemo(() => (scenario ? chosen(scenario.sliders, scenario.outcomes, state.map) : null), [scenario, state.map]);
  const others = choice ? JSON.stringify({ ...run.values, [choice.x.path]: 0, [choice.y.path]: 0 }) : "";

  useEffect(() => {
    if (!choice) return;
    const { x, y, outcome } = choice;
    const began = performance.now();
    live.ask("map", { ...asked(run), kind: "map", x: x.path, y: y.path, outcome: outcome.name }).then(
      (answer) => {
        setMap({
          ...(answer.header as CrashMap), xs: answer.arrays.x as Float64Array, ys: answer.arrays.y as Float64Array,
          values: answer.arrays.outcome as Float32Array,
        });
        setTrouble("");
        requestAnimationFrame(() => performance.measure("ridedown:map", { start: began, end: performance.now() }));
      },
      (error) => setTrouble(error instanceof RequestRefused ? error.refused.message : String(error)),
    );
  }, [choice?.x.path, choice?.y.path, choice?.outcome.name, run.scenario, run.toml, others]);

  const { bound: on, room } = state.map;
  const of: BoundOf | null = on && choice ? { run, x: choice.x.path, y: choice.y.path, outcome: choice.outcome, room, others } : null;
  const [bound, bounding] = useBoundMap(live, of);
  const [boundHere, noBound] = useBoundHere(live, of);

  const go = useCallback((x: number, y: number) => {
    if (choice) change({ run: { ...run, values: { ...run.values, [choice.x.path]: x, [choice.y.path]: y } } });
  }, [choice, run]);

  if (unreadable) return <p class="refused" role="alert">{unreadable.message}</p>;
  if (!scenario || !choice) return <p class="waiting" role="status">Reading the scenario …</p>;
  const { x, y, outcome } = choice;
  const limit = state.map.limit ?? outcome.limit;
  const at = { x: run.values[x.path] ?? x.value, y: run.values[y.path] ?? y.value };
  const set = (part: Partial<typeof state.map>) => change({ map: { ...state.map, x: x.path, y: y.path, outcome: outcome.name, ...part } });
  return (
    <div class="map-view">
      <aside class="panel" aria-label="What the map shows">
        <p><b>{scenario.name || "your own file"}</b></p>
        <Choice label="Across" value={x.path} options={scenario.sliders.filter((one) => one.path !== y.path)} onChoose={(path) => set({ x: path })} />
        <Choice label="Up" value={y.path} options={scenario.sliders.filter((one) => one.path !== x.path)} onChoose={(path) => set({ y: path })} />
        <label class="field">Outcome
          <select value={outcome.name} onChange={(event) => set({ outcome: event.currentTarget.value, limit: null })}>
            {scenario.outcomes.map((one) => <option key={one.name} value={one.name}>{one.label}</option>)}
          </select>
        </label>
        <Limit outcome={outcome} limit={limit} onChange={(limit) => set({ limit })} />
        <Point info={x} value={at.x} onChange={(value) => go(value, at.y)} />
        <Point info={y} value={at.y} onChange={(value) => go(at.x, value)} />
        {map && map.outcome.name === outcome.name && <p role="status">Here: <b>{show(boundHere?.outcome ?? valueAt(map, at.x, at.y), outcome.unit)}</b>{limit !== null && ` (limit ${show(limit, outcome.unit)})`}</p>}
        <BoundPanel outcome={outcome} on={on} room={room} here={boundHere} trouble={noBound} busy={bounding}
          onSwitch={(on) => set({ bound: on })} onRoom={(room) => set({ room })} />
        <p><button type="button" onClick={() => change({ view: "crash" })}>See this crash</button></p>
        {trouble && <p class="refused" role="alert">{trouble}</p>}
      </aside>
      <div class="stage">
        {map && <Drawing map={map} x={x} y={y} at={at} limit={limit} bound={bound} theme={theme} onGo={go} />}
        {map && <p class="quiet">{map.crashes.toLocaleString("en")} crashes{map.failed ? `, ${map.failed} of them not solved to their end` : ""}{map.refused ? `; ${map.refused.toLocaleString("en")} left out: ${map.why}` : ""}. Click to go there, or use the arrow keys.</p>}
      </div>
    </div>
  );
}

interface Chosen { x: SliderInfo; y: SliderInfo; outcome: OutcomeInfo }

/** What the address says, else what is usual: an occupant's stiffness and slack, and its acceleration. */
function chosen(sliders: SliderInfo[], outcomes: OutcomeInfo[], map: { x: string; y: string; outcome: string }): Chosen | null {
  const named = (path: string) => sliders.find((one) => one.path === path);
  const like = (pattern: RegExp, but?: SliderInfo) => sliders.find((one) => pattern.test(one.path) && one !== but);
  const x = named(map.x) ?? like(/restraint\.stiffness$|belt\.stiffness$/) ?? like(/stiffness$/) ?? sliders[0];
  const y = named(map.y) ?? like(/restraint\.slack$|belt\.slack$/, x) ?? like(/speed$|mass$/, x) ?? sliders.find((one) => one !== x);
  const outcome = outcomes.find((one) => one.name === map.outcome) ?? outcomes[0];
  return x && y && outcome ? { x, y, outcome } : null;
}

function Choice({ label, value, options, onChoose }: { label: string; value: string; options: SliderInfo[]; onChoose: (path: string) => void }) {
  return (
    <label class="field">{label}
      <select value={value} onChange={(event) => onChoose(event.currentTarget.value)}>
        {options.map((one) => <option key={one.path} value={one.path}>{one.group}, {one.label}</option>)}
      </select>
    </label>
  );
}

function Limit({ outcome, limit, onChange }: { outcome: OutcomeInfo; limit: number | null; onChange: (limit: number | null) => void }) {
  const { unit, scale } = shownUnit(outcome.unit);
  return (
    <label class="field">Limit, {unit || "a number"}
      <input key={outcome.name} type="text" inputMode="decimal" value={limit === null ? "" : digits(limit * scale)}
        onChange={(event) => onChange(event.currentTarget.value.trim() ? typed(event.currentTarget.value, outcome.unit, "") : null)} />
    </label>
  );
}

function Point({ info, value, onChange }: { info: SliderInfo; value: number; onChange: (value: number) => void }) {
  return (
    <label class="field">{info.group}, {info.label}: <b>{show(value, info.unit, info.path)}</b>
      <input type="range" min={Math.min(info.low, value)} max={Math.max(info.high, value)} step={(info.high - info.low) / 200} value={value}
        aria-valuetext={show(value, info.unit, info.path)} onInput={(event) => onChange(Number(Number(event.currentTarget.value).toPrecision(6)))} />
    </label>
  );
}

/** Between the crashes of the map, straight from one to the next. */
function valueAt(map: CrashMap, x: number, y: number): number {
  const nx = map.xs.length, ny = map.ys.length;
  const u = Math.max(0, Math.min(nx - 1.000001, ((x - map.xs[0]!) / (map.xs[nx - 1]! - map.xs[0]!)) * (nx - 1)));
  const v = Math.max(0, Math.min(ny - 1.000001, ((y - map.ys[0]!) / (map.ys[ny - 1]! - map.ys[0]!)) * (ny - 1)));
  const i = Math.floor(u), j = Math.floor(v), a = u - i, b = v - j;
  const z = (i: number, j: number) => map.values[j * nx + i]!;
  return (1 - b) * ((1 - a) * z(i, j) + a * z(i + 1, j)) + b * ((1 - a) * z(i, j + 1) + a * z(i + 1, j + 1));
}

interface DrawingProps {
  map: CrashMap; x: SliderInfo; y: SliderInfo; at: { x: number; y: number }; limit: number | null; bound: BoundMap | null; theme: string;
  onGo: (x: number, y: number) => void;
}

function Drawing({ map, x, y, at, limit, bound, theme, onGo }: DrawingProps) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [width, setWidth] = useState(700);
  const height = Math.round(Math.max(300, Math.min(620, 0.68 * width)));
  useEffect(() => {
    const watch = new ResizeObserver(([entry]) => setWidth(Math.floor(entry!.contentRect.width)));
    watch.observe(canvas.current!.parentElement!);
    return () => watch.disconnect();
  }, []);
  const inner = { width: width - LEFT - RIGHT, height: height - TOP - BOTTOM };
  const low = { x: map.xs[0]!, y: map.ys[0]! }, high = { x: map.xs[map.xs.length - 1]!, y: map.ys[map.ys.length - 1]! };
  const px = (value: number) => LEFT + ((value - low.x) / (high.x - low.x)) * inner.width;
  const py = (value: number) => TOP + (1 - (value - low.y) / (high.y - low.y)) * inner.height;

  const shownBound = bound && bound.least.length === map.values.length && bound.body === map.outcome.bound ? bound : null;
  useEffect(() => draw(canvas.current!, map, limit, shownBound, width, height), [map, limit, shownBound, width, height, theme]);

  const toValues = (left: number, top: number) => onGo(
    clamp(low.x + ((left - LEFT) / inner.width) * (high.x - low.x), low.x, high.x),
    clamp(low.y + (1 - (top - TOP) / inner.height) * (high.y - low.y), low.y, high.y),
  );
  const step = (event: KeyboardEvent) => {
    const [dx, dy] = ({ ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] } as Record<string, [number, number]>)[event.key] ?? [0, 0];
    if (!dx && !dy) return;
    event.preventDefault();
    onGo(clamp(at.x + (dx * (high.x - low.x)) / 50, low.x, high.x), clamp(at.y + (dy * (high.y - low.y)) / 50, low.y, high.y));
  };
  const sx = shownUnit(x.unit, x.path), sy = shownUnit(y.unit, y.path);
  const words = `Map of ${map.outcome.label}: here ${show(valueAt(map, at.x, at.y), map.outcome.unit)}, with ${x.group} ${x.label} ${show(at.x, x.unit, x.path)} and ${y.group} ${y.label} ${show(at.y, y.unit, y.path)}.`;
  return (
    <figure class="map">
      <figcaption>{map.outcome.label}, {shownUnit(map.outcome.unit).unit}</figcaption>
      <div class="map-area" style={{ height: `${height}px` }}>
        <canvas ref={canvas} tabIndex={0} role="application" aria-label={`${words} Arrow keys move.`} onKeyDown={step}
          onPointerDown={(event) => { const box = event.currentTarget.getBoundingClientRect(); toValues(event.clientX - box.left, event.clientY - box.top); }} />
        <svg class="map-over" width={width} height={height} aria-hidden="true">
          {niceSteps(low.x * sx.scale, high.x * sx.scale, 7).map((tick) => (
            <g key={`x${tick}`}><line x1={px(tick / sx.scale)} x2={px(tick / sx.scale)} y1={height - BOTTOM} y2={height - BOTTOM + 5} />
              <text x={px(tick / sx.scale)} y={height - BOTTOM + 19} text-anchor="middle">{digits(tick)}</text></g>
          ))}
          {niceSteps(low.y * sy.scale, high.y * sy.scale, 6).map((tick) => (
            <g key={`y${tick}`}><line x1={LEFT - 5} x2={LEFT} y1={py(tick / sy.scale)} y2={py(tick / sy.scale)} />
              <text x={LEFT - 9} y={py(tick / sy.scale)} text-anchor="end" dominant-baseline="central">{digits(tick)}</text></g>
          ))}
          <text class="axis" x={LEFT + inner.width / 2} y={height - 8} text-anchor="middle">{x.group}, {x.label}{sx.unit && `, ${sx.unit}`}</text>
          <text class="axis" transform={`translate(15 ${TOP + inner.height / 2}) rotate(-90)`} text-anchor="middle">{y.group}, {y.label}{sy.unit && `, ${sy.unit}`}</text>
          <g class="here"><circle cx={px(at.x)} cy={py(at.y)} r={8} /><circle cx={px(at.x)} cy={py(at.y)} r={2.5} class="dot" /></g>
        </svg>
      </div>
      <ColourBar map={map} />
      <ul class="legend">
        {limit !== null && <li><Line className="limit" /> limit {show(limit, map.outcome.unit)}; {extremes(map.values)[1] > limit ? "hatched: beyond it" : "no crash here is beyond it"}</li>}
        {shownBound && <li><Line className="bound" /> times the least that any restraint could give{shownBound.room === null ? " within the excursion that each crash has" : ` within ${show(shownBound.room, "m")}`}</li>}
        {shownBound && shownBound.room !== null && <li><Line className="room" /> excursion of {show(shownBound.room, "m")}; hatched the other way: more than is allowed</li>}
      </ul>
    </figure>
  );
}

function Line({ className }: { className: string }) {
  return <svg class={`key ${className}`} width="26" height="10" aria-hidden="true"><line x1="1" x2="25" y1="5" y2="5" /></svg>;
}

function clamp(value: number, low: number, high: number): number {
  return Number(Math.max(low, Math.min(high, value)).toPrecision(6));
}

// Cividis (Nuñez, Anderton, Renslow 2018), in steps: reads the same with any colour vision, and gets steadily lighter.
const CIVIDIS = [[0, 32, 77], [19, 53, 107], [63, 75, 108], [98, 98, 111], [124, 123, 120], [156, 148, 119], [190, 175, 109], [224, 204, 90], [254, 233, 69]];

function shade(part: number): [number, number, number] {
  const place = Math.max(0, Math.min(0.999999, part)) * (CIVIDIS.length - 1), i = Math.floor(place), f = place - i;
  const [a, b] = [CIVIDIS[i]!, CIVIDIS[i + 1]!];
  return [0, 1, 2].map((k) => Math.round(a[k]! + f * (b[k]! - a[k]!))) as [number, number, number];
}

function extremes(values: Float32Array): [number, number] {
  let low = Infinity, high = -Infinity;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? [low, high === low ? low + (Math.abs(low) || 1) : high] : [0, 1];
}

function draw(canvas: HTMLCanvasElement, map: CrashMap, limit: number | null, bound: BoundMap | null, width: number, height: number): void {
  const ratio = devicePixelRatio || 1, nx = map.xs.length, ny = map.ys.length;
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
  const pen = canvas.getContext("2d")!;
  pen.scale(ratio, ratio);
  const inner = { width: width - LEFT - RIGHT, height: height - TOP - BOTTOM };
  const [low, high] = extremes(map.values);
  const image = new ImageData(nx, ny);
  for (let j = 0; j < ny; j++) {
    for (let i = 0; i < nx; i++) {
      const value = map.values[j * nx + i]!, place = 4 * ((ny - 1 - j) * nx + i);
      if (Number.isNaN(value)) continue;
      image.data.set([...shade((value - low) / (high - low)), 255], place);
    }
  }
  const small = new OffscreenCanvas(nx, ny);
  small.getContext("2d")!.putImageData(image, 0, 0);
  pen.imageSmoothingEnabled = true;
  pen.drawImage(small, 0.5, 0.5, nx - 1, ny - 1, LEFT, TOP, inner.width, inner.height);

  const toX = (i: number) => LEFT + (i / (nx - 1)) * inner.width, toY = (j: number) => TOP + (1 - j / (ny - 1)) * inner.height;
  const { scale } = shownUnit(map.outcome.unit);
  pen.font = "12px system-ui, sans-serif";
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  for (const level of niceSteps(low * scale, high * scale, 9)) {
    const lines = contours(map.values, nx, ny, level / scale);
    trace(pen, lines, toX, toY, "rgba(255,255,255,.75)", 1);
    label(pen, lines, toX, toY, digits(level), inner);
  }
  if (bound) drawBound(pen, map, bound, toX, toY, inner);
  if (limit !== null) {
    hatch(pen, map.values, nx, ny, limit, toX, toY);
    const lines = contours(map.values, nx, ny, limit);
    trace(pen, lines, toX, toY, isDark() ? "#000" : "#fff", 6);
    trace(pen, lines, toX, toY, variable("--limit"), 3);
  }
}

const MOST_TIMES = 12; // the least; beyond it the lines only crowd

/** How many times the least possible: dashed lines; and, where a room is given, the edge of it. */
function drawBound(pen: CanvasRenderingContext2D, map: CrashMap, bound: BoundMap, toX: Place, toY: Place, inner: Size): void {
  const nx = map.xs.length, ny = map.ys.length;
  const times = map.values.map((value, i) => (bound.least[i]! > 0 ? value / bound.least[i]! : NaN));
  const [low, high] = extremes(times);
  for (const level of niceSteps(low, Math.min(high, MOST_TIMES), 5)) {
    const lines = contours(times, nx, ny, level);
    dashed(pen, lines, toX, toY, "#000", 3.5, []);
    dashed(pen, lines, toX, toY, "#7df9ff", 2, [7, 5]);
    label(pen, lines, toX, toY, `${digits(level, 3)}×`, inner, { ground: "#7df9ff", ink: "#000", at: 0.72 });
  }
  if (bound.room === null) return;
  hatch(pen, bound.excursion, nx, ny, bound.room, toX, toY, true);
  const edge = contours(bound.excursion, nx, ny, bound.room);
  dashed(pen, edge, toX, toY, "#000", 5, []);
  dashed(pen, edge, toX, toY, "#fff", 2.5, [2, 4]);
}

function dashed(pen: CanvasRenderingContext2D, pieces: Lines, toX: Place, toY: Place, paint: string, wide: number, dashes: number[]): void {
  pen.save();
  pen.strokeStyle = paint;
  pen.lineWidth = wide;
  pen.lineJoin = "round";
  pen.setLineDash(dashes);
  for (const line of joined(pieces)) {
    pen.beginPath();
    line.forEach(([x, y], i) => (i ? pen.lineTo(toX(x), toY(y)) : pen.moveTo(toX(x), toY(y))));
    pen.stroke();
  }
  pen.restore();
}

interface Size { width: number; height: number }

type Lines = [number, number, number, number][];
type Place = (index: number) => number;

function trace(pen: CanvasRenderingContext2D, lines: Lines, toX: Place, toY: Place, paint: string, wide: number): void {
  pen.strokeStyle = paint;
  pen.lineWidth = wide;
  pen.lineCap = "round";
  pen.beginPath();
  for (const [x1, y1, x2, y2] of lines) {
    pen.moveTo(toX(x1), toY(y1));
    pen.lineTo(toX(x2), toY(y2));
  }
  pen.stroke();
}

/** One label to a level, where its line is nearest the middle, or so far across and up. */
function label(pen: CanvasRenderingContext2D, lines: Lines, toX: Place, toY: Place, text: string, inner: Size,
  { ground = "rgba(0,0,0,.55)", ink = "#fff", at = 0.5 } = {}): void {
  let best: [number, number] | null = null, nearest = Infinity;
  for (const [i, j] of lines) {
    const x = toX(i), y = toY(j);
    const inside = x > LEFT + 22 && x < LEFT + inner.width - 22 && y > TOP + 12 && y < TOP + inner.height - 12;
    const away = Math.hypot(x - LEFT - at * inner.width, y - TOP - (1 - at) * inner.height);
    if (inside && away < nearest) [best, nearest] = [[x, y], away];
  }
  if (!best) return;
  const wide = pen.measureText(text).width + 8;
  pen.fillStyle = ground;
  pen.fillRect(best[0] - wide / 2, best[1] - 8, wide, 16);
  pen.fillStyle = ink;
  pen.fillText(text, ...best);
}

/** Strokes where the limit is exceeded: it reads without colour. */
function hatch(pen: CanvasRenderingContext2D, values: Float32Array, nx: number, ny: number, limit: number, toX: Place, toY: Place, back = false): void {
  pen.strokeStyle = "rgba(255,255,255,.5)";
  pen.lineWidth = 1;
  pen.beginPath();
  for (let j = 0; j < ny - 1; j += 2) {
    for (let i = (j / 2) % 2 ? 1 : 0; i < nx - 1; i += 2) {
      if (!(values[j * nx + i]! > limit)) continue;
      pen.moveTo(toX(i), toY(back ? j + 1 : j));
      pen.lineTo(toX(i + 1), toY(back ? j : j + 1));
    }
  }
  pen.stroke();
}

function ColourBar({ map }: { map: CrashMap }) {
  const [low, high] = extremes(map.values);
  const { unit, scale } = shownUnit(map.outcome.unit);
  const parts = Array.from({ length: 32 }, (_, i) => i / 31);
  return (
    <div class="colour-bar">
      <span>{digits(low * scale, 3)} {unit}</span>
      <svg viewBox="0 0 32 1" preserveAspectRatio="none" aria-hidden="true">{parts.map((part, i) => <rect key={i} x={i} width={1.05} height={1} fill={`rgb(${shade(part).join(",")})`} />)}</svg>
      <span>{digits(high * scale, 3)} {unit}</span>
    </div>
  );
}
