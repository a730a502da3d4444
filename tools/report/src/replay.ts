// The replay: all cars on one track, driven by the clock that the time charts share.
import { Camera } from "./camera";
import { Dial } from "./dial";
import { fixed, h, redraw, s } from "./dom";
import { Course, intervals, laps } from "./mapview";
import { carDimensions, Stage, type Layers } from "./stage";
import type { State } from "./state";
import { swatch } from "./swatch";
import { onThemeChange, stackColour } from "./theme";

const rates = [0.1, 0.25, 0.5, 1, 2, 4];

const icons: Record<string, string> = {
  play: "M5 3.5v13l11-6.5z",
  pause: "M5 3.5h3.5v13H5zM11.5 3.5H15v13h-3.5z",
  fit: "M3 7V3h4M13 3h4v4M17 13v4h-4M7 17H3v-4",
  plus: "M10 4v12M4 10h12",
  minus: "M4 10h12",
};
function icon(name: string): SVGElement {
  const filled = name === "play" || name === "pause";
  return s("svg", { viewBox: "0 0 20 20", class: filled ? "icon filled" : "icon", "aria-hidden": "true" }, s("path", { d: icons[name] }));
}

/** A small picture of something the replay draws. */
function symbol(name: string): SVGElement {
  const shapes: Record<string, SVGElement[]> = {
    plan: [s("path", { d: "M2 8H26", class: "stroke own" }), ...[8, 17, 26].map((x) => s("circle", { cx: x, cy: 8, r: 2.4, class: "fill own" }))],
    reference: [8, 17, 26].map((x) => s("circle", { cx: x, cy: 8, r: 3.2, class: "stroke" })),
    force: [s("circle", { cx: 10, cy: 8, r: 7, class: "stroke dash" }), s("path", { d: "M10 8H20", class: "stroke bold" }), s("path", { d: "M26 8L18.5 4.4V11.6Z", class: "fill" })],
    outside: [s("circle", { cx: 14, cy: 8, r: 6, class: "stroke alarm-stroke" })],
  };
  return s("svg", { viewBox: "0 0 30 16", "aria-hidden": "true" }, ...shapes[name]);
}

export class Replay {
  readonly element: HTMLElement;
  readonly canvas = h("canvas", { tabindex: 0, role: "img", "aria-label": "Cars on the track. Space plays, arrow keys step, F follows a car." });
  private readonly shownTime = h("span", { class: "film-clock" });
  private readonly holder = h("div", { class: "stage" }, this.canvas, this.shownTime);
  private readonly time = h("output", { class: "clock" });
  private readonly scrub = h("input", { type: "range", min: 0, step: "any", "aria-label": "Time" });
  private readonly strip = h("div", { class: "strip", "aria-hidden": "true" });
  private readonly playButton = h("button", { type: "button", class: "play", "aria-label": "Play" });
  private readonly rate = h("select", { "aria-label": "Speed of the replay" }, ...rates.map((r) => h("option", { value: r, selected: r === 1 }, `${r} ×`)));
  private readonly followButton = h("button", { type: "button", class: "quiet", "aria-pressed": "false" }, "Follow");
  private readonly cars = h("tbody");
  private readonly dial = new Dial();
  private readonly cells = new Map<number, HTMLElement[]>();
  private readonly layerButtons = new Map<keyof Layers, HTMLElement>();
  private readonly layers: Layers = { line: true, trail: true, plan: true, references: false, forces: true };
  private course: Course;
  private stage: Stage;
  private camera: Camera;
  private pending = false;
  /** It moves by itself until the reader takes over. */
  private demo = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  private starting = false;
  private lastNumbers = 0;
  /** How long frames took to draw [ms], for the test of the frame rate. */
  readonly cost: number[] = [];

  constructor(private readonly state: State) {
    this.course = Course.of(state.report, state.runs());
    this.stage = new Stage(this.course, carDimensions(state.report.meta.scene, this.course));
    this.camera = new Camera(this.course.box);
    this.element = this.layout();
    this.bind();
  }

