// The diagnosis: what is missing in the model, where it shows, how sure that is, and what the repair gains.
import { Chart, type ChartSpec } from "./chart";
import { download, fixed, h, percent, plain, prose, unitText } from "./dom";
import { makeFigure } from "./figure";
import { Columns } from "./data";
import { Course, drawCourse, fit } from "./mapview";
import type { Mark } from "./marks";
import { CanvasPen, SvgPen, type Pen } from "./pen";
import type { State } from "./state";
import { onThemeChange, sequential, stackColour, token } from "./theme";
import type { Case, Change, Diagnosis, DiagnosisReport, Rollout } from "./types";

const numbers = (values: (number | null)[] | undefined) => Float64Array.from(values ?? [], (v) => v ?? NaN);

type Words = DiagnosisReport["effects"];

function sentenceCase(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}

/** Delays of channels are no plugins, whose words the report has. */
const lateChannels: Record<string, string> = {
  position_delay: "the position channels are",
  yaw_delay: "the yaw channel is",
  velocity_delay: "the speed channels are",
  yaw_rate_delay: "the yaw-rate channel is",
};

/** "the wheels follow the steering with a first-order lag (time constant 0.08 s)"; the id where no words are known. */
function inWords(effect: string, params: Record<string, number | null> | undefined, words: Words): string {
  const late = lateChannels[effect];
  const delay = params?.T;
  if (late && delay != null) return `${late} ${plain(delay)} s late`;
  const known = wordsOf(words, effect);
  const sizes = Object.entries(params ?? {});
  if (!known) return sizes.length && sizes.length < 4 ? `${effect} (${sizes.map(([name, value]) => `${name} = ${plain(value)}`).join(", ")})` : effect;
  const size = ([name, value]: [string, number | null]) => {
    const p = known.params[name];
    const number = `${plain(value)}${p?.unit && p.unit !== "1" ? ` ${unitText(p.unit)}` : ""}`;
    // In a headline a long description is in the way: the table has it.
    return p && p.words.length <= 24 ? `${p.words} ${number}` : sizes.length > 1 ? `${name} ${number}` : number;
  };
  return sizes.length && sizes.length < 4 ? `${known.words} (${sizes.map(size).join(", ")})` : known.words;
}

/** "80 % (78 % to 82 %)", of a decrease. */
function decrease({ change, ci95 }: Change): string {
  const [most, least] = ci95.map((end) => percent(-(end ?? NaN)));
  return `${percent(-(change ?? NaN))} (${least} to ${most})`;
}

/** Whether errors are those of a real car's logs, where calibrating and effects are told apart. */
export function ofRealCar({ gap }: Diagnosis): boolean {
  return gap?.calibrated !== undefined;
}

/** Whether what is left is no more than what sensors alone would leave: then the whole gap is closed. */
function withinNoise({ gap }: Diagnosis): boolean {
  return gap?.noise != null && gap.after !== null && gap.after <= gap.noise;
}

/** How much of the gap is closed, as people say it. */
function closes(d: Diagnosis): string {
  const { gap } = d;
  if (!gap) return "";
  const many = (d.named ?? []).length > 1;
  const errors = `the error of ${plain(gap.horizon_s)} s predictions, on data that was not fitted,`;
  if (ofRealCar(d)) {
    const effects = gap.effects ? ` The effects that are missing take ${decrease(gap.effects)} off what is left then: ${plain(gap.after)} σ.` : "";
    return `${sentenceCase(errors)} is ${plain(gap.before)} σ with the world as given and ${plain(gap.calibrated)} σ with its unknowns fitted.${effects}`;
  }
  if (!gap.closure) return "Predictions on data that was not fitted get no better than by chance.";
  const [low, high] = gap.closure_ci95 ?? [];
  const range = low != null && high != null ? ` (${percent(low)} to ${percent(high)})` : "";
  return `With ${many ? "them" : "it"} the model closes ${percent(gap.closure)} of its gap${range}: ${errors} falls from ${plain(gap.before)} to ${plain(gap.after)} σ.`;
}

