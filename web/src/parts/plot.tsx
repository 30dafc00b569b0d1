/** One figure against time: curves, numbered events, the moment chosen, and a pinned run behind it. */
import { memo } from "preact/compat";
import { useEffect, useLayoutEffect, useMemo, useReducer, useRef } from "preact/hooks";
import uPlot from "uplot";
import type { CrashEvent, Line } from "../types";
import { digits } from "../units";
import { colour, dash, variable } from "./colours";
import { fewestPoints } from "./path";

export interface Curve { line: Line; values: Float32Array }

interface Props {
  title: string;
  label: string;
  unit: string;
  scale: number;
  time: Float64Array; // s
  curves: Curve[];
  pinned?: { time: Float64Array; curves: Curve[] } | null;
  events?: CrashEvent[];
  moment?: number; // s
  onMoment?: (time: number) => void;
  theme: string;
  height?: number;
}

const AXIS_FONT = "12px system-ui, sans-serif";

const REST = 120; // ms without a change, after which what is out of sight is drawn too

/** The props to draw by: those given, but out of sight those of before, until nothing has changed for a moment. */
function useInSight(given: Props, place: { current: HTMLElement | null }): Props {
  const drawn = useRef(given), due = useRef<Props | null>(null), seen = useRef(true);
  const [, again] = useReducer((count: number) => count + 1, 0);
  const latest = useRef(given);
  latest.current = given;
  if (seen.current || due.current === given) drawn.current = given;
  const behind = drawn.current !== given;
  useLayoutEffect(() => {
    const sight = new IntersectionObserver(([entry]) => {
      seen.current = entry!.isIntersecting;
      if (seen.current && drawn.current !== latest.current) again(0);
    });
    sight.observe(place.current!);
    return () => sight.disconnect();
  }, []);
  useEffect(() => {
    if (!behind) return undefined;
    const later = setTimeout(() => {
      due.current = given;
      again(0);
    }, REST);
    return () => clearTimeout(later);
  }, [given, behind]);
  return drawn.current;
}

export const Plot = memo(function Plot(given: Props) {
  const place = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const props = useInSight(given, place);
  const latest = useRef(props);
  latest.current = props;

  const { time, curves, pinned, scale, theme, height = 190 } = props;
  const labels = curves.map((one) => one.line.label).join("\n") + (pinned ? "\n\npinned" + pinned.curves.length : "");
  const data = useMemo(() => dataOf(time, curves, pinned, scale), [time, curves, pinned, scale]);

  useLayoutEffect(() => {
    const made = new uPlot(optionsOf(latest, place.current!.clientWidth, height), data, place.current!);
    plot.current = made;
    const watch = new ResizeObserver(() => made.setSize({ width: place.current!.clientWidth, height }));
    watch.observe(place.current!);
    return () => {
      watch.disconnect();
      made.destroy();
      plot.current = null;
    };
  }, [labels, theme, height]);

  useLayoutEffect(() => {
    if (plot.current && plot.current.data !== data) plot.current.setData(data);
  }, [data]);

  useEffect(() => moveLine(plot.current, props.moment), [props.moment, data, labels, theme]);

  const at = props.moment === undefined ? null : nearest(time, props.moment);
  return (
    <figure class="plot">
      <figcaption>{props.title} <span class="quiet">{beside(props.title, props.label)}</span></figcaption>
      <div ref={place} class="plot-area" style={{ height: `${height}px` }} role="img" aria-label={said(props)} />
      <ul class="legend">
        {curves.map(({ line, values }) => (
          <li key={line.label}>
            <Key index={line.colour} /> {line.label}
            {at !== null && <b>{digits(values[at]! * scale, 3)}{props.unit && ` ${line.unit ?? props.unit}`}</b>}
          </li>
        ))}
      </ul>
    </figure>
  );
});

/** What an axis says beyond the title: of "Velocity" and "velocity, m/s" the unit. */
function beside(title: string, label: string): string {
  const same = `${title.toLowerCase()}, `;
  return label.toLowerCase().startsWith(same) ? label.slice(same.length) : label;
}

/** A short piece of a line, as it is drawn. */
export function Key({ index }: { index: number }) {
  return (
    <svg class="key" width="22" height="8" aria-hidden="true">
      <line x1="0" x2="22" y1="4" y2="4" stroke={colour(index)} stroke-width="2.5" stroke-dasharray={dash(index).join(" ")} />
    </svg>
  );
}

type Pinned = Props["pinned"];

const inMs = new WeakMap<Float64Array, Float64Array>();

/** Times in ms; the figures of one crash share them. */
function milliseconds(time: Float64Array): Float64Array {
  let found = inMs.get(time);
  if (!found) inMs.set(time, (found = time.map((t) => 1e3 * t)));
  return found;
}

/** In the figure's unit. What is missing is NaN, which is not drawn. */
function dataOf(time: Float64Array, curves: Curve[], pinned: Pinned, scale: number): uPlot.AlignedData {
  const places = pinned ? placesIn(pinned.time, time) : null;
  const behind = (pinned?.curves ?? []).map(({ values }) => {
    const made = new Float64Array(time.length);
    for (let i = 0; i < made.length; i++) made[i] = places![i]! < 0 ? NaN : values[places![i]!]! * scale;
    return made;
  });
  const scaled = curves.map(({ values }) => {
    const made = new Float64Array(values.length);
    for (let i = 0; i < values.length; i++) made[i] = values[i]! * scale;
    return made;
  });
  return [milliseconds(time), ...scaled, ...behind];
}

