/** A measured test: dropped here, its channels, its criteria beside the official ones, its pulse for a sled, a model fitted to it. */
import { useCallback, useEffect, useState } from "preact/hooks";
import type { ViewProps } from "../app";
import { type Curve, Plot } from "../parts/plot";
import { DataTable, Verdicts } from "../parts/tables";
import { RequestRefused, rows } from "../socket";
import type { Line, TestInfo } from "../types";
import { NO_FIT } from "../url";
import { Calibrate } from "./calibrate";

const CLASSES = [1000, 600, 180, 60];
const MOST = 8;

interface Drawn { time: Float64Array; curves: Curve[] }

export function TestView({ live, state, change, theme }: ViewProps) {
  const { test, channels, cfc, fit } = state.test;
  const [info, setInfo] = useState<TestInfo | null>(null);
  const [busy, setBusy] = useState(false);
  const [trouble, setTrouble] = useState("");
  const [drawn, setDrawn] = useState<Drawn | null>(null);
  const set = (part: Partial<typeof state.test>) => change({ test: { ...state.test, ...part } });

  useEffect(() => {
    if (!test || info?.test === test) return;
    live.ask("test", { kind: "test", test }).then(
      ({ header }) => setInfo(header as TestInfo),
      (error) => setTrouble(String(error instanceof RequestRefused ? error.refused.message : error)),
    );
  }, [test]);

  useEffect(() => {
    if (!info || !channels.length) {
      setDrawn(null);
      return;
    }
    live.ask("channels", { kind: "channels", test: info.test, channels, cfc }).then(
      (answer) => {
        const values = rows(answer, "values");
        const lines = answer.header.lines as Line[];
        setDrawn({ time: answer.arrays.time as Float64Array, curves: lines.map((line) => ({ line, values: values[line.row]! })) });
        setTrouble("");
      },
      (error) => setTrouble(String(error instanceof RequestRefused ? error.refused.message : error)),
    );
  }, [info, channels.join("\n"), cfc]);

  const upload = useCallback(async (file: File | undefined) => {
    if (!file) return;
    setBusy(true);
    setTrouble("");
    try {
      const answer = await fetch("upload", {
        method: "POST", body: file, headers: { "x-filename": encodeURIComponent(file.name), "content-type": "application/octet-stream" },
      });
      const found = (await answer.json()) as TestInfo | { message: string };
      if ("message" in found) setTrouble(found.message);
      else {
        setInfo(found);
        change({ test: { test: found.test, channels: firstOf(found), cfc: 60, fit: null } });
      }
    } catch (error) {
      setTrouble(`The file did not arrive: ${String(error)}`);
    } finally {
      setBusy(false);
    }
  }, []);

  return (
    <div class="stage">
      <label class={`drop${busy ? " busy" : ""}`} onDragOver={(event) => event.preventDefault()}
        onDrop={(event) => { event.preventDefault(); void upload(event.dataTransfer?.files[0]); }}>
        <input type="file" accept=".zip,.csv,.tsv,.txt,.parquet,.pq" onChange={(event) => { void upload(event.currentTarget.files?.[0]); event.currentTarget.value = ""; }} />
        <span>{busy ? "Reading and judging the test …" : "Drop a test here, or choose one: the zip of an NHTSA EV5 or ISO-MME test, or a table of channels, CSV or Parquet. It stays in the server’s memory."}</span>
      </label>
      {trouble && <p class="refused" role="alert">{trouble}</p>}
      {info && <>
        <h2>{info.title}</h2>
        <p class="quiet">{info.description}</p>
        <div class="actions">
          <button type="button" disabled={!info.sled} title={info.no_sled} onClick={() => change({ view: "crash", run: { toml: info.sled!, values: {} }, who: "" })}>Use as pulse</button>
          <button type="button" aria-pressed={!!fit} disabled={!info.channels.some((one) => one.acceleration)} onClick={() => set({ fit: fit ? null : NO_FIT })}>Calibrate against it</button>
          {info.no_sled && <span class="quiet">{info.no_sled}</span>}
        </div>
        {fit && <Calibrate key={info.test} live={live} info={info} asked={fit} onAsk={(fit) => set({ fit })} change={change} theme={theme} />}
        <div class="test">
          <Chooser info={info} chosen={channels} onChoose={(channels) => set({ channels })} />
          <div>
            <div class="tabs" role="group" aria-label="Channel frequency class">
              {CLASSES.map((one) => <button key={one} type="button" aria-pressed={cfc === one} onClick={() => set({ cfc: one })}>CFC {one}</button>)}
              <button type="button" aria-pressed={cfc === null} onClick={() => set({ cfc: null })}>as recorded</button>
            </div>
            {drawn
              ? <Plot title="Channels" label="each in its own unit" unit=" " scale={1} time={drawn.time} curves={drawn.curves} moment={state.time}
                  onMoment={(time) => change({ time })} theme={theme} height={320} />
              : <p class="quiet">Choose channels to draw.</p>}
          </div>
        </div>
        {info.verdicts.length > 0 && <section class="card"><Verdicts rows={info.verdicts} /></section>}
        {info.tables.map((table) => <section class="card" key={table.caption}><DataTable table={table} /></section>)}
        {info.notes.length > 0 && <details class="card"><summary>{info.notes.length} notes</summary>{info.notes.map((note) => <p key={note} class="quiet">{note}</p>)}</details>}
      </>}
    </div>
  );
}

/** What to draw first: the accelerations of a vehicle along x. */
function firstOf(info: TestInfo): string[] {
  const found = info.channels.filter((one) => one.group.startsWith("vehicle") && /crossmember/.test(one.label) && /, x$/.test(one.label));
  return (found.length ? found : info.channels).slice(0, 2).map((one) => one.key);
}

function Chooser({ info, chosen, onChoose }: { info: TestInfo; chosen: string[]; onChoose: (keys: string[]) => void }) {
  const [text, setText] = useState("");
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  const found = info.channels.filter((one) => words.every((word) => `${one.key} ${one.group} ${one.label}`.toLowerCase().includes(word)));
  const toggle = (key: string) => onChoose(chosen.includes(key) ? chosen.filter((one) => one !== key) : [...chosen, key].slice(-MOST));
  return (
    <fieldset class="chooser">
      <legend>{info.channels.length} channels</legend>
      <input type="search" placeholder="head x, femur …" aria-label="Find channels" value={text} onInput={(event) => setText(event.currentTarget.value)} />
      <ul tabIndex={0} aria-label="Channels">
        {found.slice(0, 200).map((one) => (
          <li key={one.key}><label class="check"><input type="checkbox" checked={chosen.includes(one.key)} onChange={() => toggle(one.key)} />
            <span>{one.label || one.key} <span class="quiet">{one.group}, {one.unit}</span></span></label></li>
        ))}
      </ul>
    </fieldset>
  );
}
