// Charts that are not over time: laps, speed over distance, g-g, step times, trade-offs.
import { Chart } from "./chart";
import { reach, type RunData } from "./data";
import { lapChoice } from "./lapchoice";
import { fixed, h, plain, plural } from "./dom";
import { laps } from "./mapview";
import type { Mark } from "./marks";
import { measure, timeName } from "./measures";
import type { State } from "./state";
import { stackColour, stackDash, stackShape, token } from "./theme";
import { runLine } from "./timecharts";

const shownStacks = (state: State) => [...state.report.meta.stacks.keys()].filter((stack) => state.visible.has(stack));

/** Lap times side by side, their intervals, and the limit of each lap where the table knows the ratio to it. */
export function lapChart(state: State): Chart | null {
  const { table } = state.report.meta;
  const lapColumns = table.columns.filter((name) => /^lap\d+_s$/.test(name));
  if (!lapColumns.length) return null;
  const marks = (): Mark[] => {
    const shown = shownStacks(state);
    const width = 0.72 / Math.max(1, shown.length);
    const out: Mark[] = [];
    const limits: Mark[] = [];
    const most = usualLaps(state, lapColumns);
    const shownRows = table.rows.filter((row) => shown.includes(row.stack));
    const allLost = shownRows.every((row) => state.report.finished(row) === 0);
    shown.forEach((stack, k) => {
      const row = shownRows.find((r) => r.stack === stack);
      if (!row) return;
      const lost = !allLost && state.report.finished(row) === 0;
      const points = { x: [] as number[], y: [] as number[], names: [] as string[] };
      const far = { x: [] as number[], y: [] as number[], names: [] as string[] };
      lapColumns.forEach((name, lap) => {
        const index = state.report.column(name);
        const value = row.values[index];
        if (value === null) return;
        const x = lap + (k - (shown.length - 1) / 2) * width;
        const place = value > most ? far : points;
        place.x.push(x);
        place.y.push(value);
        place.names.push(`${state.report.label(stack)}, lap ${lap}`);
        // At the chart's edge a marker does not say how long the lap took.
        if (lost || value > most) out.push({ kind: "text", x, y: value, text: `${plain(value)} s`, color: token("muted"), stack, lost: true, atEdge: true });
        const [low, high] = [row.low[index], row.high[index]];
        if (low !== null && high !== null && low !== high)
          out.push({ kind: "line", x: [x, x], y: [low, high], color: stackColour(stack), stack, lost: lost || value > most, width: 1.4 });
        const ratio = row.values[state.report.column(`pace_ratio${lap}`)];
        if (ratio)
          limits.push({ kind: "line", x: [x - width * 0.42, x + width * 0.42], y: [value / ratio, value / ratio], color: token("ink"), width: 2, lost, ...(limits.length ? {} : { label: "fastest possible lap" }) });
      });
      const style = { size: lapColumns.length > 40 ? 2 : 4.5, color: stackColour(stack), shape: stackShape(stack), stack };
      if (far.x.length) out.push({ kind: "points", ...far, ...style, lost: true });
      out.push({ kind: "points", ...points, ...style, label: state.report.label(stack), lost });
    });
    return [...limits, ...out];
  };
  return new Chart(
    {
      id: "laps",
      title: drivenRatios(state).length ? "Lap by lap, against the limit" : "Lap by lap",
      note: limitNote(state),
      height: 300,
      wide: true,
      x: { label: "", fixed: [-0.5, lapColumns.length - 0.5], splits: lapColumns.map((_, i) => i).filter((i) => i % Math.ceil(lapColumns.length / 8) === 0), tick: (v) => `lap ${v}` },
      y: { label: "lap time", unit: "s", digits: 4 },
      marks,
    },
    state,
  );
}

/** Lap times beyond this are marked at the chart's edge: a car that was off the track for a while. */
function usualLaps(state: State, lapColumns: string[]): number {
  const { rows } = state.report.meta.table;
  const times = rows.flatMap((row) => lapColumns.map((name) => row.values[state.report.column(name)]).filter((v): v is number => v !== null));
  if (rows.length < 3) return Infinity;
  times.sort((a, b) => a - b);
  return 1.5 * (times[times.length >> 1] ?? Infinity);
}

