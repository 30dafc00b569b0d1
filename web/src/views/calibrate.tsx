/** A restraint fitted to a channel of the test: what is fitted, how it goes, and what comes out. The library does the fitting. */
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Change } from "../app";
import { type Banded, BandPlot } from "../parts/bands";
import { NumberField } from "../parts/number";
import { DataTable } from "../parts/tables";
import { type Answer, type Live, RequestRefused, rows } from "../socket";
import type { FitStanding, FreeNumber, Suggestion, TestInfo } from "../types";
import { digits, shownUnit } from "../units";
import type { FitAsked } from "../url";

const EVERY = 300; // ms between two looks at a fit that runs

interface Props { live: Live; info: TestInfo; asked: FitAsked; onAsk: (asked: FitAsked) => void; change: Change; theme: string }

interface Told { standing: FitStanding; curves: Banded | null }

export function Calibrate({ live, info, asked, onAsk, change, theme }: Props) {
  const [suggestion, setSuggestion] = useState<Suggestion | null>(null);
  const [told, setTold] = useState<Told | null>(null);
  const [trouble, setTrouble] = useState("");
  const [starting, setStarting] = useState(false);
  const [begun, setBegun] = useState(0); // a fit begun anew keeps its key
  const stopping = useRef(false);
  const latest = useRef({ asked, onAsk });
  latest.current = { asked, onAsk };
  const say = (error: unknown) => setTrouble(error instanceof RequestRefused ? error.refused.message : String(error));

  useEffect(() => {
    live.ask("fit", { kind: "fit", action: "suggest", test: info.test }).then(({ header }) => setSuggestion(header as unknown as Suggestion), say);
  }, [info.test]);

  useEffect(() => { // one request after the other: in a lane the newest wins, and a cancelling must not be lost
    if (!asked.key) {
      setTold(null);
      return undefined;
    }
    let current = true;
    const follow = async () => {
      while (current) {
        const action = stopping.current ? "cancel" : "look";
        stopping.current = false;
        const found = toldBy(await live.ask("fit", { kind: "fit", action, fit: asked.key }));
        if (!current) return;
        setTold(found);
        if (found.standing.ended) return;
        await new Promise((done) => setTimeout(done, EVERY));
      }
    };
    follow().catch((error) => { if (current) { say(error); setTold(null); } });
    return () => { current = false; };
  }, [asked.key, begun]);

  if (!suggestion) return <p class="waiting" role="status">{trouble || "Looking for what can be fitted …"}</p>;
  if (!suggestion.channels.length) return <p class="note">No acceleration of an occupant can be read in this test: there is nothing to fit to.</p>;
  const form = completed(asked, suggestion, info);
  const running = starting || (!!asked.key && !!told && !told.standing.ended);
  const start = async () => {
    setTrouble("");
    setStarting(true);
    stopping.current = false;
    const { template, channel, pulse, mass, end, effort } = form;
    const message = { test: info.test, channel: channel.key, pulse, template: template.name, mass, end, effort, ...numbersOf(form, asked) };
    try {
      const { header } = await live.ask("fit", { kind: "fit", action: "start", ...message });
      latest.current.onAsk({ ...latest.current.asked, key: (header as unknown as FitStanding).fit });
      setBegun((count) => count + 1);
    } catch (error) {
      say(error);
    } finally {
      setStarting(false);
    }
  };
  const choose = (chosen: FitAsked) => onAsk({ ...chosen, key: "" }); // what is shown below is always of what is chosen here
  const failed = told?.standing.trouble ?? "";
  return (
    <section class="card calibrate" aria-label="Calibrate against this test">
      <h2>Calibrate against it</h2>
      <p class="quiet">An occupant rides on the pulse of this test. The numbers of the restraint are sought that bring the model’s acceleration closest to the measured one.</p>
      <fieldset class="bare" disabled={running}>
        <legend class="unseen">What is fitted</legend>
        <Choices form={form} suggestion={suggestion} info={info} asked={asked} onAsk={choose} />
        <Numbers form={form} asked={asked} onAsk={choose} />
      </fieldset>
      <div class="actions">
        <button type="button" disabled={running} onClick={() => void start()}>Calibrate</button>
        <button type="button" disabled={!running || starting} onClick={() => { stopping.current = true; }}>Cancel, keep the best so far</button>
      </div>
      {(trouble || failed) && <p class="refused" role="alert">{trouble || failed}</p>}
      {starting && <p role="status" class="quiet">making the sled of the test …</p>}
      {told && !failed && !starting && <Progress standing={told.standing} />}
      {told?.standing.result && told.curves && !starting && <Result standing={told.standing} curves={told.curves} change={change} theme={theme} />}
    </section>
  );
}

