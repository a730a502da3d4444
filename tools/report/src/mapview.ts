// Track maps: the course, and trajectories over it.
import { Columns, reach, type Report, type RunData } from "./data";
import type { Pen } from "./pen";
import { sequential, token } from "./theme";

export interface Box {
  left: number;
  right: number;
  bottom: number;
  top: number;
}

/** From metres to pixels, north up. */
export interface View {
  scale: number;
  x(mx: number): number;
  y(my: number): number;
}

export function fit(box: Box, width: number, height: number, margin: number): View {
  const scale = Math.min((width - 2 * margin) / Math.max(1e-9, box.right - box.left), (height - 2 * margin) / Math.max(1e-9, box.top - box.bottom));
  const [cx, cy] = [(box.left + box.right) / 2, (box.bottom + box.top) / 2];
  return { scale, x: (mx) => width / 2 + (mx - cx) * scale, y: (my) => height / 2 - (my - cy) * scale };
}

/** Makes room for cars that left the track, up to a tenth of its size: who went further is out of the picture. */
function widenFor(box: Box, runs: RunData[]): void {
  const room = 0.1 * Math.max(box.right - box.left, box.top - box.bottom);
  const most = { left: box.left - room, right: box.right + room, bottom: box.bottom - room, top: box.top + room };
  for (const run of runs) {
    const [xs, ys] = [run.channel("x") ?? [], run.channel("y") ?? []];
    for (let i = 0; i < xs.length; i++) {
      if (!Number.isFinite(xs[i]) || !Number.isFinite(ys[i])) continue;
      box.left = Math.max(most.left, Math.min(box.left, xs[i]));
      box.right = Math.min(most.right, Math.max(box.right, xs[i]));
      box.bottom = Math.max(most.bottom, Math.min(box.bottom, ys[i]));
      box.top = Math.min(most.top, Math.max(box.top, ys[i]));
    }
  }
}

/** The edges and the centre of a course, as far as the log knows them. */
export class Course {
  readonly left?: [Float64Array, Float64Array];
  readonly right?: [Float64Array, Float64Array];
  readonly centre?: [Float64Array, Float64Array];
  readonly line?: [Float64Array, Float64Array];
  readonly length: number;
  readonly box: Box;

  constructor(track: Columns, line: Columns, runs: RunData[]) {
    const pair = (columns: Columns, x: string, y: string) => {
      const [xs, ys] = [columns.get(x), columns.get(y)];
      return xs && ys ? ([xs, ys] as [Float64Array, Float64Array]) : undefined;
    };
    this.left = pair(track, "left_x_m", "left_y_m");
    this.right = pair(track, "right_x_m", "right_y_m");
    this.centre = pair(track, "x_m", "y_m");
    this.line = pair(line, "x_m", "y_m");
    const s = track.get("s_m");
    this.length = s && s.length > 1 ? s[s.length - 1] + (s[s.length - 1] - s[s.length - 2]) : Math.max(0, ...runs.map((run) => reach(run.channel("s") ?? [])[1]));
    const box = { left: Infinity, right: -Infinity, bottom: Infinity, top: -Infinity };
    const cover = ([xs, ys]: [ArrayLike<number>, ArrayLike<number>]) => {
      for (let i = 0; i < xs.length; i++) {
        if (!Number.isFinite(xs[i]) || !Number.isFinite(ys[i])) continue;
        box.left = Math.min(box.left, xs[i]);
        box.right = Math.max(box.right, xs[i]);
        box.bottom = Math.min(box.bottom, ys[i]);
        box.top = Math.max(box.top, ys[i]);
      }
    };
    const edges = [this.left, this.right, this.centre].filter((edge) => edge !== undefined);
    edges.forEach(cover);
    if (!edges.length) for (const run of runs) cover([run.channel("x") ?? [], run.channel("y") ?? []]);
    else widenFor(box, runs);
    this.box = box.left <= box.right ? box : { left: -1, right: 1, bottom: -1, top: 1 };
  }
  static of(report: Report, runs: RunData[]): Course {
    return new Course(report.track, report.line, runs);
  }
  get aspect(): number {
    return (this.box.top - this.box.bottom) / Math.max(1e-9, this.box.right - this.box.left);
  }
}

function points([xs, ys]: [ArrayLike<number>, ArrayLike<number>], view: View): number[] {
  const out: number[] = [];
  for (let i = 0; i < xs.length; i++) out.push(view.x(xs[i]), view.y(ys[i]));
  return out;
}

function enclosed(outline: number[]): number {
  let area = 0;
  for (let i = 0; i < outline.length; i += 2) {
    const j = (i + 2) % outline.length;
    area += outline[i] * outline[j + 1] - outline[j] * outline[i + 1];
  }
  return Math.abs(area);
}

