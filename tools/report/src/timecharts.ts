// Charts over time: what the replay's clock runs through.
import { Chart, type ChartSpec } from "./chart";
import { indexBefore, type RunData } from "./data";
import { fixed } from "./dom";
import type { Mark } from "./marks";
import { intervals } from "./mapview";
import type { State } from "./state";
import { stackColour, stackDash, stackShape, token } from "./theme";

/** Places for a few markers along a line, each stack's beside those of others: lines are told apart without colours. */
function sparse(x: ArrayLike<number>, stack: number): number[] {
  const count = 5;
  const share = (0.5 + 0.381966 * stack) % 1;
  if (x.length < 4 * count) return x.length ? [x.length - 1] : [];
  return Array.from({ length: count }, (_, k) => Math.floor(((k + share) / count) * (x.length - 1)));
}

/** The line of one run; dashed if the stack is given the ground truth. */
export function runLine(state: State, run: RunData, y: ArrayLike<number>, x: ArrayLike<number> = run.t): Mark {
  const { truth } = state.report.meta.stacks[run.stack];
  const color = stackColour(run.stack);
  const until = x === run.t ? state.until(run) : undefined;
  return { kind: "line", x, y, color, dash: stackDash(truth), label: state.report.label(run.stack), stack: run.stack, shape: stackShape(run.stack), shapesAt: sparse(x, run.stack), until };
}

/** Where the line of a run ends that did not finish, and how it ended; or that it goes on beyond the chart. */
function endMark(state: State, run: RunData, y: ArrayLike<number>): Mark[] {
  if (run.goesOn) {
    if (run.end <= state.shownEnd) return [];
    return [{ kind: "end", x: Infinity, y: run.t.length ? y[indexBefore(run.t, state.shownEnd)] : NaN, text: `${state.report.label(run.stack)} until ${fixed(run.end, 0)} s`, color: stackColour(run.stack), stack: run.stack }];
  }
  let last = y.length - 1;
  while (last > 0 && !Number.isFinite(y[last])) last--;
  return [{ kind: "end", x: run.t[last], y: y[last], text: `${state.report.label(run.stack)} ${run.status.replace(/_/g, " ")}`, color: stackColour(run.stack), stack: run.stack }];
}

function channelMarks(state: State, channel: string, scale = 1): Mark[] {
  return state.runs().flatMap((run) => {
    const values = run.channel(channel);
    if (!values) return [];
    const y = scale === 1 ? values : values.map((v) => v * scale);
    return [runLine(state, run, y), ...endMark(state, run, y)];
  });
}

/** Thin lines for what jumps from step to step. */
function noisyMarks(state: State, channel: string): Mark[] {
  return channelMarks(state, channel).map((mark) => (mark.kind === "line" ? { ...mark, width: 0.8, alpha: 0.7, dash: undefined } : mark));
}

function violationSpans(state: State): Mark[] {
  return state.runs().flatMap((run) =>
    intervals(run, "outside")
      .filter(([from]) => from < state.until(run))
      .map(([from, to]): Mark => ({ kind: "span", from, to: Math.min(to, state.until(run)), color: stackColour(run.stack), alpha: 0.18, stack: run.stack })),
  );
}

/** The friction that was really there: the same for all, drawn once. */
function truthMark(state: State): Mark[] {
  const run = state.runs().reduce<RunData | undefined>((longest, r) => (!longest || r.end > longest.end ? r : longest), undefined);
  const truth = run?.channel("mu_true");
  return run && truth ? [{ kind: "line", x: run.t, y: truth, color: token("ink"), width: 2.4, label: "true", dash: [2, 3] }] : [];
}

/** mu of the whole car with one standard deviation to both sides, where the run states one. */
function beliefBand(state: State, run: RunData): Mark[] {
  const t = run.replay.get("t_s");
  const sigma = run.replay.get("mu_sigma");
  if (!t || !sigma || !run.channel("mu_belief")) return [];
  const mu = t.map((time) => run.value("mu_belief", time));
  return [
    { kind: "band", x: t, low: mu.map((v, i) => v - sigma[i]), high: mu.map((v, i) => v + sigma[i]), color: stackColour(run.stack), alpha: 0.24, stack: run.stack, until: state.until(run) },
  ];
}

const time = { label: "time", unit: "s" };

const specs = (state: State): (Omit<ChartSpec, "x" | "time"> & { needs: string[] })[] => [
  {
    id: "speed",
    title: "Speed",
    y: { label: "speed", unit: "m/s", include: [0], decimals: 2 },
    needs: ["speed"],
    marks: () => [...violationSpans(state), ...channelMarks(state, "speed")],
  },
  {
    id: "friction",
    title: "Friction, estimated and true",
    note: "Band: one standard deviation of the belief.",
    y: { label: "µ of the whole car", decimals: 3 },
    needs: ["mu_belief", "mu_true"],
    marks: () => [...state.runs().flatMap((run) => beliefBand(state, run)), ...channelMarks(state, "mu_belief"), ...truthMark(state)],
  },
  {
    id: "offset",
    title: "Offset from the centre line",
    note: "Left is positive. Shaded: outside the track.",
    y: { label: "offset", unit: "m", include: [0], decimals: 3 },
    needs: ["offset"],
    marks: () => [...violationSpans(state), ...channelMarks(state, "offset")],
  },
  {
    id: "steering",
    title: "Steering",
    y: { label: "road wheel angle", unit: "°", decimals: 1 },
    needs: ["delta"],
    marks: () => channelMarks(state, "delta", 180 / Math.PI),
  },
  {
    id: "throttle",
    title: "Throttle and brake",
    y: { label: "command", unit: "1", decimals: 2 },
    needs: ["d"],
    marks: () => channelMarks(state, "d"),
  },
  {
    id: "solve-time",
    title: "Time of each solve",
    y: { label: "solve", unit: "ms", log: true },
    needs: ["solve_ms"],
    marks: () => noisyMarks(state, "solve_ms"),
  },
];

/** The charts for which any run has data. */
export function timeCharts(state: State): Chart[] {
  const runs = state.runs();
  return specs(state)
    .filter(({ needs }) => needs.some((channel) => runs.some((run) => run.channel(channel))))
    .map((spec) => new Chart({ ...spec, x: time, time: true, overlay: true, height: 190 }, state));
}
