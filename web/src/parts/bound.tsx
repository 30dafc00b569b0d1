/** What physics allows: the least peak acceleration that any restraint could give, beside a crash and its neighbours. */
import { useEffect, useState } from "preact/hooks";
import { type Live, RequestRefused } from "../socket";
import type { BoundHere, BoundMap, OutcomeInfo } from "../types";
import { digits, show, typed } from "../units";
import { asked, type Run } from "../url";

/** What is asked for; the same key, the same answer. */
export interface BoundOf { run: Run; x: string; y: string; outcome: OutcomeInfo; room: number | null; others: string }

const PAUSE = 250; // ms without a change: it takes longer than a map

const keyOf = ({ run, x, y, outcome, room, others }: BoundOf) => JSON.stringify([run.scenario, run.toml, x, y, outcome.name, room, others]);

/** The bounds of the whole map; those of another map never. */
export function useBoundMap(live: Live, of: BoundOf | null): [BoundMap | null, boolean] {
  const [found, setFound] = useState<{ key: string; bound: BoundMap | null } | null>(null);
  const key = of?.outcome.bound ? keyOf(of) : "";
  useEffect(() => {
    if (!of || !key) return undefined;
    let current = true;
    const { run, x, y, outcome, room } = of;
    const later = setTimeout(() => {
      live.ask("bound", { ...asked(run), kind: "bound", x, y, outcome: outcome.name, room }).then(
        (answer) => {
          if (!current) return;
          const { x: xs, y: ys, least, excursion } = answer.arrays as Record<string, Float32Array & Float64Array>;
          setFound({ key, bound: { ...(answer.header as BoundMap), xs: xs!, ys: ys!, least: least!, excursion: excursion! } });
        },
        () => { if (current) setFound({ key, bound: null }); }, // the readout says what is wrong
      );
    }, PAUSE);
    return () => {
      current = false;
      clearTimeout(later);
    };
  }, [key]);
  return [key && found?.key === key ? found.bound : null, !!key && found?.key !== key];
}

/** The bound of the crash chosen. */
export function useBoundHere(live: Live, of: BoundOf | null): [BoundHere | null, string] {
  const [found, setFound] = useState<{ key: string; here: BoundHere | null; trouble: string } | null>(null);
  const key = of?.outcome.bound ? keyOf(of) + JSON.stringify(of.run.values) : "";
  useEffect(() => {
    if (!of || !key) return undefined;
    let current = true;
    const later = setTimeout(() => {
      live.ask("bound-here", { ...asked(of.run), kind: "bound-here", outcome: of.outcome.name, room: of.room }).then(
        ({ header }) => { if (current) setFound({ key, here: header as BoundHere, trouble: "" }); },
        (error) => { if (current) setFound({ key, here: null, trouble: error instanceof RequestRefused ? error.refused.message : String(error) }); },
      );
    }, PAUSE / 2);
    return () => {
      current = false;
      clearTimeout(later);
    };
  }, [key]);
  return key && found?.key === key ? [found.here, found.trouble] : [null, ""];
}

interface Props {
  outcome: OutcomeInfo; on: boolean; room: number | null; here: BoundHere | null; trouble: string; busy: boolean;
  onSwitch: (on: boolean) => void; onRoom: (room: number | null) => void;
}

export function BoundPanel({ outcome, on, room, here, trouble, busy, onSwitch, onRoom }: Props) {
  return (
    <section class="physics" aria-label="The bound">
      <label class="check"><input type="checkbox" checked={on} onChange={(event) => onSwitch(event.currentTarget.checked)} /> <b>What physics allows</b></label>
      {on && !outcome.bound && <p class="quiet">The bound does not apply to this outcome: it is the least <i>peak acceleration of an occupant</i> that any restraint could give. Choose one of these to see it.</p>}
      {on && outcome.bound && <>
        <label class="field">Excursion allowed, mm
          <input key={room} type="text" inputMode="decimal" value={room === null ? "" : digits(1e3 * room)} placeholder="what each crash uses"
            onChange={(event) => onRoom(event.currentTarget.value.trim() ? positive(typed(event.currentTarget.value, "m", "")) : null)} />
        </label>
        <div role="status" aria-live="polite">
          {here && <Readout here={here} />}
          {trouble && <p class="refused">{trouble}</p>}
          {!here && !trouble && <p class="quiet">Computing the bound …</p>}
          {here && busy && <p class="quiet">Computing it for the map …</p>}
        </div>
      </>}
    </section>
  );
}

function positive(value: number | null): number | null {
  return value !== null && value > 0 ? value : null;
}

function Readout({ here }: { here: BoundHere }) {
  const over = here.peak / here.least;
  const part = Math.min(100, (100 * here.least) / here.peak);
  const beyond = here.room !== null && here.excursion > here.room + 1e-6;
  return (
    <>
      <p>This design <b>{g(here.peak)}</b>, physics allows <b>{g(here.least)}</b> within {mm(here.within)}.</p>
      <div class="gauge" aria-hidden="true"><span style={{ width: `${part}%` }} /></div>
      <p class="quiet">
        {here.least > 0 && `${digits(over, 3)} times the least possible. `}
        {here.room !== null && `The design uses ${mm(here.excursion)}${beyond ? ": more than is allowed. " : ". "}`}
        {here.needs > 0 ? `Its own peak could be had within ${mm(here.needs)}. ` : "Its own peak could be had with no excursion at all: the vehicle itself has less. "}
        {here.rearward > 5e-4 && `${mm(here.rearward)} of room behind, which it used, is allowed too. `}
        {!here.holds && "It was where the proof does not allow for: it may be below the bound."}
      </p>
    </>
  );
}

const g = (value: number) => show(value, "m/s2", "", 3);
const mm = (value: number) => `${Math.round(1e3 * value)} mm`;
