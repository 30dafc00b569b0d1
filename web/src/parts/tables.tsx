/** Tables: the same as on the command line; verdicts, and where the energy went. */
import { memo } from "preact/compat";
import type { Energy, Table, VerdictRow } from "../types";
import { digits } from "../units";
import { colour } from "./colours";

export const DataTable = memo(function DataTable({ table }: { table: Table }) {
  if (!table.rows.length) return null;
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label={table.caption}>
      <table>
        <caption><span>{table.caption}</span></caption>
        <thead>
          <tr>{table.columns.map((one, i) => <th key={i} scope="col" class={one.numeric ? "number" : ""}>{breaking(one.title)}{one.unit && <span class="quiet"> {one.unit}</span>}</th>)}</tr>
        </thead>
        <tbody>
          {table.rows.map((row, i) => (
            <tr key={i}>
              {row.map((cell, j) => j === 0
                ? <th key={j} scope="row" class={table.columns[j]?.numeric ? "number" : ""}>{cell}</th>
                : <td key={j} class={table.columns[j]?.numeric ? "number" : ""}>{cell}</td>)}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
});

/** Names with dots may go on in the next line behind each. */
function breaking(title: string) {
  return title.split(".").flatMap((part, i) => (i ? [".", <wbr key={i} />, part] : [part]));
}

const MARK = { "passed": "✓", "failed": "✗", "no verdict": "–" };

export const Verdicts = memo(function Verdicts({ rows, pinned }: { rows: VerdictRow[]; pinned?: VerdictRow[] | null }) {
  if (!rows.length) return <p class="quiet">No criteria: nobody in it that a regulation is for.</p>;
  const before = (one: VerdictRow) =>
    pinned?.find((other) => other.regulation === one.regulation && other.subject === one.subject && other.criterion === one.criterion);
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label="Criteria and limits">
      <table class="verdicts">
        <caption><span>Criteria and limits</span></caption>
        <thead>
          <tr>
            <th scope="col">Of</th><th scope="col">Criterion</th><th scope="col">Verdict</th><th scope="col" class="number">Value</th>
            {pinned && <th scope="col" class="number">Pinned</th>}
            <th scope="col" class="number">Limit</th><th scope="col">Unit</th><th scope="col">Regulation</th>
          </tr>
        </thead>
        <tbody>
          {rows.map((one, i) => {
            const other = before(one);
            return (
              <tr key={i}>
                <th scope="row">{one.subject}</th><td>{one.criterion}</td>
                <td><span class={`verdict ${one.verdict.replace(" ", "-")}`} title={one.reason}>{MARK[one.verdict]} {one.verdict}</span></td>
                <td class="number">{digits(one.value, 4)}</td>
                {pinned && <td class="number quiet">{other ? digits(other.value, 4) : "–"}</td>}
                <td class="number">{digits(one.limit, 6)}</td><td>{one.unit}</td>
                <td class="quiet">{one.regulation}</td>
              </tr>
            );
          })}
        </tbody>
      </table>
    </div>
  );
});

/** Bars: each element's part of the kinetic energy at the start. */
export const EnergyBars = memo(function EnergyBars({ energy, pinned }: { energy: Energy; pinned?: Energy | null }) {
  const rows = energyRows(energy);
  const before = pinned ? new Map(energyRows(pinned)) : null;
  const most = Math.max(...rows.map(([, value]) => Math.abs(value)), 1e-9);
  return (
    <section aria-label="Where the energy went">
      <h2 class="small">Where {digits(energy.initial / 1e3, 4)} kJ went</h2>
      <ul class="bars">
        {rows.map(([name, value], i) => (
          <li key={name}>
            <span class="bar-name">{name}</span>
            <span class="bar-track">
              <span class="bar-fill" style={{ width: `${(100 * Math.abs(value)) / most}%`, background: colour(i) }} />
              {before?.has(name) && <span class="bar-pin" style={{ left: `${Math.min(100, (100 * Math.abs(before.get(name)!)) / most)}%` }} title="pinned" />}
            </span>
            <span class="bar-value">{digits(value / 1e3, 3)} kJ <span class="quiet">{energy.initial > 0 ? share(value / energy.initial) : ""}</span></span>
          </li>
        ))}
      </ul>
    </section>
  );
});

function share(part: number): string {
  const percent = 100 * part;
  return Math.abs(percent) < 0.1 ? "< 0.1 %" : `${percent.toFixed(1).replace("-", "−")} %`;
}

function energyRows(energy: Energy): [string, number][] {
  const rows: [string, number][] = energy.elements.map((one) => [one.name, one.absorbed]);
  if (Math.abs(energy.left_out) > 1e-9 * energy.initial) rows.push(["not booked on any body", energy.left_out]);
  rows.push(["still moving at the end", energy.final]);
  return rows;
}
