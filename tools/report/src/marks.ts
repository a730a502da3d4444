// What a chart consists of, independent of where it is drawn.
import { indexBefore } from "./data";
import { drawMarker, type Pen } from "./pen";
import { token, type Shape } from "./theme";

type Numbers = ArrayLike<number>;

interface Common {
  color: string;
  alpha?: number;
  /** Stands in legends and tooltips. */
  label?: string;
  /** Whose mark this is: those of others are grey while this stack is lit. */
  stack?: number;
  /** Axes make room for what is before this x only: a car that is lost later shows nothing but that. */
  until?: number;
  /** Axes make no room for it; beyond them it stands at their edge. */
  lost?: boolean;
}
export type Mark = Common &
  (
    | { kind: "line"; x: Numbers; y: Numbers; width?: number; dash?: number[]; step?: boolean; shape?: Shape; shapesAt?: number[] }
    | { kind: "band"; x: Numbers; low: Numbers; high: Numbers }
    | { kind: "points"; x: Numbers; y: Numbers; size?: number; shape?: Shape; names?: string[] }
    | { kind: "rule"; at: number; axis: "x" | "y"; dash?: number[]; width?: number }
    | { kind: "span"; from: number; to: number }
    | { kind: "end"; x: number; y: number; text: string }
    /** `atEdge`: only where its place lies beyond the axes. */
    | { kind: "text"; x: number; y: number; text: string; atEdge?: boolean }
  );

/** From data to pixels. */
export interface Frame {
  x(value: number): number;
  y(value: number): number;
  left: number;
  top: number;
  width: number;
  height: number;
}

/** What is drawn while one stack is lit: the others first, grey and thin, without their bands and spans. */
function lighted(marks: Mark[], lit: number | null, grey: string): Mark[] {
  if (lit === null || !marks.some((mark) => mark.stack === lit)) return marks;
  const isQuiet = (mark: Mark) => mark.stack !== undefined && mark.stack !== lit;
  const quiet = marks
    .filter((mark) => isQuiet(mark) && mark.kind !== "band" && mark.kind !== "span")
    .map((mark): Mark => ({ ...mark, color: grey, alpha: 0.75 * (mark.alpha ?? 1), ...(mark.kind === "line" ? { width: Math.min(1, mark.width ?? 1) } : {}) }));
  return [...quiet, ...marks.filter((mark) => !isQuiet(mark))];
}

/** A place in the frame, and on which side it lies outside. */
function clamped(frame: Frame, x: number, y: number): { x: number; y: number; beyond: string } {
  const [left, right, top, bottom] = [frame.left + 7, frame.left + frame.width - 7, frame.top + 7, frame.top + frame.height - 7];
  const beyond = y < frame.top ? "↑" : y > frame.top + frame.height ? "↓" : x > frame.left + frame.width ? "→" : x < frame.left ? "←" : "";
  return { x: Math.min(Math.max(x, left), right), y: Math.min(Math.max(y, top), bottom), beyond };
}

/** Runs of points that are numbers, as pixel lists. */
function pieces(frame: Frame, xs: Numbers, ys: Numbers, step = false): number[][] {
  const out: number[][] = [];
  let piece: number[] = [];
  for (let i = 0; i < xs.length; i++) {
    if (!Number.isFinite(ys[i]) || !Number.isFinite(xs[i])) {
      if (piece.length) out.push(piece);
      piece = [];
      continue;
    }
    const [x, y] = [frame.x(xs[i]), frame.y(ys[i])];
    if (step && piece.length) piece.push(x, piece[piece.length - 1]);
    piece.push(x, y);
  }
  if (piece.length) out.push(piece);
  return out;
}

interface Label {
  x: number;
  y: number;
  width: number;
}

/** A place for a label beside a point: inside the frame, over no other label. */
function placeLabel(frame: Frame, placed: Label[], x: number, y: number, width: number): Label {
  const beside = [
    [9, -9],
    [9, 9],
    [-9 - width, -9],
    [-9 - width, 9],
    [9, 22],
    [-9 - width, 22],
    [9, -22],
    [-9 - width, -22],
  ].map(([dx, dy]): Label => ({ x: x + dx, y: y + dy, width }));
  const inside = (l: Label) => l.x >= frame.left && l.x + width <= frame.left + frame.width && l.y >= frame.top && l.y <= frame.top + frame.height;
  const free = (l: Label) => placed.every((p) => Math.abs(p.y - l.y) > 11 || p.x + p.width < l.x || l.x + l.width < p.x);
  const label = beside.find((l) => inside(l) && free(l)) ?? beside[0];
  placed.push(label);
  return label;
}

