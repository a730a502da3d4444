// Small track maps, one per stack: the trajectory coloured by speed, violations marked.
import { decimalsFor, fixed, h } from "./dom";
import { makeFigure } from "./figure";
import { lapChoice } from "./lapchoice";
import { Course, drawCourse, drawSpeedTrail, drawViolations, fit, intervals, laps } from "./mapview";
import { CanvasPen, SvgPen, type Pen } from "./pen";
import type { State } from "./state";
import { onThemeChange, sequential, token } from "./theme";

function speedRange(state: State): [number, number] {
  let [low, high] = [Infinity, 0];
  for (const run of state.runs())
    for (const v of run.channel("speed") ?? [])
      if (Number.isFinite(v)) [low, high] = [Math.min(low, v), Math.max(high, v)];
  return low < high ? [low, high] : [0, 1];
}

function colourScale(low: number, high: number): HTMLElement {
  const stops = Array.from({ length: 11 }, (_, i) => sequential(i / 10)).join(", ");
  return h(
    "div",
    { class: "colour-scale" },
    h("span", {}, fixed(low, decimalsFor(high - low, 2))),
    h("i", { style: `background: linear-gradient(to right, ${stops})` }),
    h("span", {}, `${fixed(high, decimalsFor(high - low, 2))} m/s`),
    h("span", { class: "violation-key" }, "outside the track"),
  );
}

/** One map as a picture of a given size. */
function drawMap(pen: Pen, state: State, course: Course, stack: number, lap: number | null, width: number, height: number): void {
  const run = state.data(stack);
  const view = fit(course.box, width, height, 14);
  drawCourse(pen, course, view);
  if (!run) return;
  const [from, to] = lap === null ? [0, Infinity] : (laps(run)[lap] ?? [Infinity, Infinity]);
  const [low, high] = speedRange(state);
  drawSpeedTrail(pen, run, view, { from, to, low, high, width: 2 });
  drawViolations(pen, run, view, from, to);
}

export function mapsSection(state: State): HTMLElement {
  const grid = h("div", { class: "maps" });
  const scale = h("div");
  let lap: number | null = null;
  const count = Math.max(0, ...state.runs().map((run) => laps(run).length));
  const course = () => Course.of(state.report, state.runs());

  const draw = () => {
    const track = course();
    const shown = state.runs().length;
    grid.style.setProperty("--columns", String(shown <= 3 ? Math.max(shown, 2) : shown === 4 ? 2 : 3));
    scale.replaceChildren(colourScale(...speedRange(state)));
    grid.replaceChildren(
      ...state.runs().map(({ stack }) => {
        const run = state.data(stack)!;
        const label = state.report.label(stack);
        const size = { width: 480, height: Math.round(Math.min(560, Math.max(200, 480 * track.aspect + 10))) };
        const figure = makeFigure({
          id: `map-${state.report.meta.stacks[stack].name}`,
          title: label,
          svg: () => {
            const pen = new SvgPen(640, Math.round(640 * size.height / size.width) + 20, token("surface"));
            pen.text(16, 18, label, { color: token("ink"), size: 15, weight: 600 });
            drawMap(pen, state, track, stack, lap, 640, Math.round(640 * size.height / size.width) + 20);
            return pen.toString();
          },
          rows: function* () {
            yield ["t_s", "x_m", "y_m", "speed_mps", "outside"];
            for (let i = 0; i < run.t.length; i++)
              yield [run.t[i], run.channel("x")?.[i] ?? NaN, run.channel("y")?.[i] ?? NaN, run.channel("speed")?.[i] ?? NaN, run.channel("outside")?.[i] ?? NaN];
          },
        });
        const [from, to] = lap === null ? [0, Infinity] : (laps(run)[lap] ?? [Infinity, Infinity]);
        const counted = lap === null ? state.report.meta.runs.find((r) => r.stack === stack && r.seed === state.seed)?.values.violation_s : undefined;
        const outside = counted ?? intervals(run, "outside", from, to).reduce((sum, [a, b]) => sum + b - a, 0);
        figure.readout.append(outside > 0 ? h("span", { class: "alarm" }, `${outside.toFixed(2)} s outside`) : "never outside");
        const canvas = h("canvas", { role: "img", "aria-label": `Trajectory of ${label} over the track, coloured by speed` });
        canvas.style.aspectRatio = `${size.width} / ${size.height}`;
        const ratio = Math.min(2, devicePixelRatio);
        [canvas.width, canvas.height] = [size.width * ratio, size.height * ratio];
        const ctx = canvas.getContext("2d")!;
        ctx.scale(ratio, ratio);
        drawMap(new CanvasPen(ctx), state, track, stack, lap, size.width, size.height);
        figure.body.append(canvas);
        return figure.element;
      }),
    );
  };
  const choice = lapChoice(count, null, (chosen) => {
    lap = chosen;
    draw();
  });
  draw();
  state.changed.on(draw);
  onThemeChange(draw);
  return h("div", {}, h("div", { class: "bar" }, choice, scale), grid);
}
