// A chart as an SVG file: the same marks, with axes drawn here.
import type { AxisSpec } from "./chart";
import { fixed, plain, unitText } from "./dom";
import { legendMarks, paintMarks, type Frame, type Mark, type Range } from "./marks";
import { drawMarker, SvgPen } from "./pen";
import { token } from "./theme";

/** Round numbers within a range, about `count` of them; powers of ten on a logarithmic axis. */
export function ticks([low, high]: Range, count: number, log = false): number[] {
  if (!(high > low)) return [low];
  if (log) {
    const out: number[] = [];
    for (let e = Math.ceil(Math.log10(low) - 1e-9); e <= Math.log10(high) + 1e-9; e++) out.push(10 ** e);
    return out;
  }
  const rough = (high - low) / Math.max(1, count);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * (rough / power < 1.5 ? 1 : rough / power < 3.5 ? 2 : rough / power < 7.5 ? 5 : 10);
  const out: number[] = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) out.push(i * step);
  return out;
}

/** Texts of ticks with as many decimals as the one that needs most; on a logarithmic axis each for itself. */
export function tickTexts(values: (number | null)[], axis: AxisSpec): string[] {
  const texts = values.map((v) => (v === null ? "" : (axis.tick?.(v) ?? plain(v, 6))));
  if (axis.tick || axis.log || texts.some((text) => text.includes("×"))) return texts;
  const decimals = Math.max(0, ...texts.map((text) => (text.split(".")[1] ?? "").length));
  return values.map((v) => (v === null ? "" : fixed(v, decimals)));
}

function scale([low, high]: Range, from: number, to: number, log?: boolean): (v: number) => number {
  const map = log ? Math.log10 : (v: number) => v;
  const [a, b] = [map(low), map(high)];
  return (v) => from + ((map(v) - a) / (b - a)) * (to - from);
}

export function axisTitle(axis: AxisSpec): string {
  return axis.unit ? `${axis.label} [${unitText(axis.unit)}]` : axis.label;
}

export interface SvgChart {
  title: string;
  x: AxisSpec;
  y: AxisSpec;
  xRange: Range;
  yRange: Range;
  marks: Mark[];
  /** The stack in colour; null: all are. */
  lit: number | null;
  width: number;
  height: number;
}

export function chartSvg({ title, x, y, xRange, yRange, marks, lit, width, height }: SvgChart): string {
  const named = legendMarks(marks);
  const [left, right] = [62, 16];
  // The legend breaks its lines before the picture ends.
  const places: [number, number][] = [];
  let [at, line] = [left, 0];
  for (const mark of named) {
    const wide = 44 + mark.label!.length * 6.4;
    if (at > left && at + wide - 20 > width - right) [at, line] = [left, line + 1];
    places.push([at, 38 + 18 * line]);
    at += wide;
  }
  const legendHeight = named.length ? 22 + 18 * line : 0;
  const pen = new SvgPen(width, height, token("surface"), title.replace(/[^A-Za-z0-9]/g, ""));
  const [top, bottom] = [34 + legendHeight, 46];
  const [plotWidth, plotHeight] = [width - left - right, height - top - bottom];
  const frame: Frame = {
    x: scale(xRange, left, left + plotWidth, x.log),
    y: scale(yRange, top + plotHeight, top, y.log),
    left,
    top,
    width: plotWidth,
    height: plotHeight,
  };
  const [ink, muted, grid] = [token("ink"), token("muted"), token("grid")];
  const xTicks = x.splits ?? ticks(xRange, plotWidth / 90, x.log);
  const xTexts = tickTexts(xTicks, x);
  xTicks.forEach((v, i) => {
    pen.line([frame.x(v), top, frame.x(v), top + plotHeight], { color: grid, width: 1 });
    pen.text(frame.x(v), top + plotHeight + 14, xTexts[i], { color: muted, align: "center" });
  });
  const yTicks = ticks(yRange, plotHeight / 45, y.log);
  const yTexts = tickTexts(yTicks, y);
  yTicks.forEach((v, i) => {
    pen.line([left, frame.y(v), left + plotWidth, frame.y(v)], { color: grid, width: 1 });
    pen.text(left - 8, frame.y(v), yTexts[i], { color: muted, align: "right" });
  });
  pen.clipped(left - 2, top - 8, plotWidth + 8, plotHeight + 16, () => paintMarks(pen, frame, marks, lit, muted, token("quiet")));
  pen.text(left, 16, title, { color: ink, size: 14, weight: 600 });
  named.forEach((mark, i) => {
    const [x0, y0] = places[i];
    if (mark.kind === "points") drawMarker(pen, mark.shape ?? "circle", x0 + 9, y0, 4, mark.color);
    else pen.line([x0, y0, x0 + 18, y0], { color: mark.color, width: 2.5, dash: mark.kind === "line" ? mark.dash : undefined });
    if (mark.kind === "line" && mark.shape && mark.shapesAt?.length) drawMarker(pen, mark.shape, x0 + 9, y0, 3, mark.color);
    pen.text(x0 + 24, y0, mark.label!, { color: ink });
  });
  pen.text(left + plotWidth / 2, height - 12, axisTitle(x), { color: muted, align: "center" });
  pen.text(left, top - 12, axisTitle(y), { color: muted });
  return pen.toString();
}
