#include "report/measured_page.hpp"

#include <algorithm>
#include <cmath>

#include "report/html.hpp"
#include "report/packing.hpp"
#include "report/plot.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::report {
namespace {

using nlohmann::json;
using Values = std::vector<double>;

struct Quantity {
  const char *key, *label;
};
constexpr Quantity shown_quantities[] = {{"position_m", "position [m]"},
                                         {"yaw_rad", "yaw [rad]"},
                                         {"vx_mps", "vx [m/s]"},
                                         {"vy_mps", "vy [m/s]"},
                                         {"yaw_rate_radps", "yaw rate [rad/s]"}};

Values values_of(const json& object, const std::string& key) {
  Values out;
  if (const auto found = object.find(key); found != object.end() && found->is_array())
    for (const json& value : *found) out.push_back(number_of(value));
  return out;
}

/// One value with its interval, level beside others: a point and a bar.
void add_interval(Panel& panel, double at, const Values& value, const std::string& colour) {
  if (value.size() < 3 || !std::isfinite(value[0])) return;
  Series bar;
  bar.x = {value[1], value[2]};
  bar.y = {at, at};
  bar.colour = colour;
  bar.width = 3;
  bar.opacity = 0.5;
  Series point;
  point.kind = Series::Kind::points;
  point.x = {value[0]};
  point.y = {at};
  point.colour = colour;
  point.width = 7;
  panel.series.push_back(std::move(bar));
  panel.series.push_back(std::move(point));
}

/// Names down the side, one panel a quantity.
std::string intervals_figure(const std::string& title, const json& rows, bool from_zero) {
  std::vector<Panel> panels;
  for (const Quantity& quantity : shown_quantities) {
    Panel panel;
    panel.x.label = quantity.label;
    if (from_zero) panel.x.low = 0.0;
    double at = static_cast<double>(rows.size());
    bool any = false;
    for (const json& row : rows) {
      const Values value = values_of(row, quantity.key);
      any = any || (value.size() == 3 && std::isfinite(value[0]));
      panel.y.ticks.emplace_back(at, text_of(row, "name"));
      add_interval(panel, at, value, series_colour(text_of(row, "name") == "fitted" ? 0 : 1));
      at -= 1.0;
    }
    panel.y.low = 0.3;
    panel.y.high = static_cast<double>(rows.size()) + 0.7;
    if (!from_zero) {
      Series zero;
      zero.x = {0, 0};
      zero.y = {*panel.y.low, *panel.y.high};
      zero.dash = "3 3";
      zero.width = 1;
      panel.series.push_back(std::move(zero));
    }
    if (any) panels.push_back(std::move(panel));
  }
  return panels.empty() ? "" : draw_panels(title, panels, 2, 430, 60.0 + 22.0 * static_cast<double>(rows.size()));
}

/// Lines are broken where time jumps from one held-out block to the next.
Values with_gaps(const Values& t, const Values& y) {
  Values out = y;
  for (std::size_t i = 1; i < t.size() && i < y.size(); ++i)
    if (t[i] - t[i - 1] > 3.0) out[i] = not_a_number;
  return out;
}

std::string traces_figure(const json& log) {
  const Values t = values_of(log, "t_s");
  std::vector<Panel> panels;
  for (const Quantity& quantity : shown_quantities) {
    Panel panel;
    panel.x.label = "t [s]";
    panel.y.label = quantity.label;
    const std::string key = quantity.key;
    if (key == "position_m") {
      const Values x = values_of(log, "predicted_x_m"), y = values_of(log, "predicted_y_m");
      const Values mx = values_of(log, "measured_x_m"), my = values_of(log, "measured_y_m");
      Series error;
      for (std::size_t i = 0; i < x.size(); ++i) error.y.push_back(std::hypot(x[i] - mx[i], y[i] - my[i]));
      error.x = t;
      error.y = with_gaps(t, error.y);
      error.colour = series_colour(0);
      error.label = "error";
      panel.y.label = "position error [m]";
      panel.series.push_back(std::move(error));
    } else {
      Series measured, predicted;
      measured.x = predicted.x = t;
      measured.y = with_gaps(t, values_of(log, "measured_" + key));
      predicted.y = with_gaps(t, values_of(log, "predicted_" + key));
      if (std::none_of(measured.y.begin(), measured.y.end(), [](double v) { return std::isfinite(v); })) continue;
      measured.label = "measured";
      predicted.label = "predicted";
      predicted.colour = series_colour(0);
      panel.series.push_back(std::move(measured));
      panel.series.push_back(std::move(predicted));
    }
    panels.push_back(std::move(panel));
  }
  return draw_panels("What the log shows and what was predicted: " + text_of(log, "log"), panels, 1, 900, 190);
}

/// Places of the predictions, coloured by how far they were off.
std::string road_figure(const json& log, const json& road) {
  constexpr int shades = 8;
  const Values mx = values_of(log, "measured_x_m"), my = values_of(log, "measured_y_m");
  const Values x = values_of(log, "predicted_x_m"), y = values_of(log, "predicted_y_m");
  Values error;
  for (std::size_t i = 0; i < x.size(); ++i) error.push_back(std::hypot(x[i] - mx[i], y[i] - my[i]));
  Values finite;
  for (const double e : error)
    if (std::isfinite(e)) finite.push_back(e);
  if (finite.empty()) return "";
  const double most = lower_quantile(finite, 0.95);
  Panel panel;
  panel.equal = true;
  panel.x.label = "x [m]";
  panel.y.label = "y [m]";
  if (road.is_object())
    for (const char* side : {"left", "right"}) {
      Series edge;
      edge.kind = Series::Kind::closed;
      edge.x = values_of(road, std::string(side) + "_x_m");
      edge.y = values_of(road, std::string(side) + "_y_m");
      edge.width = 1;
      edge.opacity = 0.5;
      panel.series.push_back(std::move(edge));
    }
  for (int shade = 0; shade < shades; ++shade) {
    Series points;
    points.kind = Series::Kind::points;
    points.width = 5;
    points.colour = sequential_colour((shade + 0.5) / shades);
    const double low = most * shade / shades, high = shade + 1 == shades ? 1e300 : most * (shade + 1) / shades;
    points.label = shade % 2 == 0 ? short_number(low) + " m" : "";
    for (std::size_t i = 0; i < error.size(); ++i)
      if (error[i] >= low && error[i] < high) {
        points.x.push_back(mx[i]);
        points.y.push_back(my[i]);
      }
    if (!points.x.empty()) panel.series.push_back(std::move(points));
  }
  return draw_panels("Where predictions were off: " + text_of(log, "log"), {panel}, 1, 900, 640);
}

std::string errors_table(const json& rows, const char* first) {
  std::vector<std::string> head{first};
  for (const Quantity& q : shown_quantities) head.emplace_back(q.label);
  std::vector<std::vector<std::string>> lines;
  for (const json& row : rows) {
    std::vector<std::string> line{text_of(row, "name")};
    for (const Quantity& q : shown_quantities) {
      const Values v = values_of(row, q.key);
      line.push_back(v.size() == 3 && std::isfinite(v[0])
                         ? short_number(v[0]) + " (" + short_number(v[1]) + " to " + short_number(v[2]) + ")"
                         : "–");
    }
    lines.push_back(std::move(line));
  }
  return html_table(head, lines);
}

std::string parameters_table(const json& parameters) {
  std::vector<std::vector<std::string>> lines;
  for (const json& p : parameters)
    lines.push_back(
        {text_of(p, "pointer"), text_of(p, "group"), short_number(number_of(p.value("value", json()))),
         short_number(number_of(p.value("low", json()))) + " to " + short_number(number_of(p.value("high", json()))),
         short_number(number_of(p.value("prior", json()))), text_of(p, "status")});
  return html_table({"parameter", "group", "value", "95 %", "prior", "status"}, lines);
}

const json* row_named(const json& rows, const char* name) {
  for (const json& row : rows)
    if (text_of(row, "name") == name) return &row;
  return nullptr;
}

/// What the fit is worth, in words: the fitted row's position error, and against the best of the others.
std::string lead_paragraph(const json& data) {
  const json& rows = list_of(data, "rows");
  const json* const fitted = row_named(rows, "fitted");
  const Values error = fitted != nullptr ? values_of(*fitted, "position_m") : Values{};
  if (error.size() < 3 || !std::isfinite(error[0])) return "";
  std::string text = "The fitted model predicts where the car is ";
  text.append(short_number(number_of(data.value("horizon_s", json())))).append(" s ahead to ");
  text.append(short_number(error[0])).append(" m (95 %: ").append(short_number(error[1])).append(" to ");
  text.append(short_number(error[2])).append(" m), in data that it was not fitted to");
  double least = INFINITY;
  std::string other;
  for (const json& row : rows) {
    const Values v = values_of(row, "position_m");
    if (&row == fitted || v.empty() || !std::isfinite(v[0]) || v[0] >= least) continue;
    least = v[0];
    other = text_of(row, "name");
  }
  if (!other.empty())
    text.append("; the best of the others, ").append(other).append(", to ").append(short_number(least)).append(" m");
  return "<p class=\"lead\">" + html_escaped(text) + ".</p>\n";
}

/// The pictures of one held-out log, folded: a page may have ten.
std::string log_figures(const json& log, const json& road) {
  std::string inside;
  for (const std::string& svg : {traces_figure(log), road_figure(log, road)})
    if (!svg.empty()) inside += "<figure>" + svg + "</figure>\n";
  return html_folded("Predictions of " + text_of(log, "log"), inside);
}

std::string health_tables(const json& data) {
  std::vector<std::pair<std::string, std::vector<std::vector<std::string>>>> logs;
  for (const json& line : list_of(data, "health")) {
    const std::string log = text_of(line, "log");
    if (logs.empty() || logs.back().first != log) logs.push_back({log, {}});
    logs.back().second.push_back({text_of(line, "check"), text_of(line, "found"), text_of(line, "done")});
  }
  std::string out;
  for (const auto& [log, lines] : logs)
    out += "<h2>" + html_escaped(log) + "</h2>\n" + html_table({"check", "found", "done"}, lines);
  return html_folded("Health of the logs", out);
}

std::string claims_list(const json& claims) {
  std::string out;
  for (const json& claim : claims.is_array() ? claims : list_of(claims, "claims"))
    if (claim.is_object())
      out += "<li>" + std::string(claim.value("holds", json()) == true ? "holds: " : "does not hold: ") +
             html_escaped(text_of(claim, "text")) + "</li>\n";
  return out.empty() ? "" : "<h2>Claims</h2>\n<ul>\n" + out + "</ul>\n";
}

}  // namespace

