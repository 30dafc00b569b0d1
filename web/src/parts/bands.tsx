/** A measured curve, the model's, and the bands around it, against time. */
import { memo } from "preact/compat";
import { useLayoutEffect, useRef } from "preact/hooks";
import uPlot from "uplot";
import { digits } from "../units";
import { colour, dash, variable } from "./colours";
import { Key } from "./plot";

export interface Banded {
  time: Float64Array; // s
  measured: Float32Array; model: Float32Array; low: Float32Array; high: Float32Array; wideLow: Float32Array; wideHigh: Float32Array;
}

interface Props { title: string; label: string; unit: string; scale: number; curves: Banded; theme: string }

const MODEL = 1, MEASURED = 6;
const HEIGHT = 320;
const FONT = "12px system-ui, sans-serif";

export const BandPlot = memo(function BandPlot({ title, label, unit, scale, curves, theme }: Props) {
  const place = useRef<HTMLDivElement>(null);
  useLayoutEffect(() => {
    const { time, measured, model, low, high, wideLow, wideHigh } = curves;
    const shown = [wideHigh, wideLow, high, low, measured, model].map((row) => Float64Array.from(row, (value) => value * scale));
    const made = new uPlot(options(place.current!.clientWidth), [time.map((t) => 1e3 * t), ...shown], place.current!);
    const watch = new ResizeObserver(() => made.setSize({ width: place.current!.clientWidth, height: HEIGHT }));
    watch.observe(place.current!);
    return () => {
      watch.disconnect();
      made.destroy();
    };
  }, [curves, scale, theme]);
  return (
    <figure class="plot">
      <figcaption>{title} <span class="quiet">{label}</span></figcaption>
      <div ref={place} class="plot-area" style={{ height: `${HEIGHT}px` }} role="img" aria-label={said(title, curves, unit, scale)} />
      <ul class="legend">
        <li><Measured /> measured</li>
        <li><Key index={MODEL} /> model</li>
        <li><Shade part={0.4} /> 95 %, of the parameters</li>
        <li><Shade part={0.15} /> with the scatter of the fit</li>
      </ul>
    </figure>
  );
});

function Measured() {
  return <svg class="key" width="22" height="8" aria-hidden="true"><line x1="0" x2="22" y1="4" y2="4" stroke={colour(MEASURED)} stroke-width="2.5" /></svg>;
}

function Shade({ part }: { part: number }) {
  return <svg class="key" width="22" height="10" aria-hidden="true"><rect width="22" height="10" fill={colour(MODEL)} fill-opacity={part} /></svg>;
}

function options(width: number): uPlot.Options {
  const grid = { stroke: variable("--grid"), width: 1 };
  const axis = { stroke: variable("--ink-quiet"), grid, ticks: { ...grid, size: 4 }, font: FONT };
  const edge = { width: 0, points: { show: false } };
  const line = (index: number, dashes: number[]) => ({ stroke: colour(index), width: 2, dash: dashes, points: { show: false } });
  return {
    width: Math.max(width, 120),
    height: HEIGHT,
    legend: { show: false },
    cursor: { show: false },
    scales: { x: { time: false } },
    axes: [{ ...axis, size: 30, values: (_, ticks) => ticks.map((tick) => `${tick}`) }, { ...axis, size: 48 }],
    bands: [{ series: [1, 2], fill: faint(0.15) }, { series: [3, 4], fill: faint(0.4) }],
    series: [{}, edge, edge, edge, edge, line(MEASURED, []), line(MODEL, dash(MODEL))],
  };
}

/** The model's colour, so much of it. */
function faint(part: number): string {
  return colour(MODEL) + Math.round(255 * part).toString(16).padStart(2, "0");
}

function said(title: string, { time, measured, model }: Banded, unit: string, scale: number): string {
  const peak = (row: Float32Array) => {
    let best = 0;
    for (let i = 1; i < row.length; i++) if (Math.abs(row[i]!) > Math.abs(row[best]!)) best = i;
    return `${digits(row[best]! * scale, 3)} ${unit} at ${digits(1e3 * time[best]!, 3)} ms`;
  };
  return `${title}: measured and model against time, with the bands of the model. Peaks: measured ${peak(measured)}; model ${peak(model)}.`;
}
