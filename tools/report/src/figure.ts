// The frame around every picture: title, note, readout, and the buttons that hand out the picture and its data.
import { csvCell, download, h } from "./dom";

export interface FigureContent {
  /** File name stem and anchor. */
  id: string;
  title: string;
  note?: string;
  wide?: boolean;
  svg?: () => string;
  rows?: () => Iterable<(string | number)[]>;
}

export interface Figure {
  element: HTMLElement;
  body: HTMLElement;
  readout: HTMLElement;
  /** Choices that change the picture. */
  controls: HTMLElement;
}

export function makeFigure({ id, title, note, wide, svg, rows }: FigureContent): Figure {
  const body = h("div", { class: "figure-body" });
  const readout = h("div", { class: "readout", "aria-live": "off" });
  const controls = h("div", { class: "figure-controls" });
  const tools = h("div", { class: "figure-tools" });
  if (svg)
    tools.append(
      h("button", { type: "button", class: "quiet", title: `Save ${title} as SVG`, click: () => download(`${id}.svg`, "image/svg+xml", svg()) }, "SVG"),
    );
  if (rows)
    tools.append(
      h(
        "button",
        {
          type: "button",
          class: "quiet",
          title: `Save the data of ${title} as CSV`,
          click: () => {
            const lines = [...rows()].map((row) => row.map(csvCell).join(","));
            download(`${id}.csv`, "text/csv", `${lines.join("\n")}\n`);
          },
        },
        "CSV",
      ),
    );
  const element = h(
    "figure",
    { class: wide ? "figure wide" : "figure", id: `figure-${id}` },
    h("figcaption", {}, h("div", { class: "figure-head" }, h("h3", {}, title), tools), note ? h("p", { class: "note" }, note) : null, controls, readout),
    body,
  );
  return { element, body, readout, controls };
}

/** Calls `build` once, when the element comes near the window or `force` is called. */
export class Lazy {
  private static readonly waiting = new Map<Element, () => void>();
  private static readonly watcher = new IntersectionObserver(
    (entries) => {
      for (const entry of entries) if (entry.isIntersecting) Lazy.open(entry.target);
    },
    { rootMargin: "300px" },
  );
  private static open(element: Element): void {
    const build = Lazy.waiting.get(element);
    Lazy.waiting.delete(element);
    Lazy.watcher.unobserve(element);
    build?.();
  }
  static when(element: Element, build: () => void): void {
    Lazy.waiting.set(element, build);
    Lazy.watcher.observe(element);
  }
  /** Builds everything that still waits: before printing, and when the page is idle. */
  static openAll(): void {
    for (const element of [...Lazy.waiting.keys()]) Lazy.open(element);
  }
  /** Builds one thing that still waits; false if there is none. */
  static openOne(): boolean {
    const [element] = Lazy.waiting.keys();
    if (element) Lazy.open(element);
    return Boolean(element);
  }
}