  /** Follows the car of a stack, or stops following. */
  follow(on: boolean): void {
    if (on) this.camera.follow(0, 0, this.stage.car.length, 56);
    else this.camera.fit();
    this.followButton.setAttribute("aria-pressed", String(on));
    this.request();
  }
  get following(): boolean {
    return this.camera.mode === "follow";
  }
  /** Fills the window with the track alone, to be filmed; the reader's page is gone. */
  film(follow: boolean): void {
    this.demo = false;
    this.state.clock.pause();
    document.documentElement.classList.add("film");
    this.holder.append(h("div", { class: "film-names" }, ...this.state.runs().map(({ stack }) => h("span", {}, swatch(stack), this.state.report.label(stack)))));
    document.body.replaceChildren(this.holder);
    this.resize();
    this.follow(follow);
  }
  zoomBy(factor: number): void {
    this.camera.zoomBy(factor);
    this.request();
  }
  toggleLayer(layer: keyof Layers): void {
    this.layers[layer] = !this.layers[layer];
    this.layerButtons.get(layer)?.setAttribute("aria-pressed", String(this.layers[layer]));
    this.request();
  }
  /** Where a car is drawn, in CSS pixels of the canvas; for tests. */
  carOnScreen(stack: number): { x: number; y: number } {
    const pose = this.state.data(stack)!.pose(this.state.clock.t);
    return { x: this.camera.px(pose.x), y: this.camera.py(pose.y) };
  }

  private layout(): HTMLElement {
    const button = (name: string, label: string, click: () => void) =>
      h("button", { type: "button", class: "quiet square", "aria-label": label, title: label, click }, icon(name));
    const layerNames: Record<keyof Layers, string> = { plan: "Plan", references: "References", forces: "Forces", trail: "Trail", line: "Line" };
    for (const [layer, label] of Object.entries(layerNames) as [keyof Layers, string][])
      this.layerButtons.set(
        layer,
        h("button", { type: "button", class: "quiet", "aria-pressed": String(this.layers[layer]), click: () => this.toggleLayer(layer) }, label),
      );
    const transport = h(
      "div",
      { class: "transport" },
      this.playButton,
      this.time,
      h("div", { class: "scrubber" }, this.scrub, this.strip),
      this.rate,
    );
    const options = h(
      "div",
      { class: "bar" },
      h("span", { class: "group" }, this.followButton, button("fit", "Whole track", () => this.follow(false)), button("minus", "Smaller", () => this.zoomBy(1 / 1.4)), button("plus", "Larger", () => this.zoomBy(1.4))),
      h("span", { class: "group", role: "group", "aria-label": "Layers" }, ...this.layerButtons.values()),
    );
    const head = h("tr", {}, ...["car", "lap", "m/s", "offset, m", "µ"].map((text, i) => h("th", { scope: "col", class: i ? "number" : undefined }, text)));
    const panel = h("aside", { class: "panel" }, this.dial.element, h("table", { class: "cars" }, h("thead", {}, head), this.cars), this.symbols());
    return h("div", { class: "replay" }, h("div", { class: "replay-main" }, this.holder, transport, options), panel);
  }

  /** What is drawn around the car followed, in words. */
  private symbols(): HTMLElement {
    const { layers } = this;
    const entries: [boolean, string, string][] = [
      [layers.plan && this.knows("plan0_x_m"), "plan", "plan of its controller"],
      [this.knows("ref0_x_m"), "reference", "reference points"],
      [this.knows("force_front_n"), "force", "tyre forces (when it is followed), and what friction allows"],
      [true, "outside", "outside the track"],
    ];
    return h("ul", { class: "symbols" }, ...entries.filter(([there]) => there).map(([, name, words]) => h("li", {}, symbol(name), words)));
  }
  private knows(column: string): boolean {
    return this.state.runs().some((run) => run.replay.get(column));
  }

