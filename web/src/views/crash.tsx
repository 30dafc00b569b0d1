/** The crash: turn a knob, and both cars, everyone in them and every curve follow. */
import { useCallback, useEffect, useRef, useState } from "preact/hooks";
import type { ViewProps } from "../app";
import { type Curve, Plot } from "../parts/plot";
import { SideView } from "../parts/sideview";
import { Sliders } from "../parts/sliders";
import { DataTable, EnergyBars, Verdicts } from "../parts/tables";
import { TopView } from "../parts/topview";
import { useCurves, useResults, useScenario } from "../run";
import type { Curves, Entry, Figure } from "../types";
import { digits } from "../units";
import { asked, type Run } from "../url";

export function CrashView({ live, state, change, theme }: ViewProps) {
  const { run, pin, time } = state;
  const [scenario, unreadable] = useScenario(live, run);
  const [curves, refused, ask] = useCurves(live, "crash", run);
  const [pinned] = useCurves(live, "pin", pin);
  const [results, stale] = useResults(live, "results", run);
  const [pinnedResults] = useResults(live, "pinned", pin);
  const latest = useRef(run);
  latest.current = run;

  const set = useCallback((path: string, value: number, at: number) => {
    latest.current = { ...latest.current, values: { ...latest.current.values, [path]: value } };
    ask(latest.current, at); // before anything is drawn: the server works meanwhile
    change({ run: latest.current });
  }, []);
  const reset = useCallback((path: string) => {
    const { [path]: _, ...values } = latest.current.values;
    change({ run: { ...latest.current, values } });
  }, []);
  const move = useCallback((time: number) => change({ time }), []);
  const wrong = unreadable ?? refused;
  const people = curves?.geometry.occupants ?? [];
  const who = people.some((one) => one.name === state.who) ? state.who : people[0]?.name ?? "";

  return (
    <div class="crash">
      <aside class="panel" aria-label="Scenario and its numbers">
        <Picker live={live} run={run} onPick={(run) => change({ run, who: "" })} />
        {scenario && <p class="quiet about">{scenario.description}</p>}
        <label class="check"><input type="checkbox" checked={state.all} onChange={(event) => change({ all: event.currentTarget.checked })} /> every number</label>
        {wrong && <p class="refused" role="alert">{wrong.message}</p>}
        {scenario && <Sliders sliders={scenario.sliders} values={run.values} all={state.all} refused={refused} onChange={set} onReset={reset} />}
      </aside>
      <div class="stage">
        <Actions run={run} pin={pin} onPin={() => change({ pin: pin ? null : run })} onReset={() => change({ run: { ...run, values: {} } })} />
        {curves && <>
          {!curves.completed && <p class="refused" role="alert">Stopped at {digits(1e3 * curves.end, 4)} ms: {curves.status}.</p>}
          <div class="scenes">
            <section class="card" aria-label="From above"><TopView curves={curves} time={time} /></section>
            {who && (
              <section class="card" aria-label="From the side">
                <div class="tabs" role="group" aria-label="Occupant">
                  {people.map((one) => <button key={one.name} type="button" aria-pressed={one.name === who} onClick={() => change({ who: one.name })}>{one.name}</button>)}
                </div>
                <SideView curves={curves} who={who} time={time} />
              </section>
            )}
          </div>
          <TimeSlider curves={curves} time={time} onMove={move} />
          <div class="plots">
            {curves.figures.map((figure) => (
              <Plot key={figure.name} title={figure.title} label={figure.label} unit={figure.unit} scale={figure.scale} time={curves.time}
                curves={linesOf(figure, curves)} pinned={pinnedLines(figure, pinned)} events={curves.events} moment={time}
                onMoment={move} theme={theme} />
            ))}
          </div>
        </>}
        {results && (
          <div class={`results${stale ? " stale" : ""}`} aria-busy={stale}>
            {results.notes.map((note) => <p key={note} class="note">{note}</p>)}
            <div class="two">
              <section class="card"><Verdicts rows={results.verdicts} pinned={pin ? pinnedResults?.verdicts ?? [] : null} /></section>
              <section class="card"><EnergyBars energy={results.energy} pinned={pin ? pinnedResults?.energy : null} /></section>
            </div>
            {results.tables.map((table) => <section class="card" key={table.caption}><DataTable table={table} /></section>)}
            {curves && <section class="card"><Events curves={curves} onMove={move} /></section>}
            <section class="card"><DataTable table={results.sources} /></section>
          </div>
        )}
      </div>
    </div>
  );
}