/** The candidate that helps predictions most by itself, where nothing was named. */
function nearest(d: Diagnosis, words: Words): string {
  const best = (d.ranking ?? [])
    .filter((entry) => entry.rollout?.says === "helps" && entry.rollout.change !== null)
    .sort((a, b) => a.rollout!.change! - b.rollout!.change!)[0];
  if (!best) {
    const tried = ofRealCar(d) ? "effect that was tried" : "effect of the catalogue";
    const untold = (d.ranking ?? []).some((entry) => entry.rollout?.says === "cannot tell");
    return untold ? `No ${tried} makes predictions significantly better by itself: the data that was not fitted cannot tell.` : `No ${tried} makes predictions better by itself.`;
  }
  return `What comes nearest: ${inWords(best.effect, undefined, words)}; by itself it changes the prediction error by ${fixed(100 * best.rollout!.change!, 0)} %.`;
}

/** What was found, in words. */
function headline(d: Diagnosis, words: Words): string {
  const named = (d.named ?? []).map(({ effect, params }) => inWords(effect, params, words));
  const last = named.pop();
  const list = last ? `${sentenceCase([named.join("; "), last].filter(Boolean).join("; and "))}.` : "";
  switch (d.verdict) {
    case "named":
      return list;
    case "nothing_missing":
      return "The model lacks nothing that this log could show.";
    case "indistinguishable":
      return `${list} Other explanations fit this log as well.`;
    case "unknown": {
      const found = [refitted(d), list].filter(Boolean).join(" ");
      const rest = d.gap?.at_noise
        ? "What is left is as large as the sensors' own noise: these logs tell nothing more."
        : d.gap?.noise_too_large
          ? "The sensors' noise is measured too large to say what is left."
          : withinNoise(d)
            ? "What is left is in sum no more than sensor noise alone would leave."
            : "The rest is not known.";
      return found || d.gap?.at_noise || withinNoise(d) ? `${found} ${rest}`.trim() : "Something is missing that the catalogue does not know.";
    }
  }
}

/** What fitting the world's own parameters takes off, where that is told apart from effects or nothing else was found. */
function refitted({ gap, named, nominal_fit }: Diagnosis): string {
  if (gap?.calibration) return (gap.calibration.change ?? 0) < 0 ? `Calibrating the world takes ${decrease(gap.calibration)} off the error of predictions.` : "";
  if (named?.length || !gap?.closure || !Object.keys(nominal_fit ?? {}).length) return "";
  return `Refitting ${Object.keys(nominal_fit!).join(", ")} closes ${percent(gap.closure)} of the gap.`;
}

/** The words of an effect, or of that to which a parameter belongs ("steer_map.a"). */
function wordsOf(words: Words, effect: string) {
  return words?.[effect] ?? words?.[effect.split(".")[0]];
}

function whereText({ unknown }: Diagnosis): string {
  if (!unknown) return "";
  const quantity = { position: "along the lap", time: "over time", state: "with the car's state", input: "with the commands", reading: "in the readings" }[unknown.where] ?? unknown.where;
  const unit = unknown.where === "time" ? " s" : "";
  return `What is left shows ${quantity}${unknown.interval ? `, from ${plain(unknown.interval[0])} to ${plain(unknown.interval[1])}${unit || " of the lap"}` : ""}.`;
}

/** What to say if the diagnosis did not say it itself. */
function sentence(d: Diagnosis): string {
  const names = (d.named ?? []).map(({ effect, params, confidence }) => {
    const values = Object.entries(params ?? {}).map(([name, value]) => `${name} ${plain(value)}`);
    return `${effect} (${values.join(", ")}${confidence == null ? "" : `; ${percent(confidence)} sure`})`;
  });
  switch (d.verdict) {
    case "named":
      return `The model lacks ${names.join(" and ")}.`;
    case "nothing_missing":
      return "Nothing is missing: no effect of the catalogue is supported by the log.";
    case "indistinguishable":
      return `Something is missing, but the log cannot tell apart ${(d.equivalent ?? []).map((set) => set.join(", ")).join("; ")}.`;
    case "unknown":
      return `Something is missing that the catalogue cannot explain; it shows by ${d.unknown?.where ?? "no single quantity"}${d.unknown?.interval ? ` in ${plain(d.unknown.interval[0])} to ${plain(d.unknown.interval[1])}` : ""}.`;
  }
}

