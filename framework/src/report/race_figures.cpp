#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <tuple>
#include <utility>

#include <gripline/types.hpp>

#include "report/figures.hpp"
#include "report/packing.hpp"
#include "report/plot.hpp"
#include "report/series.hpp"
#include "report/tables.hpp"
#include "util/numbers.hpp"

namespace gripline::report {
namespace {

constexpr const char* dashed = "6 4";

/// One run as the figures need it.
struct RunSeries {
  std::size_t stack;
  std::string label, colour, dash;
  std::map<std::string, std::vector<double>> channels;
  std::vector<double> mu_sigma;  // of the rows of run.replay; may be empty
  Run run;

  [[nodiscard]] const std::vector<double>& at(const std::string& name) const {
    static const std::vector<double> nothing;
    const auto found = channels.find(name);
    return found == channels.end() ? nothing : found->second;
  }
  [[nodiscard]] bool has(const std::string& name) const { return channels.contains(name); }
};

std::string label_of(const StackEntry& stack) { return stack.needs_truth ? stack.name + " *" : stack.name; }

/// The first run that left a log, of every stack.
std::vector<RunSeries> first_runs(const Inputs& inputs) {
  std::vector<RunSeries> drawn;
  const CarShape car = car_shape(inputs.scene);
  for (std::size_t i = 0; i < inputs.stacks.size(); ++i) {
    const StackEntry& stack = inputs.stacks[i];
    for (const RunName& name : inputs.runs) {
      if (name.stack != stack.name) continue;
      RunSeries one{i,  label_of(stack),       series_colour(i), stack.needs_truth ? dashed : "", {},
                    {}, read_run(inputs, name)};
      for (TimeSeries& channel : step_channels(one.run, car)) one.channels[channel.name] = std::move(channel.values);
      if (one.channels.empty()) continue;
      one.mu_sigma = mu_sigma(one.run, car);
      drawn.push_back(std::move(one));
      break;
    }
  }
  return drawn;
}

Series line_of(const RunSeries& d, const std::vector<double>& x, const std::vector<double>& y) {
  // Two values per pixel of a broad figure are plenty; extremes are kept.
  const std::size_t stride = std::max<std::size_t>(1, y.size() / 2400);
  Series s;
  s.x = thin(x, Thinning::sample, stride);
  s.y = thin(y, Thinning::extremes, stride);
  s.colour = d.colour;
  s.label = d.label;
  s.dash = d.dash;
  return s;
}

std::vector<double> speed_of(const RunSeries& d) {
  std::vector<double> speed = d.at("vx");
  const std::vector<double>& vy = d.at("vy");
  for (std::size_t i = 0; i < std::min(speed.size(), vy.size()); ++i) speed[i] = std::hypot(speed[i], vy[i]);
  return speed;
}

Series outline(std::span<const double> x, std::span<const double> y) {
  Series s;
  s.kind = Series::Kind::closed;
  s.x.assign(x.begin(), x.end());
  s.y.assign(y.begin(), y.end());
  s.colour = "#8b8f96";
  s.width = 1;
  return s;
}

/// The course's edges; its centre if the log has no edges.
std::vector<Series> course_of(const Columns& track) {
  if (!track.has("left_x_m"))
    return track.has("x_m") ? std::vector{outline(track.numbers("x_m"), track.numbers("y_m"))} : std::vector<Series>();
  return {outline(track.numbers("left_x_m"), track.numbers("left_y_m")),
          outline(track.numbers("right_x_m"), track.numbers("right_y_m"))};
}

void add_trail(std::vector<Series>& out, const RunSeries& d, double low, double high) {
  constexpr int levels = 24;
  const std::vector<double>&x = d.at("x"), &y = d.at("y");
  const std::vector<double> speed = speed_of(d);
  // A speed that is missing is drawn as the lowest.
  const auto level = [&](std::size_t i) {
    const double share = (speed[i] - low) / std::max(high - low, 1e-9);
    return std::isfinite(share) ? static_cast<int>(std::lround(std::clamp(share, 0.0, 1.0) * levels)) : 0;
  };
  Series piece;
  const auto flush = [&](int at) {
    piece.colour = sequential_colour(static_cast<double>(at) / levels);
    piece.width = 1.6;
    if (piece.x.size() > 1) out.push_back(piece);
    piece = Series();
  };
  const std::size_t points = std::min({x.size(), y.size(), speed.size()});
  for (std::size_t i = 0; i < points; ++i) {
    piece.x.push_back(x[i]);
    piece.y.push_back(y[i]);
    if (i + 1 == points || level(i + 1) != level(i)) {
      flush(level(i));
      piece.x.push_back(x[i]);
      piece.y.push_back(y[i]);
    }
  }
  const std::vector<double>& outside = d.at("outside");
  Series bad;
  bad.colour = "#d6176b";
  bad.width = 4;
  bool any = false;
  for (std::size_t i = 0; i < std::min({outside.size(), x.size(), y.size()}); ++i) {
    const bool on = outside[i] >= 0.5;
    any |= on;
    bad.x.push_back(x[i]);
    bad.y.push_back(on ? y[i] : not_a_number);
  }
  bad.label = "outside the track";
  if (any) out.push_back(std::move(bad));
}

/// What the course spans along one axis, with a margin.
std::pair<double, double> drawn_range(const std::vector<Series>& series, std::vector<double> Series::*axis) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Series& s : series)
    for (const double v : s.*axis) low = std::min(low, v), high = std::max(high, v);
  const double margin = 0.05 * (high - low);
  return {low - margin, high + margin};
}

