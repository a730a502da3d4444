// Reading the page's data blocks: columns are unpacked when somebody asks for them, runs parsed when they are shown.
import type { Meta, Packed, PackedColumns, PackedTyres, RunBlock, TableRow } from "./types";

function bytesOf(base64: string): DataView {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return new DataView(bytes.buffer);
}

/** The numbers of a packed column; gaps are NaN. */
export function unpack(column: Packed): Float64Array {
  const values = new Float64Array(column.n);
  const offset = column.o ?? NaN;
  const step = column.s ?? 0;
  if (column.k === "c") return values.fill(offset);
  if (column.k === "u") return values.map((_, i) => offset + step * i);
  const bytes = bytesOf(column.b ?? "");
  if (column.k === "f") {
    for (let i = 0; i < column.n; i++) values[i] = offset + bytes.getFloat32(4 * i, true);
  } else {
    for (let i = 0; i < column.n; i++) {
      const code = bytes.getInt16(2 * i, true);
      values[i] = code === -32768 ? NaN : offset + step * code;
    }
  }
  return values;
}

/** Columns that unpack on first use. */
export class Columns {
  private readonly ready = new Map<string, Float64Array | undefined>();
  constructor(private readonly packed: PackedColumns) {}

  get(name: string): Float64Array | undefined {
    if (!this.ready.has(name)) {
      const column = this.packed[name];
      const values = column && unpack(column);
      this.ready.set(name, values && values.some(Number.isFinite) ? values : undefined);
    }
    return this.ready.get(name);
  }
  set(name: string, values: Float64Array): void {
    this.ready.set(name, values);
  }
  names(): string[] {
    return Object.keys(this.packed);
  }
}

/** The smallest and the largest number; [Infinity, -Infinity] if there is none. However many: they are no arguments. */
export function reach(values: ArrayLike<number>): [number, number] {
  let [low, high] = [Infinity, -Infinity];
  for (let i = 0; i < values.length; i++) {
    if (!Number.isFinite(values[i])) continue;
    if (values[i] < low) low = values[i];
    if (values[i] > high) high = values[i];
  }
  return [low, high];
}

/** The last index whose value is at most x, at least 0, for ascending values. */
export function indexBefore(values: ArrayLike<number>, x: number): number {
  let low = 0;
  let high = values.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (values[middle] <= x) low = middle;
    else high = middle - 1;
  }
  return low;
}

/** values(x) by linear interpolation over ascending xs, held at the ends. */
export function interpolate(xs: ArrayLike<number>, values: ArrayLike<number>, x: number): number {
  const i = indexBefore(xs, x);
  if (x <= xs[i] || i + 1 >= xs.length) return values[i];
  const w = (x - xs[i]) / (xs[i + 1] - xs[i]);
  return values[i] + w * (values[i + 1] - values[i]);
}

/** One axle's tyre curve at one instant. */
export interface TyreCurve {
  t: number;
  /** Asked for a time before this one. */
  early: boolean;
  slip: Float64Array;
  learned?: Float64Array;
  sigma?: Float64Array;
  truth?: Float64Array;
}

class TyreHistory {
  private readonly columns: Columns;
  constructor(private readonly packed: PackedTyres) {
    const { slip, learned, sigma, truth } = packed;
    this.columns = new Columns(
      Object.fromEntries(Object.entries({ slip, learned, sigma, truth }).filter(([, c]) => c)) as PackedColumns,
    );
  }
  get times(): number[] {
    return this.packed.t.map((t) => t ?? NaN);
  }
  /** The last snapshot taken until t; before the first one nothing was learned, and that one is `early`. */
  at(t: number): TyreCurve | undefined {
    if (!this.packed.start.length) return undefined;
    const times = this.times;
    const i = indexBefore(times, t);
    const [from, to] = [this.packed.start[i], this.packed.start[i + 1]];
    const cut = (name: string) => this.columns.get(name)?.subarray(from, to);
    return { t: times[i], early: times[i] > t + 1e-9, slip: cut("slip")!, learned: cut("learned"), sigma: cut("sigma"), truth: cut("truth") };
  }
}

export interface Pose {
  x: number;
  y: number;
  yaw: number;
  /** Whether the run covers this time. */
  driving: boolean;
}

/** What is known of one run over time. */
export class RunData {
  readonly t: Float64Array;
  readonly replay: Columns;
  readonly front: TyreHistory;
  readonly rear: TyreHistory;
  readonly stride: number;
  readonly undrawable: number;
  private readonly steps: Columns;

