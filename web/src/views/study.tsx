/** Design studies: started here, watched, cancelled, taken up again, looked at, and downloaded. One runs at a time. */
import { useCallback, useEffect, useState } from "preact/hooks";
import type { ViewProps } from "../app";
import { Drawing, type Drawn } from "../parts/drawing";
import { DataTable } from "../parts/tables";
import { type Live, RequestRefused } from "../socket";
import type { Table } from "../types";
import { digits, shownUnit } from "../units";
import { asked, type Run } from "../url";

interface Running {
  name: string; rows: number; done: number; before: number; failed: number; cancelled: boolean; ended: boolean; trouble: string; seconds: number;
}

interface Kept {
  name: string; kind: string; rows: number | null; done: number; complete: boolean; began: number; why: string;
  outcomes: Record<string, { unit: string; min: number | null; mean: number | null; max: number | null }>;
  failed: { status: string; why: string; rows: number }[];
}

interface Standing { possible: boolean; kinds: Record<string, string>; running: Running | null; studies: Kept[] }

interface Shown { status: string; notes: string[]; sections: { title: string; tables: Table[]; plots: Drawn[] }[] }

const EVERY = 500; // ms between two looks at a study that runs

export function StudyView({ live, state, change, theme }: ViewProps) {
  const [standing, setStanding] = useState<Standing | null>(null);
  const [trouble, setTrouble] = useState("");
  const ask = useCallback(async (action: string, more: Record<string, unknown> = {}): Promise<Standing | null> => {
    try {
      const header = (await live.ask("study", { kind: "study", action, ...more })).header as Standing;
      setStanding(header);
      if (action !== "list") setTrouble("");
      return header;
    } catch (error) {
      setTrouble(error instanceof RequestRefused ? error.refused.message : String(error));
      return null;
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
  const studies = [...standing.studies].sort((a, b) => b.began - a.began);
  const chosen = studies.find((one) => one.name === state.study);
  const choose = (study: string) => { setTrouble(""); change({ study }); };
  const start = async (text: string) => {
    const now = await ask("start", { toml: text });
    if (now?.running) change({ study: now.running.name });
  };
  return (
    <div class="study">
      <aside class="panel" aria-label="Studies">
        <button type="button" class="new" aria-pressed={!chosen} onClick={() => choose("")}>New study</button>
        {studies.length > 0 && <ul class="kept">
          {studies.map((one) => (
            <li key={one.name}>
              <button type="button" aria-pressed={one === chosen} onClick={() => choose(one.name)}>
                <b>{one.name}</b> <span>{one.kind}</span> <span>{stateOf(one, standing.running)}</span>
              </button>
            </li>
          ))}
        </ul>}
      </aside>
      <div class="stage">
        {state.study && !chosen && <p class="refused" role="alert">{`There is no study ${state.study} in the folder of this server.`}</p>}
        {chosen
          ? <Study key={chosen.name} live={live} study={chosen} running={standing.running} theme={theme} trouble={trouble}
              onCancel={() => void ask("cancel")} onResume={() => void ask("resume", { study: chosen.name })} />
          : <NewStudy live={live} run={state.run} kind={state.kind} kinds={standing.kinds} possible={standing.possible} busy={going} trouble={trouble}
              onKind={(kind) => change({ kind })} onStart={(text) => void start(text)} />}
      </div>
    </div>
  );
}

function stateOf(study: Kept, running: Running | null): string {
  if (running?.name === study.name && !running.ended) return share(running.before + running.done, running.rows);
  return study.complete ? "done" : study.done ? "stopped" : "not begun";
}

function standOf({ done, rows, complete }: Kept): string {
  const of = complete || rows === null ? "" : ` of ${rows.toLocaleString("en")}`;
  return `${done.toLocaleString("en")}${of} rows; ${complete ? "done" : "stopped, what is done is kept"}`;
}

function share(done: number, rows: number): string {
  return `${Math.floor((100 * done) / Math.max(rows, 1))} %`;
}

interface NewProps {
  live: Live; run: Run; kind: string; kinds: Record<string, string>; possible: boolean; busy: boolean; trouble: string;
  onKind: (kind: string) => void; onStart: (text: string) => void;
}

/** A file of the kind chosen, for the crash of the other views; it may be changed before it is started. */
function NewStudy({ live, run, kind, kinds, possible, busy, trouble, onKind, onStart }: NewProps) {
  const [made, setMade] = useState("");
  const [edited, setEdited] = useState<string | null>(null);
  const [unmade, setUnmade] = useState("");
  const text = edited ?? made;
  useEffect(() => {
    let current = true;
    live.ask("study-file", { ...asked(run), kind: "study-file", study: kind }).then(
      ({ header }) => {
        if (!current) return;
        setMade(header.toml as string);
        setUnmade("");
      },
      (error) => {
        if (!current) return;
        setMade("");
        setUnmade(error instanceof RequestRefused ? error.refused.message : String(error));
      },
    );
    return () => { current = false; };
  }, [kind, run]);
  const choose = (one: string) => {
    setEdited(null);
    onKind(one);
  };
  return (
    <section class="card study-new">
      <h2>A new study</h2>
      {!possible && <p class="note">Studies need a folder to be kept in. Start the server with <code>ridedown serve --studies DIR</code>.</p>}
      <fieldset class="kinds">
        <legend>What it answers, of <b>{run.toml === undefined ? run.scenario : "your own file"}</b>{Object.keys(run.values).length > 0 && " as the Crash view has it"}</legend>
        {Object.entries(kinds).map(([one, answers]) => (
          <label key={one} class={one === kind ? "chosen" : ""}>
            <input type="radio" name="kind" checked={one === kind} onChange={() => choose(one)} />
            <span><b>{one}</b> <span class="quiet">{answers}</span></span>
          </label>
        ))}
      </fieldset>
      {unmade && <p class="refused" role="alert">{unmade}</p>}
      <label class="field"><span>Study file, as for <code>ridedown study</code></span>
        <textarea rows={18} spellcheck={false} value={text} onInput={(event) => setEdited(event.currentTarget.value)} />
      </label>
      <div class="actions">
        <button type="button" class="main" disabled={!possible || busy || !text.trim()} onClick={() => onStart(text)}>Start</button>
        <button type="button" disabled={edited === null} onClick={() => setEdited(null)}>As it was</button>
        {busy && <span class="quiet">Another study runs: it has to end first.</span>}
      </div>
      {trouble && <p class="refused" role="alert">{trouble}</p>}
    </section>
  );
}

interface StudyProps {
  live: Live; study: Kept; running: Running | null; theme: string; trouble: string; onCancel: () => void; onResume: () => void;
}

function Study({ live, study, running, theme, trouble, onCancel, onResume }: StudyProps) {
  const mine = running?.name === study.name ? running : null;
  const runs = !!mine && !mine.ended;
  const busy = !!running && !running.ended;
  const [shown, why] = useFigures(live, study, runs);
  const file = (name: string) => `study/${study.name}/${name}`;
  return (
    <>
      <section class="card study-head">
        <h2>{study.name} <span class="quiet">{study.kind}</span></h2>
        {mine && (runs || mine.cancelled || mine.trouble) && <Progress running={mine} />}
        {!runs && !mine?.cancelled && !mine?.trouble && <p class="quiet" role="status">{standOf(study)}</p>}
        {study.why && !runs && <p class="quiet">{study.why}</p>}
        <div class="actions">
          {runs && <button type="button" disabled={mine!.cancelled} onClick={onCancel}>Cancel</button>}
          {!runs && !study.complete && <button type="button" class="main" disabled={busy} onClick={onResume}>Resume</button>}
          {study.done > 0 && <a class="button" href={file("results.parquet")} download>Download Parquet</a>}
          {shown && <a class="button" href={file("report.html")} download>HTML report</a>}
          {shown && <a class="button" href={file("report.pdf")} download>PDF report</a>}
        </div>
        {trouble && <p class="refused" role="alert">{trouble}</p>}
        {study.failed.map((one) => <p key={one.why} class="refused">{one.rows.toLocaleString("en")} rows {one.status}: {one.why}</p>)}
      </section>
      {shown?.notes.map((note) => <p key={note} class="note">{note}</p>)}
      {shown?.sections.map((section) => (
        <section key={section.title} class="study-part" aria-label={section.title}>
          <h3>{section.title}</h3>
          {section.plots.length > 0 && <div class="drawings">{section.plots.map((one) => <Drawing key={one.name} drawn={one} theme={theme} />)}</div>}
          {section.tables.map((table) => <section class="card" key={table.caption}><DataTable table={table} /></section>)}
        </section>
      ))}
      {!shown && study.done > 0 && <p class="quiet" role="status">{why || (runs ? "Figures come when it has ended." : "Drawing the figures …")}</p>}
      {!shown && <Outcomes study={study} />}
    </>
  );
}

/** What the report of a study has on it, drawn once it has ended. */
function useFigures(live: Live, study: Kept, runs: boolean): [Shown | null, string] {
  const [shown, setShown] = useState<Shown | null>(null);
  const [why, setWhy] = useState("");
  useEffect(() => {
    setShown(null);
    setWhy("");
    if (runs || !study.done) return undefined;
    let current = true;
    live.ask("figures", { kind: "figures", study: study.name }).then(
      ({ header }) => { if (current) setShown(header as Shown); },
      (error) => { if (current) setWhy(error instanceof RequestRefused ? error.refused.message : String(error)); },
    );
    return () => { current = false; };
  }, [study.name, study.done, study.complete, runs]);
  return [shown, why];
}

function Progress({ running }: { running: Running }) {
  const done = running.before + running.done;
  const rate = running.done / Math.max(running.seconds, 0.1);
  const left = Math.max(0, running.rows - done);
  const state = running.trouble || (running.ended ? (running.cancelled ? "cancelled; what is done is kept" : "done")
    : running.cancelled ? "stopping" : !left && running.rows ? "adding up" : rate > 0 ? `${digits(rate, 3)} rows a second, ${digits(left / rate, 2)} s left at most` : "starting");
  return (
    <div aria-label="The study that runs" role="group">
      <progress max={running.rows || 1} value={done} aria-label={`${running.name}: rows done`} />
      <p role="status" class={running.trouble ? "refused" : ""}>{done.toLocaleString("en")} of {running.rows.toLocaleString("en")} rows; {state}{running.failed ? `; ${running.failed.toLocaleString("en")} failed` : ""}</p>
    </div>
  );
}

function Outcomes({ study }: { study: Kept }) {
  const outcomes = Object.entries(study.outcomes);
  if (!outcomes.length) return null;
  const cell = (value: number | null, unit: string) => (value === null ? "–" : digits(value * shownUnit(unit).scale));
  const columns = [["Outcome", false], ["Unit", false], ["Least", true], ["Mean", true], ["Largest", true]] as const;
  const table: Table = {
    caption: "Outcomes so far",
    columns: columns.map(([title, numeric]) => ({ title, unit: "", numeric })),
    rows: outcomes.map(([name, of]) => [name, shownUnit(of.unit).unit, cell(of.min, of.unit), cell(of.mean, of.unit), cell(of.max, of.unit)]),
  };
  return <section class="card"><DataTable table={table} /></section>;
}
