// The page: sections in their order, built when they are needed.
import { chartRange, refreshCharts, repaintCharts, type Chart } from "./chart";
import { ggChart, lapChart, speedDistance, timesChart, tradeOff, tyreChart, undrawable } from "./charts";
import { Report } from "./data";
import { calibratedTable, casesTable, diagnosisHead, gapCharts, healthTable, namedTable, ofRealCar, patchBox, rankingNote, rankingTable, residualCharts, residualMap, seenAtTable } from "./diagnosis";
import { h, redraw } from "./dom";
import { Lazy } from "./figure";
import { bindKeys, helpCard } from "./keys";
import { mapsSection } from "./maps";
import { Course } from "./mapview";
import { Replay } from "./replay";
import { State } from "./state";
import { summarySection } from "./summary";
import { lineSwatch } from "./swatch";
import { claimsSection, pairsSection, tableSection } from "./table";
import { onThemeChange, stackColour } from "./theme";
import { timeCharts } from "./timecharts";
import { validationCharts, validationTable } from "./validation";

interface Section {
  id: string;
  title: string;
  note?: string;
  content: HTMLElement;
}

/** Charts in a grid that are drawn when they come near the window. */
function grid(charts: (Chart | null)[], columns = ""): HTMLElement {
  const present = charts.filter((chart): chart is Chart => chart !== null);
  for (const chart of present) Lazy.when(chart.figure.element, () => chart.build());
  return h("div", { class: `grid ${columns}` }, ...present.map((chart) => chart.figure.element));
}

/** Content that is made when it comes near the window. */
function later(make: () => HTMLElement, height: number): HTMLElement {
  const box = h("div", { style: `min-height:${height}px` });
  Lazy.when(box, () => {
    box.style.minHeight = "";
    box.append(make());
  });
  return box;
}

function part(...children: (HTMLElement | null)[]): HTMLElement {
  return h("div", { class: "stacked" }, ...children);
}

function raceSections(state: State, replay: Replay | null): Section[] {
  const { meta } = state.report;
  const sections: Section[] = [];
  if (meta.table.rows.length) sections.push({ id: "table", title: "Comparison", content: tableSection(state) });
  if (replay) {
    const lost = undrawable(state);
    sections.push({
      id: "replay",
      title: "Replay",
      note: lost ? `${lost}.` : undefined,
      content: part(replay.element),
    });
    sections.push({ id: "time", title: "Over time", note: overTimeNote(state), content: grid(timeCharts(state)) });
  }
  if (meta.pairs?.length) sections.push({ id: "pairs", title: `Against ${meta.stacks[meta.pairs[0].baseline].name}`, content: pairsSection(state) });
  if (meta.claims.length && !meta.cases.length) sections.push({ id: "claims", title: "Claims", content: claimsSection(state) });
  if (replay) {
    const length = () => Course.of(state.report, state.runs()).length;
    sections.push({ id: "laps", title: "Laps", content: grid([lapChart(state), speedDistance(state, length)]) });
    sections.push({ id: "maps", title: "Where they drove", content: later(() => mapsSection(state), 500) });
    sections.push({ id: "grip", title: "Grip", content: grid([tyreChart(state, "front"), tyreChart(state, "rear"), ggChart(state)], "three") });
  }
  const costs = [
    timesChart(state),
    tradeOff(state, "pareto-pace", "Pace against safety", state.report.filled(/^pace_ratio\d+$/).pop() ?? state.report.filled(/^lap\d+_s$/).pop() ?? "", "violation_s"),
    tradeOff(state, "pareto-cost", "Accuracy against cost", "solve_ms_median", "mean_deviation_m"),
  ];
  if (meta.table.rows.length && costs.some(Boolean)) sections.push({ id: "costs", title: "Cost and trade-offs", content: grid(costs, "three") });
  return sections;
}

function overTimeNote(state: State): string {
  const lost = state.runs().some((run) => !run.goesOn);
  return [
    "Point at a chart to move the cars; press ? for keys.",
    state.crowded ? "One row is in colour: point at another, or choose it in a legend or the table." : "",
    lost ? "Axes make room for the runs that go on; ✕ is where one ended that did not." : "",
  ].filter(Boolean).join(" ");
}