/** Draws marks; `lit` is the stack in colour, null where all are; `text` and `grey` are colours. */
export function paintMarks(pen: Pen, frame: Frame, all: Mark[], lit: number | null, text: string, grey: string): void {
  const marks = lighted(all, lit, grey);
  const right = frame.left + frame.width;
  // Labels keep clear of one another and of the points that have names.
  const placed: Label[] = marks.flatMap((mark) => (mark.kind === "text" && !mark.atEdge ? [{ x: frame.x(mark.x) - 6, y: frame.y(mark.y), width: 12 }] : []));
  const bottom = frame.top + frame.height;
  for (const mark of marks) {
    const alpha = mark.alpha ?? 1;
    const { color } = mark;
    switch (mark.kind) {
      case "line":
        for (const piece of pieces(frame, mark.x, mark.y, mark.step))
          pen.line(piece, { color, alpha, width: mark.width ?? 1.6, dash: mark.dash });
        break;
      case "band": {
        const high = pieces(frame, mark.x, mark.high);
        pieces(frame, mark.x, mark.low).forEach((low, i) => {
          const back: number[] = [];
          for (let k = low.length - 2; k >= 0; k -= 2) back.push(low[k], low[k + 1]);
          if (!high[i]) return;
          pen.area([...high[i], ...back], color, alpha);
          // Edges show where the band ends, and that there is one where it is thin.
          for (const edge of [high[i], low]) pen.line(edge, { color, alpha: Math.min(1, 2.2 * alpha), width: 0.8 });
        });
        break;
      }
      case "points":
        for (let i = 0; i < mark.x.length; i++)
          if (Number.isFinite(mark.x[i]) && Number.isFinite(mark.y[i])) {
            const real = { x: frame.x(mark.x[i]), y: frame.y(mark.y[i]), beyond: "" };
            const at = mark.lost ? clamped(frame, real.x, real.y) : real;
            drawMarker(pen, mark.shape ?? "circle", at.x, at.y, mark.size ?? 3, color, alpha);
            if (at.beyond && (mark.size ?? 3) > 3) pen.text(at.x + 9, at.y, at.beyond, { color: text, size: 11 });
          }
        break;
      case "end": {
        const at = clamped(frame, mark.x === Infinity ? right + 1 : frame.x(mark.x), frame.y(mark.y));
        if (!Number.isFinite(at.y)) break;
        if (at.beyond === "→") pen.area([at.x + 6, at.y, at.x - 3, at.y - 5, at.x - 3, at.y + 5], color, alpha);
        else drawMarker(pen, "cross", at.x, at.y, 5, color, alpha);
        const width = mark.text.length * 6.2;
        const place = placeLabel(frame, placed, at.x, at.y, width);
        // On lines a text needs a ground of its own.
        pen.area([place.x - 3, place.y - 8, place.x + width + 3, place.y - 8, place.x + width + 3, place.y + 7, place.x - 3, place.y + 7], token("surface"), 0.85);
        pen.text(place.x, place.y, mark.text, { color: text, size: 11 });
        break;
      }
      case "rule": {
        const at = mark.axis === "x" ? frame.x(mark.at) : frame.y(mark.at);
        const points = mark.axis === "x" ? [at, frame.top, at, bottom] : [frame.left, at, right, at];
        pen.line(points, { color, alpha, width: mark.width ?? 1, dash: mark.dash });
        if (mark.label && mark.axis === "y") pen.text(right - 4, at - 8, mark.label, { color: text, align: "right", size: 11 });
        if (mark.label && mark.axis === "x") pen.text(at + 4, frame.top + 8, mark.label, { color: text, size: 11 });
        break;
      }
      case "span": {
        const [a, b] = [frame.x(mark.from), frame.x(mark.to)];
        pen.area([a, frame.top, b, frame.top, b, bottom, a, bottom], color, alpha);
        break;
      }
      case "text": {
        const edge = clamped(frame, frame.x(mark.x), frame.y(mark.y));
        if (mark.atEdge && !edge.beyond) break;
        // The arrow beside its marker stays readable.
        if (mark.atEdge) placed.push({ x: edge.x + 9, y: edge.y, width: 8 });
        const at = mark.lost ? edge : { x: frame.x(mark.x), y: frame.y(mark.y) };
        const { x, y } = placeLabel(frame, placed, at.x, at.y, mark.text.length * 6.2);
        pen.text(x, y, mark.text, { color, size: 11 });
        break;
      }
    }
  }
  // Above all lines: one drawn later would hide them.
  for (const mark of marks) {
    if (mark.kind !== "line" || !mark.shape) continue;
    for (const i of mark.shapesAt ?? [])
      if (Number.isFinite(mark.x[i]) && Number.isFinite(mark.y[i])) drawMarker(pen, mark.shape, frame.x(mark.x[i]), frame.y(mark.y[i]), 3, mark.color, mark.alpha ?? 1);
  }
}

