// The comparison table, and the claims.
import { decimalsFor, fixed, h, percent, plain, prose, redraw } from "./dom";
import { measure, type Measure } from "./measures";
import type { State } from "./state";
import { swatch } from "./swatch";
import { stackColour } from "./theme";
import type { Claim, Pair, TableRow } from "./types";

interface Column {
  index: number;
  name: string;
  measure: Measure;
}

/** The fewest draws whose 95 % interval of the median is more than their range: framework/src/util/resampling.hpp. */
const leastForInterval = 6;
/** The least p that the sign test can give for so many draws. */
const leastP = (draws: number): number => 2 ** (1 - draws);

/** Columns of later laps stand aside with the rest. */
const mostLaps = 12;
function lapOf(column: string): number {
  return Number(/^(?:lap|pace_ratio|body_pace_ratio)(\d+)/.exec(column)?.[1] ?? 0);
}

/** The best value of a column among the contenders; null where nothing is better than another. */
function best(state: State, column: Column): number | null {
  const values = state.report
    .contenders()
    .map((row) => row.values[column.index])
    .filter((v): v is number => v !== null);
  if (values.length < 2 || !column.measure.better) return null;
  const [low, high] = [Math.min(...values), Math.max(...values)];
  if (low === high) return null;
  return column.measure.better === "low" ? low : high;
}

function cell(state: State, row: TableRow, column: Column, bestValue: number | null, able: boolean): HTMLElement {
  const { index, measure: m } = column;
  const value = row.values[index];
  if (column.name === "finished") return finishedCell(state, row, value);
  const shown = fixed(value, m.decimals);
  const isBest = bestValue !== null && able && value !== null && fixed(bestValue, m.decimals) === shown;
  const [low, high] = [row.low[index], row.high[index]];
  const spread = low !== null && high !== null && fixed(low, m.decimals) !== fixed(high, m.decimals);
  return h(
    "td",
    { class: isBest ? "best" : undefined },
    h("span", { class: "value" }, value === null ? h("span", { class: "none" }, "–") : shown, isBest ? h("span", { class: "visually-hidden" }, " (best)") : null),
    spread ? h("span", { class: "interval" }, `${fixed(low, m.decimals)}–${fixed(high, m.decimals)}`) : worstHidden(state, row, column, shown),
  );
}

/** The worst run of a column that has one, where the median and its interval show nothing of it. */
function worstHidden(state: State, row: TableRow, { name, measure: m }: Column, shown: string): HTMLElement | null {
  const index = state.report.column(`${name}_max`);
  const worst = index < 0 ? null : row.values[index];
  if (worst === null || Number(shown) !== 0 || fixed(worst, m.decimals) === shown) return null;
  return h("span", { class: "interval" }, `worst ${fixed(worst, m.decimals)}`);
}

/** How many of its runs a stack finished: nobody's figures mean much who lost some. */
function finishedCell(state: State, row: TableRow, value: number | null): HTMLElement {
  const runs = state.report.column("runs") < 0 ? null : row.values[state.report.column("runs")];
  const lost = value !== null && runs !== null && value < runs;
  return h("td", { class: lost ? "alarm" : undefined }, runs === null ? fixed(value, 0) : `${fixed(value, 0)} of ${fixed(runs, 0)}`);
}

function headRows(columns: Column[], sort: (column: Column) => void, sorted: Column | null, up: boolean): HTMLElement {
  const groups: [string, number][] = [];
  for (const column of columns) {
    const last = groups[groups.length - 1];
    if (last && last[0] === column.measure.group) last[1]++;
    else groups.push([column.measure.group, 1]);
  }
  return h(
    "thead",
    {},
    h("tr", { class: "groups" }, h("th", { class: "name" }), ...groups.map(([name, span]) => h("th", { colspan: span, scope: "colgroup" }, name))),
    h(
      "tr",
      {},
      h("th", { scope: "col", class: "name" }, "stack"),
      ...columns.map((column, i) => {
        const { measure: m } = column;
        const first = i === 0 || columns[i - 1].measure.group !== m.group;
        return h(
          "th",
          { scope: "col", class: first ? "first" : undefined, title: m.help || undefined, "aria-sort": sorted === column ? (up ? "ascending" : "descending") : undefined },
          h("button", { type: "button", click: () => sort(column) }, m.label, m.unit && m.unit !== "1" ? h("small", {}, ` ${m.unit}`) : null),
        );
      }),
    ),
  );
}

/** "none 10 crashed, gp 8 crashed" */
function lostCounts(state: State): string {
  const { runs, stacks } = state.report.meta;
  const counts = new Map<string, number>();
  for (const { stack, status } of runs) {
    const key = `${stacks[stack].name}\t${status.replace(/_/g, " ")}`;
    if (status && status !== "finished") counts.set(key, (counts.get(key) ?? 0) + 1);
  }
  return [...counts].map(([key, count]) => key.replace("\t", ` ${count} × `)).join(", ");
}

