/** A run as it is on the server: what it is made of, its curves, and what it comes to. */
import { useCallback, useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import { type Answer, type Live, RequestRefused, rows } from "./socket";
import type { Curves, Refused, Results, ScenarioInfo } from "./types";
import { asked, type Run } from "./url";

export function curvesOf(answer: Answer): Curves {
  return { ...(answer.header as Curves), time: answer.arrays.time as Float64Array, values: rows(answer, "values") };
}

function refusedBy(error: unknown): Refused {
  if (error instanceof RequestRefused) return error.refused;
  throw error;
}

/** What a scenario is made of; null until it is known. */
export function useScenario(live: Live, run: Run): [ScenarioInfo | null, Refused | null] {
  const [found, setFound] = useState<ScenarioInfo | null>(null);
  const [refused, setRefused] = useState<Refused | null>(null);
  useEffect(() => {
    let current = true;
    live.ask("describe", { ...asked(run), values: undefined, kind: "describe" }).then(
      ({ header }) => { if (current) { setFound(header as ScenarioInfo); setRefused(null); } },
      (error) => { if (current) { setFound(null); setRefused(refusedBy(error)); } },
    );
    return () => { current = false; };
  }, [run.scenario, run.toml]);
  return [found, refused];
}

/** The curves of a run: those of the run before stay until the next are there. `ask` asks for those of a run that is to come. */
export function useCurves(live: Live, lane: string, run: Run | null): [Curves | null, Refused | null, (run: Run, since: number) => void] {
  const [found, setFound] = useState<Curves | null>(null);
  const [refused, setRefused] = useState<Refused | null>(null);
  const asking = useRef<Run | null>(null);
  const ask = useCallback((run: Run, since: number) => {
    asking.current = run;
    live.ask(lane, { ...asked(run), kind: "simulate" }).then(
      (answer) => {
        if (!asking.current) return;
        setFound(curvesOf(answer));
        setRefused(null);
        if (since) measure(since);
      },
      (error) => { if (asking.current === run) setRefused(refusedBy(error)); },
    );
  }, []);
  useLayoutEffect(() => { // at once: an effect would wait for the frame before
    if (run && asking.current !== run) ask(run, 0);
    if (run) return;
    asking.current = null;
    setFound(null);
  }, [run]);
  return [found, refused, ask];
}

/** From the slider's own event to the frame in which every plot is drawn: what the tests and benchmarks read. */
function measure(began: number): void {
  requestAnimationFrame(() => {
    const channel = new MessageChannel(); // its message comes after the frame is painted
    channel.port1.onmessage = () => performance.measure("ridedown:redraw", { start: began, end: performance.now() });
    channel.port2.postMessage(null);
  });
}

const PAUSE = 150; // ms without a change, before tables are asked for

/** What a run comes to, once it stays the same for a moment; `stale` until then. */
export function useResults(live: Live, lane: string, run: Run | null): [Results | null, boolean] {
  const [found, setFound] = useState<{ run: Run; results: Results } | null>(null);
  useEffect(() => {
    if (!run) {
      setFound(null);
      return;
    }
    let current = true;
    const later = setTimeout(() => {
      live.ask(lane, { ...asked(run), kind: "results" }).then(
        ({ header }) => { if (current) setFound({ run, results: header as Results }); },
        () => undefined, // the curves say what is wrong
      );
    }, PAUSE);
    return () => {
      current = false;
      clearTimeout(later);
    };
  }, [run]);
  return [found?.results ?? null, found?.run !== run];
}