function diagnosisSections(state: State): Section[] {
  const { diagnosis: d, diagnosis_report: more } = state.report.meta;
  if (!d) return [];
  const extra = more ?? {};
  const sections: Section[] = [{ id: "verdict", title: "What was found", content: part(diagnosisHead(d, more), namedTable(d, extra.effects)) }];
  const calibrated = calibratedTable(d, extra);
  if (calibrated) sections.push({ id: "calibrated", title: "Calibrated parameters", note: ofRealCar(d) ? "What the logs do not determine is not listed." : undefined, content: calibrated });
  if (extra.residual) sections.push({ id: "where", title: "Where it shows", content: part(later(() => residualMap(extra) ?? h("div"), 400), grid(residualCharts(state, extra, d), "three")) });
  if (extra.horizon || extra.traces?.length) sections.push({ id: "gap", title: "Before and after", content: grid(gapCharts(state, extra)) });
  const ranking = rankingTable(d, extra.effects);
  if (ranking) sections.push({ id: "ranking", title: "Ranking of effects", note: rankingNote(d), content: ranking });
  const seen = seenAtTable(extra);
  if (seen) sections.push({ id: "sensitivity", title: "What would have been seen", content: seen });
  const patch = patchBox(state);
  if (patch) sections.push({ id: "patch", title: "Repair", content: patch });
  const health = healthTable(extra);
  if (health) sections.push({ id: "health", title: "The log's health", content: health });
  return sections;
}

function validationNote(state: State): string {
  const { scene } = state.report.meta;
  return [
    scene?.kind === "force_validation"
      ? "R² and root mean square error over the first full lap after each trusts what it learned; it is asked about a step before it learns from it."
      : "R² and root mean square error on data that was not used for training.",
    scene?.told?.length ? "* is given the true friction; bold and marked: best among the others." : "",
  ].filter(Boolean).join(" ");
}

function validationSections(state: State): Section[] {
  const { validation, traces } = state.report.meta;
  if (!validation.length && !traces.length) return [];
  return [{ id: "validation", title: "Validation", note: validationNote(state), content: part(validation.length ? validationTable(state) : null, grid(validationCharts(state))) }];
}

function chips(state: State): HTMLElement {
  const bar = h("div", { class: "chips", role: "group", "aria-label": "Stacks on show" });
  const draw = () =>
    redraw(
      bar,
      ...state.report.meta.stacks.map(({ truth }, stack) =>
        h(
          "button",
          {
            type: "button",
            class: "chip",
            style: `--c:${stackColour(stack)}`,
            "aria-pressed": String(state.visible.has(stack)),
            title: "Click: show or hide. Shift-click: alone.",
            click: (event: MouseEvent) => (event.shiftKey ? state.solo(stack) : state.toggle(stack)),
            mouseenter: () => state.hover(stack),
            mouseleave: () => state.hover(null),
          },
          lineSwatch(stack, truth),
          state.report.label(stack),
        ),
      ),
    );
  draw();
  state.changed.on(draw);
  onThemeChange(draw);
  return bar;
}

function seedChoice(state: State): HTMLElement | null {
  const { seeds } = state.report;
  if (seeds.length < 2) return null;
  const select = h("select", {}, ...seeds.map((seed) => h("option", { value: seed }, `seed ${seed}`)));
  select.addEventListener("change", () => state.setSeed(select.value));
  return h("label", { class: "seed" }, h("span", { class: "visually-hidden" }, "Seed"), select);
}

/** Which row is in colour where there are many. */
function colourChoice(state: State): HTMLElement {
  const box = h("span");
  const draw = () => {
    const label = (stack: number) => state.report.label(stack);
    const select = h(
      "select",
      { "aria-label": "In colour" },
      ...state.runs().map(({ stack }) => h("option", { value: stack, selected: !state.alike && stack === state.focus }, `${label(stack)} in colour`)),
      h("option", { value: -1, selected: state.alike }, "all in colour"),
    );
    select.addEventListener("change", () => {
      const stack = Number(select.value);
      if (stack < 0) return state.setAlike(true);
      state.alike = false;
      state.setFocus(stack);
    });
    if (state.crowded) redraw(box, select);
    else box.replaceChildren();
  };
  draw();
  state.changed.on(draw);
  return box;
}

