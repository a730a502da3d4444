// A chart: uPlot draws axes and handles cursor and zoom; the marks are drawn here, the same on screen and in SVG files.
import uPlot from "uplot";
import { decimalsFor, fixed, h, plain, short, unitText } from "./dom";
import { makeFigure, type Figure } from "./figure";
import { extent, legendMarks, lineAt, markRows, paintMarks, type Frame, type Mark, type Range } from "./marks";
import { CanvasPen, drawMarker, fontFamily, SvgPen } from "./pen";
import type { State } from "./state";
import { axisTitle, chartSvg, tickTexts } from "./svgchart";
import { token } from "./theme";

export interface AxisSpec {
  label: string;
  unit?: string;
  log?: boolean;
  /** Values that must be within the range. */
  include?: number[];
  /** Exactly this range. */
  fixed?: Range;
  /** Where the ticks are. */
  splits?: number[];
  /** Text of a tick. */
  tick?: (value: number) => string;
  /** Digits in readouts. */
  digits?: number;
  /** Decimals in readouts, where the span of the values shall not decide. */
  decimals?: number;
}

export interface ChartSpec {
  id: string;
  title: string;
  note?: string;
  height?: number;
  wide?: boolean;
  x: AxisSpec;
  y: AxisSpec;
  /** x is the replay's time: the cursor is shared and moves the cars. */
  time?: boolean;
  /** One unit is equally long on both axes, around the origin. */
  square?: boolean;
  /** Lines of all stacks lie over one another: where they are many, one is in colour. */
  overlay?: boolean;
  /** No legend for named points: their names stand beside them. */
  bare?: boolean;
  /** Called again whenever the reader's choice changes. */
  marks: () => Mark[];
}

const charts = new Map<Element, Chart>();

/** Charts out of sight are redrawn when they come into it. */
const sight = new IntersectionObserver(
  (entries) => {
    for (const { target, isIntersecting } of entries) charts.get(target)?.setSeen(isIntersecting);
  },
  { rootMargin: "200px" },
);

/** Redraws every chart with fresh marks and colours; `all` whether anybody sees them or not. */
export function refreshCharts(all = false): void {
  for (const chart of charts.values()) chart.refresh(all);
}
/** What a chart shows on both axes, by the name of its figure; for tests. */
export function chartRange(id: string): { x: Range; y: Range } | null {
  for (const chart of charts.values()) if (chart.spec.id === id) return chart.range();
  return null;
}
/** Redraws for another emphasis. */
export function repaintCharts(): void {
  for (const chart of charts.values()) chart.repaint();
}

/** A sample of a mark for the legend: lines dashed or dotted as drawn, markers in their shape. */
function legendKey(mark: Mark): SVGElement {
  const [width, height] = [mark.kind === "points" ? 12 : 20, 12];
  const pen = new SvgPen(width, height, "none");
  if (mark.kind === "points") drawMarker(pen, mark.shape ?? "circle", 6, 6, 4, mark.color);
  else pen.line([0, 6, width, 6], { color: mark.color, width: mark.kind === "line" ? 2.4 : 8, dash: mark.kind === "line" ? mark.dash : undefined, alpha: mark.kind === "line" ? 1 : 0.4 });
  if (mark.kind === "line" && mark.shape && mark.shapesAt?.length) drawMarker(pen, mark.shape, 10, 6, 3, mark.color);
  return pen.element("key-mark");
}

export class Chart {
  readonly figure: Figure;
  private plot?: uPlot;
  private observer?: ResizeObserver;
  private marks: Mark[] = [];
  private full: Range = [0, 1];
  private window: Range = [0, 1];
  /** What all values span: all readouts of the chart have the same decimals. */
  private reach: Range = [0, 1];
  private now?: HTMLElement;
  private readonly values = new Map<Mark, HTMLElement>();
  private readonly tip = h("div", { class: "tip", hidden: true });
  private lastReadout = 0;
  private seen = true;
  private stale: "" | "paint" | "marks" = "";

