// The head of the page: what was raced, and what came out of it in a few figures.
import { fixed, h, plural, prose } from "./dom";
import { measure } from "./measures";
import type { State } from "./state";
import { swatch } from "./swatch";
import type { Claim } from "./types";

interface Winner {
  stack: number;
  value: number;
}

/** Best value of a column among the contenders; null if there is nobody to beat. */
function winner(state: State, column: string): Winner | null {
  const index = state.report.column(column);
  const able = state.report.contenders();
  if (index < 0 || able.length < 2) return null;
  let best: Winner | null = null;
  for (const row of able) {
    const value = row.values[index];
    if (value === null) continue;
    if (!best || value < best.value) best = { stack: row.stack, value };
  }
  return best;
}

/** "4 laps", or how many of them were driven at most. */
function drivenLaps(state: State): string {
  const { scene, runs } = state.report.meta;
  const finished = runs.map((run) => Object.keys(run.values).filter((name) => /^lap\d+_s$/.test(name)).length);
  if (!runs.length) return "";
  const most = Math.max(...finished);
  const asked = scene?.laps ?? 0;
  if (!asked || most >= asked) return most ? plural(most, "lap") : "no lap finished";
  return most ? `${most} of ${plural(asked, "lap")} driven` : `none of ${plural(asked, "lap")} finished`;
}

function tile(label: string, value: string, who: Node | string | null): HTMLElement {
  return h("div", { class: "tile" }, h("span", { class: "tile-label" }, label), h("strong", {}, value), h("span", { class: "tile-who" }, who));
}

/** Claims that do not hold, as far as they fit: a reader must not have to look for them. */
function failedClaims(claims: Claim[]): HTMLElement {
  const failed = claims.filter((claim) => claim.holds === false);
  const shown = failed.slice(0, 4);
  return h(
    "ul",
    { class: "failed" },
    ...shown.map(({ text }) => h("li", {}, h("span", { class: "sign" }, "✗"), h("code", {}, text), " does not hold")),
    failed.length > shown.length ? h("li", {}, h("a", { href: "#claims" }, `and ${failed.length - shown.length} more`)) : null,
  );
}

export function summarySection(state: State): HTMLElement {
  const { meta } = state.report;
  const { scene, stacks, claims, runs, table } = meta;
  const name = (stack: number) => h("span", {}, swatch(stack), state.report.label(stack));
  const tiles: HTMLElement[] = [];

  const decided = claims.filter((claim) => claim.holds !== null);
  if (decided.length) {
    const held = decided.filter((claim) => claim.holds).length;
    const skipped = claims.length - decided.length;
    tiles.push(tile("Claims that hold", `${held} of ${decided.length}`, skipped ? `${skipped} not decided` : null));
  }
  const lastLap = table.columns.filter((c) => /^lap\d+_s$/.test(c)).pop();
  for (const [label, column] of [
    ["Fastest last lap", lastLap ?? ""],
    ["Least time outside", "violation_s"],
    ["Closest to its line", "mean_deviation_m"],
    ["Cheapest solve", "solve_ms_median"],
  ]) {
    const best = winner(state, column);
    const { unit, decimals } = measure(column);
    if (!best) continue;
    // Several equal firsts are no news about one of them.
    const equal = state.report.contenders().filter((row) => fixed(row.values[state.report.column(column)], decimals) === fixed(best.value, decimals));
    tiles.push(tile(label, `${fixed(best.value, decimals)} ${unit}`, equal.length > 1 ? `${equal.length} stacks alike` : name(best.stack)));
  }
  const seeds = state.report.seeds.length;
  const parts = [
    stacks.length ? plural(stacks.length, "stack") : "",
    seeds ? plural(seeds, "seed") + (scene?.seeds_from ? ` drawn from “${scene.seeds_from}”` : "") : "",
    drivenLaps(state),
    scene?.world ? `world ${scene.world}` : "",
  ].filter(Boolean);
  const broken = runs.filter((run) => run.status && run.status !== "finished").length;
  return h(
    "header",
    { class: "summary" },
    h("p", { class: "eyebrow" }, [scene?.kind ?? (meta.diagnosis ? "diagnosis" : "report"), ...parts].map((part, i) => (i ? part : part.replace(/_/g, " "))).join(" · ")),
    h("h1", {}, meta.title),
    scene?.note ? h("p", { class: "lede" }, ...prose(scene.note)) : null,
    decided.some((claim) => !claim.holds) ? failedClaims(claims) : null,
    broken ? h("p", { class: "lede alarm" }, `${broken} of ${plural(runs.length, "run")} did not finish.`) : null,
    tiles.length > 1 ? h("div", { class: "tiles" }, ...tiles) : null,
  );
}
