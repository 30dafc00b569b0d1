/** Design studies: started here, watched, cancelled, taken up again, and downloaded. One runs at a time. */
import { useCallback, useEffect, useState } from "preact/hooks";
import type { ViewProps } from "../app";
import { RequestRefused } from "../socket";
import { digits, shownUnit } from "../units";

interface Running {
  name: string; rows: number; done: number; before: number; failed: number; cancelled: boolean; ended: boolean; trouble: string; seconds: number;
}

interface Kept {
  name: string; rows: number | null; done: number; complete: boolean; why: string;
  outcomes: Record<string, { unit: string; min: number | null; mean: number | null; max: number | null }>;
  failed: { status: string; why: string; rows: number }[];
}

interface Standing { possible: boolean; running: Running | null; studies: Kept[] }

const EVERY = 500; // ms between two looks at a study that runs

const EXAMPLE = `kind = "sweep"
name = "belts"
scenario = "p1"
outcomes = ["adult.excursion.max", "adult.acceleration.peak"]

[[parameters]]
path = "adult.restraint.stiffness"
grid = { start = "40 kN/m", stop = "120 kN/m", count = 81 }

[[parameters]]
path = "adult.restraint.slack"
grid = { start = "0 mm", stop = "50 mm", count = 51 }
`;

export function StudyView({ live }: ViewProps) {
  const [standing, setStanding] = useState<Standing | null>(null);
  const [text, setText] = useState(EXAMPLE);
  const [trouble, setTrouble] = useState("");
  const ask = useCallback(async (action: string, more: Record<string, unknown> = {}) => {
    try {
      const { header } = await live.ask("study", { kind: "study", action, ...more });
      setStanding(header as unknown as Standing);
      if (action !== "list") setTrouble("");
    } catch (error) {
      setTrouble(error instanceof RequestRefused ? error.refused.message : String(error));
    }
  }, []);
  const going = !!standing?.running && !standing.running.ended;
  useEffect(() => void ask("list"), []);
  useEffect(() => {
    if (!going) return undefined;
    const timer = setInterval(() => void ask("list"), EVERY);
    return () => clearInterval(timer);
  }, [going]);

  if (!standing) return <p class="waiting" role="status">{trouble || "Looking for studies …"}</p>;
  return (
    <div class="stage">
      {!standing.possible && <p class="note">Studies need a folder to be kept in. Start the server with <code>ridedown serve --studies DIR</code>.</p>}
      <section class="card study-new">
        <h2>A new study</h2>
        <label class="field"><span>Study file, as for <code>ridedown study</code></span>
          <textarea rows={15} spellcheck={false} value={text} onInput={(event) => setText(event.currentTarget.value)} />
        </label>
        <button type="button" disabled={!standing.possible || going} onClick={() => void ask("start", { toml: text })}>Start</button>
        {trouble && <p class="refused" role="alert">{trouble}</p>}
      </section>
      {standing.running && <Progress running={standing.running} onCancel={() => void ask("cancel")} />}
      {standing.studies.map((one) => (
        <StudyCard key={one.name} study={one} busy={going} runs={going && standing.running!.name === one.name} onResume={() => void ask("resume", { study: one.name })} />
      ))}
    </div>
  );
}

function Progress({ running, onCancel }: { running: Running; onCancel: () => void }) {
  const done = running.before + running.done;
  const rate = running.done / Math.max(running.seconds, 0.1);
  const state = running.trouble || (running.ended ? (running.cancelled ? "cancelled; what is done is kept" : "done")
    : running.cancelled ? "stopping" : rate > 0 ? `${digits(rate, 3)} rows a second, ${digits((running.rows - done) / rate, 2)} s left` : "starting");
  return (
    <section class="card" aria-label="The study that runs">
      <h3>{running.name}</h3>
      <progress max={running.rows} value={done} aria-label={`${running.name}: rows done`} />
      <p role="status">{done.toLocaleString("en")} of {running.rows.toLocaleString("en")} rows; {state}{running.failed ? `; ${running.failed} failed` : ""}</p>
      <button type="button" disabled={running.ended || running.cancelled} onClick={onCancel}>Cancel</button>
    </section>
  );
}

function StudyCard({ study, busy, runs, onResume }: { study: Kept; busy: boolean; runs: boolean; onResume: () => void }) {
  const outcomes = Object.entries(study.outcomes);
  const cell = (value: number | null, unit: string) => (value === null ? "–" : digits(value * shownUnit(unit).scale));
  return (
    <section class="card">
      <h3>{study.name} <span class="quiet">{study.rows === null ? "" : `${study.done.toLocaleString("en")} of ${study.rows.toLocaleString("en")} rows`}</span></h3>
      {study.why && !runs && <p class="quiet">{study.why}</p>}
      <div class="actions">
        {!study.complete && <button type="button" disabled={busy} onClick={onResume}>Resume</button>}
        {study.done > 0 && <a class="button" href={`study/${study.name}/results.parquet`} download>Download Parquet</a>}
        {study.done > 0 && <a class="button" href={`study/${study.name}/report.html`} download>Report</a>}
      </div>
      {study.failed.map((one) => <p key={one.why} class="refused">{one.rows} rows: {one.status}; {one.why}</p>)}
      {outcomes.length > 0 && (
        <div class="scroll" tabIndex={0} role="region" aria-label={`Outcomes of ${study.name}`}>
          <table>
            <thead><tr><th scope="col">Outcome</th><th scope="col">Unit</th><th scope="col" class="number">Least</th><th scope="col" class="number">Mean</th><th scope="col" class="number">Largest</th></tr></thead>
            <tbody>
              {outcomes.map(([name, of]) => (
                <tr key={name}><th scope="row">{name}</th><td>{shownUnit(of.unit).unit}</td>
                  <td class="number">{cell(of.min, of.unit)}</td><td class="number">{cell(of.mean, of.unit)}</td><td class="number">{cell(of.max, of.unit)}</td></tr>
              ))}
            </tbody>
          </table>
        </div>
      )}
    </section>
  );
}
