// The comparison table, and the claims.
import { fixed, h, plain } from "./dom";
import { measure, type Measure } from "./measures";
import type { State } from "./state";
import { stackColour } from "./theme";
import type { Claim, TableRow } from "./types";

interface Column {
  index: number;
  name: string;
  measure: Measure;
}

/** The best value of a column among stacks that were not told the truth; null where nothing is better than another. */
function best(state: State, column: Column): number | null {
  const { rows } = state.report.meta.table;
  const values = rows
    .filter((row) => !state.report.meta.stacks[row.stack].truth)
    .map((row) => row.values[column.index])
    .filter((v): v is number => v !== null);
  if (values.length < 2 || !column.measure.better) return null;
  const [low, high] = [Math.min(...values), Math.max(...values)];
  if (low === high) return null;
  return column.measure.better === "low" ? low : high;
}

function cell(row: TableRow, column: Column, bestValue: number | null, truth: boolean): HTMLElement {
  const { index, measure: m } = column;
  const value = row.values[index];
  const shown = fixed(value, m.decimals);
  const isBest = bestValue !== null && !truth && value !== null && fixed(bestValue, m.decimals) === shown;
  const [low, high] = [row.low[index], row.high[index]];
  const spread = low !== null && high !== null && fixed(low, m.decimals) !== fixed(high, m.decimals);
  return h(
    "td",
    { class: isBest ? "best" : undefined },
    h("span", { class: "value" }, value === null ? h("span", { class: "none" }, "–") : shown, isBest ? h("span", { class: "visually-hidden" }, " (best)") : null),
    spread ? h("span", { class: "interval" }, `${fixed(low, m.decimals)} – ${fixed(high, m.decimals)}`) : null,
  );
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

export function tableSection(state: State): HTMLElement {
  const { table, stacks, runs } = state.report.meta;
  let all = false;
  let sorted: Column | null = null;
  let up = true;
  const box = h("div", { class: "table-scroll", tabindex: 0, role: "region", "aria-label": "Comparison table" });
  const every = table.columns.map((name, index) => ({ index, name, measure: measure(name) }));
  const order = ["Lap time", "Pace over limit", "Driving", "Friction", "Step time", "Runs", "Friction factor", "Other"];
  every.sort((a, b) => order.indexOf(a.measure.group) - order.indexOf(b.measure.group) || a.index - b.index);
  const used = every.filter((column) => table.rows.some((row) => row.values[column.index] !== null));

  const draw = () => {
    const columns = used.filter((column) => all || column.measure.main);
    const rows = [...table.rows];
    if (sorted) {
      const { index } = sorted;
      const key = (row: TableRow) => row.values[index] ?? Infinity;
      rows.sort((a, b) => (up ? key(a) - key(b) : key(b) - key(a)));
    }
    const bests = columns.map((column) => best(state, column));
    const body = rows.map((row) => {
      const { name, truth } = stacks[row.stack];
      return h(
        "tr",
        { class: truth ? "truth" : undefined, mouseenter: () => state.hover(row.stack), mouseleave: () => state.hover(null) },
        h("th", { scope: "row", class: "name" }, h("i", { class: "swatch", style: `--c:${stackColour(row.stack)}` }), name, truth ? h("abbr", { title: "was told the truth" }, " *") : null),
        ...columns.map((column, i) => cell(row, column, bests[i], truth)),
      );
    });
    const sort = (column: Column) => {
      up = sorted === column ? !up : true;
      sorted = column;
      draw();
    };
    box.replaceChildren(h("table", { class: "comparison" }, headRows(columns, sort, sorted, up), h("tbody", {}, ...body)));
  };
  draw();
  state.changed.on(draw);

  const most = Math.max(0, ...table.rows.flatMap((row) => row.n));
  const legend = [
    stacks.some((stack) => stack.truth) ? "* was told the true friction." : "",
    "Bold and marked: best among the others.",
    most >= 6 ? `Medians over ${most} seeds, below them the 95 % interval of the median.` : most > 1 ? `Medians over ${most} seeds, below them smallest and largest.` : "",
  ];
  const more = h("button", { type: "button", class: "quiet" }, "All columns");
  more.addEventListener("click", () => {
    all = !all;
    more.textContent = all ? "Fewer columns" : "All columns";
    draw();
  });
  const lost = runs.filter((run) => run.status && run.status !== "finished");
  return h(
    "div",
    {},
    box,
    h("div", { class: "under-table" }, h("p", { class: "note" }, legend.filter(Boolean).join(" ")), used.some((c) => !c.measure.main) ? more : null),
    lost.length
      ? h("p", { class: "note" }, "Not finished: ", lost.map((run) => `${stacks[run.stack].name}, seed ${run.seed} (${[run.status, run.message].filter(Boolean).join(": ")})`).join("; "), ".")
      : null,
  );
}

const verdicts = new Map<boolean | null, [string, string, string]>([
  [true, ["holds", "✓", "holds"]],
  [false, ["fails", "✗", "does not hold"]],
  [null, ["skipped", "○", "not decided"]],
]);

/** "0.46 against 4.32, in 4 of 5 runs" */
function claimDetail({ values, why }: Claim): string {
  if (!values) return why;
  const { left, right, runs_held: held, runs } = values;
  const known = (v: number | null | undefined) => v !== null && v !== undefined;
  return [known(left) || known(right) ? `${plain(left, 4)} against ${plain(right, 4)}` : "", runs && runs > 1 && held !== undefined ? `in ${held} of ${runs} runs` : "", why].filter(Boolean).join(", ");
}

export function claimsSection(claims: Claim[]): HTMLElement {
  return h(
    "ul",
    { class: "claims" },
    ...claims.map((claim) => {
      const { text, holds } = claim;
      const detail = claimDetail(claim);
      const [style, sign, words] = verdicts.get(holds)!;
      return h(
        "li",
        { class: style },
        h("span", { class: "sign", "aria-hidden": "true" }, sign),
        h("div", {}, h("code", {}, text), h("span", { class: "visually-hidden" }, ` ${words}`), detail ? h("p", { class: "note" }, detail) : null),
      );
    }),
  );
}