export function drawCourse(pen: Pen, course: Course, view: View, withLine = false): void {
  if (course.left && course.right) {
    const [a, b] = [points(course.left, view), points(course.right, view)];
    const [outer, inner] = enclosed(a) > enclosed(b) ? [a, b] : [b, a];
    pen.ring(outer, inner, token("asphalt"));
    pen.line(outer, { color: token("edge"), width: 1.2 }, true);
    pen.line(inner, { color: token("edge"), width: 1.2 }, true);
    pen.line([a[0], a[1], b[0], b[1]], { color: token("edge"), width: 2 });
  } else if (course.centre) {
    pen.line(points(course.centre, view), { color: token("edge"), width: 1.2 }, true);
  }
  if (withLine && course.line) pen.line(points(course.line, view), { color: token("edge"), width: 1, dash: [2, 4] }, true);
}

export interface TrailOptions {
  from?: number;
  to?: number;
  width?: number;
  low: number;
  high: number;
}

/** A trajectory coloured by speed, in runs of equal colour. */
export function drawSpeedTrail(pen: Pen, run: RunData, view: View, { from = 0, to = Infinity, width = 2, low, high }: TrailOptions): void {
  const [xs, ys, speed] = [run.channel("x"), run.channel("y"), run.channel("speed")];
  if (!xs || !ys) return;
  const steps = 24;
  const level = (i: number) => (speed && Number.isFinite(speed[i]) ? Math.round(((speed[i] - low) / Math.max(1e-9, high - low)) * steps) : 0);
  let piece: number[] = [];
  let current = -1;
  const flush = () => {
    if (piece.length > 2) pen.line(piece, { color: sequential(current / steps), width });
  };
  for (let i = 0; i < xs.length; i++) {
    if (run.t[i] < from || run.t[i] > to || !Number.isFinite(xs[i]) || !Number.isFinite(ys[i])) {
      flush();
      piece = [];
      continue;
    }
    const at = [view.x(xs[i]), view.y(ys[i])];
    const now = level(i);
    if (now !== current && piece.length) {
      piece.push(...at);
      flush();
      piece = [];
    }
    current = now;
    piece.push(...at);
  }
  flush();
}

/** Intervals of time in which a flag was set. */
export function intervals(run: RunData, flag: string, from = 0, to = Infinity): [number, number][] {
  const values = run.channel(flag);
  const out: [number, number][] = [];
  if (!values) return out;
  let start = NaN;
  for (let i = 0; i < values.length; i++) {
    const on = values[i] >= 0.5 && run.t[i] >= from && run.t[i] <= to;
    if (on && Number.isNaN(start)) start = run.t[i];
    if (!on && !Number.isNaN(start)) {
      out.push([start, run.t[i]]);
      start = NaN;
    }
  }
  if (!Number.isNaN(start)) out.push([start, Math.min(run.end, to)]);
  return out;
}

/** Where the car was outside: a broad stroke with a ring at its beginning, readable without its colour. */
export function drawViolations(pen: Pen, run: RunData, view: View, from = 0, to = Infinity): void {
  const color = token("alarm");
  for (const [begin, end] of intervals(run, "outside", from, to)) {
    const piece: number[] = [];
    const step = Math.max((end - begin) / 200, 1e-3);
    for (let t = begin; t <= end + 1e-9; t += step) {
      const pose = run.pose(t);
      piece.push(view.x(pose.x), view.y(pose.y));
    }
    if (piece.length > 2) pen.line(piece, { color, width: 5 });
    const ring = Array.from({ length: 24 }, (_, i) => [piece[0] + 7 * Math.cos((i * Math.PI) / 12), piece[1] + 7 * Math.sin((i * Math.PI) / 12)]).flat();
    pen.line(ring, { color, width: 2 }, true);
  }
}

/** The laps of a run as intervals of time. */
export function laps(run: RunData): [number, number][] {
  const lap = run.channel("lap");
  if (!lap || !lap.length) return [[0, run.end]];
  const out: [number, number][] = [];
  let begin = run.t[0];
  let current = NaN;
  for (let i = 0; i < lap.length; i++) {
    // What was not logged ends no lap.
    if (!Number.isFinite(lap[i]) || lap[i] === current) continue;
    if (Number.isFinite(current)) {
      out.push([begin, run.t[i]]);
      begin = run.t[i];
    }
    current = lap[i];
  }
  // The step after the finish line is no lap.
  if (run.end - begin > 0.2) out.push([begin, run.end]);
  return out;
}