/** Runs that did not finish, those of a stack with the same end together. */
function lostRuns(state: State): string[] {
  const { runs, stacks } = state.report.meta;
  const ends = new Map<string, { stack: number; end: string; seeds: string[] }>();
  for (const { stack, seed, status, message } of runs) {
    if (!status || status === "finished") continue;
    const end = [status.replace(/_/g, " "), message].filter(Boolean).join(": ");
    const key = `${stack} ${end}`;
    const known = ends.get(key) ?? { stack, end, seeds: [] };
    known.seeds.push(seed);
    ends.set(key, known);
  }
  return [...ends.values()].map(({ stack, end, seeds }) => `${stacks[stack].name}, seed${seeds.length > 1 ? "s" : ""} ${seeds.join(", ")}: ${end}`);
}

export function tableSection(state: State): HTMLElement {
  const { table, stacks, runs } = state.report.meta;
  let all = false;
  let sorted: Column | null = null;
  let up = true;
  const box = h("div", { class: "table-scroll", tabindex: 0, role: "region", "aria-label": "Comparison table" });
  const every = table.columns.map((name, index) => ({ index, name, measure: measure(name) }));
  const order = ["Runs", "Lap time", "Pace over limit", "Driving", "Friction", "Step time", "Friction factor", "Size", "Other"];
  every.sort((a, b) => order.indexOf(a.measure.group) - order.indexOf(b.measure.group) || a.index - b.index);
  const used = every.filter((column) => table.rows.some((row) => row.values[column.index] !== null));

  const most = Math.max(0, ...table.rows.flatMap((row) => row.n));
  const draw = () => {
    const columns = used.filter((column) => all || (column.measure.main && lapOf(column.name) < mostLaps));
    const rows = [...table.rows];
    if (sorted) {
      const { index } = sorted;
      const key = (row: TableRow) => row.values[index] ?? Infinity;
      rows.sort((a, b) => (up ? key(a) - key(b) : key(b) - key(a)));
    }
    const able = new Set(state.report.contenders().map((row) => row.stack));
    const bests = columns.map((column) => best(state, column));
    const body = rows.map((row) => {
      const { name, truth } = stacks[row.stack];
      return h(
        "tr",
        {
          class: [truth ? "truth" : "", state.crowded && state.focus === row.stack ? "lit" : "", state.data(row.stack) ? "follows" : ""].filter(Boolean).join(" ") || undefined,
          style: `--c:${stackColour(row.stack)}`,
          click: () => state.data(row.stack) && state.setFocus(row.stack),
          mouseenter: () => state.hover(row.stack),
          mouseleave: () => state.hover(null),
        },
        h("th", { scope: "row", class: "name" }, swatch(row.stack), name, truth ? h("abbr", { title: "is given the ground truth" }, " *") : null),
        ...columns.map((column, i) => cell(state, row, column, bests[i], able.has(row.stack))),
      );
    });
    const sort = (column: Column) => {
      up = sorted === column ? !up : true;
      sorted = column;
      draw();
    };
    redraw(box, h("table", { class: most > 1 ? "comparison dense" : "comparison" }, headRows(columns, sort, sorted, up), h("tbody", {}, ...body)));
  };
  draw();
  state.changed.on(draw);

  const legend = [
    stacks.some((stack) => stack.truth) ? "* is given the true friction." : "",
    state.report.contenders().length < 2 ? "" : `Bold and marked: best${stacks.some((stack) => stack.truth) ? " among the others" : ""}.`,
    most >= leastForInterval ? `Medians over ${most} seeds, below them the 95 % interval of the median.` : most > 1 ? `Medians over ${most} seeds, below them smallest and largest.` : stacks.length > 1 ? "One seed: how much of a difference is chance cannot be told." : "",
  ];
  const more = h("button", { type: "button", class: "quiet" }, "All columns");
  more.addEventListener("click", () => {
    all = !all;
    more.textContent = all ? "Fewer columns" : "All columns";
    draw();
  });
  const lost = runs.filter((run) => run.status && run.status !== "finished");
  const ends = lostRuns(state);
  return h(
    "div",
    {},
    box,
    h("div", { class: "under-table" }, h("p", { class: "note" }, legend.filter(Boolean).join(" ")), used.some((c) => !c.measure.main || lapOf(c.name) >= mostLaps) ? more : null),
    lost.length
      ? h("details", { class: "note lost", open: ends.length <= 6 }, h("summary", {}, `Not finished: ${lostCounts(state)}`), h("ul", {}, ...ends.map((text) => h("li", {}, ...prose(text)))))
      : null,
  );
}

function pairCell(pair: Pair | undefined, m: Measure): HTMLElement {
  if (!pair) return h("td", {}, h("span", { class: "value" }, h("span", { class: "none" }, "–")));
  const signed = (v: number) => `${v > 0 ? "+" : ""}${fixed(v, m.decimals)}`;
  const ends = pair.lo !== null && pair.hi !== null ? `${signed(pair.lo)} to ${signed(pair.hi)}` : "";
  return h(
    "td",
    { title: `p ${plain(pair.p, 2)} over ${pair.draws} draws, at least ${plain(leastP(pair.draws), 2)}${pair.draws < leastForInterval ? "; below: smallest and largest" : ""}` },
    h("span", { class: "value" }, signed(pair.difference)),
    h("span", { class: "interval" }, ends, ends ? ", " : "", `p ${plain(pair.p, 2)}`),
  );
}

