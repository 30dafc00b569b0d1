/** The state of the page, and the address that holds all of it. */

export const VIEWS = ["crash", "map", "test", "paper", "study"] as const;
export type View = (typeof VIEWS)[number];

/** A scenario: by its name in the catalogue, or as the text of a file; and the numbers that differ from it. */
export interface Run { scenario?: string; toml?: string; values: Record<string, number> }

export interface State {
  view: View;
  run: Run;
  pin: Run | null;
  time: number; // s
  who: string; // occupant in the side view
  all: boolean; // every slider
  map: { x: string; y: string; outcome: string; limit: number | null; bound: boolean; room: number | null };
  test: { test: string; channels: string[]; cfc: number | null; fit: FitAsked | null };
  study: string; // its name; none where a new one is made
  kind: string; // of a new study
}

/** A restraint fitted to the test: what was chosen; what is empty is as the server suggests. */
export interface FitAsked {
  channel: string; pulse: string; template: string; mass: number | null; end: number | null; effort: string;
  bounds: Record<string, [number, number]>; // SI, by the numbers' names
  held: Record<string, number>; // those that are not sought
  key: string; // of the fit that was begun
}

export const NO_FIT: FitAsked = { channel: "", pulse: "", template: "", mass: null, end: null, effort: "", bounds: {}, held: {}, key: "" };

export const START: State = {
  view: "crash",
  run: { scenario: "example-offset", values: {} },
  pin: null,
  time: 0.06,
  who: "",
  all: false,
  map: { x: "", y: "", outcome: "", limit: null, bound: true, room: null },
  test: { test: "", channels: [], cfc: 60, fit: null },
  study: "",
  kind: "sweep",
};

/** What a run is asked for by. */
export function asked(run: Run): Record<string, unknown> {
  return run.toml === undefined ? { scenario: run.scenario, values: run.values } : { toml: run.toml, values: run.values };
}

export async function write(state: State): Promise<string> {
  const found = new URLSearchParams();
  await writeRun(found, "", state.run);
  if (state.pin) await writeRun(found, "pin.", state.pin);
  if (state.time !== START.time) found.set("t", String(state.time));
  if (state.who) found.set("who", state.who);
  if (state.all) found.set("all", "1");
  if (state.view === "map") {
    const { x, y, outcome, limit, bound, room } = state.map;
    for (const [key, value] of Object.entries({ x, y, outcome })) if (value) found.set(key, value);
    if (limit !== null) found.set("limit", String(limit));
    if (!bound) found.set("bound", "0");
    if (room !== null) found.set("room", String(room));
  }
  if (state.view === "study") {
    if (state.study) found.set("study", state.study);
    else if (state.kind !== START.kind) found.set("kind", state.kind);
  }
  if (state.test.test) {
    found.set("test", state.test.test);
    for (const channel of state.test.channels) found.append("channel", channel);
    found.set("cfc", String(state.test.cfc ?? "none"));
    if (state.test.fit) found.set("fit", writeFit(state.test.fit));
  }
  return `#/${state.view}?${found}`;
}

export async function read(hash: string): Promise<State> {
  const [, view = "", query = ""] = /^#\/?([a-z]*)\??(.*)$/s.exec(hash) ?? [];
  const found = new URLSearchParams(query);
  const number = (key: string) => (found.has(key) && Number.isFinite(Number(found.get(key))) ? Number(found.get(key)) : null);
  return {
    view: VIEWS.find((known) => known === view) ?? START.view,
    run: (await readRun(found, "")) ?? START.run,
    pin: await readRun(found, "pin."),
    time: number("t") ?? START.time,
    who: found.get("who") ?? "",
    all: found.get("all") === "1",
    map: { x: found.get("x") ?? "", y: found.get("y") ?? "", outcome: found.get("outcome") ?? "", limit: number("limit"), bound: found.get("bound") !== "0", room: number("room") },
    test: {
      test: found.get("test") ?? "",
      channels: found.getAll("channel"),
      cfc: found.get("cfc") === "none" ? null : number("cfc") ?? 60,
      fit: readFit(found.get("fit")),
    },
    study: found.get("study") ?? "",
    kind: found.get("kind") ?? START.kind,
  };
}

async function writeRun(found: URLSearchParams, prefix: string, run: Run): Promise<void> {
  if (run.toml === undefined) found.set(`${prefix}s`, run.scenario ?? "");
  else found.set(`${prefix}file`, await packed(run.toml));
  for (const [path, value] of Object.entries(run.values)) found.set(`${prefix}v.${path}`, String(value));
}

async function readRun(found: URLSearchParams, prefix: string): Promise<Run | null> {
  const scenario = found.get(`${prefix}s`), file = found.get(`${prefix}file`);
  if (!scenario && !file) return null;
  const start = `${prefix}v.`, values: Record<string, number> = {};
  for (const [key, value] of found) {
    if (key.startsWith(start) && Number.isFinite(Number(value))) values[key.slice(start.length)] = Number(value);
  }
  if (file) {
    const toml = await unpacked(file);
    return toml === null ? null : { toml, values };
  }
  return { scenario: scenario!, values };
}

/** What was chosen, as JSON without what is as suggested. */
function writeFit(fit: FitAsked): string {
  const chosen = Object.entries(fit).filter(([, value]) => value && (typeof value !== "object" || Object.keys(value).length));
  return JSON.stringify(Object.fromEntries(chosen));
}

/** The address may come from anywhere: what is not of its kind is left out. */
function readFit(text: string | null): FitAsked | null {
  if (text === null) return null;
  let given: Record<string, unknown> = {};
  try {
    given = Object(JSON.parse(text));
  } catch { /* none that can be read */ }
  const word = (key: string) => (typeof given[key] === "string" ? given[key] : "");
  const number = (value: unknown): value is number => typeof value === "number" && Number.isFinite(value);
  const named = <T,>(key: string, fits: (value: unknown) => value is T) =>
    Object.fromEntries(Object.entries(Object(given[key])).filter((entry): entry is [string, T] => fits(entry[1])));
  const two = (value: unknown): value is [number, number] => Array.isArray(value) && value.length === 2 && value.every(number);
  return {
    channel: word("channel"), pulse: word("pulse"), template: word("template"), effort: word("effort"), key: word("key"),
    mass: number(given.mass) ? given.mass : null, end: number(given.end) ? given.end : null,
    bounds: named("bounds", two), held: named("held", number),
  };
}

const MOST_TEXT = 200_000; // characters unpacked: an address from elsewhere must not fill the memory

async function packed(text: string): Promise<string> {
  const stream = new Blob([text]).stream().pipeThrough(new CompressionStream("deflate-raw"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  let binary = "";
  for (const byte of bytes) binary += String.fromCharCode(byte);
  return btoa(binary).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

async function unpacked(text: string): Promise<string | null> {
  try {
    const bytes = Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (c) => c.charCodeAt(0));
    const reader = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw")).getReader();
    const decoder = new TextDecoder();
    let result = "";
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return result + decoder.decode();
      result += decoder.decode(value, { stream: true });
      if (result.length > MOST_TEXT) return null;
    }
  } catch {
    return null;
  }
}