const verdictWords: Record<Diagnosis["verdict"], string> = {
  named: "Named",
  nothing_missing: "Nothing missing",
  indistinguishable: "Cannot be told apart",
  unknown: "Unknown effect",
};

/** How much of the gap is closed, as a bar. */
function gapBar(d: Diagnosis): HTMLElement | null {
  const closure = d.gap?.closure;
  if (!closure) return null;
  const share = (100 * Math.min(Math.max(closure, 0), 1)).toFixed(1);
  return h("div", { class: "gap-bar", role: "img", "aria-label": `${percent(closure)} of the gap closed` }, h("i", { style: `width:${share}%` }), h("span", {}, `${percent(closure)} of the gap`));
}

/** What the verdict comes to, in a few words. */
function badge(d: Diagnosis): string {
  if (d.gap?.at_noise) return "As good as the sensors";
  if (d.gap?.noise_too_large) return "Noise measured too large";
  return withinNoise(d) ? "In sum as good as the sensors" : verdictWords[d.verdict];
}

export function diagnosisHead(d: Diagnosis, more: DiagnosisReport | null): HTMLElement {
  const words = more?.effects;
  const found = (d.named ?? []).length > 0 || (d.verdict === "unknown" && refitted(d) !== "");
  const atNoise = d.gap?.at_noise === true;
  const open = d.verdict === "unknown" && !atNoise && !withinNoise(d);
  return h(
    "div",
    { class: "verdict" },
    h("p", { class: "sentence" }, ...prose(headline(d, words))),
    gapBar(d),
    h("p", { class: "lede" }, ...prose([found ? closes(d) : "", d.verdict === "unknown" && !atNoise && !(d.named ?? []).length ? nearest(d, words) : "", open ? whereText(d) : ""].filter(Boolean).join(" "))),
    d.manoeuvre ? h("p", { class: "lede" }, h("strong", {}, "To decide: "), ...prose(d.manoeuvre)) : null,
    h("p", { class: "note" }, h("span", { class: `badge ${d.verdict}` }, badge(d)), " ", ...prose(more?.sentence || sentence(d))),
    more?.log ? h("p", { class: "note" }, `Log ${more.log}${more.world ? `, world ${more.world}` : ""}.`) : null,
  );
}

/** The cases of an experiment: what was found in each, whether that was right, and the way to its own page. */
export function casesTable(cases: Case[]): HTMLElement {
  const head = ["case", "found", "right", "confidence", "error before", "after", "gap closed"];
  const sigmas = (v: number | undefined) => (v === undefined ? "–" : `${fixed(v, 2)} σ`);
  const right = (v: number | undefined) => (v === undefined ? "–" : v === 1 ? "✓ yes" : v > 0 ? "among others" : "✗ no");
  return h(
    "div",
    { class: "table-scroll", tabindex: 0, role: "region", "aria-label": "Cases" },
    h(
      "table",
      { class: "comparison" },
      h("thead", {}, h("tr", {}, ...head.map((text, i) => h("th", { scope: "col", class: i === 0 ? "name" : i === 1 ? "text" : undefined }, text)))),
      h(
        "tbody",
        {},
        ...cases.map(({ case: name, verdict, sentence: words, page, values: v }) =>
          h(
            "tr",
            {},
            h("th", { scope: "row", class: "name" }, page ? h("a", { href: `${encodeURIComponent(name)}/report.html` }, name) : name),
            h("td", { class: "text found" }, h("strong", {}, verdictWords[verdict as Diagnosis["verdict"]] ?? verdict), words ? h("p", { class: "note" }, ...prose(words)) : null),
            h("td", { class: v.right === 0 ? "alarm" : undefined }, right(v.right)),
            h("td", {}, percent(v.confidence)),
            h("td", {}, sigmas(v.before)),
            h("td", {}, sigmas(v.after)),
            h("td", {}, percent(v.closure)),
          ),
        ),
      ),
    ),
  );
}

