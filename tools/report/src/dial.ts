// The friction dial: the estimate, its standard deviation, and the truth.
import { h, s, short } from "./dom";

const full = 1.2;
const sweep = 220;

function at(value: number, radius: number): [number, number] {
  const angle = ((-90 - sweep / 2 + (sweep * Math.min(Math.max(value, 0), full)) / full) * Math.PI) / 180;
  return [100 + radius * Math.cos(angle), 92 + radius * Math.sin(angle)];
}
function arc(from: number, to: number, radius: number): string {
  const [a, b] = [at(from, radius), at(to, radius)];
  const large = ((to - from) / full) * sweep > 180 ? 1 : 0;
  return `M${a[0].toFixed(2)} ${a[1].toFixed(2)}A${radius} ${radius} 0 ${large} 1 ${b[0].toFixed(2)} ${b[1].toFixed(2)}`;
}

export class Dial {
  readonly element: HTMLElement;
  private readonly band = s("path", { class: "dial-band" });
  private readonly needle = s("line", { class: "dial-needle" });
  private readonly truth = s("path", { class: "dial-truth" });
  private readonly number = s("text", { class: "dial-number", x: 100, y: 96, "text-anchor": "middle" });
  private readonly caption = s("text", { class: "dial-caption", x: 100, y: 114, "text-anchor": "middle" });

  constructor() {
    const ticks = [0, 0.2, 0.4, 0.6, 0.8, 1, 1.2].flatMap((value) => {
      const [outer, inner, text] = [at(value, 82), at(value, 77), at(value, 60)];
      return [
        s("line", { class: "dial-tick", x1: outer[0], y1: outer[1], x2: inner[0], y2: inner[1] }),
        s("text", { class: "dial-label", x: text[0], y: text[1] + 3, "text-anchor": "middle" }, value.toFixed(1)),
      ];
    });
    const picture = s(
      "svg",
      { viewBox: "0 0 200 132", role: "img", "aria-label": "Friction, estimated and true" },
      s("path", { class: "dial-arc", d: arc(0, full, 82) }),
      this.band,
      ...ticks,
      this.truth,
      this.needle,
      this.number,
      this.caption,
    );
    this.element = h("div", { class: "dial" }, picture);
  }

  show(belief: number, sigma: number, truth: number, color: string): void {
    this.element.style.setProperty("--c", color);
    const known = Number.isFinite(belief);
    const [from, to] = [at(belief, 75), at(belief, 93)];
    this.needle.setAttribute("visibility", known ? "visible" : "hidden");
    if (known) for (const [name, value] of Object.entries({ x1: from[0], y1: from[1], x2: to[0], y2: to[1] })) this.needle.setAttribute(name, value.toFixed(2));
    this.band.setAttribute("d", known && sigma > 0 ? arc(Math.max(0, belief - sigma), Math.min(full, belief + sigma), 82) : "");
    if (Number.isFinite(truth)) {
      const angle = (Math.min(truth, full) / full) * sweep - sweep / 2;
      this.truth.setAttribute("d", "M100 4L94 -6L106 -6Z");
      this.truth.setAttribute("transform", `rotate(${angle.toFixed(2)} 100 92) translate(0 4)`);
    }
    this.number.textContent = known ? `µ ${short(belief, 3)}` : "µ –";
    this.caption.textContent = Number.isFinite(truth) ? `true ${short(truth, 3)}` : "";
  }
}
