// Building the document, and numbers as people read them.
type Child = Node | string | null | undefined | false;
type Attributes = Record<string, string | number | boolean | ((event: never) => void) | undefined>;

function fill(element: Element, attributes: Attributes, children: Child[]): void {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === false) continue;
    if (typeof value === "function") element.addEventListener(name, value as (event: Event) => void);
    else element.setAttribute(name, value === true ? "" : String(value));
  }
  element.append(...children.filter((child): child is Node | string => Boolean(child)));
}

/** An HTML element with attributes, listeners (functions) and children. Text is always text, never markup. */
export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  fill(element, attributes, children);
  return element;
}

/** The same for SVG. */
export function s<K extends keyof SVGElementTagNameMap>(
  tag: K,
  attributes: Attributes = {},
  ...children: Child[]
): SVGElementTagNameMap[K] {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  fill(element, attributes, children);
  return element;
}

/** Text in which every minus is a true one, whoever wrote it. */
export function trueMinus(text: string): string {
  return text.replace(/(^|[^\p{L}\p{N}_)\]}])-(?=\.?\d)/gu, "$1−");
}

/** 1.5e-7 as people write it: 1.5 × 10⁻⁷. */
function powerOfTen(text: string): string {
  const [mantissa, exponent] = text.split("e");
  return `${mantissa} × 10${exponent.replace("+", "").replace(/[-\d]/g, (c) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)] ?? "⁻")}`.replace("-", "−");
}

/** A number with `digits` significant digits, a true minus, and no noise behind them. */
export function short(value: number | null | undefined, digits = 3): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  // Of the rounded number: 0.0999999 is written as 0.100, like 0.1.
  const size = Math.floor(Math.log10(Math.abs(Number(value.toPrecision(digits)))) + 1e-12);
  if (size >= 6 || size < -4) return powerOfTen(value.toExponential(digits - 1));
  return value.toFixed(Math.max(0, Math.min(8, digits - 1 - size))).replace("-", "−");
}

/** The same without zeros at its end: for texts and ticks, not for values that change before one's eyes. */
export function plain(value: number | null | undefined, digits = 3): string {
  return short(value, digits).replace(/(\.\d*?)0+(?=$| )/, "$1").replace(/\.(?=$| )/, "");
}

/** A number with a fixed count of decimals; what rounds to zero has no sign. */
export function fixed(value: number | null | undefined, decimals: number): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (Math.abs(value) >= 1e7) return powerOfTen(value.toExponential(2));
  const text = value.toFixed(decimals);
  return (Number(text) === 0 ? (0).toFixed(decimals) : text).replace("-", "−");
}

/** How many decimals tell apart about 10^digits values within a span. */
export function decimalsFor(span: number, digits = 3): number {
  return span > 0 && Number.isFinite(span) ? Math.max(0, Math.min(6, digits - 1 - Math.floor(Math.log10(span)))) : digits;
}

/** A share as percent; only what is all of it is called 100 %. */
export function percent(share: number | null | undefined): string {
  if (share === null || share === undefined || !Number.isFinite(share)) return "–";
  if (share >= 1 - 1e-9) return "100 %";
  if (share > 0.9995) return "> 99.9 %";
  return `${fixed(100 * share, share > 0.995 ? 1 : 0)} %`;
}

/** Units as written by hand: m/s2 is m/s². */
export function unitText(unit: string | undefined): string {
  return (unit ?? "").replace(/(?<=[a-z])([23])\b/g, (digit) => (digit === "2" ? "²" : "³"));
}

/** Text of a JSON file, perhaps in lines, with `code` between backticks set as such. */
export function prose(text: string | string[]): (HTMLElement | string)[] {
  const whole = Array.isArray(text) ? text.join(" ") : text;
  const parts = whole.split("`");
  // A backtick without its partner is one that was meant.
  const typeset = (part: string) => trueMinus(part).replace(/(?<=\b(m|rad)\/s)2\b/g, "²");
  if (parts.length % 2 === 0) return [typeset(whole)];
  return parts.map((part, i) => (i % 2 ? h("code", {}, part) : typeset(part)));
}

/** Puts new children in a box; who stood on a control of it with the keyboard stands there still. */
export function redraw(box: HTMLElement, ...children: HTMLElement[]): void {
  const controls = () => [...box.querySelectorAll<HTMLElement>("button, select, a, input, [tabindex]")];
  const at = controls().indexOf(document.activeElement as HTMLElement);
  box.replaceChildren(...children);
  if (at >= 0) controls()[at]?.focus({ preventScroll: true });
}

export function plural(count: number, one: string, many = `${one}s`): string {
  return `${count} ${count === 1 ? one : many}`;
}

/** Hands the reader a file made here. */
export function download(name: string, type: string, text: string): void {
  const url = URL.createObjectURL(new Blob([text], { type: `${type};charset=utf-8` }));
  h("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

/** A cell of a CSV file. */
export function csvCell(value: string | number): string {
  if (typeof value === "number") return Number.isFinite(value) ? String(Number(value.toPrecision(9))) : "";
  return /[",\r\n]/.test(value) ? `"${value.replace(/"/g, '""')}"` : value;
}