FigureFile trajectories(const Inputs& inputs, const std::vector<RunSeries>& runs) {
  double low = std::numeric_limits<double>::infinity(), high = 0;
  for (const RunSeries& d : runs)
    for (const double v : speed_of(d)) low = std::min(low, v), high = std::max(high, v);
  std::vector<Panel> panels;
  for (const RunSeries& d : runs) {
    Panel panel;
    panel.title = d.label;
    panel.equal = true;
    panel.x.label = "x [m]";
    panel.y.label = "y [m]";
    panel.series = course_of(inputs.track);
    // The same cut-out for all.
    if (!panel.series.empty()) {
      const auto [x_low, x_high] = drawn_range(panel.series, &Series::x);
      const auto [y_low, y_high] = drawn_range(panel.series, &Series::y);
      panel.x.low = x_low, panel.x.high = x_high, panel.y.low = y_low, panel.y.high = y_high;
    }
    add_trail(panel.series, d, low, high);
    panels.push_back(std::move(panel));
  }
  const auto tenths = [](double v) { return number_or_null(std::round(v * 10) / 10).dump(); };
  return {"trajectories.svg", draw_panels("Trajectories, coloured by speed from " + tenths(low) + " (dark) to " +
                                              tenths(high) + " m/s (light)",
                                          panels, 2, 480, 380)};
}

/// Of the runs whose stacks were not told the truth and finished, the one whose last lap and time outside together are
/// least: the row that the page has in colour.
std::size_t most_telling(const Inputs& inputs, const std::vector<RunSeries>& runs) {
  const Columns& table = inputs.table;
  std::string last_lap;
  for (int lap = 0; table.has("lap" + std::to_string(lap) + "_s"); ++lap) {
    const std::string name = "lap" + std::to_string(lap) + "_s";
    if (std::ranges::any_of(table.numbers(name), [](double v) { return std::isfinite(v); })) last_lap = name;
  }
  const auto rank = [&](const RunSeries& d) {
    std::size_t row = 0;
    while (row < table.rows() && stack_of_row(inputs, row) != d.stack) ++row;
    const auto value = [&](const std::string& column) {
      const double v = table.number(column, row);
      return std::isfinite(v) ? v : std::numeric_limits<double>::infinity();
    };
    const double outside = value("violation_s");
    return std::tuple(inputs.stacks[d.stack].needs_truth, table.number("finished", row) == 0.0,
                      value(last_lap) + outside, outside);
  };
  return static_cast<std::size_t>(std::ranges::min_element(runs, {}, rank) - runs.begin());
}

FigureFile over_time(const Inputs& inputs, const std::vector<RunSeries>& runs) {
  constexpr std::size_t told_apart = 4;  // lines in one picture, as on the page
  Panel panel;
  panel.x.label = "time [s]";
  panel.y.label = "speed [m/s]";
  for (const RunSeries& d : runs) panel.series.push_back(line_of(d, d.at("t"), speed_of(d)));
  if (runs.size() > told_apart) {
    const std::size_t lit = most_telling(inputs, runs);
    for (std::size_t i = 0; i < runs.size(); ++i) {
      if (i == lit) continue;
      panel.series[i].colour = "#c9ccd1";
      panel.series[i].width = 1;
      panel.series[i].label = "other rows";
    }
    std::swap(panel.series[lit], panel.series.back());  // on top
  }
  return {"speed.svg", draw_panels("Speed", {panel}, 1, 900, 320)};
}

