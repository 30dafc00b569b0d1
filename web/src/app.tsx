/** The page: its views, its state in the address, and the one socket they share. */
import { useCallback, useEffect, useRef, useState } from "preact/hooks";
import { Live, type Status } from "./socket";
import { read, START, type State, type View, VIEWS, write } from "./url";
import { CrashView } from "./views/crash";
import { MapView } from "./views/map";
import { PaperView } from "./views/paper";
import { StudyView } from "./views/study";
import { TestView } from "./views/test";

const live = new Live();

const SAID: Record<Status, string> = {
  connecting: "connecting",
  compiling: "compiling the solver, once; some twenty seconds",
  ready: "live",
  lost: "connection lost; trying again",
};

const NAMES: Record<View, string> = { crash: "Crash", map: "Map", test: "Test", paper: "Paper", study: "Study" };
const THEMES = ["", "light", "dark"] as const;

export type Change = (change: Partial<State>) => void;

export interface ViewProps { live: Live; state: State; change: Change; theme: string; ready: boolean }

/** Where the browser's history stands: the address that the state was read from or written to, and the view it shows. */
interface Entry { address: string | null; view: View | null } // no view until it is read

export function App() {
  const [state, setState] = useState<State | null>(null);
  const [status, setStatus] = useState<Status>(live.status);
  const [theme, setTheme] = useTheme();
  const entry = useRef<Entry>({ address: null, view: null });

  useEffect(() => {
    const follow = async () => {
      const address = location.hash;
      if (address === entry.current.address) return;
      const gone: Entry = entry.current = { address, view: null };
      const there = await read(address);
      if (entry.current !== gone) return; // gone on while it was read
      gone.view = there.view;
      setState(there);
    };
    void follow();
    addEventListener("hashchange", follow);
    const stop = live.onStatus(setStatus);
    setStatus(live.status);
    return () => {
      removeEventListener("hashchange", follow);
      stop();
    };
  }, []);

  useEffect(() => {
    const here = entry.current;
    if (!state || here.view === null) return; // an address is being read, and this is not its state
    let stale = false;
    const later = setTimeout(async () => {
      const address = await write(state);
      // Gone back or forward meanwhile: that address is followed. Written now, this one would cut off what lies ahead of it.
      if (stale || entry.current !== here || location.hash !== here.address) return;
      const way = here.view === state.view ? "replaceState" : "pushState";
      here.view = state.view;
      document.title = `${NAMES[state.view]} · ridedown`;
      if (address === here.address) return;
      here.address = address;
      history[way](null, "", address);
    }, 120);
    return () => {
      stale = true;
      clearTimeout(later);
    };
  }, [state]);

  const change = useCallback<Change>((part) => setState((before) => ({ ...(before ?? START), ...part })), []);
  if (!state) return null;
  const props: ViewProps = { live, state, change, theme, ready: status === "ready" };
  return (
    <>
      <a class="skip" href="#main" onClick={(event) => { event.preventDefault(); document.getElementById("main")?.focus(); }}>To the content</a>
      <header class="top">
        <h1>ridedown</h1>
        <nav aria-label="Views">
          {VIEWS.map((view) => (
            <button key={view} type="button" aria-current={state.view === view ? "page" : undefined} onClick={() => change({ view })}>{NAMES[view]}</button>
          ))}
        </nav>
        <p class={`status ${status}`} role="status"><span aria-hidden="true">●</span> {SAID[status]}</p>
        <button type="button" class="theme" onClick={() => setTheme(THEMES[(THEMES.indexOf(theme) + 1) % THEMES.length]!)}
          aria-label={`Theme: ${theme || "as the system's"}`}>{theme === "dark" ? "☾" : theme === "light" ? "☀" : "◐"}</button>
      </header>
      {status === "compiling" && <p class="banner" role="alert">The solver is being compiled, once for this machine. The page answers in some twenty seconds.</p>}
      {status === "lost" && <p class="banner" role="alert">The server does not answer. The page goes on as soon as it does.</p>}
      <main id="main" tabIndex={-1}>
        {state.view === "crash" && <CrashView {...props} />}
        {state.view === "map" && <MapView {...props} />}
        {state.view === "test" && <TestView {...props} />}
        {state.view === "paper" && <PaperView {...props} />}
        {state.view === "study" && <StudyView {...props} />}
      </main>
    </>
  );
}

type Theme = (typeof THEMES)[number];

function useTheme(): [Theme, (theme: Theme) => void] {
  const [theme, setTheme] = useState<Theme>(() => THEMES.find((one) => one === localStorage.getItem("ridedown-theme")) ?? "");
  if (theme) document.documentElement.dataset.theme = theme;
  else delete document.documentElement.dataset.theme;
  const keep = (chosen: Theme) => {
    localStorage.setItem("ridedown-theme", chosen);
    setTheme(chosen);
  };
  return [theme, keep];
}