  private bind(): void {
    const { state } = this;
    const { clock } = state;
    this.playButton.addEventListener("click", () => clock.toggle());
    this.scrub.addEventListener("input", () => {
      clock.pause();
      clock.seek(Number(this.scrub.value));
    });
    this.rate.addEventListener("change", () => clock.setRate(Number(this.rate.value)));
    this.followButton.addEventListener("click", () => this.follow(!this.following));
    clock.moved.on(() => this.request());
    clock.changed.on(() => {
      if (!this.starting) this.demo = false;
      this.showPlaying();
      this.request();
    });
    state.changed.on(() => this.refresh());
    onThemeChange(() => this.refresh());
    new ResizeObserver(() => requestAnimationFrame(() => this.resize())).observe(this.holder);
    this.bindPointer();
    this.showPlaying();
    this.refresh();
    this.showLap();
  }
  /** Drives lap 1 while the track is in sight, until the reader takes over. */
  private showLap(): void {
    const { clock } = this.state;
    const end = this.state.demoLap()[1];
    const drive = (seen: boolean) => {
      if (!this.demo || seen === clock.playing || clock.t >= end) return;
      this.starting = true;
      if (seen) clock.playUntil(end);
      else clock.pause();
      this.starting = false;
    };
    new IntersectionObserver((entries) => drive(entries[entries.length - 1].isIntersecting), { threshold: 0.4 }).observe(this.holder);
  }

  private bindPointer(): void {
    let last: PointerEvent | null = null;
    let moved = 0;
    this.canvas.addEventListener("pointerdown", (event) => {
      last = event;
      moved = 0;
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (!last || event.pointerType === "touch") return;
      const [dx, dy] = [event.clientX - last.clientX, event.clientY - last.clientY];
      moved += Math.hypot(dx, dy);
      last = event;
      if (moved < 4) return;
      this.followButton.setAttribute("aria-pressed", "false");
      this.camera.pan(dx, dy);
      this.request();
    });
    const up = (event: PointerEvent) => {
      if (last && moved < 4) this.pick(event);
      last = null;
    };
    this.canvas.addEventListener("pointerup", up);
    this.canvas.addEventListener("pointerleave", () => (last = null));
    this.canvas.addEventListener(
      "wheel",
      (event) => {
        if (!event.ctrlKey && document.activeElement !== this.canvas) return;
        event.preventDefault();
        this.zoomBy(Math.exp(-event.deltaY / 300));
      },
      { passive: false },
    );
  }
  /** A click chooses the nearest car. */
  private pick(event: PointerEvent): void {
    const box = this.canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    const near = this.state
      .runs()
      .map((run) => {
        const at = this.carOnScreen(run.stack);
        return { stack: run.stack, distance: Math.hypot(at.x - x, at.y - y) };
      })
      .sort((a, b) => a.distance - b.distance)[0];
    if (near && near.distance < 40) this.state.setFocus(near.stack);
  }

