/** What the server sends; see docs/live-page.md. All numbers are SI unless a unit stands beside them. */

export interface Line { label: string; row: number; colour: number; scenario?: string; unit?: string }

export interface Figure { name: string; title: string; label: string; unit: string; scale: number; lines: Line[] }

export interface CrashEvent { time: number; who: string; what: string }

export interface RestraintShape {
  name: string; kind: string; on?: string | null; slack?: number; gap?: number; fire_time?: number; fill_time?: number;
}

export interface OccupantShape {
  name: string; kind: "adult" | "child"; vehicle: number;
  bodies: { name: string; channel: string }[]; restraints: RestraintShape[];
}

export interface Geometry {
  kind: "crash" | "wall" | "sled" | "network";
  width?: number; arms?: [number, number, number, number];
  masses: ({ name: string; mass: number } | number)[];
  elements?: { name: string; between: string[] }[];
  occupants: OccupantShape[];
}

export interface Curves {
  kind: "curves"; completed: boolean; status: string; end: number; name: string; description: string;
  figures: Figure[]; channels: string[]; units: string[]; events: CrashEvent[]; geometry: Geometry;
  time: Float64Array; values: Float32Array[];
}

export interface SliderInfo {
  path: string; group: string; label: string; value: number; unit: string; low: number; high: number; first: boolean;
}

export interface OutcomeInfo { name: string; label: string; unit: string; limit: number | null; bound: string | null }

export interface ScenarioInfo {
  kind: "scenario"; of: string; name: string; description: string; sliders: SliderInfo[]; outcomes: OutcomeInfo[]; toml: string;
}

export interface Table { caption: string; columns: { title: string; unit: string; numeric: boolean }[]; rows: string[][] }

export interface VerdictRow {
  regulation: string; subject: string; criterion: string; unit: string; value: number; limit: number;
  start: number | null; end: number | null; verdict: "passed" | "failed" | "no verdict"; reason: string;
}

export interface Energy {
  initial: number; final: number; left_out: number;
  elements: { name: string; absorbed: number; stored: number; dissipated: number }[];
}

export interface Results {
  kind: "results"; notes: string[]; verdicts: VerdictRow[]; energy: Energy; tables: Table[]; sources: Table;
  peaks: { who: string; channel: string; unit: string; value: number; time: number }[];
}

export interface CrashMap {
  kind: "map"; x: string; y: string; outcome: OutcomeInfo; crashes: number; failed: number; refused: number; why: string;
  xs: Float64Array; ys: Float64Array; values: Float32Array;
}

/** Beside the map: the least peak that any restraint could give each of its crashes, and the excursion that each has. */
export interface BoundMap { kind: "bound"; body: string; room: number | null; xs: Float64Array; ys: Float64Array; least: Float32Array; excursion: Float32Array }

export interface BoundHere {
  kind: "bound-here"; body: string; room: number | null; outcome: number; peak: number; excursion: number; rearward: number;
  within: number; least: number; needs: number; holds: boolean;
}

export interface TestInfo {
  kind: "test"; test: string; title: string; description: string; notes: string[]; tables: Table[]; verdicts: VerdictRow[];
  channels: { key: string; label: string; unit: string; group: string; acceleration: boolean }[]; sled: string | null; no_sled: string;
}

export interface FreeNumber { name: string; path: string; unit: string; low: number; high: number; value: number; by_ratio: boolean }

/** What a test can be fitted with. */
export interface Suggestion {
  kind: "suggestion"; test: string; end: number; efforts: string[];
  channels: { key: string; label: string; seat: string; unit: string; mass: number }[];
  pulses: { key: string; label: string }[];
  templates: { name: string; what: string; numbers: FreeNumber[] }[];
}

/** A fit: how it goes, and what it came to. */
export interface FitStanding {
  kind: "fit"; fit: string; stage: string; tried: number; misfit: number | null; seconds: number; cancelled: boolean; ended: boolean; trouble: string;
  result?: {
    name: string; unit: string; cfc: number | null; rating: number | null; grade: string | null; peak_error: number | null;
    peak_time_error: number | null; within: number | null; interrupted: boolean; warnings: string[]; parameters: Table; tables: Table[];
    values: Record<string, number>; toml: string;
  };
}

export interface Refused { kind: "refused"; status: number; field: string; message: string }

export interface Entry { name: string; description: string; confidence: string }
