// Offline and force validation: how well estimators predict what the nominal model leaves unexplained.
import { Chart } from "./chart";
import { unpack } from "./data";
import { fixed, h, short } from "./dom";
import type { Mark } from "./marks";
import type { State } from "./state";
import { stackColour, token } from "./theme";
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
  const bestR2 = channels.map((channel) => Math.max(...validation.filter((e) => e.channel === channel).map((e) => e.r2 ?? -Infinity)));
  return h(
    "div",
    { class: "table-scroll", tabindex: 0, role: "region", "aria-label": "Validation" },
    h(
      "table",
      { class: "comparison" },
      h(
        "thead",
        {},
        h("tr", {}, h("th", { class: "name", scope: "col" }, "estimator"), ...channels.map((channel) => h("th", { scope: "col", title: nameOf[channel] }, `R² ${channel}`)), ...channels.map((channel) => h("th", { scope: "col" }, `rmse ${channel}`, h("small", {}, ` ${validation.find((e) => e.channel === channel)?.unit ?? ""}`)))),
      ),
      h(
        "tbody",
        {},
        ...rows.map((estimator, i) =>
          h(
            "tr",
            {},
            h("th", { scope: "row", class: "name" }, h("i", { class: "swatch", style: `--c:${stackColour(i)}` }), estimator),
            ...channels.map((channel, k) => {
              const r2 = find(estimator, channel)?.r2;
              return h("td", { class: rows.length > 1 && r2 === bestR2[k] ? "best" : undefined }, h("span", { class: "value" }, fixed(r2, 3)));
            }),
            ...channels.map((channel) => h("td", {}, short(find(estimator, channel)?.rmse))),
          ),
        ),
      ),
    ),
  );
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
    const marks = (): Mark[] => {
      const x = (trace: Trace) => (overSlip ? columns(trace, "slip_rad").map((a) => (a * 180) / Math.PI) : columns(trace, "t_s"));
      const truth: Mark = overSlip
        ? { kind: "points", x: x(own[0]), y: columns(own[0], "truth"), size: 1.6, alpha: 0.5, color: token("ink"), label: "true" }
        : { kind: "line", x: x(own[0]), y: columns(own[0], "truth"), width: 2.2, color: token("ink"), dash: [2, 3], label: "true" };
      const predictions = own.map((trace): Mark => {
        const stack = names.indexOf(trace.estimator);
        const common = { x: x(trace), y: columns(trace, "predicted"), color: stackColour(stack), label: trace.estimator };
        return overSlip ? { kind: "points", size: 1.6, alpha: 0.6, ...common } : { kind: "line", ...common };
      });
      return [truth, ...predictions];
    };
    return new Chart(
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
  });
}