  constructor(
    readonly stack: number,
    readonly seed: string,
    readonly status: string,
    block: RunBlock,
  ) {
    this.steps = new Columns(block.steps);
    this.replay = new Columns(block.replay);
    this.front = new TyreHistory(block.tyres.front);
    this.rear = new TyreHistory(block.tyres.rear);
    this.stride = block.stride;
    this.undrawable = block.undrawable;
    this.t = this.steps.get("t") ?? new Float64Array(0);
    const vx = this.steps.get("vx");
    const vy = this.steps.get("vy");
    if (vx) this.steps.set("speed", vy ? vx.map((v, i) => Math.hypot(v, vy[i])) : vx);
  }

  /** A channel of steps.csv by its short name, or what was derived of it. */
  channel(name: string): Float64Array | undefined {
    return this.steps.get(name);
  }
  get end(): number {
    return this.t.length ? this.t[this.t.length - 1] : 0;
  }
  /** It came to its end, as far as the log says. */
  get goesOn(): boolean {
    return !this.status || this.status === "finished";
  }
  value(name: string, t: number): number {
    const values = this.channel(name);
    return values && this.t.length ? interpolate(this.t, values, t) : NaN;
  }
  /** A value that must not be blended: a lap number, a flag. */
  held(name: string, t: number): number {
    const values = this.channel(name);
    return values && this.t.length ? values[indexBefore(this.t, t)] : NaN;
  }
  pose(t: number): Pose {
    return { x: this.value("x", t), y: this.value("y", t), yaw: this.value("yaw", t), driving: t <= this.end + 1e-9 };
  }
  replayValue(name: string, t: number): number {
    const values = this.replay.get(name);
    const times = this.replay.get("t_s");
    return values && times ? interpolate(times, values, t) : NaN;
  }
  /** Points plan0.. or ref0.. at time t, as [x, y, x, y, ...]; empty if unknown. */
  ahead(kind: "plan" | "ref", t: number): number[] {
    const times = this.replay.get("t_s");
    const out: number[] = [];
    if (!times) return out;
    const row = indexBefore(times, t);
    for (let k = 0; ; k++) {
      const x = this.replay.get(`${kind}${k}_x_m`);
      const y = this.replay.get(`${kind}${k}_y_m`);
      if (!x || !y) return out;
      if (Number.isFinite(x[row]) && Number.isFinite(y[row])) out.push(x[row], y[row]);
    }
  }
}

function block<T>(id: string): T {
  return JSON.parse(document.getElementById(id)!.textContent!) as T;
}

/** All that the page knows. */
export class Report {
  readonly meta: Meta;
  readonly track: Columns;
  readonly line: Columns;
  private readonly runs = new Map<number, RunData | undefined>();

  constructor() {
    this.meta = block<Meta>("meta");
    this.track = new Columns(this.meta.track);
    this.line = new Columns(this.meta.line);
  }
  get seeds(): string[] {
    return [...new Set(this.meta.runs.map((run) => run.seed))];
  }
  /** The run of a stack with a seed, if it left a log. */
  run(stack: number, seed: string): RunData | undefined {
    const index = this.meta.runs.findIndex((run) => run.stack === stack && run.seed === seed);
    if (index < 0) return undefined;
    if (!this.runs.has(index)) {
      const info = this.meta.runs[index];
      this.runs.set(
        index,
        info.block ? new RunData(stack, seed, info.status, block<RunBlock>(info.block)) : undefined,
      );
    }
    return this.runs.get(index);
  }
  /** Name as displayed: a star behind stacks that are given the ground truth. */
  label(stack: number): string {
    const info = this.meta.stacks[stack];
    return info.truth ? `${info.name} *` : info.name;
  }
  /** How many runs of a row finished; null where the log does not say. */
  finished(row: TableRow): number | null {
    const index = this.column("finished");
    return index < 0 ? null : row.values[index];
  }
  /** Rows that may be best: not given the ground truth, and in the end at least once where the log says. */
  contenders(): TableRow[] {
    return this.meta.table.rows.filter((row) => !this.meta.stacks[row.stack].truth && this.finished(row) !== 0);
  }
  column(name: string): number {
    return this.meta.table.columns.indexOf(name);
  }
  /** The columns of that name in which some row has a value. */
  filled(name: RegExp): string[] {
    const { columns, rows } = this.meta.table;
    return columns.filter((column, i) => name.test(column) && rows.some((row) => row.values[i] !== null));
  }
}