/** The columns of ratios to the limit that have a value: without a limit they are there, and empty. */
function drivenRatios(state: State): string[] {
  return state.report.filled(/^pace_ratio\d+$/);
}

/** What the bars of the limit are, and who came closest to one. */
function limitNote(state: State): string | undefined {
  const ratios = drivenRatios(state);
  if (!ratios.length) return undefined;
  let best: { ratio: number; stack: number; lap: string } | null = null;
  for (const row of state.report.contenders())
    for (const name of ratios) {
      const ratio = row.values[state.report.column(name)];
      if (ratio !== null && (!best || ratio < best.ratio)) best = { ratio, stack: row.stack, lap: name.slice(10) };
    }
  const words = "Black bars: the fastest lap that the car could drive at that lap's mean friction, by a time-optimal or quasi-steady-state computation. A marker on its bar drove at the limit.";
  if (!best) return words;
  const off = 100 * (best.ratio - 1);
  return `${words} Closest came ${state.report.label(best.stack)}, ${fixed(Math.abs(off), 1)} % ${off < 0 ? "faster" : "slower"}, in lap ${best.lap}.`;
}

/** Speed of one lap on an even grid of distance from the start line. */
function speedOverLap(run: RunData, [from, to]: [number, number], length: number): { x: number[]; y: number[] } | null {
  const [s, speed] = [run.channel("s"), run.channel("speed")];
  if (!s || !speed || !length) return null;
  const s0 = s[0];
  const x: number[] = [];
  const y: number[] = [];
  for (let i = 0; i < run.t.length; i++) {
    if (run.t[i] < from || run.t[i] >= to) continue;
    let distance = (s[i] - s0) % length;
    if (distance < 0) distance += length;
    // Against the direction of the file, or just before the line again: no distance may come twice.
    if (x.length && distance <= x[x.length - 1]) continue;
    if (!x.length && distance > length / 2) continue;
    x.push(distance);
    y.push(speed[i]);
  }
  return x.length > 1 ? { x, y } : null;
}

export function speedDistance(state: State, length: () => number): Chart {
  let lap = 0;
  const count = Math.max(1, ...state.runs().map((run) => laps(run).length));
  const chart = new Chart(
    {
      id: "speed-distance",
      title: "Speed over the lap",
      note: "Dotted: the reference speed of the car followed.",
      overlay: true,
      height: 260,
      wide: true,
      x: { label: "distance from the start line", unit: "m" },
      y: { label: "speed", unit: "m/s", include: [0] },
      marks: () => [
        ...state.runs().flatMap((run) => {
          const window = laps(run)[lap];
          const line = window && speedOverLap(run, window, length());
          return line ? [runLine(state, run, line.y, line.x)] : [];
        }),
        ...wanted(state, lap, length()),
      ],
    },
    state,
  );
  chart.figure.controls.append(
    lapChoice(count, 0, (choice) => {
      lap = choice ?? 0;
      chart.refresh();
    }),
  );
  return chart;
}

function wanted(state: State, lap: number, length: number): Mark[] {
  const run = state.visible.has(state.focus) ? state.data(state.focus) : undefined;
  const reference = run?.channel("v_ref");
  const window = run && laps(run)[lap];
  if (!run || !reference || !window) return [];
  const line = speedOverLap(run, window, length);
  if (!line) return [];
  const s = run.channel("s")!;
  const y: number[] = [];
  // The same rows as the speed itself: look each distance up by its time.
  let i = 0;
  for (const x of line.x) {
    while (i < run.t.length && (run.t[i] < window[0] || Math.abs((((s[i] - s[0]) % length) + length) % length - x) > 1e-9)) i++;
    y.push(reference[Math.min(i, reference.length - 1)]);
  }
  return [{ kind: "line", x: line.x, y, color: stackColour(run.stack), dash: [1, 3], alpha: 0.9, label: `${state.report.label(run.stack)}, reference`, stack: run.stack }];
}