function toldBy(answer: Answer): Told {
  const standing = answer.header as unknown as FitStanding;
  if (!standing.result) return { standing, curves: null };
  const [measured, model, low, high, wideLow, wideHigh] = rows(answer, "values") as [Float32Array, Float32Array, Float32Array, Float32Array, Float32Array, Float32Array];
  return { standing, curves: { time: answer.arrays.time as Float64Array, measured, model, low, high, wideLow, wideHigh } };
}

interface Form {
  channel: Suggestion["channels"][number]; pulse: string; template: Suggestion["templates"][number]; mass: number; end: number; effort: string;
}

/** What is asked, with what is suggested where nothing else was chosen. */
function completed(asked: FitAsked, suggestion: Suggestion, info: TestInfo): Form {
  const channel = suggestion.channels.find((one) => one.key === asked.channel) ?? suggestion.channels[0]!;
  const pulses = pulsesOf(suggestion, channel.key);
  const own = info.sled ? "" : pulses[0]?.key ?? "";
  return {
    channel,
    pulse: pulses.some((one) => one.key === asked.pulse) ? asked.pulse : own,
    template: suggestion.templates.find((one) => one.name === asked.template) ?? suggestion.templates[0]!,
    mass: asked.mass ?? channel.mass,
    end: asked.end ?? suggestion.end,
    effort: suggestion.efforts.includes(asked.effort) ? asked.effort : "normal",
  };
}

/** The channels that the vehicle's pulse can be, where one is fitted. */
function pulsesOf(suggestion: Suggestion, channel: string): Suggestion["pulses"] {
  return suggestion.pulses.filter((one) => one.key !== channel);
}

/** The numbers to find, with their bounds, and those that are held. */
function numbersOf({ template }: Form, { bounds, held }: FitAsked) {
  const free: Record<string, [number, number]> = {}, kept: Record<string, number> = {};
  for (const one of template.numbers) {
    if (one.name in held) kept[one.name] = held[one.name]!;
    else free[one.name] = bounds[one.name] ?? [one.low, one.high];
  }
  return { free, held: kept };
}

interface FormProps { form: Form; asked: FitAsked; onAsk: (asked: FitAsked) => void }

function Choices({ form, suggestion, info, asked, onAsk }: FormProps & { suggestion: Suggestion; info: TestInfo }) {
  const set = (part: Partial<FitAsked>) => onAsk({ ...asked, ...part });
  return (
    <div class="choices">
      <label class="field">Measured acceleration
        <select value={form.channel.key} onChange={(event) => set({ channel: event.currentTarget.value, mass: null })}>
          {suggestion.channels.map((one) => <option key={one.key} value={one.key}>{one.seat ? `${one.label}, seat ${one.seat}` : one.label}</option>)}
        </select>
      </label>
      <label class="field">Pulse of the vehicle
        <select value={form.pulse} onChange={(event) => set({ pulse: event.currentTarget.value })}>
          {info.sled && <option value="">as judged: the best sensors of the compartment</option>}
          {pulsesOf(suggestion, form.channel.key).map((one) => <option key={one.key} value={one.key}>{one.label}</option>)}
        </select>
      </label>
      <label class="field">Restraint
        <select value={form.template.name} onChange={(event) => set({ template: event.currentTarget.value, bounds: {}, held: {} })}>
          {suggestion.templates.map((one) => <option key={one.name} value={one.name}>{one.name}: {one.what}</option>)}
        </select>
      </label>
      <label class="field">Search
        <select value={form.effort} onChange={(event) => set({ effort: event.currentTarget.value })}>
          {suggestion.efforts.map((one) => <option key={one} value={one}>{one}</option>)}
        </select>
      </label>
      <div class="field"><span>Occupant’s mass, kg</span>
        <NumberField label="Occupant’s mass, kg" value={form.mass} unit="kg" onChange={(mass) => set({ mass })} /></div>
      <div class="field"><span>Fitted from 0 to, ms</span>
        <NumberField label="End of the fit, ms" value={form.end} unit="s" onChange={(end) => set({ end })} /></div>
    </div>
  );
}