const known = new WeakMap<Float64Array, { of: Float64Array; places: Int32Array }>();

/** For each of the times, the place of the last one of `of` that is not after it; −1 beyond its end. The figures of one crash share them. */
function placesIn(of: Float64Array, times: Float64Array): Int32Array {
  const found = known.get(times);
  if (found?.of === of) return found.places;
  const last = of[of.length - 1]!, places = new Int32Array(times.length);
  for (let i = 0, at = 0; i < times.length; i++) {
    while (at + 1 < of.length && of[at + 1]! <= times[i]! + SAME) at++;
    places[i] = times[i]! <= last ? at : -1;
  }
  known.set(times, { of, places });
  return places;
}

const SAME = 1e-9; // s: times no further apart are one

/** Index of the last time that is not after t: at an event, the value just after it. */
export function nearest(time: Float64Array, t: number): number {
  let low = 0, high = time.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (time[middle]! <= t + SAME) low = middle;
    else high = middle - 1;
  }
  return low;
}

function optionsOf(latest: { current: Props }, width: number, height: number): uPlot.Options {
  const { curves, pinned } = latest.current;
  const ink = variable("--ink-quiet"), grid = { stroke: variable("--grid"), width: 1 };
  const axis = { stroke: ink, grid, ticks: { ...grid, size: 4 }, font: AXIS_FONT };
  return {
    width: Math.max(width, 120),
    height,
    legend: { show: false },
    cursor: { drag: { x: false, y: false }, points: { show: false }, x: false, y: false },
    scales: { x: { time: false }, y: { range: rangeOf } },
    axes: [{ ...axis, size: 30, values: (_, ticks) => ticks.map((tick) => `${tick}`) }, { ...axis, size: 48 }],
    series: [
      {},
      ...curves.map(({ line }) => ({ stroke: colour(line.colour), width: 2, dash: dash(line.colour), points: { show: false }, paths: fewestPoints })),
      ...(pinned?.curves ?? []).map(({ line }) => ({
        stroke: colour(line.colour), width: 1.25, alpha: 0.45, dash: [3, 3], points: { show: false }, paths: fewestPoints,
      })),
    ],
    hooks: {
      init: [(made) => listen(made, latest)],
      draw: [(made) => drawEvents(made, latest.current)],
      setSize: [(made) => moveLine(made, latest.current.moment)],
    },
  };
}

/** Room above and below, and zero always in sight. */
function rangeOf(_: uPlot, low: number | null, high: number | null): [number, number] {
  const from = Math.min(low ?? 0, 0), to = Math.max(high ?? 0, 0);
  const room = 0.06 * (to - from || 1);
  return [from < 0 ? from - room : from, to > 0 ? to + room : to];
}

/** The line of the moment moves without anything being drawn again. */
function listen(made: uPlot, latest: { current: Props }): void {
  const line = document.createElement("div");
  line.className = "moment";
  made.over.appendChild(line);
  const choose = (event: PointerEvent) => {
    if (!(event.buttons & 1) || !latest.current.onMoment) return;
    const left = event.clientX - made.over.getBoundingClientRect().left;
    latest.current.onMoment(Math.max(0, made.posToVal(left, "x")) / 1e3);
  };
  made.over.addEventListener("pointerdown", choose);
  made.over.addEventListener("pointermove", choose);
}

function moveLine(made: uPlot | null, moment: number | undefined): void {
  const line = made?.over.querySelector<HTMLElement>(".moment");
  if (!made || !line) return;
  line.hidden = moment === undefined;
  if (moment !== undefined) line.style.transform = `translateX(${made.valToPos(1e3 * moment, "x")}px)`;
}

function drawEvents(made: uPlot, { events }: Props): void {
  if (!events?.length) return;
  const { ctx, bbox } = made;
  ctx.save();
  ctx.strokeStyle = variable("--event");
  ctx.lineWidth = devicePixelRatio;
  const high = 7 * devicePixelRatio;
  ctx.beginPath();
  for (const event of events) {
    const x = made.valToPos(1e3 * event.time, "x", true);
    if (x < bbox.left || x > bbox.left + bbox.width) continue;
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + high);
  }
  ctx.stroke();
  ctx.restore();
}

/** The figure in words: what a screen reader says of it. */
function said({ title, label, unit, scale, time, curves }: Props): string {
  const peaks = curves.map(({ line, values }) => {
    let best = 0;
    for (let i = 1; i < values.length; i++) if (Math.abs(values[i]!) > Math.abs(values[best]!)) best = i;
    return `${line.label} ${digits((values[best] ?? 0) * scale, 3)} ${line.unit ?? unit} at ${digits(1e3 * (time[best] ?? 0), 3)} ms`;
  });
  return `${title}, ${label}, against time. Peaks: ${peaks.join("; ")}.`;
}