/** On a narrow screen sections are folded but for the first ones; a link to one opens it. */
function bindFolds(sections: Section[], open: number): void {
  const narrow = matchMedia("(max-width: 560px)");
  const fold = (id: string, title: string, folded: boolean) => {
    const section = document.getElementById(id)!;
    const head = section.querySelector("h2")!;
    section.classList.toggle("folds", narrow.matches);
    section.classList.toggle("folded", folded && narrow.matches);
    if (!narrow.matches) return head.replaceChildren(title);
    const button = h("button", { type: "button", class: "fold", "aria-expanded": String(!folded), click: () => fold(id, title, button.getAttribute("aria-expanded") === "true") }, title);
    redraw(head, button);
  };
  const all = () => sections.slice(open).forEach(({ id, title }) => fold(id, title, true));
  all();
  narrow.addEventListener("change", all);
  const opened = () => sections.slice(open).forEach(({ id, title }) => location.hash === `#${id}` && fold(id, title, false));
  addEventListener("hashchange", opened);
  opened();
}

function topBar(state: State, sections: Section[], openHelp: () => void): HTMLElement {
  const links = sections.map(({ id, title }) => h("a", { href: `#${id}` }, title));
  const watcher = new IntersectionObserver(
    (entries) => {
      for (const { target, isIntersecting } of entries) if (isIntersecting) links.forEach((link) => link.classList.toggle("here", link.hash === `#${target.id}`));
    },
    { rootMargin: "-20% 0px -75% 0px" },
  );
  requestAnimationFrame(() => sections.forEach(({ id }) => watcher.observe(document.getElementById(id)!)));
  const raced = state.report.meta.runs.some((run) => run.block);
  return h(
    "div",
    { class: "top" },
    h("nav", { "aria-label": "Sections" }, h("span", { class: "brand" }, "gripline"), ...links, h("button", { type: "button", class: "quiet help-button", "aria-label": "Keyboard help", click: openHelp }, "?")),
    raced ? h("div", { class: "choices" }, chips(state), colourChoice(state), seedChoice(state)) : null,
  );
}

function footer(state: State): HTMLElement {
  const { version, provenance } = state.report.meta;
  return h(
    "footer",
    {},
    h("p", {}, `Written by gripline ${version}. This file holds everything it shows and asks nobody for anything.`),
    provenance ? h("details", {}, h("summary", {}, "Where this comes from"), h("pre", {}, h("code", {}, JSON.stringify(provenance, null, 2)))) : null,
  );
}

function start(): void {
  const report = new Report();
  const state = new State(report);
  const replay = state.runs().some((run) => run.channel("x")) ? new Replay(state) : null;
  const { cases, claims } = report.meta;
  const overview: Section[] = cases.length ? [{ id: "cases", title: "Cases", note: "Error over 1 s on data that was not fitted, in sensor standard deviations.", content: casesTable(cases) }] : [];
  if (cases.length && claims.length) overview.push({ id: "claims", title: "Claims", content: claimsSection(state) });
  const sections = [...overview, ...diagnosisSections(state), ...raceSections(state, replay), ...validationSections(state)];
  const card = helpCard();
  const app = document.getElementById("app")!;
  app.replaceChildren(
    h("a", { class: "skip", href: "#main" }, "Skip to the content"),
    topBar(state, sections, () => card.showModal()),
    h(
      "main",
      { id: "main" },
      summarySection(state),
      ...sections.map(({ id, title, note, content }) => h("section", { id, "aria-labelledby": `${id}-title` }, h("h2", { id: `${id}-title` }, title), note ? h("p", { class: id === "time" ? "section-note on-screen" : "section-note" }, note) : null, content)),
    ),
    footer(state),
    card,
  );
  const opened = sections.findIndex(({ id }) => id === "replay");
  bindFolds(sections, Math.max(opened + 1, 1));
  state.changed.on(() => refreshCharts());
  state.hovered.on(repaintCharts);
  // Paper shows everything.
  onThemeChange(() => refreshCharts(matchMedia("print").matches));
  bindKeys(state, replay, card);
  addEventListener("beforeprint", () => {
    Lazy.openAll();
    refreshCharts(true);
  });
  const idle = window.requestIdleCallback ?? ((work: () => void) => setTimeout(work, 50));
  const fillIn = () => {
    if (Lazy.openOne()) idle(fillIn);
  };
  idle(fillIn);
  // For tests and the curious.
  Object.assign(window, { gripline: { state, replay, chartRange } });
  performance.mark("gripline-built");
}

try {
  start();
} catch (error) {
  // A page that cannot draw itself says so; the console has the rest.
  document.getElementById("app")!.replaceChildren(
    h("main", {}, h("h1", {}, "This report cannot be drawn"), h("p", {}, `${error instanceof Error ? error.message : error}. One of the files it was made from is not as gripline writes it; race again, or look at table.csv and runs.csv.`)),
  );
  throw error;
}