  constructor(
    readonly spec: ChartSpec,
    private readonly state: State,
  ) {
    this.figure = makeFigure({
      ...spec,
      svg: () => this.svg(),
      rows: () => this.rows(),
    });
    this.figure.body.style.minHeight = `${spec.height ?? 220}px`;
    charts.set(this.figure.element, this);
    sight.observe(this.figure.element);
    if (spec.time) state.clock.moved.on(() => this.follow());
  }

  /** Draws for the first time; the figure must be in the document. */
  build(): this {
    this.marks = this.spec.marks();
    this.full = this.xRange();
    this.reach = extent(this.marks, "y");
    this.plot = this.makePlot();
    this.fillReadout();
    if (!this.observer) {
      // In the next frame: a figure that grows while sizes are being told would have to be told again.
      this.observer = new ResizeObserver(() => requestAnimationFrame(() => this.resize()));
      this.observer.observe(this.figure.body);
    }
    this.follow();
    return this;
  }
  setSeen(seen: boolean): void {
    this.seen = seen;
    if (!seen) return;
    if (this.stale === "marks") this.refresh();
    else if (this.stale === "paint") this.repaint();
  }
  refresh(all = false): void {
    if (!this.plot) return;
    if (!this.seen && !all) {
      this.stale = "marks";
      return;
    }
    this.stale = "";
    const { scales } = this.plot;
    const zoomed = scales.x.min! > this.full[0] || scales.x.max! < this.full[1];
    const kept: Range = [scales.x.min!, scales.x.max!];
    this.plot.destroy();
    this.build();
    if (zoomed) this.plot.setScale("x", { min: kept[0], max: kept[1] });
  }
  repaint(): void {
    if (!this.seen) {
      this.stale ||= "paint";
      return;
    }
    this.stale = "";
    this.plot?.redraw(false, false);
  }

  private size(): { width: number; height: number } {
    const width = Math.max(160, this.figure.body.clientWidth);
    return { width, height: this.spec.square ? Math.min(width - 6, 420) : (this.spec.height ?? 220) };
  }
  private resize(): void {
    const size = this.size();
    if (this.plot && (size.width !== this.plot.width || size.height !== this.plot.height)) {
      this.plot.setSize(size);
      this.follow();
    }
  }

  /** The stack that is drawn in colour alone, if one is. */
  private get lit(): number | null {
    return this.spec.overlay ? this.state.lit : this.state.hot;
  }
  private xRange(): Range {
    const { x, square } = this.spec;
    if (x.fixed) return x.fixed;
    let [low, high] = extent(this.marks, "x");
    if (this.spec.time && this.state.shownEnd > low) high = Math.min(high, this.state.shownEnd);
    if (square && low <= high) {
      const reach = Math.max(-low, high);
      return [-reach, reach];
    }
    for (const v of x.include ?? []) [low, high] = [Math.min(low, v), Math.max(high, v)];
    if (!(low <= high)) return x.log ? [0.1, 10] : [0, 1];
    if (x.log) return [low / 1.25, high * 1.25];
    const pad = this.spec.time || x.tick ? 0 : (high - low) * 0.04;
    return low === high ? [low - 0.5, high + 0.5] : [low - pad, high + pad];
  }
  private yRange(): Range {
    const { y } = this.spec;
    if (y.fixed) return y.fixed;
    let [low, high] = extent(this.marks, "y", this.window);
    for (const v of y.include ?? []) [low, high] = [Math.min(low, v), Math.max(high, v)];
    if (!(low <= high)) return y.log ? [0.1, 10] : [0, 1];
    if (y.log) return [Math.max(low, 1e-12) / 1.4, Math.max(high, 1e-12) * 1.4];
    const pad = (high - low) * 0.08 || Math.max(Math.abs(high) * 0.1, 0.1);
    return [low >= 0 ? Math.max(0, low - pad) : low - pad, high + pad];
  }