/** Accelerations along and across the car, with the circle of the largest and the smallest friction of the run. */
export function ggChart(state: State): Chart | null {
  if (!state.runs().some((run) => run.channel("ax"))) return null;
  const g = 9.81;
  const circle = (radius: number, dash: number[], label: string): Mark => {
    const angles = Array.from({ length: 73 }, (_, i) => (i * Math.PI) / 36);
    return { kind: "line", x: angles.map((a) => radius * Math.cos(a)), y: angles.map((a) => radius * Math.sin(a)), color: token("ink"), width: 1.6, dash, label };
  };
  return new Chart(
    {
      id: "g-g",
      title: "g-g diagram",
      note: "Circles: true friction when it was highest and lowest.",
      overlay: true,
      square: true,
      x: { label: "to the left", unit: "g" },
      y: { label: "forward", unit: "g" },
      marks: () => {
        const runs = state.runs();
        const frictions = runs.flatMap((run) => {
          const mu = run.channel("mu_true");
          return mu ? [reach(mu)] : [];
        });
        const high = Math.max(...frictions.map(([, v]) => v));
        const low = Math.min(...frictions.map(([v]) => v));
        const half = Number.isFinite(high) ? high * 1.2 : 1.2;
        const points = runs.flatMap((run): Mark[] => {
          const [ax, ay] = [run.channel("ax"), run.channel("ay")];
          if (!ax || !ay) return [];
          const keep = [...ax.keys()].filter((i) => Math.hypot(ax[i], ay[i]) < 1.15 * half * g);
          return [
            { kind: "points", x: keep.map((i) => ay[i] / g), y: keep.map((i) => ax[i] / g), size: 1.3, alpha: 0.5, color: stackColour(run.stack), label: state.report.label(run.stack), stack: run.stack },
          ];
        });
        const frame: Mark = { kind: "points", x: [-half, half], y: [NaN, NaN], color: "transparent" };
        if (!Number.isFinite(high)) return [frame, ...points];
        return [frame, ...points, circle(high, [], `µ ${plain(high)}`), ...(high - low > 0.01 ? [circle(low, [5, 4], `µ ${plain(low)}`)] : [])];
      },
    },
    state,
  );
}

/** How long steps took: share of steps per bin of a logarithmic axis. */
export function timesChart(state: State): Chart | null {
  const { times } = state.report.meta;
  const kinds = [...new Set(times.map((entry) => entry.what))].sort((a, b) => Number(b === "solve_ms") - Number(a === "solve_ms"));
  if (!kinds.length) return null;
  let what = kinds[0];
  const edge = (bin: number) => 1e-4 * 10 ** (bin / 20);
  const chart = new Chart(
    {
      id: "step-times",
      title: "Step times",
      note: "Share of all steps per bin, all seeds. Thread CPU time.",
      overlay: true,
      height: 300,
      x: { label: "time", unit: "ms", log: true },
      y: { label: "share of steps", unit: "%", include: [0] },
      marks: () =>
        times
          .filter((entry) => entry.what === what && state.visible.has(entry.stack))
          .map((entry): Mark => {
            const x: number[] = [];
            const y: number[] = [];
            for (const [bin, count] of entry.bins) {
              // Bins without a step between two with steps are zero, not missing.
              if (!x.length || Math.abs(x[x.length - 1] / edge(bin) - 1) > 1e-6) {
                if (x.length) y[y.length - 1] = 0;
                x.push(edge(bin));
                y.push(0);
              }
              y[y.length - 1] = (100 * count) / entry.n;
              x.push(edge(bin + 1));
              y.push(0);
            }
            const { truth } = state.report.meta.stacks[entry.stack];
            const highest = [...y.keys()].sort((a, b) => y[b] - y[a]).slice(0, 3);
            return { kind: "line", step: true, x, y, color: stackColour(entry.stack), dash: stackDash(truth), label: state.report.label(entry.stack), stack: entry.stack, shape: stackShape(entry.stack), shapesAt: highest };
          }),
    },
    state,
  );
  const choice = h("select", { "aria-label": "Which time" }, ...kinds.map((kind) => h("option", { value: kind }, timeName(kind))));
  choice.addEventListener("change", () => {
    what = choice.value;
    chart.refresh();
  });
  if (kinds.length > 1) chart.figure.controls.append(choice);
  return chart;
}