/// y at the times `at`: each the last sample by then, before the first one that one.
std::vector<double> sample_and_hold(std::span<const double> at, const std::vector<double>& x,
                                    const std::vector<double>& y) {
  std::vector<double> out;
  for (const double t : at) {
    const auto i = static_cast<std::size_t>(std::upper_bound(x.begin(), x.end(), t) - x.begin());
    out.push_back(i == 0 ? y.front() : y[i - 1]);
  }
  return out;
}

FigureFile friction(const std::vector<RunSeries>& runs) {
  Panel panel;
  panel.x.label = "time [s]";
  panel.y.label = "µ of the whole car";
  for (const RunSeries& d : runs) {
    const auto t = d.run.replay.numbers("t_s");
    if (!d.has("mu_belief") || t.empty() || d.mu_sigma.size() != t.size()) continue;
    Series band;
    band.kind = Series::Kind::band;
    band.x.assign(t.begin(), t.end());
    band.y = band.high = sample_and_hold(t, d.at("t"), d.at("mu_belief"));
    for (std::size_t i = 0; i < t.size(); ++i) {
      band.y[i] -= d.mu_sigma[i];
      band.high[i] += d.mu_sigma[i];
    }
    band.colour = d.colour;
    band.opacity = 0.16;
    panel.series.push_back(std::move(band));
  }
  const RunSeries* longest = nullptr;
  for (const RunSeries& d : runs) {
    if (d.has("mu_belief")) panel.series.push_back(line_of(d, d.at("t"), d.at("mu_belief")));
    if (d.has("mu_true") && (longest == nullptr || d.at("t").size() > longest->at("t").size())) longest = &d;
  }
  if (longest != nullptr) {
    Series truth = line_of(*longest, longest->at("t"), longest->at("mu_true"));
    truth.colour = "#1a1c20";
    truth.dash = "2 3";
    truth.width = 2.2;
    truth.label = "true";
    panel.series.push_back(std::move(truth));
  }
  return {"friction.svg", draw_panels("Friction, estimated and true", {panel}, 1, 900, 340)};
}

/// The last snapshot of one axle.
struct Curve {
  std::vector<double> slip, learned, truth;
};
Curve last_curve(const Columns& tyres, const char* axle) {
  Curve curve;
  double last = not_a_number;
  for (std::size_t i = 0; i < tyres.rows(); ++i) {
    if (tyres.text("axle", i) != axle) continue;
    if (tyres.number("t_s", i) != last) curve = Curve();
    last = tyres.number("t_s", i);
    curve.slip.push_back(tyres.number("slip_rad", i) * 180 / std::numbers::pi);
    curve.learned.push_back(tyres.number("learned_n", i));
    curve.truth.push_back(tyres.number("true_n", i));
  }
  return curve;
}

std::vector<FigureFile> tyre_curves(const std::vector<RunSeries>& runs) {
  std::vector<Panel> panels;
  for (const char* axle : {"front", "rear"}) {
    Panel panel;
    panel.title = axle;
    panel.x.label = "slip angle [°]";
    panel.y.label = "lateral force [N]";
    Series truth;
    truth.dash = "2 3";
    truth.label = "true";
    truth.width = 2.2;
    for (const RunSeries& d : runs) {
      const Curve curve = last_curve(d.run.tyres, axle);
      if (curve.slip.empty()) continue;
      if (panel.series.empty()) truth.x = curve.slip, truth.y = curve.truth;
      panel.series.push_back(line_of(d, curve.slip, curve.learned));
    }
    if (panel.series.empty()) continue;
    panel.series.push_back(std::move(truth));  // last, on top of the learned ones
    panels.push_back(std::move(panel));
  }
  if (panels.empty()) return {};
  return {
      {"tyre_curves.svg", draw_panels("Tyre curves at the last full second, learned and true", panels, 2, 450, 340)}};
}

Series circle(double radius, const char* dash, std::string label) {
  Series s;
  for (int i = 0; i <= 90; ++i) {
    s.x.push_back(radius * std::cos(i * std::numbers::pi / 45));
    s.y.push_back(radius * std::sin(i * std::numbers::pi / 45));
  }
  s.dash = dash;
  s.label = std::move(label);
  return s;
}