/** Whether anything of a mark can be seen. */
function visible(mark: Mark): boolean {
  const some = (values: Numbers) => {
    for (let i = 0; i < values.length; i++) if (Number.isFinite(values[i])) return true;
    return false;
  };
  return mark.kind === "line" || mark.kind === "points" ? some(mark.y) : mark.kind === "band" ? some(mark.low) : true;
}

/** The first mark of every label that stands in the legend: what is not drawn has no place there. */
export function legendMarks(marks: Mark[]): Mark[] {
  const seen = new Set<string>();
  return marks.filter((mark) => {
    if (!mark.label || mark.kind === "rule" || seen.has(mark.label) || !visible(mark)) return false;
    seen.add(mark.label);
    return true;
  });
}

export type Range = [number, number];

function widen(range: Range, values: Numbers, xs?: Numbers, window?: Range, until = Infinity): void {
  for (let i = 0; i < values.length; i++) {
    const v = values[i];
    if (!Number.isFinite(v) || (xs && xs[i] > until)) continue;
    if (xs && window && (xs[i] < window[0] || xs[i] > window[1])) continue;
    if (v < range[0]) range[0] = v;
    if (v > range[1]) range[1] = v;
  }
}

/** What the marks span along x, or along y within a window of x. Infinite if there is nothing. */
export function extent(marks: Mark[], axis: "x" | "y", window?: Range): Range {
  const range: Range = [Infinity, -Infinity];
  for (const mark of marks) {
    if (mark.kind === "end" || mark.lost) continue;
    if (mark.kind === "rule") {
      if (mark.axis === axis) widen(range, [mark.at]);
    } else if (mark.kind === "span") {
      if (axis === "x") widen(range, [mark.from, mark.to]);
    } else if (mark.kind === "text") {
      widen(range, [mark[axis]]);
    } else if (axis === "x") {
      widen(range, mark.x, mark.x, undefined, mark.until);
    } else if (mark.kind === "band") {
      widen(range, mark.low, mark.x, window, mark.until);
      widen(range, mark.high, mark.x, window, mark.until);
    } else {
      widen(range, mark.y, mark.x, window, mark.until);
    }
  }
  return range;
}

/** The value of a line at x, for ascending x; NaN outside. */
export function lineAt(mark: Mark, x: number): number {
  if (mark.kind !== "line" || !mark.x.length) return NaN;
  const { x: xs, y: ys } = mark;
  if (x < xs[0] || x > xs[xs.length - 1]) return NaN;
  const i = indexBefore(xs, x);
  if (mark.step || i + 1 >= xs.length || x === xs[i]) return ys[i];
  return ys[i] + ((x - xs[i]) / (xs[i + 1] - xs[i])) * (ys[i + 1] - ys[i]);
}

/** Rows for a CSV file: [series, x, y] or [series, x, low, high]. */
export function* markRows(marks: Mark[]): Generator<(string | number)[]> {
  for (const mark of marks) {
    const name = mark.label ?? "";
    if (mark.kind === "line" || mark.kind === "points") {
      for (let i = 0; i < mark.x.length; i++) {
        const row = mark.kind === "points" && mark.names ? mark.names[i] : name;
        if (row) yield [row, mark.x[i], mark.y[i]];
      }
    } else if (mark.kind === "band") {
      for (let i = 0; i < mark.x.length; i++) yield [`${name} low`, mark.x[i], mark.low[i]], yield [`${name} high`, mark.x[i], mark.high[i]];
    }
  }
}