export function namedTable(d: Diagnosis, words: Words): HTMLElement | null {
  const rows = (d.named ?? []).flatMap(({ effect, params, units, ci95, confidence }) =>
    Object.entries(params ?? {}).map(([name, value], i) => {
      const interval = ci95?.[name];
      const unit = unitOf(words, effect, name) || (units?.[name] && units[name] !== "1" ? unitText(units[name]) : "");
      return h(
        "tr",
        {},
        h("th", { scope: "row", class: "text" }, i === 0 ? sentenceCase(wordsOf(words, effect)?.words ?? (lateChannels[effect] ? `${lateChannels[effect]} late` : effect)) : ""),
        h("td", { class: "text" }, i === 0 ? h("code", {}, effect) : ""),
        h("td", { class: "text" }, wordsOf(words, effect)?.params[name]?.words ?? "", " ", h("code", {}, name)),
        h("td", {}, `${plain(value, 4)} ${unit}`),
        h("td", {}, interval ? `${plain(interval[0], 4)} to ${plain(interval[1], 4)}` : "–"),
        h("td", {}, i === 0 && confidence != null ? percent(confidence) : ""),
      );
    }),
  );
  if (!rows.length) return null;
  const head = ["what is missing", "id", "parameter", "value", "95 % interval", "confidence"];
  return h("div", { class: "table-scroll" }, h("table", { class: "comparison plain" }, h("thead", {}, h("tr", {}, ...head.map((text, i) => h("th", { scope: "col", class: i < 3 ? "text" : undefined }, text)))), h("tbody", {}, ...rows)));
}