FigureFile g_g(const std::vector<RunSeries>& runs) {
  Panel panel;
  panel.equal = true;
  panel.x.label = "to the left [g]";
  panel.y.label = "forward [g]";
  double low = std::numeric_limits<double>::infinity(), high = 0;
  for (const RunSeries& d : runs) {
    for (const double mu : d.at("mu_true"))
      if (std::isfinite(mu)) low = std::min(low, mu), high = std::max(high, mu);
    Series s;
    s.kind = Series::Kind::points;
    for (std::size_t i = 0; i < std::min(d.at("ax").size(), d.at("ay").size()); ++i) {
      s.x.push_back(d.at("ay")[i] / gravity);
      s.y.push_back(d.at("ax")[i] / gravity);
    }
    s.colour = d.colour;
    s.label = d.label;
    s.width = 2.2;
    s.opacity = 0.5;
    panel.series.push_back(std::move(s));
  }
  if (high > 0) {
    panel.x.low = panel.y.low = -1.2 * high;
    panel.x.high = panel.y.high = 1.2 * high;
    panel.series.push_back(circle(high, "", "friction, highest"));
    if (high - low > 0.01) panel.series.push_back(circle(low, "5 4", "friction, lowest"));
  }
  return {"g_g.svg", draw_panels("g-g diagram", {panel}, 1, 560, 560)};
}

FigureFile step_times(const Inputs& inputs) {
  Panel panel;
  panel.x.label = "solve [ms]";
  panel.x.logarithmic = true;
  panel.y.label = "share of steps [%]";
  panel.y.low = 0;
  for (std::size_t i = 0; i < inputs.stacks.size(); ++i) {
    TimeHistogram histogram;
    for (const RunName& name : inputs.runs) {
      if (name.stack != inputs.stacks[i].name) continue;
      const Columns timing = Columns::read(inputs.folder / name.stack / name.seed / "timing.csv");
      for (const double ms : timing.numbers("solve_ms")) histogram.add(ms);
    }
    const nlohmann::json counts = histogram.json();
    if (counts["n"] == 0) continue;
    Series s;
    s.kind = Series::Kind::step;
    int next = -1;
    const auto edge = [](int bin) {
      return TimeHistogram::first_ms * std::pow(10, static_cast<double>(bin) / TimeHistogram::bins_per_decade);
    };
    for (const nlohmann::json& bin : counts["bins"]) {
      const int index = bin[0].get<int>();
      if (index != next) {
        s.x.insert(s.x.end(), {edge(next < 0 ? index : next), edge(index)});
        s.y.insert(s.y.end(), {0, 0});
      }
      s.x.push_back(edge(index));
      s.y.push_back(100 * bin[1].get<double>() / counts["n"].get<double>());
      next = index + 1;
    }
    s.x.push_back(edge(next));
    s.y.push_back(0);
    s.colour = series_colour(i);
    s.dash = inputs.stacks[i].needs_truth ? dashed : "";
    s.label = label_of(inputs.stacks[i]);
    panel.series.push_back(std::move(s));
  }
  return {"step_times.svg", panel.series.empty() ? "" : draw_panels("Time of each solve", {panel}, 1, 700, 340)};
}

/// A line from one end of an interval to the other; nothing where the table has none.
void add_interval(std::vector<Series>& out, std::array<double, 2> x, std::array<double, 2> y,
                  const std::string& colour) {
  for (const double v : {x[0], x[1], y[0], y[1]})
    if (!std::isfinite(v)) return;
  Series s;
  s.x.assign(x.begin(), x.end());
  s.y.assign(y.begin(), y.end());
  s.colour = colour;
  s.width = 2;
  out.push_back(std::move(s));
}