  private showPlaying(): void {
    const { playing, rate } = this.state.clock;
    this.playButton.replaceChildren(icon(playing ? "pause" : "play"));
    this.playButton.setAttribute("aria-label", playing ? "Pause" : "Play");
    this.rate.value = String(rate);
  }
  private refresh(): void {
    const { state } = this;
    this.scrub.max = String(state.clock.end);
    this.drawStrip();
    this.cells.clear();
    redraw(
      this.cars,
      ...state.runs().map(({ stack }) => {
        const cells = Array.from({ length: 4 }, () => h("td", { class: "number" }));
        this.cells.set(stack, cells);
        return h(
          "tr",
          { class: stack === state.focus ? "focus" : undefined, mouseenter: () => state.hover(stack), mouseleave: () => state.hover(null) },
          h("th", { scope: "row" }, h("button", { type: "button", title: state.report.label(stack), click: () => state.setFocus(stack) }, swatch(stack), state.report.label(stack))),
          ...cells,
        );
      }),
    );
    this.request();
  }
  /** Laps of the car looked at, and when which car was outside. */
  private drawStrip(): void {
    const { state } = this;
    const end = Math.max(state.clock.end, 1e-9);
    const runs = state.runs();
    const followed = runs.find((run) => run.stack === state.focus);
    const share = (t: number) => `${((100 * Math.min(t, end)) / end).toFixed(3)}%`;
    const marks: HTMLElement[] = [];
    const driven = followed ? laps(followed) : [];
    const every = Math.ceil(driven.length / 8);
    driven.forEach(([from], lap) => {
      if (lap % every === 0 && from < end) marks.push(h("span", { class: "lap", style: `left:${share(from)}` }, `lap ${lap}`));
    });
    // One row per car that was outside at all.
    runs
      .map((run) => ({ run, out: intervals(run, "outside").filter(([from]) => from < Math.min(end, state.until(run))) }))
      .filter(({ out }) => out.length)
      .forEach(({ run, out }, row) => {
        const until = Math.min(end, state.until(run));
        for (const [from, to] of out)
          marks.push(h("i", { style: `left:${share(from)};width:${share(Math.min(to, until) - from)};top:${15 + 5 * row}px;background:${stackColour(run.stack)}` }));
        this.strip.style.height = `${20 + 5 * row}px`;
      });
    this.strip.title = "Laps of the car followed; below them when which car was outside";
    this.strip.replaceChildren(...marks);
  }

  private resize(): void {
    const width = this.holder.clientWidth;
    if (!width) return;
    const wanted = width * this.course.aspect + 40;
    const filmed = document.documentElement.classList.contains("film");
    const height = filmed ? innerHeight : Math.round(Math.min(Math.max(wanted, width < 500 ? 240 : 320), Math.max(260, innerHeight * 0.7), 640));
    const ratio = Math.min(devicePixelRatio, 2);
    this.canvas.style.height = `${height}px`;
    [this.canvas.width, this.canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    this.camera.resize(width, height);
    this.draw();
  }
  private request(): void {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.draw();
    });
  }
  private draw(): void {
    const { state, camera } = this;
    const ctx = this.canvas.getContext("2d");
    if (!ctx || !this.canvas.width) return;
    const begin = performance.now();
    const { t } = state.clock;
    if (camera.mode === "follow") {
      const pose = state.data(state.focus)?.pose(t);
      if (pose && Number.isFinite(pose.x)) camera.follow(pose.x, pose.y, this.stage.car.length, 56);
    }
    this.stage.draw(ctx, camera, state.runs(), state.focus, t, this.layers, this.canvas.width / this.holder.clientWidth);
    this.scrub.value = String(t);
    this.shownTime.textContent = `${t.toFixed(2)} s`;
    this.time.textContent = `${t.toFixed(2)} s`;
    this.scrub.setAttribute("aria-valuetext", `${t.toFixed(1)} seconds`);
    const now = performance.now();
    if (!state.clock.playing || now - this.lastNumbers > 100) {
      this.lastNumbers = now;
      this.showNumbers(t);
    }
    if (this.cost.length < 1000) this.cost.push(performance.now() - begin);
  }
  private showNumbers(t: number): void {
    const { state } = this;
    for (const run of state.runs()) {
      const cells = this.cells.get(run.stack);
      if (!cells) continue;
      const over = t > run.end;
      const texts = over
        ? [run.status && run.status !== "finished" ? run.status : "done", "", "", ""]
        : [fixed(run.held("lap", t), 0), fixed(run.value("speed", t), 2), fixed(run.value("offset", t), 3), fixed(run.value("mu_belief", t), 3)];
      texts.forEach((text, i) => (cells[i].textContent = text));
      cells[2].classList.toggle("alarm", !over && run.held("outside", t) >= 0.5);
    }
    const looked = state.data(state.focus);
    if (!looked) return;
    this.dial.show(looked.value("mu_belief", t), looked.replayValue("mu_sigma", t), looked.value("mu_true", t), stackColour(state.focus));
  }
}