function Numbers({ form, asked, onAsk }: FormProps) {
  const { bounds, held } = asked;
  const bound = (one: FreeNumber, ends: [number, number]) => onAsk({ ...asked, bounds: { ...bounds, [one.name]: ends } });
  const toggle = (one: FreeNumber, free: boolean) => {
    const { [one.name]: _, ...others } = held;
    onAsk({ ...asked, held: free ? others : { ...others, [one.name]: one.value } });
  };
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label="Parameters to find">
      <table>
        <caption>Parameters: those that are free are sought within their bounds</caption>
        <thead><tr><th scope="col">Free</th><th scope="col">Parameter</th><th scope="col">From</th><th scope="col">To</th><th scope="col">Held at</th><th scope="col">Unit</th></tr></thead>
        <tbody>
          {form.template.numbers.map((one) => {
            const free = !(one.name in held), [low, high] = bounds[one.name] ?? [one.low, one.high];
            const { unit } = shownUnit(one.unit, one.path);
            const field = (label: string, value: number, onChange: (value: number) => void) =>
              <NumberField label={`${one.name}, ${label}${unit && `, ${unit}`}`} value={value} unit={one.unit} path={one.path} onChange={onChange} />;
            return (
              <tr key={one.name}>
                <td><input type="checkbox" aria-label={`${one.name}, free`} checked={free} onChange={(event) => toggle(one, event.currentTarget.checked)} /></td>
                <th scope="row">{one.name}</th>
                <td>{free ? field("from", low, (value) => bound(one, [value, high])) : "–"}</td>
                <td>{free ? field("to", high, (value) => bound(one, [low, value])) : "–"}</td>
                <td>{free ? "–" : field("held at", held[one.name]!, (value) => onAsk({ ...asked, held: { ...held, [one.name]: value } }))}</td>
                <td>{unit}{one.by_ratio && <span class="quiet"> by ratio</span>}</td>
              </tr>
            );
          })}
        </tbody>
      </table>
    </div>
  );
}

function Progress({ standing }: { standing: FitStanding }) {
  const said = standing.ended ? (standing.result?.interrupted ? "stopped; the best so far" : "done") : standing.cancelled ? "stopping" : standing.stage;
  const misfit = standing.misfit === null ? "" : `, misfit ${digits(standing.misfit, 3)}`;
  return (
    <div>
      {!standing.ended && <progress aria-label="The fit that runs" />}
      <p role="status" class="quiet">{said}: {standing.tried.toLocaleString("en")} candidates{misfit}, {digits(standing.seconds, 2)} s</p>
    </div>
  );
}

function Result({ standing, curves, change, theme }: { standing: FitStanding; curves: Banded; change: Change; theme: string }) {
  const result = standing.result!;
  const { unit, scale } = shownUnit(result.unit);
  const open = () => change({ view: "crash", run: { toml: result.toml, values: {} }, who: "" });
  const figures = useMemo(() => figuresOf(result), [result]);
  return (
    <div class="results">
      <dl class="fit-figures">{figures.map(([name, value]) => <div key={name}><dt>{name}</dt><dd>{value}</dd></div>)}</dl>
      <BandPlot title={result.name} label={`${unit}${result.cfc ? `, CFC ${result.cfc}` : ""}, against time, ms`} unit={unit} scale={scale} curves={curves} theme={theme} />
      <div class="actions">
        <button type="button" onClick={open}>Open the fitted scenario in Crash</button>
        <a class="button" href={`fit/${standing.fit}/scenario.toml`} download>Scenario file</a>
        <a class="button" href={`fit/${standing.fit}/report.html`} download>HTML report</a>
        <a class="button" href={`fit/${standing.fit}/report.pdf`} download>PDF report</a>
      </div>
      <DataTable table={result.parameters} />
      {result.warnings.map((warning) => <p key={warning} class="note">{warning}</p>)}
      {result.tables.map((table) => <DataTable key={table.caption} table={table} />)}
    </div>
  );
}

function figuresOf(result: NonNullable<FitStanding["result"]>): [string, string][] {
  const signed = (value: number, unit: string) => `${value > 0 ? "+" : ""}${digits(value, 2)} ${unit}`;
  const found: [string, string][] = [];
  if (result.rating !== null) found.push(["ISO/TS 18571", `${digits(result.rating, 3)}, ${result.grade}`]);
  if (result.peak_error !== null) found.push(["Peak, model against measured", signed(100 * result.peak_error, "%")]);
  if (result.peak_time_error !== null) found.push(["Its time", signed(1e3 * result.peak_time_error, "ms")]);
  if (result.within !== null) found.push(["Measured within the wide band", `${digits(100 * result.within, 3)} %`]);
  return found;
}
