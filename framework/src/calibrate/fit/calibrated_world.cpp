#include "calibrate/fit/calibrated_world.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "config/json_file.hpp"
#include "measured/estimates/session_delays.hpp"
#include "measured/session/centre_of_gravity.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::calibrate {
namespace {

constexpr double slowest_share = 0.25;  // of v_ref
/// A figure without more digits than anybody needs.
Node figure(double value, int digits = 6) { return number_or_null(rounded(value, digits)); }

Node parameter_record(const FittedParameter& p) {
  Node record = Node::empty_object();
  record.set("pointer", Node(p.unknown.pointer));
  record.set("group", Node(p.unknown.group));
  record.set("value", figure(p.value));
  record.set("low", figure(p.interval.low));
  record.set("high", figure(p.interval.high));
  record.set("prior", figure(p.unknown.prior));
  record.set("learned", figure(p.interval.learned, 3));
  record.set("status", Node(status_names[static_cast<std::size_t>(p.status)]));
  return record;
}

Node errors_record(std::span<const HorizonRow> rows) {
  Node all = Node::empty_object();
  for (const HorizonRow& row : rows) {
    Node one = Node::empty_object();
    for (std::size_t q = 0; q < quantities; ++q) {
      if (row.error[q].count == 0) continue;
      Node figures{Node::Array{}};
      for (const double v : {row.error[q].rms, row.error[q].low, row.error[q].high})
        figures.array().push_back(figure(v, 4));
      one.set(quantity_names[q], std::move(figures));
    }
    all.set(row.name, std::move(one));
  }
  return all;
}

Node friction_record(const Friction& friction) {
  Node record = Node::empty_object();
  record.set("front", figure(friction.front, 4));
  record.set("rear", figure(friction.rear, 4));
  record.set("total", figure(friction.total, 4));
  record.set("low", figure(friction.total_low, 4));
  record.set("high", figure(friction.total_high, 4));
  return record;
}

/// A file named in the world stays the same file seen from another folder; an empty one is the current folder.
void rename_file(Node& node, const std::filesystem::path& folder) {
  if (!node.is_text()) return;
  const std::filesystem::path file = std::filesystem::absolute(resolve_path(node)).lexically_normal();
  const auto from = std::filesystem::absolute(folder.empty() ? "." : folder).lexically_normal();
  const auto relative = file.lexically_relative(from);
  node = Node((relative.empty() ? file : relative).generic_string());
}

}  // namespace

ForecastOptions forecast_options(const WorldSpec& world) {
  constexpr double longest_step = 0.05;   // [s]
  constexpr double longest_block = 20.0;  // [s] every block costs a pre-roll
  const Car& car = world.car.car;
  ForecastOptions options;
  options.step = std::min(world.dt, longest_step);
  options.v_min = car.v_min;
  options.v_ref = car.v_ref;
  options.wheelbase = car.lf + car.lr;
  options.delta_max = car.delta_max;
  options.block = longest_block;
  return options;
}

double slowest_start(const WorldSpec& world) { return slowest_share * world.car.car.v_ref; }

namespace {

/// The value that logs or a map give an unknown, as near as its bounds allow.
double within_bounds(const Unknown& unknown, double value) { return std::clamp(value, unknown.low, unknown.high); }

/// An unknown whose own parameter is stated goes on with the first of those that are the same.
void hand_over(Unknown& unknown, double prior) {
  unknown.pointer = unknown.same.front().pointer;
  unknown.index = unknown.same.front().index;
  unknown.same.erase(unknown.same.begin());
  unknown.prior = within_bounds(unknown, prior);
}

}  // namespace

