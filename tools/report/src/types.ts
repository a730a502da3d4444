// The data that the report's writer (framework/src/report) puts into the page.

/** One column of numbers; see framework/src/report/packing.hpp. */
export interface Packed {
  n: number;
  k: "c" | "u" | "f" | "h";
  o: number | null;
  s?: number;
  b?: string;
}
export type PackedColumns = Record<string, Packed>;

export interface StackInfo {
  name: string;
  truth: boolean;
}

export interface TableRow {
  stack: number;
  values: (number | null)[];
  low: (number | null)[];
  high: (number | null)[];
  n: number[];
}

/** A row less the baseline under the same seeds: median of the differences, its interval, sign test. */
export interface Pair {
  stack: number;
  baseline: number;
  column: string;
  difference: number;
  lo: number | null;
  hi: number | null;
  p: number;
  draws: number;
}

export interface RunInfo {
  stack: number;
  seed: string;
  status: string;
  message: string;
  values: Record<string, number>;
  block: string | null;
}

export interface Claim {
  text: string;
  /** null: it was not decided, `why` says the reason. */
  holds: boolean | null;
  values: { left?: number | null; right?: number | null; medians_hold?: boolean; runs_held?: number; runs?: number; share?: number } | null;
  why: string;
}

export interface Times {
  stack: number;
  what: string;
  n: number;
  median: number;
  p95: number;
  p99: number;
  max: number;
  bins: [number, number][];
}

export interface Validation {
  estimator: string;
  channel: string;
  unit: string;
  n: number | null;
  r2: number | null;
  rmse: number | null;
}

export interface Trace {
  estimator: string;
  channel: string;
  t_s?: Packed;
  truth?: Packed;
  predicted?: Packed;
  sigma?: Packed;
  slip_rad?: Packed;
}

/** What predictions of data not fitted say of an effect: relative change of their error. */
export interface Rollout {
  change: number | null;
  ci95: [number | null, number | null];
  says: string;
}

export interface Named {
  effect: string;
  class?: string;
  rollout?: Rollout;
  params?: Record<string, number | null>;
  units?: Record<string, string>;
  ci95?: Record<string, Range>;
  confidence?: number | null;
}

type Range = [number | null, number | null];

/** Relative change of an error. */
export interface Change {
  change: number | null;
  ci95: Range;
}

/** What the effects found do to one log. */
export interface SessionChange extends Change {
  log: string;
  calibrated: number | null;
  after: number | null;
}

export interface Diagnosis {
  verdict: "named" | "nothing_missing" | "indistinguishable" | "unknown";
  named?: Named[];
  equivalent?: string[][];
  unknown?: { where: string; interval: Range | null } | null;
  nominal_fit?: Record<string, number | null> | null;
  /** `calibrated` and what follows: of a real car's logs, where calibrating closes a part and effects another. */
  gap?: { horizon_s: number | null; before: number | null; after: number | null; closure: number | null; closure_ci95?: Range; calibrated?: number | null; noise?: number | null; at_noise?: boolean; noise_too_large?: boolean; judged?: number | null; calibration?: Change; effects?: Change | null; sessions?: SessionChange[] | null };
  ranking?: { effect: string; gain?: number | null; less_error?: number | null; held_out: number | null; selected_fraction: number | null; rollout?: Rollout }[];
  manoeuvre?: string | null;
}

type Numbers = (number | null)[];

export interface DiagnosisReport {
  sentence?: string;
  log?: string;
  world?: string;
  /** The world's own parameters that were refitted. */
  calibrated?: { param: string; given: number | null; found: number | null; ci95: Range | null }[];
  track?: Record<string, Numbers>;
  residual?: Record<string, Numbers>;
  horizon?: { horizon_s: Numbers; before: Numbers; after: Numbers };
  traces?: { channel: string; t_s: Numbers; measured: Numbers; before: Numbers; after: Numbers }[];
  seen_at?: { effect: string; param: string; unit: string; size: number | null }[];
  /** What the effects of the catalogue are, in words. */
  effects?: Record<string, { words: string; params: Record<string, { words: string; unit: string }> }>;
  health?: { check: string; found: string; done: string; level: "good" | "note" | "bad" }[];
  patch?: unknown;
}

/** One case of a diagnose experiment. */
export interface Case {
  case: string;
  verdict: string;
  sentence: string;
  /** Whether it has a page of its own beside this one. */
  page: boolean;
  values: Record<string, number>;
}

export interface Scene {
  name?: string;
  kind?: string;
  world?: string;
  note?: string | string[];
  /** The text that seeds were drawn from. */
  seeds_from?: string;
  dt?: number;
  laps?: number;
  told?: string[];
  car?: { m?: number; lf?: number; lr?: number; length?: number; width?: number };
}

export interface Meta {
  version: string;
  title: string;
  scene: Scene | null;
  stacks: StackInfo[];
  table: { columns: string[]; rows: TableRow[] };
  pairs: Pair[];
  runs: RunInfo[];
  claims: Claim[];
  times: Times[];
  track: PackedColumns;
  line: PackedColumns;
  validation: Validation[];
  traces: Trace[];
  cases: Case[];
  diagnosis: Diagnosis | null;
  diagnosis_report: DiagnosisReport | null;
  augmented_world: unknown;
  provenance: Record<string, unknown> | null;
}

/** A run's own block. */
export interface RunBlock {
  steps: PackedColumns;
  stride: number;
  undrawable: number;
  replay: PackedColumns;
  tyres: { front: PackedTyres; rear: PackedTyres };
}

export interface PackedTyres {
  t: (number | null)[];
  start: number[];
  slip?: Packed;
  learned?: Packed;
  sigma?: Packed;
  truth?: Packed;
}
