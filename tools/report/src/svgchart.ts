// A chart as an SVG file: the same marks, with axes drawn here.
import type { AxisSpec } from "./chart";
import { plain } from "./dom";
import { paintMarks, type Frame, type Mark, type Range } from "./marks";
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

function scale([low, high]: Range, from: number, to: number, log?: boolean): (v: number) => number {
  const map = log ? Math.log10 : (v: number) => v;
  const [a, b] = [map(low), map(high)];
  return (v) => from + ((map(v) - a) / (b - a)) * (to - from);
}

export function axisTitle(axis: AxisSpec): string {
  return axis.unit ? `${axis.label} [${axis.unit}]` : axis.label;
}

export interface SvgChart {
  title: string;
  x: AxisSpec;
  y: AxisSpec;
  xRange: Range;
  yRange: Range;
  marks: Mark[];
  width: number;
  height: number;
}

export function chartSvg({ title, x, y, xRange, yRange, marks, width, height }: SvgChart): string {
  const named = marks.filter((mark, i) => mark.label && mark.kind !== "rule" && marks.findIndex((m) => m.label === mark.label) === i);
  const legendHeight = named.length ? 22 : 0;
  const pen = new SvgPen(width, height, token("surface"));
  const [left, right, top, bottom] = [62, 16, 34 + legendHeight, 46];
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
  for (const v of ticks(xRange, plotWidth / 90, x.log)) {
    pen.line([frame.x(v), top, frame.x(v), top + plotHeight], { color: grid, width: 1 });
    pen.text(frame.x(v), top + plotHeight + 14, x.tick?.(v) ?? plain(v, 6), { color: muted, align: "center" });
  }
  for (const v of ticks(yRange, plotHeight / 45, y.log)) {
    pen.line([left, frame.y(v), left + plotWidth, frame.y(v)], { color: grid, width: 1 });
    pen.text(left - 8, frame.y(v), y.tick?.(v) ?? plain(v, 6), { color: muted, align: "right" });
  }
  pen.clipped(left, top - 4, plotWidth, plotHeight + 8, () => paintMarks(pen, frame, marks, null, muted));
  pen.text(left, 16, title, { color: ink, size: 14, weight: 600 });
  let at = left;
  for (const mark of named) {
    if (mark.kind === "points") drawMarker(pen, mark.shape ?? "circle", at + 9, 38, 4, mark.color);
    else pen.line([at, 38, at + 18, 38], { color: mark.color, width: 2.5, dash: mark.kind === "line" ? mark.dash : undefined });
    pen.text(at + 24, 38, mark.label!, { color: ink });
    at += 44 + mark.label!.length * 6.4;
  }
  pen.text(left + plotWidth / 2, height - 12, axisTitle(x), { color: muted, align: "center" });
  pen.text(left, top - 12, axisTitle(y), { color: muted });
  return pen.toString();
}
