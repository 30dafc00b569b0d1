/** The founding paper, live: its figures 6 to 19, its numbers beside ours, and what it says of them. */
import { useEffect, useState } from "preact/hooks";
import type { ViewProps } from "../app";
import { Plot } from "../parts/plot";
import { DataTable } from "../parts/tables";
import { rows } from "../socket";
import type { Figure, Table } from "../types";

interface Paper { figures: Figure[]; tables: Table[]; time: Float64Array; values: Float32Array[] }

export function PaperView({ live, state, change, theme }: ViewProps) {
  const [paper, setPaper] = useState<Paper | null>(null);
  useEffect(() => {
    live.ask("paper", { kind: "paper" }).then((answer) => setPaper({
      ...(answer.header as Paper), time: answer.arrays.time as Float64Array, values: rows(answer, "values"),
    }), () => undefined);
  }, []);
  const [lines] = useState(() => new Map<string, { line: Figure["lines"][number]; values: Float32Array }[]>());
  if (!paper) return <p class="waiting" role="status">Simulating the paper’s crashes …</p>;
  const linesOf = (figure: Figure) => {
    if (!lines.has(figure.name)) lines.set(figure.name, figure.lines.map((line) => ({ line, values: paper.values[line.row]! })));
    return lines.get(figure.name)!;
  };
  const open = (scenario: string) => change({ view: "crash", run: { scenario, values: {} }, who: "" });
  return (
    <div class="stage">
      <p class="note">The vehicle is a reconstruction: the paper does not print its data.</p>
      {paper.tables.slice(0, 1).map((table) => <section class="card" key={table.caption}><DataTable table={table} /></section>)}
      <div class="plots">
        {paper.figures.map((figure) => (
          <div key={figure.name} class="card opening">
            <Plot title={figure.title} label={figure.label} unit="" scale={1} time={paper.time} curves={linesOf(figure)}
              moment={state.time} onMoment={(time) => change({ time })} theme={theme} />
            <p class="open">Open in Crash: {figure.lines.map((line) => (
              <button key={line.scenario} type="button" class="link" onClick={() => open(line.scenario!)}>{line.label}</button>
            ))}</p>
          </div>
        ))}
      </div>
      {paper.tables.slice(1).map((table) => <section class="card" key={table.caption}><DataTable table={table} /></section>)}
    </div>
  );
}