/** Every row less the baseline, draw by draw. */
export function pairsSection(state: State): HTMLElement {
  const { pairs, stacks } = state.report.meta;
  const names = [...new Set(pairs.map((pair) => pair.column))].filter((name) => measure(name).main && lapOf(name) < mostLaps);
  const rows = [...new Set(pairs.map((pair) => pair.stack))];
  const draws = Math.max(...pairs.map((pair) => pair.draws));
  const head = names.map((name) => {
    const m = measure(name);
    return h("th", { scope: "col", title: m.help || undefined }, m.group === "Pace over limit" ? `pace, ${m.label}` : m.label, m.unit && m.unit !== "1" ? h("small", {}, ` ${m.unit}`) : null);
  });
  const body = rows.map((stack) =>
    h(
      "tr",
      {},
      h("th", { scope: "row", class: "name" }, swatch(stack), stacks[stack].name),
      ...names.map((name) => pairCell(pairs.find((pair) => pair.stack === stack && pair.column === name), measure(name))),
    ),
  );
  return h(
    "div",
    {},
    h(
      "div",
      { class: "table-scroll", tabindex: 0, role: "region", "aria-label": "Paired differences" },
      h("table", { class: "comparison dense" }, h("thead", {}, h("tr", {}, h("th", { scope: "col", class: "name" }, "stack"), ...head)), h("tbody", {}, ...body)),
    ),
    h("p", { class: "note" }, `Median over up to ${draws} draws of the row less ${stacks[pairs[0].baseline].name} under the same seed; below it ${draws < leastForInterval ? "smallest and largest" : "the 95 % bootstrap interval"} and the sign test, whose p is at least ${plain(leastP(draws), 2)}.`),
  );
}

const verdicts = new Map<boolean | null, [string, string, string]>([
  [true, ["holds", "✓", "holds"]],
  [false, ["fails", "✗", "does not hold"]],
  [null, ["skipped", "○", "not decided"]],
]);

/** The measure that a claim compares: the first column named after a stack. */
function claimMeasure(state: State, text: string): Measure | null {
  const { columns } = state.report.meta.table;
  const name = [...text.matchAll(/\.([A-Za-z_]\w*)/g)].map(([, column]) => column).find((column) => columns.includes(column));
  return name ? measure(name) : null;
}

/** "0.46 against 4.32 s, in 4 of 5 runs"; of one that single runs refute, that they do: its medians look true. */
function claimDetail(state: State, { text, holds, values, why }: Claim): string {
  if (!values) return why;
  const { left, right, medians_hold, runs_held: held, runs, share } = values;
  const sides = [left, right].filter((v): v is number => typeof v === "number" && Number.isFinite(v));
  const m = claimMeasure(state, text);
  // Both sides with the same decimals, as many as it takes to see that they differ.
  const apart = sides.length === 2 ? Math.abs(sides[0] - sides[1]) : 0;
  const most = Math.max(...sides.map(Math.abs));
  const decimals = Math.max(m?.decimals ?? 0, apart > 0 ? Math.min(6, decimalsFor(apart, 1)) : m ? 0 : decimalsFor(most, 4));
  const side = (v: number | null | undefined) => (Math.abs(v ?? 0) >= 1e6 ? plain(v, 4) : fixed(v, decimals));
  const unit = m?.unit && m.unit !== "1" ? ` ${m.unit}` : "";
  const byRuns = holds === false && medians_hold && share !== undefined;
  const inRuns = runs && runs > 1 && held !== undefined ? `in ${held} of ${runs} runs` : "";
  return [
    sides.length ? `${side(left)} against ${side(right)}${unit}${byRuns ? " at the median" : ""}` : "",
    byRuns ? `but holds ${inRuns || "in no run"}, ${percent(share)} wanted` : inRuns,
    why,
  ].filter(Boolean).join(", ");
}

/** The claims that were decided, and those that were not, put aside where they are many. */
export function claimsSection(state: State): HTMLElement {
  const { claims } = state.report.meta;
  const skipped = claims.filter((claim) => claim.holds === null);
  if (skipped.length < 3) return claimList(state, claims);
  const decided = claims.filter((claim) => claim.holds !== null);
  return h(
    "div",
    {},
    decided.length ? claimList(state, decided) : null,
    h("details", { class: "aside" }, h("summary", {}, `${skipped.length} not decided`), claimList(state, skipped)),
  );
}

function claimList(state: State, claims: Claim[]): HTMLElement {
  return h(
    "ul",
    { class: "claims" },
    ...claims.map((claim) => {
      const { text, holds } = claim;
      const detail = claimDetail(state, claim);
      const [style, sign, words] = verdicts.get(holds)!;
      return h(
        "li",
        { class: style },
        h("span", { class: "sign", "aria-hidden": "true" }, sign),
        h("div", {}, h("code", {}, text), h("span", { class: "visually-hidden" }, ` ${words}`), detail ? h("p", { class: "note" }, ...prose(detail)) : null),
      );
    }),
  );
}
