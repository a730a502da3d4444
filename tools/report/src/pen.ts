// One way of drawing for the screen and for SVG files. Coordinates are pixels, y down; points are [x, y, x, y, ...].
import type { Shape } from "./theme";

export interface Stroke {
  color: string;
  width?: number;
  dash?: number[];
  alpha?: number;
}

export interface TextStyle {
  color: string;
  size?: number;
  align?: "left" | "center" | "right";
  weight?: number;
}

export interface Pen {
  line(points: number[], stroke: Stroke, closed?: boolean): void;
  area(points: number[], color: string, alpha?: number): void;
  /** The area between two closed curves. */
  ring(outer: number[], inner: number[], color: string, alpha?: number): void;
  disc(x: number, y: number, radius: number, color: string, alpha?: number): void;
  text(x: number, y: number, text: string, style: TextStyle): void;
}

export const fontFamily =
  'system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", "Noto Sans", "Liberation Sans", Arial, sans-serif';

export class CanvasPen implements Pen {
  constructor(private readonly ctx: CanvasRenderingContext2D) {}

  private trace(points: number[], closed: boolean): void {
    const { ctx } = this;
    for (let i = 0; i < points.length; i += 2) {
      if (i === 0) ctx.moveTo(points[0], points[1]);
      else ctx.lineTo(points[i], points[i + 1]);
    }
    if (closed) ctx.closePath();
  }
  line(points: number[], { color, width = 1.5, dash = [], alpha = 1 }: Stroke, closed = false): void {
    const { ctx } = this;
    ctx.globalAlpha = alpha;
    ctx.strokeStyle = color;
    ctx.lineWidth = width;
    ctx.lineJoin = "round";
    ctx.setLineDash(dash);
    ctx.beginPath();
    this.trace(points, closed);
    ctx.stroke();
    ctx.setLineDash([]);
    ctx.globalAlpha = 1;
  }
  area(points: number[], color: string, alpha = 1): void {
    const { ctx } = this;
    ctx.globalAlpha = alpha;
    ctx.fillStyle = color;
    ctx.beginPath();
    this.trace(points, true);
    ctx.fill();
    ctx.globalAlpha = 1;
  }
  ring(outer: number[], inner: number[], color: string, alpha = 1): void {
    const { ctx } = this;
    ctx.globalAlpha = alpha;
    ctx.fillStyle = color;
    ctx.beginPath();
    this.trace(outer, true);
    this.trace(inner, true);
    ctx.fill("evenodd");
    ctx.globalAlpha = 1;
  }
  disc(x: number, y: number, radius: number, color: string, alpha = 1): void {
    const { ctx } = this;
    ctx.globalAlpha = alpha;
    ctx.fillStyle = color;
    ctx.beginPath();
    ctx.arc(x, y, radius, 0, 2 * Math.PI);
    ctx.fill();
    ctx.globalAlpha = 1;
  }
  text(x: number, y: number, text: string, { color, size = 11, align = "left", weight = 400 }: TextStyle): void {
    const { ctx } = this;
    ctx.fillStyle = color;
    ctx.font = `${weight} ${size}px ${fontFamily}`;
    ctx.textAlign = align;
    ctx.textBaseline = "middle";
    ctx.fillText(text, x, y);
  }
}

