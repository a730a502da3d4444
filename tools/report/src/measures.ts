// What the columns of the tables mean: names for people, units, which end is better.
export interface Measure {
  group: string;
  label: string;
  unit: string;
  decimals: number;
  better: "low" | "high" | null;
  /** Shown before the reader asks for all columns. */
  main: boolean;
  help: string;
}

const known: Record<string, Omit<Measure, "help"> & { help?: string }> = {
  mean_deviation_m: { group: "Driving", label: "deviation", unit: "m", decimals: 3, better: "low", main: true, help: "time mean of the distance to the line the planner follows" },
  violation_s: { group: "Driving", label: "outside", unit: "s", decimals: 2, better: "low", main: true, help: "time with the centre of gravity outside the track" },
  violation_s_max: { group: "Driving", label: "outside, worst", unit: "s", decimals: 2, better: "low", main: false },
  violation_body_s: { group: "Driving", label: "corner outside", unit: "s", decimals: 2, better: "low", main: false, help: "time with any corner of the car outside" },
  violation_after_adapt_s: { group: "Driving", label: "outside, adapted", unit: "s", decimals: 2, better: "low", main: true, help: "counted from the moment the stack trusts what it learned" },
  violation_body_after_adapt_s: { group: "Driving", label: "corner outside, adapted", unit: "s", decimals: 2, better: "low", main: false, help: "time with any corner of the car outside, from the moment the stack trusts what it learned" },
  violation_after_adapt_s_max: { group: "Driving", label: "adapted, worst", unit: "s", decimals: 2, better: "low", main: false },
  mu_rmse: { group: "Friction", label: "µ error", unit: "1", decimals: 3, better: "low", main: true, help: "rms of estimated less true friction" },
  mu_visited_rmse: { group: "Friction", label: "µ error, visited", unit: "1", decimals: 3, better: "low", main: false, help: "against the best that the visited slips can tell" },
  solve_ms_median: { group: "Step time", label: "solve", unit: "ms", decimals: 2, better: "low", main: true, help: "median time of one solve" },
  solve_ms_p95: { group: "Step time", label: "solve 95 %", unit: "ms", decimals: 2, better: "low", main: false },
  solve_ms_p99: { group: "Step time", label: "solve 99 %", unit: "ms", decimals: 2, better: "low", main: false },
  update_ms_median: { group: "Step time", label: "learn", unit: "ms", decimals: 3, better: "low", main: false, help: "median time of one update of the estimator" },
  plan_latency_s: { group: "Step time", label: "plan latency", unit: "s", decimals: 2, better: "low", main: false, help: "longest time from the order of a plan to the step that first drove it" },
  solver_failures: { group: "Step time", label: "failed solves", unit: "", decimals: 0, better: "low", main: true },
  runs: { group: "Runs", label: "runs", unit: "", decimals: 0, better: null, main: false },
  finished: { group: "Runs", label: "finished", unit: "", decimals: 0, better: "high", main: true },
  crashed: { group: "Runs", label: "crashed", unit: "", decimals: 0, better: "low", main: false },
  steps: { group: "Size", label: "steps", unit: "", decimals: 0, better: null, main: false },
  cpu_s: { group: "Size", label: "CPU", unit: "s", decimals: 1, better: null, main: false },
  simulated_s: { group: "Size", label: "simulated", unit: "s", decimals: 1, better: null, main: false },
};

export function measure(column: string): Measure {
  const lap = /^lap(\d+)_s$/.exec(column);
  if (lap) return { group: "Lap time", label: `lap ${lap[1]}`, unit: "s", decimals: 2, better: "low", main: true, help: "" };
  const pace = /^pace_ratio(\d+)$/.exec(column);
  if (pace)
    return { group: "Pace over limit", label: `lap ${pace[1]}`, unit: "", decimals: 3, better: "low", main: true, help: "lap time over the limit at the lap's mean friction" };
  const bodyPace = /^body_pace_ratio(\d+)$/.exec(column);
  if (bodyPace)
    return { group: "Pace over limit, whole car", label: `lap ${bodyPace[1]}`, unit: "", decimals: 3, better: "low", main: false, help: "lap time over the limit with the whole car inside, at the lap's mean friction" };
  const factor = /^lap(\d+)_mean_factor$/.exec(column);
  if (factor)
    return { group: "Friction factor", label: `lap ${factor[1]}`, unit: "", decimals: 3, better: null, main: false, help: "mean friction factor of the lap" };
  const entry = known[column];
  if (entry) return { help: "", ...entry };
  const unit = /_(s|ms|m|mps|rad)$/.exec(column)?.[1] ?? "";
  return { group: "Other", label: column.replace(/_/g, " "), unit, decimals: 3, better: null, main: false, help: "" };
}

/** Names and units of the per-step times of timing.csv. */
export function timeName(column: string): string {
  const names: Record<string, string> = { solve_ms: "Solve", update_ms: "Learn", plan_ms: "Plan", step_ms: "Whole step" };
  return names[column] ?? column.replace(/_ms$/, "").replace(/_/g, " ");
}