const cache = new WeakMap<Float32Array[], Map<string, Curve[]>>();

/** The lines of a figure; the same arrays give the same lines, so that nothing is drawn twice. */
function linesOf(figure: Figure, curves: Curves): Curve[] {
  let known = cache.get(curves.values);
  if (!known) cache.set(curves.values, (known = new Map()));
  let found = known.get(figure.name);
  if (!found) known.set(figure.name, (found = figure.lines.map((line) => ({ line, values: curves.values[line.row]! }))));
  return found;
}

const pinnedCache = new WeakMap<Curves, Map<string, { time: Float64Array; curves: Curve[] }>>();

function pinnedLines(figure: Figure, pinned: Curves | null): { time: Float64Array; curves: Curve[] } | null {
  const same = pinned?.figures.find((one) => one.name === figure.name);
  if (!pinned || !same) return null;
  let known = pinnedCache.get(pinned);
  if (!known) pinnedCache.set(pinned, (known = new Map()));
  let found = known.get(figure.name);
  if (!found) known.set(figure.name, (found = { time: pinned.time, curves: linesOf(same, pinned) }));
  return found;
}

function Picker({ live, run, onPick }: { live: ViewProps["live"]; run: Run; onPick: (run: Run) => void }) {
  const [entries, setEntries] = useState<Entry[]>([]);
  useEffect(() => {
    live.ask("catalogue", { kind: "catalogue" }).then(({ header }) => setEntries(header.entries as Entry[]), () => undefined);
  }, []);
  const take = async (file: File | undefined) => {
    if (file) onPick({ toml: await file.slice(0, 200_000).text(), values: {} });
  };
  return (
    <div class="picker" onDragOver={(event) => event.preventDefault()} onDrop={(event) => { event.preventDefault(); void take(event.dataTransfer?.files[0]); }}>
      <label for="scenario">Scenario</label>
      <select id="scenario" value={run.toml === undefined ? run.scenario : " file"} onChange={(event) => onPick({ scenario: event.currentTarget.value, values: {} })}>
        {run.toml !== undefined && <option value=" file">your own file</option>}
        {entries.length === 0 && run.scenario && <option value={run.scenario}>{run.scenario}</option>}
        {entries.map((one) => <option key={one.name} value={one.name}>{one.name} ({one.confidence})</option>)}
      </select>
      <label class="file">
        <input type="file" accept=".toml" onChange={(event) => { void take(event.currentTarget.files?.[0]); event.currentTarget.value = ""; }} />
        <span>Open a scenario file …</span>
      </label>
    </div>
  );
}

const EXPORTS: [string, string][] = [["scenario", "Scenario"], ["csv", "CSV"], ["isomme", "ISO-MME"], ["report", "HTML report"], ["pdf", "PDF report"]];