export function escapeXml(text: string): string {
  return text.replace(/[&<>"']/g, (c) => `&#${c.charCodeAt(0)};`);
}

/** Writes an SVG document. */
export class SvgPen implements Pen {
  private readonly parts: string[] = [];
  constructor(
    readonly width: number,
    readonly height: number,
    paper: string,
    private readonly name = "",
  ) {
    this.parts.push(`<rect width="${width}" height="${height}" fill="${paper}"/>`);
  }
  private static path(points: number[], closed: boolean): string {
    let d = "";
    for (let i = 0; i < points.length; i += 2) d += `${i ? "L" : "M"}${+points[i].toFixed(2)} ${+points[i + 1].toFixed(2)}`;
    return closed ? `${d}Z` : d;
  }
  private static alpha(alpha: number): string {
    return alpha < 1 ? ` opacity="${+alpha.toFixed(3)}"` : "";
  }
  line(points: number[], { color, width = 1.5, dash, alpha = 1 }: Stroke, closed = false): void {
    const dashes = dash?.length ? ` stroke-dasharray="${dash.join(" ")}"` : "";
    this.parts.push(
      `<path d="${SvgPen.path(points, closed)}" fill="none" stroke="${color}" stroke-width="${width}" ` +
        `stroke-linejoin="round"${dashes}${SvgPen.alpha(alpha)}/>`,
    );
  }
  area(points: number[], color: string, alpha = 1): void {
    this.parts.push(`<path d="${SvgPen.path(points, true)}" fill="${color}"${SvgPen.alpha(alpha)}/>`);
  }
  ring(outer: number[], inner: number[], color: string, alpha = 1): void {
    const d = SvgPen.path(outer, true) + SvgPen.path(inner, true);
    this.parts.push(`<path d="${d}" fill="${color}" fill-rule="evenodd"${SvgPen.alpha(alpha)}/>`);
  }
  disc(x: number, y: number, radius: number, color: string, alpha = 1): void {
    const at = `cx="${+x.toFixed(2)}" cy="${+y.toFixed(2)}" r="${radius}"`;
    this.parts.push(`<circle ${at} fill="${color}"${SvgPen.alpha(alpha)}/>`);
  }
  text(x: number, y: number, text: string, { color, size = 11, align = "left", weight = 400 }: TextStyle): void {
    const anchor = { left: "start", center: "middle", right: "end" }[align];
    this.parts.push(
      `<text x="${+x.toFixed(2)}" y="${+y.toFixed(2)}" fill="${color}" font-size="${size}" font-weight="${weight}" ` +
        `text-anchor="${anchor}" dominant-baseline="central">${escapeXml(text)}</text>`,
    );
  }
  /** Everything drawn by `draw` is cut off outside the rectangle. */
  clipped(x: number, y: number, width: number, height: number, draw: () => void): void {
    // A name of its own: several figures may stand in one page.
    const id = `clip-${this.name}-${this.parts.length}`;
    this.parts.push(`<clipPath id="${id}"><rect x="${x}" y="${y}" width="${width}" height="${height}"/></clipPath>`);
    this.parts.push(`<g clip-path="url(#${id})">`);
    draw();
    this.parts.push("</g>");
  }
  /** As a part of the page. */
  element(className: string): SVGElement {
    const { documentElement } = new DOMParser().parseFromString(this.toString().replace(/\n/g, ""), "image/svg+xml");
    documentElement.setAttribute("class", className);
    documentElement.setAttribute("aria-hidden", "true");
    return document.importNode(documentElement, true) as unknown as SVGElement;
  }
  toString(): string {
    return (
      `<svg xmlns="http://www.w3.org/2000/svg" width="${this.width}" height="${this.height}" ` +
      `viewBox="0 0 ${this.width} ${this.height}" font-family="${escapeXml(fontFamily)}">\n${this.parts.join("\n")}\n</svg>\n`
    );
  }
}

/** A marker of a given half size; the shape alone tells stacks apart. */
export function drawMarker(pen: Pen, shape: Shape, x: number, y: number, r: number, color: string, alpha = 1): void {
  const polygon = (corners: number, turn: number, radius: number, inner = radius) =>
    Array.from({ length: corners }, (_, i) => {
      const a = turn + (2 * Math.PI * i) / corners;
      const length = i % 2 ? inner : radius;
      return [x + length * Math.sin(a), y - length * Math.cos(a)];
    }).flat();
  const stroke = { color, width: Math.max(1.5, r * 0.55), alpha };
  switch (shape) {
    case "circle":
      return pen.disc(x, y, r, color, alpha);
    case "square":
      return pen.area(polygon(4, Math.PI / 4, r * 1.25), color, alpha);
    case "triangle":
      return pen.area(polygon(3, 0, r * 1.35), color, alpha);
    case "diamond":
      return pen.area(polygon(4, 0, r * 1.35), color, alpha);
    case "star":
      return pen.area(polygon(10, 0, r * 1.5, r * 0.65), color, alpha);
    case "wedge":
      return pen.area(polygon(3, Math.PI, r * 1.35), color, alpha);
    case "ring":
      return pen.line(polygon(20, 0, r), stroke, true);
    case "bar":
      return pen.line([x - r * 1.2, y, x + r * 1.2, y], { ...stroke, width: r });
    case "plus":
      pen.line([x - r, y, x + r, y], stroke);
      return pen.line([x, y - r, x, y + r], stroke);
    case "cross":
      pen.line([x - r, y - r, x + r, y + r], stroke);
      return pen.line([x - r, y + r, x + r, y - r], stroke);
  }
}
