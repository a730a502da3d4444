// Offline and force validation: how well estimators predict what the nominal model leaves unexplained.
import { Chart } from "./chart";
import { unpack } from "./data";
import { decimalsFor, fixed, h, unitText } from "./dom";
import type { Mark } from "./marks";
import type { State } from "./state";
import { swatch } from "./swatch";
import { stackColour, stackDash, token } from "./theme";
import type { Trace } from "./types";

const nameOf: Record<string, string> = {
  e_vx: "Residual along the car",
  e_vy: "Residual across the car",
  e_omega: "Residual in yaw",
  force_front: "Front axle force",
  force_rear: "Rear axle force",
};

export function estimators(state: State): string[] {
  return [...new Set([...state.report.meta.validation, ...state.report.meta.traces].map((entry) => entry.estimator))];
}

export function validationTable(state: State): HTMLElement {
  const { validation } = state.report.meta;
  const rows = estimators(state);
  const channels = [...new Set(validation.map((entry) => entry.channel))];
  const find = (estimator: string, channel: string) => validation.find((e) => e.estimator === estimator && e.channel === channel);
  const told = new Set(state.report.meta.scene?.told ?? []);
  const able = (estimator: string) => !told.has(estimator);
  const texts = (channel: string) => {
    const own = validation.filter((e) => e.channel === channel);
    const rivals = own.filter((e) => able(e.estimator));
    const errors = own.map((e) => e.rmse).filter((v): v is number => v !== null);
    // As many decimals as the smallest error needs for three digits.
    const decimals = decimalsFor(Math.min(...errors));
    return { r2: (v?: number | null) => fixed(v, 3), rmse: (v?: number | null) => fixed(v, decimals), unit: unitText(own[0]?.unit), most: Math.max(...rivals.map((e) => e.r2 ?? -Infinity)), least: Math.min(...rivals.map((e) => e.rmse ?? Infinity)) };
  };
  const cell = (text: string, best: boolean) =>
    h("td", { class: best ? "best" : undefined }, h("span", { class: "value" }, text, best ? h("span", { class: "visually-hidden" }, " (best)") : null));
  return h(
    "div",
    { class: "table-scroll", tabindex: 0, role: "region", "aria-label": "Validation" },
    h(
      "table",
      { class: "comparison" },
      h(
        "thead",
        {},
        h("tr", { class: "groups" }, h("th", { class: "name" }), ...channels.map((channel) => h("th", { colspan: 2, scope: "colgroup" }, nameOf[channel] ?? channel))),
        h("tr", {}, h("th", { class: "name", scope: "col" }, "estimator"), ...channels.flatMap((channel) => [h("th", { scope: "col", class: "first", title: "1 is perfect, 0 is no better than the mean" }, "R²"), h("th", { scope: "col", title: "root mean square error" }, "rms error", h("small", {}, ` ${texts(channel).unit}`))])),
      ),
      h(
        "tbody",
        {},
        ...rows.map((estimator, i) =>
          h(
            "tr",
            { class: able(estimator) ? undefined : "truth" },
            h("th", { scope: "row", class: "name" }, swatch(i), estimator, able(estimator) ? null : h("abbr", { title: "is given the ground truth" }, " *")),
            ...channels.flatMap((channel) => {
              const found = find(estimator, channel);
              const { r2, rmse, most, least } = texts(channel);
              const rival = found !== undefined && able(estimator) && rows.filter(able).length > 1;
              return [cell(r2(found?.r2), rival && r2(found.r2) === r2(most)), cell(rmse(found?.rmse), rival && rmse(found.rmse) === rmse(least))];
            }),
          ),
        ),
      ),
    ),
  );
}

/** Whether all were asked about the same drive: on a drive of its own each has a truth of its own. */
function oneTruth(traces: Trace[]): boolean {
  const values = ({ t_s, truth }: Trace) => [t_s, truth].flatMap((column) => (column ? [...unpack(column)] : []));
  const first = values(traces[0]);
  return traces.every((trace) => {
    const own = values(trace);
    return own.length === first.length && own.every((v, i) => Object.is(v, first[i]));
  });
}

/** The estimator that explains a channel best without having been told. */
function mostTrusted(state: State, channel: string, own: Trace[]): string {
  const { validation, scene } = state.report.meta;
  const rivals = validation.filter((entry) => entry.channel === channel && !scene?.told?.includes(entry.estimator) && own.some((trace) => trace.estimator === entry.estimator));
  return [...rivals].sort((a, b) => (b.r2 ?? -Infinity) - (a.r2 ?? -Infinity))[0]?.estimator ?? own[0].estimator;
}

/** Truth and predictions of one channel: over time, or over the slip angle where there is one. */
export function validationCharts(state: State): Chart[] {
  const { traces, validation } = state.report.meta;
  const names = estimators(state);
  return [...new Set(traces.map((trace) => trace.channel))].map((channel) => {
    const own = traces.filter((trace) => trace.channel === channel);
    const unit = validation.find((e) => e.channel === channel)?.unit;
    const overSlip = own.some((trace) => trace.slip_rad && unpack(trace.slip_rad).some(Number.isFinite));
    const columns = (trace: Trace, name: "t_s" | "truth" | "predicted" | "slip_rad") => (trace[name] ? unpack(trace[name]!) : new Float64Array(0));
    const shared = oneTruth(own);
    let chosen = mostTrusted(state, channel, own);
    const marks = (): Mark[] => {
      const shown = shared ? own : own.filter((trace) => trace.estimator === chosen);
      const x = (trace: Trace) => (overSlip ? columns(trace, "slip_rad").map((a) => (a * 180) / Math.PI) : columns(trace, "t_s"));
      const truth: Mark = overSlip
        ? { kind: "points", x: x(shown[0]), y: columns(shown[0], "truth"), size: 2.4, alpha: 0.5, shape: "ring", color: token("ink"), label: "true" }
        : { kind: "line", x: x(shown[0]), y: columns(shown[0], "truth"), width: 2.2, color: token("ink"), dash: [2, 3], label: "true" };
      const predictions = shown.map((trace): Mark => {
        const stack = names.indexOf(trace.estimator);
        const truth = state.report.meta.scene?.told?.includes(trace.estimator) ?? false;
        const common = { x: x(trace), y: columns(trace, "predicted"), color: stackColour(stack), label: truth ? `${trace.estimator} *` : trace.estimator };
        return overSlip ? { kind: "points", size: 1.6, alpha: 0.6, ...common } : { kind: "line", dash: stackDash(truth), ...common };
      });
      return [truth, ...predictions];
    };
    const chart = new Chart(
      {
        id: `validation-${channel}`,
        title: nameOf[channel] ?? channel,
        wide: !overSlip,
        height: 240,
        x: overSlip ? { label: "slip angle", unit: "°" } : { label: "time", unit: "s" },
        y: { label: channel, unit },
        marks,
      },
      state,
    );
    if (!shared) {
      const select = h("select", { "aria-label": "Estimator" }, ...own.map(({ estimator }) => h("option", { value: estimator, selected: estimator === chosen }, estimator)));
      select.addEventListener("change", () => {
        chosen = select.value;
        chart.refresh();
      });
      chart.figure.controls.append(select);
    }
    return chart;
  });
}