  private makePlot(): uPlot {
    const { x, y, time, square } = this.spec;
    const axis = (spec: AxisSpec, size: uPlot.Axis["size"], space: number): uPlot.Axis => ({
      stroke: token("muted"),
      font: `11px ${fontFamily}`,
      size,
      space,
      gap: 4,
      grid: { stroke: token("grid"), width: 1 },
      ticks: { show: false },
      border: { show: false },
      values: (_, splits) => tickTexts(splits, spec),
      ...(spec.splits ? { splits: spec.splits } : {}),
      // One, two and five of each power of ten.
      ...(spec.log ? { filter: (_u: uPlot, splits: number[]) => splits.map((v) => (/^[125]/.test(v.toExponential(3)) && /^.\.000/.test(v.toExponential(3)) ? v : null)) } : {}),
    });
    const options: uPlot.Options = {
      ...this.size(),
      pxAlign: false,
      legend: { show: false },
      cursor: {
        y: !time,
        points: { show: false },
        drag: { x: true, y: false, setScale: true, dist: 6 },
        ...(time ? { sync: { key: "time", scales: ["x", null] as [string, null], setSeries: false } } : {}),
      },
      scales: {
        x: { time: false, distr: x.log ? 3 : 1, range: (_, low, high) => (this.window = [low, high]) },
        y: { distr: y.log ? 3 : 1, range: () => (square ? this.squareRange() : this.yRange()) },
      },
      axes: [{ ...axis(x, 24, 60), ...(x.label ? { label: axisTitle(x), labelSize: 18, labelGap: 0, labelFont: `11px ${fontFamily}` } : {}) }, axis(y, (_, texts) => Math.max(46, 10 + 6.4 * Math.max(0, ...(texts ?? []).map((text) => text.length))), 34)],
      series: [{}, { show: false }],
      padding: [8, 10, 0, 0],
      hooks: { draw: [(u) => this.paint(u)], setCursor: [(u) => this.hover(u)] },
    };
    this.figure.body.replaceChildren(h("div", { class: "axis-title" }, axisTitle(y)));
    const plot = new uPlot(options, [this.full, [null, null]], this.figure.body);
    plot.root.setAttribute("aria-hidden", "true");
    plot.over.append(this.tip);
    if (time) this.bindClock(plot);
    plot.over.addEventListener("mouseleave", () => this.leave());
    return plot;
  }
  private squareRange(): Range {
    const { width, height } = this.size();
    const reach = ((this.window[1] - this.window[0]) / 2) * ((height - 50) / (width - 56));
    return [-reach, reach];
  }

  private bindClock(plot: uPlot): void {
    this.now = h("div", { class: "now" });
    plot.over.append(this.now);
    const { clock } = this.state;
    const seek = (event: MouseEvent) => clock.seek(plot.posToVal(event.offsetX, "x"));
    plot.over.addEventListener("mousemove", (event) => {
      if (!clock.playing && event.buttons === 0 && event.target === plot.over) seek(event);
    });
    plot.over.addEventListener("click", (event) => {
      if (event.target === plot.over && plot.select.width < 6) seek(event);
    });
  }

  private frame(u: uPlot, pixels: boolean): Frame {
    const box = u.bbox;
    const ratio = pixels ? 1 : 1 / devicePixelRatio;
    return {
      x: (v) => u.valToPos(v, "x", pixels),
      y: (v) => u.valToPos(v, "y", pixels),
      left: box.left * ratio,
      top: box.top * ratio,
      width: box.width * ratio,
      height: box.height * ratio,
    };
  }
  private paint(u: uPlot): void {
    const { ctx } = u;
    const ratio = devicePixelRatio;
    const frame = this.frame(u, true);
    ctx.save();
    ctx.beginPath();
    // Marks on an axis are drawn whole.
    ctx.rect(frame.left - 2 * ratio, frame.top - 8 * ratio, frame.width + 8 * ratio, frame.height + 16 * ratio);
    ctx.clip();
    ctx.scale(ratio, ratio);
    const scaled: Frame = {
      x: (v) => frame.x(v) / ratio,
      y: (v) => frame.y(v) / ratio,
      left: frame.left / ratio,
      top: frame.top / ratio,
      width: frame.width / ratio,
      height: frame.height / ratio,
    };
    paintMarks(new CanvasPen(ctx), scaled, this.marks, this.lit, token("muted"), token("quiet"));
    ctx.restore();
  }