FigureFile laps(const Inputs& inputs) {
  Panel panel;
  panel.y.label = "lap time [s]";
  std::vector<std::string> columns;
  while (inputs.table.has("lap" + std::to_string(columns.size()) + "_s"))
    columns.push_back("lap" + std::to_string(columns.size()) + "_s");
  const double width = 0.72 / static_cast<double>(std::max<std::size_t>(1, inputs.table.rows()));
  std::vector<Series> limits;
  for (std::size_t row = 0; row < inputs.table.rows(); ++row) {
    Series s, limit;
    s.kind = Series::Kind::points;
    for (std::size_t lap = 0; lap < columns.size(); ++lap) {
      const double time = inputs.table.number(columns[lap], row),
                   ratio = inputs.table.number("pace_ratio" + std::to_string(lap), row);
      const double x = static_cast<double>(lap) +
                       (static_cast<double>(row) - (static_cast<double>(inputs.table.rows()) - 1) / 2) * width;
      s.x.push_back(x);
      s.y.push_back(time);
      add_interval(panel.series, {x, x},
                   {inputs.table.number(columns[lap] + "_lo", row), inputs.table.number(columns[lap] + "_hi", row)},
                   series_colour(row));
      limit.x.insert(limit.x.end(), {x - 0.42 * width, x + 0.42 * width, x});
      limit.y.insert(limit.y.end(), {time / ratio, time / ratio, not_a_number});
    }
    s.colour = series_colour(row);
    s.label = label_of(inputs.stacks[stack_of_row(inputs, row)]);
    s.width = 9;
    limit.label = "limit at that friction";
    limit.width = 2;
    panel.series.push_back(std::move(s));
    // Without a limit the ratios are there, and empty.
    if (std::ranges::any_of(limit.y, [](double v) { return std::isfinite(v); })) limits.push_back(std::move(limit));
  }
  const char* const title = limits.empty() ? "Lap times" : "Lap times against the limit";
  std::move(limits.begin(), limits.end(), std::back_inserter(panel.series));  // in the legend after all rows
  panel.x.low = -0.5;
  panel.x.high = static_cast<double>(columns.size()) - 0.5;
  for (std::size_t lap = 0; lap < columns.size(); ++lap)
    panel.x.ticks.emplace_back(static_cast<double>(lap), "lap " + std::to_string(lap));
  return {"laps.svg", columns.empty() ? "" : draw_panels(title, {panel}, 1, 900, 340)};
}

FigureFile pareto(const Inputs& inputs) {
  std::string pace;
  const auto filled = [&](const std::string& name) {
    return std::ranges::any_of(inputs.table.numbers(name), [](double v) { return std::isfinite(v); });
  };
  for (const std::string& name : inputs.table.names())
    if (name.starts_with("pace_ratio") && !name.ends_with("_lo") && !name.ends_with("_hi") && filled(name)) pace = name;
  if (pace.empty() || !inputs.table.has("violation_s")) return {"pareto.svg", ""};
  Panel panel;
  panel.x.label = "lap time over the limit, last lap";
  panel.y.label = "time outside [s]";
  for (std::size_t row = 0; row < inputs.table.rows(); ++row) {
    Series s;
    s.kind = Series::Kind::points;
    s.x = {inputs.table.number(pace, row)};
    s.y = {inputs.table.number("violation_s", row)};
    s.colour = series_colour(row);
    s.width = 10;
    const auto ends = [&](const std::string& column) {
      return std::array{inputs.table.number(column + "_lo", row), inputs.table.number(column + "_hi", row)};
    };
    add_interval(panel.series, ends(pace), {s.y[0], s.y[0]}, s.colour);
    add_interval(panel.series, {s.x[0], s.x[0]}, ends("violation_s"), s.colour);
    if (std::isfinite(s.x[0]) && std::isfinite(s.y[0]))
      panel.labels.push_back({{s.x[0], s.y[0]}, label_of(inputs.stacks[stack_of_row(inputs, row)])});
    panel.series.push_back(std::move(s));
  }
  return {"pareto.svg", draw_panels("Pace against safety", {panel}, 1, 640, 400)};
}

bool any_has(const std::vector<RunSeries>& runs, const std::string& channel) {
  return std::any_of(runs.begin(), runs.end(), [&](const RunSeries& d) { return d.has(channel); });
}

}  // namespace

std::vector<FigureFile> race_figures(const Inputs& inputs) {
  std::vector<FigureFile> figures;
  const std::vector<RunSeries> runs = first_runs(inputs);
  if (any_has(runs, "x")) figures.push_back(trajectories(inputs, runs));
  if (any_has(runs, "vx")) figures.push_back(over_time(inputs, runs));
  if (any_has(runs, "mu_belief")) figures.push_back(friction(runs));
  for (FigureFile& figure : tyre_curves(runs)) figures.push_back(std::move(figure));
  if (any_has(runs, "ax")) figures.push_back(g_g(runs));
  figures.push_back(laps(inputs));
  figures.push_back(step_times(inputs));
  figures.push_back(pareto(inputs));
  std::erase_if(figures, [](const FigureFile& figure) { return figure.svg.empty(); });
  return figures;
}

}  // namespace gripline::report