/** What fitting made of the world's own parameters. Older files have only what was found. */
export function calibratedTable(d: Diagnosis, more: DiagnosisReport): HTMLElement | null {
  const rows = more.calibrated ?? Object.entries(d.nominal_fit ?? {}).map(([param, found]) => ({ param, given: null, found, ci95: null }));
  if (!rows.length) return null;
  const head = ["parameter", "as given", "calibrated", "95 % interval"];
  return h(
    "div",
    { class: "table-scroll", tabindex: 0, role: "region", "aria-label": "Calibrated parameters" },
    h(
      "table",
      { class: "comparison plain" },
      h("thead", {}, h("tr", {}, ...head.map((text, i) => h("th", { scope: "col", class: i === 0 ? "name" : undefined }, text)))),
      h(
        "tbody",
        {},
        ...rows.map(({ param, given, found, ci95 }) =>
          h(
            "tr",
            {},
            h("th", { scope: "row", class: "text" }, h("code", {}, param.replace(/^\/plant\/params\//, ""))),
            ...[given, found].map((v) => h("td", {}, plain(v, 4))),
            h("td", {}, ci95 && ci95[0] !== null ? `${plain(ci95[0], 4)} to ${plain(ci95[1], 4)}` : "–"),
          ),
        ),
      ),
    ),
  );
}

function unitOf(words: Words, effect: string, param: string): string {
  const unit = wordsOf(words, effect)?.params[param]?.unit;
  return unit && unit !== "1" ? unitText(unit) : "";
}

/** "helps, -42 % (-50 to -33 %)", or only that nothing can be told. */
function rolloutText(r: Rollout | undefined): string {
  if (!r || r.change === null || r.says === "cannot tell") return r?.says ?? "";
  const share = (v: number | null) => fixed(100 * (v ?? NaN), 1);
  return `${r.says}, ${share(r.change)} % (${share(r.ci95[0])} to ${share(r.ci95[1])} %)`;
}

/** Rows of the ranking that are shown, where those that were tried or named leave room for others. */
const mostRanked = 20;

export function rankingTable(d: Diagnosis, words: Words): HTMLElement | null {
  const ranking = d.ranking ?? [];
  if (!ranking.length) return null;
  const real = ofRealCar(d);
  const gain = (entry: { gain?: number | null; less_error?: number | null }) => (real ? entry.less_error : entry.gain) ?? null;
  const most = Math.max(...ranking.map((entry) => gain(entry) ?? 0), 1e-9);
  const named = new Set((d.named ?? []).map((entry) => entry.effect));
  const bar = (share: number) => h("span", { class: "bar-cell" }, h("i", { style: `width:${(100 * Math.min(Math.max(share, 0), 1)).toFixed(1)}%` }));
  const head = ["effect", real ? "squared error, fitted" : "evidence gained", "", "error with it", "predictions", real ? "probability that it helps" : "wins resampled"];
  const gained = (value: number | null) => (real ? `${fixed(value === null ? value : -100 * value, 1)} %` : fixed(value, 1));
  // A candidate that was not fitted has no error of its own.
  const tried = (entry: { held_out: number | null }) => entry.held_out !== null;
  const kept = (entry: (typeof ranking)[number]) => tried(entry) || named.has(entry.effect);
  let room = mostRanked - ranking.filter(kept).length;
  const shown = ranking.filter((entry) => kept(entry) || room-- > 0);
  const table = h(
    "div",
    { class: "table-scroll", tabindex: 0, role: "region", "aria-label": "Ranking of effects" },
    h(
      "table",
      { class: "comparison plain" },
      h("thead", {}, h("tr", {}, ...head.map((text, i) => h("th", { scope: "col", class: i === 0 ? "name" : undefined }, text)))),
      h(
        "tbody",
        {},
        ...shown.map((entry) =>
          h(
            "tr",
            { class: named.has(entry.effect) ? "chosen" : undefined },
            h("th", { scope: "row", class: "text effect" }, sentenceCase(wordsOf(words, entry.effect)?.words ?? ""), wordsOf(words, entry.effect) ? " " : "", h("code", {}, entry.effect)),
            h("td", {}, gained(gain(entry))),
            h("td", { class: "wide" }, bar((gain(entry) ?? 0) / most)),
            h("td", {}, tried(entry) ? `${fixed(entry.held_out, (entry.held_out ?? 1) < 0.1 ? 3 : 2)} σ` : "not tried"),
            h("td", {}, tried(entry) ? rolloutText(entry.rollout) : ""),
            h("td", {}, !real || tried(entry) ? percent(entry.selected_fraction) : ""),
          ),
        ),
      ),
    ),
  );
  const left = ranking.length - shown.length;
  return h("div", {}, table, left ? h("p", { class: "note" }, `Left out: ${left} more that ${left === 1 ? "was" : "were"} not tried.`) : null);
}

/** What the ranking's columns are of. */
export function rankingNote(d: Diagnosis): string {
  if (!ofRealCar(d)) return "Evidence over the nominal model; error on held-out data; share of resampled logs in which the effect wins.";
  const without = d.gap?.judged == null ? "" : ` (${fixed(d.gap.judged, 2)} σ without any)`;
  return `Each effect beside the calibrated world alone. Squared error: of the time that is fitted; to first order where the effect was not tried. Error and predictions: of the same logs' time that is not fitted${without}, also where other logs were held out.`;
}

/** Where on the track the residual is large. */
export function residualMap(more: DiagnosisReport): HTMLElement | null {
  const residual = more.residual;
  const [xs, ys, size] = [numbers(residual?.x_m), numbers(residual?.y_m), numbers(residual?.size)];
  if (!xs.length || !size.length) return null;
  const track = new Columns({});
  for (const [name, values] of Object.entries(more.track ?? {})) track.set(name, numbers(values));
  if (!more.track) [track.set("x_m", xs), track.set("y_m", ys)];
  const course = new Course(track, new Columns({}), []);
  const sorted = [...size].filter(Number.isFinite).sort((a, b) => a - b);
  // A few outliers must not take the whole scale.
  const high = sorted[Math.floor(0.98 * (sorted.length - 1))] || 1;
  const draw = (pen: Pen, width: number, height: number) => {
    const view = fit(course.box, width, height, 16);
    if (more.track) drawCourse(pen, course, view);
    for (const i of [...size.keys()].filter((k) => Number.isFinite(size[k])).sort((a, b) => size[a] - size[b]))
      pen.disc(view.x(xs[i]), view.y(ys[i]), 1.6 + 2.6 * Math.min(1, size[i] / high), sequential(size[i] / high), 0.85);
  };
  const height = Math.round(Math.min(560, Math.max(240, 720 * course.aspect + 30)));
  const figure = makeFigure({
    id: "residual-map",
    title: "Where the model disagrees",
    note: "Size and colour: error of a short simulation that starts there, in sensor sigmas.",
    wide: true,
    svg: () => {
      const pen = new SvgPen(720, height, token("surface"));
      draw(pen, 720, height);
      return pen.toString();
    },
    rows: function* () {
      yield ["x_m", "y_m", "size_sigma"];
      for (let i = 0; i < xs.length; i++) yield [xs[i], ys[i], size[i]];
    },
  });
  const canvas = h("canvas", { role: "img", "aria-label": "Residual over the track" });
  const paint = () => {
    const ratio = Math.min(2, devicePixelRatio * 1.5);
    [canvas.width, canvas.height] = [720 * ratio, height * ratio];
    canvas.style.aspectRatio = `720 / ${height}`;
    const ctx = canvas.getContext("2d")!;
    ctx.scale(ratio, ratio);
    draw(new CanvasPen(ctx), 720, height);
    const stops = Array.from({ length: 11 }, (_, i) => sequential(i / 10)).join(", ");
    figure.readout.replaceChildren(h("div", { class: "colour-scale" }, h("span", {}, "0"), h("i", { style: `background: linear-gradient(to right, ${stops})` }), h("span", {}, `${plain(high)} σ`)));
  };
  paint();
  onThemeChange(paint);
  figure.body.append(canvas);
  return figure.element;
}

const residuals: [string, string, string, string][] = [
  ["e_vx", "along the car", "m/s²", "e_vx"],
  ["e_vy", "across the car", "m/s²", "e_vy"],
  ["e_omega", "in yaw", "rad/s²", "e_omega"],
];
const against: Record<string, [string, string, number]> = {
  lap_fraction: ["lap fraction", "1", 1],
  t_s: ["time", "s", 1],
  vx_mps: ["speed", "m/s", 1],
  vy_mps: ["lateral speed", "m/s", 1],
  yaw_rate_radps: ["yaw rate", "rad/s", 1],
  d: ["throttle and brake", "1", 1],
  delta_rad: ["steering", "°", 180 / Math.PI],
};

const channelNames: Record<string, [string, string]> = {
  x_m: ["x", "m"],
  y_m: ["y", "m"],
  yaw_rad: ["heading", "rad"],
  vx_mps: ["speed along the car", "m/s"],
  vy_mps: ["speed across the car", "m/s"],
  yaw_rate_radps: ["yaw rate", "rad/s"],
};

/** The residual of one channel against a quantity of the reader's choice, before and after. */
export function residualCharts(state: State, more: DiagnosisReport, d: Diagnosis): Chart[] {
  const residual = more.residual;
  if (!residual) return [];
  const choices = Object.keys(against).filter((name) => residual[name]?.some((v) => v !== null));
  const where = { position: "lap_fraction", time: "t_s", state: "vx_mps", input: "d" }[d.unknown?.where ?? "position"] ?? "lap_fraction";
  let by = choices.includes(where) ? where : choices[0];
  if (!by) return [];
  const x = { label: "", unit: "" };
  const setAxis = () => ([x.label, x.unit] = against[by]);
  setAxis();
  const list: Chart[] = [];
  for (const [name, words, unit, label] of residuals) {
    if (!residual[name]) continue;
    const marks = (): Mark[] => {
      const xs = numbers(residual[by]).map((v) => v * against[by][2]);
      const points = (column: string, text: string, color: string, alpha: number): Mark[] =>
        residual[column] ? [{ kind: "points", x: xs, y: numbers(residual[column]), size: 1.4, alpha, color, label: text }] : [];
      return [...points(name, "nominal model", stackColour(1), 0.45), ...points(`after_${name}`, "with what was named", stackColour(0), 0.45), { kind: "rule", axis: "y", at: 0, color: token("muted") }];
    };
    list.push(new Chart({ id: `residual-${name}`, title: `Unexplained ${words}`, height: 220, x, y: { label, unit }, marks }, state));
  }
  const select = h("select", { "aria-label": "Against" }, ...choices.map((name) => h("option", { value: name, selected: name === by }, `by ${against[name][0]}`)));
  select.addEventListener("change", () => {
    by = select.value;
    setAxis();
    for (const chart of list) chart.refresh();
  });
  list[0]?.figure.controls.append(select);
  return list;
}

/** Error before and after against the horizon, and overlaid traces. */
export function gapCharts(state: State, more: DiagnosisReport): Chart[] {
  const specs: ChartSpec[] = [];
  const { horizon } = more;
  const [before, after] = ["nominal model", "with what was named"];
  if (horizon)
    specs.push({
      id: "horizon",
      title: "Error against horizon",
      note: "Open-loop simulation on held-out data.",
      height: 260,
      x: { label: "horizon", unit: "s", log: true },
      y: { label: "error", unit: "σ", log: true },
      marks: () => {
        const x = numbers(horizon.horizon_s);
        return [
          { kind: "line", x, y: numbers(horizon.before), color: stackColour(1), width: 2, dash: [6, 4], label: before },
          { kind: "points", x, y: numbers(horizon.before), color: stackColour(1), size: 3.5, shape: "square" },
          { kind: "line", x, y: numbers(horizon.after), color: stackColour(0), width: 2, label: after },
          { kind: "points", x, y: numbers(horizon.after), color: stackColour(0), size: 3.5 },
        ];
      },
    });
  for (const trace of more.traces ?? []) {
    const [name, unit] = channelNames[trace.channel] ?? [trace.channel, ""];
    specs.push({
      id: `trace-${trace.channel}`,
      title: `Held-out ${name}`,
      note: "Each piece starts from the measured state and runs freely.",
      height: 220,
      x: { label: "time", unit: "s" },
      y: { label: name, unit },
      marks: () => {
        const x = numbers(trace.t_s);
        return [
          { kind: "line", x, y: numbers(trace.measured), color: token("ink"), width: 2.2, dash: [2, 3], label: "measured" },
          { kind: "line", x, y: numbers(trace.before), color: stackColour(1), dash: [6, 4], label: before },
          { kind: "line", x, y: numbers(trace.after), color: stackColour(0), label: after },
        ];
      },
    });
  }
  return specs.map((spec) => new Chart(spec, state));
}

export function seenAtTable(more: DiagnosisReport): HTMLElement | null {
  const rows = more.seen_at ?? [];
  if (!rows.length) return null;
  return h(
    "div",
    { class: "table-scroll" },
    h(
      "table",
      { class: "comparison plain" },
      h("thead", {}, h("tr", {}, h("th", { class: "name", scope: "col" }, "effect"), h("th", { class: "text", scope: "col" }, "parameter"), h("th", { scope: "col" }, "would have been seen from"))),
      h("tbody", {}, ...rows.map((row) => h("tr", {}, h("th", { scope: "row", class: "text effect" }, sentenceCase(more.effects?.[row.effect]?.words ?? ""), " ", h("code", {}, row.effect)), h("td", { class: "text" }, row.param), h("td", {}, `${plain(row.size)} ${row.unit}`)))),
    ),
  );
}

export function healthTable(more: DiagnosisReport): HTMLElement | null {
  const rows = more.health ?? [];
  if (!rows.length) return null;
  const sign = { good: "✓", note: "●", bad: "✗" };
  return h(
    "div",
    { class: "table-scroll" },
    h(
      "table",
      { class: "comparison plain health" },
      h("thead", {}, h("tr", {}, ...["", "check", "found", "done about it"].map((text) => h("th", { class: "text", scope: "col" }, text)))),
      h("tbody", {}, ...rows.map((row) => h("tr", { class: row.level }, h("td", { class: "text sign" }, sign[row.level] ?? ""), ...[row.check, row.found, row.done].map((text) => h("td", { class: "text" }, ...prose(text)))))),
    ),
  );
}

export function patchBox(state: State): HTMLElement | null {
  const patch = state.report.meta.diagnosis_report?.patch ?? state.report.meta.augmented_world;
  if (!patch) return null;
  const text = JSON.stringify(patch, null, 2);
  return h(
    "div",
    { class: "patch" },
    h("div", { class: "figure-head" }, h("h3", {}, "The patch"), h("button", { type: "button", class: "quiet", click: () => download("augmented_world.json", "application/json", `${text}\n`) }, "Save")),
    h("p", { class: "note" }, "Stands in augmented_world.json; usable wherever a world is."),
    h("pre", {}, h("code", {}, text)),
  );
}