  private fillReadout(): void {
    const { readout } = this.figure;
    readout.replaceChildren();
    this.values.clear();
    for (const mark of legendMarks(this.marks)) {
      // Points with names speak for themselves.
      if (mark.kind === "points" && mark.names && this.spec.bare) continue;
      const value = this.reads(mark) ? h("b", {}, "") : null;
      const { stack } = mark;
      const hover = { mouseenter: () => this.state.hover(stack ?? null), mouseleave: () => this.state.hover(null) };
      const parts = [legendKey(mark), mark.label!, value];
      readout.append(
        this.spec.overlay && stack !== undefined && this.state.crowded && mark.label === this.state.report.label(stack)
          ? h("button", { type: "button", class: "key", "aria-pressed": String(this.state.lit === stack), title: "Show this one in colour", click: () => this.state.setFocus(stack), ...hover }, ...parts)
          : h("span", { class: "key", ...hover }, ...parts),
      );
      if (value) this.values.set(mark, value);
    }
  }
  /** Whether the mark has one value at each x that is worth reading off. */
  private reads(mark: Mark): boolean {
    return mark.kind === "line" && !mark.step && !this.spec.square && mark.x.length > 2;
  }
  private showValues(x: number | null): void {
    const { log, digits = 3, decimals = decimalsFor(this.reach[1] - this.reach[0], digits) } = this.spec.y;
    for (const [mark, element] of this.values) {
      const v = x === null ? NaN : lineAt(mark, x);
      element.textContent = Number.isFinite(v) ? (log ? short(v, digits) : fixed(v, decimals)) : "";
    }
  }

  private follow(): void {
    const { plot, now } = this;
    if (!plot || !now) return;
    const { t } = this.state.clock;
    now.style.transform = `translateX(${plot.valToPos(t, "x")}px)`;
    now.hidden = t < plot.scales.x.min! || t > plot.scales.x.max!;
    const time = performance.now();
    if (this.state.clock.playing && time - this.lastReadout < 120) return;
    this.lastReadout = time;
    this.showValues(t);
  }
  private hover(u: uPlot): void {
    const { left, top } = u.cursor;
    if (left === undefined || left < 0 || top === undefined || top < 0) return;
    if (!this.spec.time) this.showValues(u.posToVal(left, "x"));
    this.showTip(u, left, top);
  }
  private leave(): void {
    if (!this.spec.time) this.showValues(null);
    this.tip.hidden = true;
  }
  /** The name of the nearest named point. */
  private showTip(u: uPlot, left: number, top: number): void {
    let nearest = 24;
    let text = "";
    for (const mark of this.marks) {
      if (mark.kind !== "points" || !mark.names) continue;
      for (let i = 0; i < mark.x.length; i++) {
        const distance = Math.hypot(u.valToPos(mark.x[i], "x") - left, u.valToPos(mark.y[i], "y") - top);
        if (distance < nearest) {
          nearest = distance;
          const { x, y } = this.spec;
          text = `${mark.names[i]}: ${plain(mark.x[i], x.digits)} ${unitText(x.unit)}, ${plain(mark.y[i], y.digits)} ${unitText(y.unit)}`;
        }
      }
    }
    this.tip.hidden = !text;
    this.tip.textContent = text;
    this.tip.style.transform = `translate(${Math.min(left + 12, u.over.clientWidth - 160)}px, ${Math.max(0, top - 28)}px)`;
  }

  range(): { x: Range; y: Range } | null {
    const scales = this.plot?.scales;
    return scales ? { x: [scales.x.min!, scales.x.max!], y: [scales.y.min!, scales.y.max!] } : null;
  }
  private svg(): string {
    const marks = this.plot ? this.marks : this.spec.marks();
    const scales = this.plot?.scales;
    return chartSvg({
      title: this.spec.title,
      x: this.spec.x,
      y: this.spec.y,
      xRange: scales ? [scales.x.min!, scales.x.max!] : this.full,
      yRange: scales ? [scales.y.min!, scales.y.max!] : this.yRange(),
      marks,
      lit: this.lit,
      width: this.spec.square ? 480 : 760,
      height: this.spec.square ? 480 : 360,
    });
  }
  private *rows(): Generator<(string | number)[]> {
    yield ["series", `${this.spec.x.label} [${this.spec.x.unit ?? "1"}]`, `${this.spec.y.label} [${this.spec.y.unit ?? "1"}]`];
    yield* markRows(this.plot ? this.marks : this.spec.marks());
  }
}