std::vector<FigureFile> measured_figures(const json& data) {
  std::vector<FigureFile> figures;
  const auto add = [&](std::string name, std::string svg) {
    if (!svg.empty()) figures.push_back({std::move(name), std::move(svg)});
  };
  add("errors.svg", intervals_figure("Errors of held-out predictions", list_of(data, "rows"), true));
  add("ablation.svg", intervals_figure("Rise of the error without an effect", list_of(data, "ablations"), false));
  const json road = data.value("road", json());
  std::size_t n = 0;
  for (const json& log : list_of(data, "held_out")) {
    ++n;
    add("traces_" + std::to_string(n) + ".svg", traces_figure(log));
    add("road_" + std::to_string(n) + ".svg", road_figure(log, road));
  }
  return figures;
}

std::string measured_page(const json& data, const json& scene, const json& claims) {
  const std::string name = scene.is_object() ? text_of(scene, "name") : "measured";
  std::string page = html_begin(name) + lead_paragraph(data);
  if (scene.is_object() && !text_of(scene, "note").empty())
    page += "<p>" + html_escaped(text_of(scene, "note")) + "</p>\n";
  const auto figure = [](const std::string& svg) { return svg.empty() ? "" : "<figure>" + svg + "</figure>\n"; };
  page +=
      "<h2>Errors at " + short_number(number_of(data.value("horizon_s", json()))) +
      " s, in blocks of time that were not fitted</h2>\n<p>Root mean squares; 95 % intervals from drawing blocks of "
      "ten seconds.</p>\n" +
      errors_table(list_of(data, "rows"), "model") +
      figure(intervals_figure("Errors of held-out predictions", list_of(data, "rows"), true));
  page += claims_list(claims);
  if (!list_of(data, "ablations").empty())
    page +=
        "<h2>What each effect is worth</h2>\n<p>Rise of the error when it is taken out and the rest fitted again; an "
        "interval that holds 0 says that it may be left out.</p>\n" +
        errors_table(list_of(data, "ablations"), "without") +
        figure(intervals_figure("Rise of the error without an effect", list_of(data, "ablations"), false));
  if (!list_of(data, "advice").empty()) {
    page += "<h2>What else would help</h2>\n<ul>\n";
    for (const json& a : list_of(data, "advice"))
      page += "<li>" + html_escaped(text_of(a, "effect")) + ": " +
              short_number(100.0 * number_of(a.value("gain", json()))) + " % less squared error to first order, " +
              short_number(number_of(a.value("score", json()))) + " standard deviations</li>\n";
    page += "</ul>\n";
  }
  const json road = data.value("road", json());
  for (const json& log : list_of(data, "held_out")) page += log_figures(log, road);
  if (!list_of(data, "parameters").empty())
    page += html_folded("Parameters", parameters_table(list_of(data, "parameters")));
  page += health_tables(data);
  return page + "</body></html>\n";
}

}  // namespace gripline::report