function Actions({ run, pin, onPin, onReset }: { run: Run; pin: Run | null; onPin: () => void; onReset: () => void }) {
  const [trouble, setTrouble] = useState("");
  const [making, setMaking] = useState("");
  const save = async (kind: string) => {
    setTrouble("");
    setMaking(kind);
    const answer = await fetch(`export/${kind}`, { method: "POST", body: JSON.stringify(asked(run)) }).catch(() => null);
    setMaking("");
    if (!answer?.ok) {
      setTrouble(!answer ? "The server does not answer." : ((await answer.json().catch(() => null)) as { message?: string } | null)?.message ?? answer.statusText);
      return;
    }
    const link = document.createElement("a");
    link.href = URL.createObjectURL(await answer.blob());
    link.download = /filename="(.*?)"/.exec(answer.headers.get("content-disposition") ?? "")?.[1] ?? kind;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  };
  return (
    <div class="actions">
      <button type="button" onClick={onPin} aria-pressed={!!pin}>{pin ? "Unpin" : "Pin this run"}</button>
      <button type="button" onClick={onReset} disabled={!Object.keys(run.values).length}>Reset all</button>
      <span class="spring" />
      <span class="quiet" id="save-as">Save as</span>
      {EXPORTS.map(([kind, name]) => <button key={kind} type="button" aria-describedby="save-as" aria-busy={making === kind} disabled={!!making} onClick={() => void save(kind)}>{name}</button>)}
      {trouble && <p class="refused" role="alert">{trouble}</p>}
    </div>
  );
}

const SLOWER = 20; // times slower than the crash itself

function TimeSlider({ curves, time, onMove }: { curves: Curves; time: number; onMove: (time: number) => void }) {
  const [playing, setPlaying] = useState(false);
  const now = useRef(time);
  now.current = time;
  useEffect(() => {
    if (!playing) return undefined;
    let frame = 0, before = performance.now();
    const step = (at: number) => {
      const next = now.current + (at - before) / 1e3 / SLOWER;
      before = at;
      onMove(next > curves.end ? 0 : next);
      frame = requestAnimationFrame(step);
    };
    frame = requestAnimationFrame(step);
    return () => cancelAnimationFrame(frame);
  }, [playing, curves.end]);
  const shown = Math.min(time, curves.end);
  const before = [...curves.events].reverse().find((event) => event.time < shown - 1e-6);
  const after = curves.events.find((event) => event.time > shown + 1e-6);
  const last = [...curves.events].reverse().find((event) => event.time <= shown + 1e-6);
  return (
    <div class="time">
      <button type="button" onClick={() => setPlaying(!playing)} aria-label={playing ? "Stop" : "Play, twenty times slower"}><Icon path={playing ? "M4 3h3v10H4zM9 3h3v10H9z" : "M4 2.5v11l9-5.5z"} /></button>
      <button type="button" disabled={!before} onClick={() => before && onMove(before.time)} aria-label="To the event before"><Icon path="M3 3h2v10H3zM13 3v10L6 8z" /></button>
      <input type="range" min={0} max={curves.end} step={curves.end / 1000 || "any"} value={shown} aria-label="Time"
        aria-valuetext={`${digits(1e3 * shown, 4)} milliseconds`} onInput={(event) => onMove(Number(Number(event.currentTarget.value).toPrecision(6)))} />
      <button type="button" disabled={!after} onClick={() => after && onMove(after.time)} aria-label="To the next event"><Icon path="M11 3h2v10h-2zM3 3v10l7-5z" /></button>
      <output>{(1e3 * shown).toFixed(1)} ms</output>
      <span class="quiet last-event">{last ? `${last.who}: ${last.what}` : ""}</span>
    </div>
  );
}

function Icon({ path }: { path: string }) {
  return <svg class="icon" viewBox="0 0 16 16" width="14" height="14" aria-hidden="true"><path d={path} /></svg>;
}

function Events({ curves, onMove }: { curves: Curves; onMove: (time: number) => void }) {
  const [open, setOpen] = useState(false);
  return (
    <details onToggle={(event) => setOpen(event.currentTarget.open)}>
      <summary>{curves.events.length} events</summary>
      <ol class="events">
        {open && curves.events.slice(0, 80).map((event, i) => (
          <li key={i}><button type="button" onClick={() => onMove(event.time)}>{(1e3 * event.time).toFixed(2)} ms</button> {event.who}: {event.what}</li>
        ))}
      </ol>
    </details>
  );
}