/** Stacks that no other stack beats in both columns, from left to right. */
export function paretoFront(points: { x: number; y: number }[]): { x: number; y: number }[] {
  const sorted = [...points].sort((a, b) => a.x - b.x || a.y - b.y);
  let lowest = Infinity;
  return sorted.filter(({ y }) => {
    const better = y < lowest;
    if (better) lowest = y;
    return better;
  });
}

interface Axis {
  name: string;
  label: string;
}

/** Any column against any other; medians as marks, seeds as small ones, and the front of what nobody beats. */
export function tradeOff(state: State, id: string, title: string, first: string, second: string): Chart | null {
  const { table, runs } = state.report.meta;
  const usable = table.columns
    .filter((name) => measure(name).better && table.rows.some((row) => row.values[state.report.column(name)] !== null))
    .map((name): Axis => {
      const m = measure(name);
      return { name, label: `${m.group === "Lap time" || m.group === "Pace over limit" ? `${m.group.toLowerCase()}, ` : ""}${m.label}${m.unit && m.unit !== "1" ? ` [${m.unit}]` : ""}` };
    });
  const find = (name: string) => usable.find((axis) => axis.name === name);
  if (usable.length < 2) return null;
  let [xAxis, yAxis] = [find(first) ?? usable[0], find(second) ?? usable[1]];
  const x = { label: xAxis.label, digits: 4 };
  const y = { label: yAxis.label, digits: 4 };
  const marks = (): Mark[] => {
    const [xi, yi] = [state.report.column(xAxis.name), state.report.column(yAxis.name)];
    const medians: { x: number; y: number }[] = [];
    const out: Mark[] = [];
    for (const row of table.rows) {
      const { stack } = row;
      const [vx, vy] = [row.values[xi], row.values[yi]];
      if (!state.visible.has(stack) || vx === null || vy === null) continue;
      const own = runs.filter((run) => run.stack === stack && xAxis.name in run.values && yAxis.name in run.values);
      const [color, shape] = [stackColour(stack), stackShape(stack)];
      // Who finished no run drove less than the others: its place is marked, and stretches no axis.
      const lost = state.report.finished(row) === 0;
      if (own.length > 1)
        out.push({ kind: "points", x: own.map((run) => run.values[xAxis.name]), y: own.map((run) => run.values[yAxis.name]), names: own.map((run) => `${state.report.label(stack)}, seed ${run.seed}`), size: 2.2, alpha: 0.45, color, stack, lost });
      out.push({ kind: "points", x: [vx], y: [vy], names: [state.report.label(stack)], size: 6, color, shape, stack, lost, label: state.report.label(stack) });
      out.push({ kind: "text", x: vx, y: vy, text: lost ? `${state.report.label(stack)}, finished none` : state.report.label(stack), color: token("ink"), stack, lost });
      // Who never finished has beaten nobody.
      if (state.report.finished(row) !== 0) medians.push({ x: vx, y: vy });
    }
    const bothLow = measure(xAxis.name).better === "low" && measure(yAxis.name).better === "low";
    const front = bothLow ? paretoFront(medians) : [];
    if (front.length > 1)
      out.unshift({ kind: "line", x: front.map((p) => p.x), y: front.map((p) => p.y), color: token("muted"), dash: [3, 3], width: 1.2, label: "nobody is better in both" });
    return out;
  };
  const chart = new Chart({ id, title, height: 300, bare: true, x, y, marks }, state);
  const choose = (current: Axis, name: string, set: (axis: Axis) => void) => {
    const select = h("select", { "aria-label": name }, ...usable.map((axis) => h("option", { value: axis.name, selected: axis === current }, axis.label)));
    select.addEventListener("change", () => {
      set(find(select.value)!);
      x.label = xAxis.label;
      y.label = yAxis.label;
      chart.refresh();
    });
    return select;
  };
  chart.figure.controls.append(
    choose(xAxis, "Horizontal axis", (axis) => (xAxis = axis)),
    choose(yAxis, "Vertical axis", (axis) => (yAxis = axis)),
  );
  return chart;
}