void fix_or_start_delays(const measured::LogMap& map, const std::list<measured::SessionFile>& files,
                         const Forecaster& forecaster, const Node& world, std::vector<double>& values,
                         std::vector<Unknown>& unknowns) {
  std::vector<std::array<double, measured::delay_groups>> of_files;  // looked for once, where one is wanted
  for (std::size_t g = 0; g < measured::delay_groups; ++g) {
    const std::size_t index = forecaster.index(ForecastParameter::delay_position) + g;
    const auto same = [&](const Unknown& u) { return u.index == index; };
    const auto stated = map.delay(g);
    if (stated) {
      if (!map.file.empty() || *stated != 0.0) values[index] = *stated;
      for (Unknown& u : unknowns) {
        if (same(u)) assign(values, u, values[index]);
        std::erase_if(u.same, [&](const Unknown::Same& s) { return s.index == index; });
        if (!same(u) || u.same.empty()) continue;
        hand_over(u, values[index]);
        assign(values, u, u.prior);
      }
      std::erase_if(unknowns, same);
      continue;
    }
    const std::string pointer = std::string("/calibration/delays/") + measured::delay_names[g];
    if (find_pointer(world, pointer) != nullptr) continue;  // fitted before
    if (of_files.empty() && !map.delay_start[g])
      for (const measured::SessionFile& file : files)
        of_files.push_back(measured::stated_or_found_delays(map, measured::pairwise_delays_of_file(file)));
    std::vector<double> found;
    if (map.delay_start[g]) found.push_back(*map.delay_start[g]);
    for (const auto& delays : of_files)
      if (!map.delay_start[g] && std::isfinite(delays[g])) found.push_back(delays[g]);
    if (found.empty()) continue;
    constexpr double most_early = -0.4, most_late = 0.9;  // [s] inside the range of the parameter
    values[index] = std::clamp(upper_median(std::move(found)), most_early, most_late);
    for (Unknown& u : unknowns)
      if (same(u)) values[index] = u.prior = within_bounds(u, values[index]);
  }
  unite(values, unknowns);
}

measured::TurningLateness turning_lateness(const Forecaster& forecaster, std::span<const double> params,
                                           std::span<const FittedParameter> fitted) {
  const auto of = [&](ForecastParameter delay) {
    const std::size_t at = forecaster.index(delay);
    measured::Lateness out{params[at], params[at], params[at]};
    for (const FittedParameter& p : fitted) {
      const bool same = std::ranges::any_of(p.unknown.same, [&](const Unknown::Same& s) { return s.index == at; });
      if (p.unknown.index != at && !same) continue;
      out.low = p.interval.low;
      out.high = p.interval.high;
    }
    return out;
  };
  return {of(ForecastParameter::delay_yaw_rate), of(ForecastParameter::delay_yaw)};
}

Node fitted_world(Node world, const WorldSpec& spec, const Forecaster& forecaster, const FitResult& result,
                  const FitSource& source, const std::filesystem::path& folder) {
  for (const FittedParameter& p : result.parameters) {
    set_value(world, p.unknown.pointer, rounded(p.value, 9));
    for (const Unknown::Same& s : p.unknown.same) set_value(world, s.pointer, rounded(p.value, 9));
  }
  const auto places = parameter_places(spec, forecaster);
  for (std::size_t i = places.size() - forecast_parameter_count; i < places.size(); ++i)
    set_value(world, places[i].pointer, rounded(result.params[places[i].index], 9));
  Node& calibration = *world.find("calibration");
  Node logs{Node::Array{}}, parameters{Node::Array{}};
  for (const std::string& log : source.logs) logs.array().push_back(Node(log));
  for (const FittedParameter& p : result.parameters) parameters.array().push_back(parameter_record(p));
  calibration.set("logs", std::move(logs));
  if (!source.map.empty()) calibration.set("map", Node(source.map));
  calibration.set("starts", Node(static_cast<double>(result.starts)));
  if (result.friction.known) calibration.set("friction", friction_record(result.friction));
  calibration.set("parameters", std::move(parameters));
  calibration.set("errors_at_horizon", errors_record(result.errors));
  for (const char* key : {"car", "track", "friction"})
    if (Node* const node = world.find(key); node != nullptr) rename_file(*node, folder);
  if (Node* const track = world.find("track"); track != nullptr && track->is_object()) {
    if (Node* const centre = track->find("centre"); centre != nullptr) rename_file(*centre, folder);
    if (Node* const edges = track->find("edges"); edges != nullptr)
      for (const char* key : {"inner", "outer"})
        if (Node* const edge = edges->find(key); edge != nullptr) rename_file(*edge, folder);
  }
  return world;
}

}  // namespace gripline::calibrate
