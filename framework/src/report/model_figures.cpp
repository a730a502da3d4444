#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "report/figures.hpp"
#include "report/plot.hpp"
#include "util/numbers.hpp"

namespace gripline::report {
namespace {

std::vector<std::string> distinct(const Columns& table, const char* column) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < table.rows(); ++i)
    if (const std::string name = table.text(column, i); std::find(names.begin(), names.end(), name) == names.end())
      names.push_back(name);
  return names;
}

struct PredictionTrace {
  std::vector<double> t, slip, truth, predicted;
};
PredictionTrace select(const Columns& traces, const std::string& estimator, const std::string& channel) {
  PredictionTrace p;
  for (std::size_t i = 0; i < traces.rows(); ++i) {
    if (traces.text("estimator", i) != estimator || traces.text("channel", i) != channel) continue;
    p.t.push_back(traces.number("t_s", i));
    p.slip.push_back(traces.number("slip_rad", i) * 180 / std::numbers::pi);
    p.truth.push_back(traces.number("truth", i));
    p.predicted.push_back(traces.number("predicted", i));
  }
  return p;
}

bool any_number(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

std::string unit_of(const Columns& scores, const std::string& channel) {
  for (std::size_t i = 0; i < scores.rows(); ++i)
    if (scores.text("channel", i) == channel) return " [" + scores.text("unit", i) + "]";
  return "";
}

Series series(Series::Kind kind, std::vector<double> x, std::vector<double> y, std::string colour, std::string label) {
  Series s;
  s.kind = kind;
  s.x = std::move(x);
  s.y = std::move(y);
  s.colour = std::move(colour);
  s.label = std::move(label);
  if (kind == Series::Kind::points) s.width = 2.4, s.opacity = 0.6;
  return s;
}

/// Whether all predict the same drive, which then has one truth.
bool one_truth(const std::vector<std::pair<std::size_t, PredictionTrace>>& all) {
  return std::all_of(all.begin(), all.end(), [&](const auto& one) {
    return one.second.t == all.front().second.t && one.second.truth == all.front().second.truth;
  });
}

std::vector<FigureFile> validation(const Inputs& inputs) {
  const Columns& traces = inputs.validation_traces;
  const std::vector<std::string> estimators = distinct(traces, "estimator");
  std::vector<Panel> over_time, over_slip;
  bool shared = true;
  for (const std::string& channel : distinct(traces, "channel")) {
    std::vector<std::pair<std::size_t, PredictionTrace>> all;
    for (std::size_t k = 0; k < estimators.size(); ++k)
      if (PredictionTrace p = select(traces, estimators[k], channel); !p.t.empty()) all.emplace_back(k, std::move(p));
    if (all.empty()) continue;
    shared = shared && one_truth(all);
    const bool slip = any_number(all.front().second.slip);
    const Series::Kind kind = slip ? Series::Kind::points : Series::Kind::line;
    std::vector<Panel>& panels = slip ? over_slip : over_time;
    for (const auto& [k, p] : all) {
      if (!one_truth(all) || k == all.front().first) {
        Panel panel;
        panel.y.label = channel + unit_of(inputs.validation, channel);
        panel.x.label = slip ? "slip angle [°]" : "time [s]";
        if (!one_truth(all)) panel.title = estimators[k];
        Series truth = series(kind, slip ? p.slip : p.t, p.truth, "#1a1c20", "true");
        if (!slip) truth.dash = "2 3", truth.width = 2;
        panel.series.push_back(std::move(truth));
        panels.push_back(std::move(panel));
      }
      panels.back().series.push_back(series(kind, slip ? p.slip : p.t, p.predicted, series_colour(k), estimators[k]));
    }
  }
  const int side_by_side = static_cast<int>(estimators.size());
  std::vector<FigureFile> figures;
  if (!over_time.empty())
    figures.push_back(
        {"offline_validation.svg", draw_panels("What the nominal model misses, true and predicted", over_time,
                                               shared ? 1 : side_by_side, shared ? 900 : 420, 230)});
  if (!over_slip.empty())
    figures.push_back({"force_validation.svg", draw_panels("Axle forces, true and predicted", over_slip,
                                                           shared ? 2 : side_by_side, shared ? 450 : 420, 340)});
  return figures;
}

/// An array of numbers and nulls; empty if it is not there.
std::vector<double> numbers(const nlohmann::json& object, const char* key) {
  std::vector<double> out;
  if (!object.is_object() || !object.contains(key) || !object[key].is_array()) return out;
  for (const nlohmann::json& value : object[key]) out.push_back(value.is_number() ? value.get<double>() : not_a_number);
  return out;
}

constexpr const char* nominal = "nominal model";
constexpr const char* repaired = "with what was named";

FigureFile gap(const nlohmann::json& horizon) {
  Panel panel;
  panel.x.label = "horizon [s]";
  panel.y.label = "error on held-out data [sensor sigmas]";
  panel.x.logarithmic = panel.y.logarithmic = true;
  const std::vector<double> x = numbers(horizon, "horizon_s");
  Series before = series(Series::Kind::line, x, numbers(horizon, "before"), series_colour(1), nominal);
  Series after = series(Series::Kind::line, x, numbers(horizon, "after"), series_colour(0), repaired);
  before.dash = "6 4";
  before.width = after.width = 2;
  panel.series = {std::move(before), std::move(after)};
  return {"diagnosis_gap.svg", draw_panels("Error against horizon, before and after", {panel}, 1, 560, 380)};
}

FigureFile residual(const nlohmann::json& data) {
  std::vector<Panel> panels;
  const std::pair<const char*, const char*> channels[] = {
      {"e_vx", "e_vx [m/s2]"}, {"e_vy", "e_vy [m/s2]"}, {"e_omega", "e_omega [rad/s2]"}};
  const std::pair<const char*, const char*> against[] = {{"lap_fraction", "lap fraction"}, {"vx_mps", "speed [m/s]"}};
  for (const auto& [channel, label] : channels)
    for (const auto& [quantity, words] : against) {
      const std::vector<double> x = numbers(data, quantity), before = numbers(data, channel),
                                after = numbers(data, ("after_" + std::string(channel)).c_str());
      if (!any_number(x) || !any_number(before)) continue;
      Panel panel;
      panel.x.label = words;
      panel.y.label = label;
      panel.series.push_back(series(Series::Kind::points, x, before, series_colour(1), nominal));
      if (any_number(after)) panel.series.push_back(series(Series::Kind::points, x, after, series_colour(0), repaired));
      panels.push_back(std::move(panel));
    }
  return {"diagnosis_residual.svg",
          panels.empty() ? "" : draw_panels("What the model leaves unexplained", panels, 2, 450, 240)};
}

FigureFile traces(const nlohmann::json& list) {
  std::vector<Panel> panels;
  for (const nlohmann::json& trace : list) {
    Panel panel;
    panel.x.label = "time [s]";
    panel.y.label = trace.value("channel", "");
    const std::vector<double> t = numbers(trace, "t_s");
    Series measured = series(Series::Kind::line, t, numbers(trace, "measured"), "#1a1c20", "measured");
    measured.dash = "2 3";
    measured.width = 2;
    Series before = series(Series::Kind::line, t, numbers(trace, "before"), series_colour(1), nominal);
    before.dash = "6 4";
    panel.series = {std::move(measured), std::move(before),
                    series(Series::Kind::line, t, numbers(trace, "after"), series_colour(0), repaired)};
    panels.push_back(std::move(panel));
  }
  return {"diagnosis_traces.svg",
          panels.empty() ? "" : draw_panels("Held-out data and free simulation", panels, 1, 900, 220)};
}

}  // namespace

std::vector<FigureFile> model_figures(const Inputs& inputs) {
  std::vector<FigureFile> figures = validation(inputs);
  const nlohmann::json& diagnosis = inputs.diagnosis_report;
  if (diagnosis.is_object()) {
    if (diagnosis.contains("horizon")) figures.push_back(gap(diagnosis["horizon"]));
    if (diagnosis.contains("residual")) figures.push_back(residual(diagnosis["residual"]));
    if (diagnosis.contains("traces")) figures.push_back(traces(diagnosis["traces"]));
  }
  std::erase_if(figures, [](const FigureFile& figure) { return figure.svg.empty(); });
  return figures;
}

}  // namespace gripline::report