/** The tyre curves of the stack looked at, at the replay's time. */
export function tyreChart(state: State, axle: "front" | "rear"): Chart | null {
  const some = [...state.report.meta.stacks.keys()].some((stack) => state.data(stack)?.[axle].times.length);
  if (!some) return null;
  const degrees = 180 / Math.PI;
  const visited = (run: RunData): Mark[] => {
    const [t, slip] = [run.replay.get("t_s"), run.replay.get(`slip_${axle}_rad`)];
    if (!t || !slip) return [];
    const [from, to] = reach(slip.filter((_, i) => t[i] <= state.clock.t));
    return from <= to ? [{ kind: "span", from: from * degrees, to: to * degrees, color: token("muted"), alpha: 0.12 }] : [];
  };
  const early = h("p", { class: "note early" });
  // Friction multiplies the peak force, so a curve of another time is one of now but for its size.
  const scaled = (forces: Float64Array, by: number) => (Number.isFinite(by) ? forces.map((f) => f * by) : forces);
  const chart = new Chart(
    {
      id: `tyre-${axle}`,
      title: `${axle === "front" ? "Front" : "Rear"} tyre, learned and true`,
      note: "At the replay's time. Shaded: slips visited so far by the stack followed; band: one standard deviation.",
      overlay: true,
      height: 330,
      x: { label: "slip angle", unit: "°" },
      y: { label: "lateral force", unit: "N" },
      marks: () => {
        const runs = state.runs();
        const out: Mark[] = [];
        let truth: Mark | undefined;
        const waiting: string[] = [];
        for (const run of runs) {
          const curve = run[axle].at(state.clock.t);
          if (!curve) continue;
          const x = curve.slip.map((a) => a * degrees);
          const { learned, sigma } = curve;
          if (curve.truth && (!truth || run.stack === state.focus)) {
            const y = curve.early ? scaled(curve.truth, run.value("mu_true", state.clock.t) / run.value("mu_true", curve.t)) : curve.truth;
            truth = { kind: "line", x, y, color: token("ink"), width: 2.4, dash: [2, 3], label: "true" };
          }
          if (curve.early) waiting.push(state.report.label(run.stack));
          if (!learned || curve.early) continue;
          if (sigma) out.push({ kind: "band", x, low: learned.map((f, i) => f - sigma[i]), high: learned.map((f, i) => f + sigma[i]), color: stackColour(run.stack), alpha: 0.24, stack: run.stack });
          out.push(runLine(state, run, learned, x));
        }
        early.textContent = waiting.length ? `Nothing learned yet: ${waiting.join(", ")}.` : "";
        const followed = runs.find((run) => run.stack === state.focus);
        return [...(followed ? visited(followed) : []), ...out, ...(truth ? [truth] : [])];
      },
    },
    state,
  );
  chart.figure.element.querySelector("figcaption")!.append(early);
  let drawn = -1;
  state.clock.moved.on(() => {
    // Snapshots are a second apart: redrawing more often shows nothing new.
    const tick = Math.floor(state.clock.t * 4);
    if (tick !== drawn) {
      drawn = tick;
      chart.refresh();
    }
  });
  return chart;
}

/** One line per stack: when it ended and what is not drawn. */
export function undrawable(state: State): string {
  const lost = state.runs().filter((run) => run.undrawable > 0);
  return lost.map((run) => `${state.report.label(run.stack)}: ${plural(run.undrawable, "value")} beyond drawing`).join("; ");
}
