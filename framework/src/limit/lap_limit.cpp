#include "limit/lap_limit.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>

#include "config/node.hpp"
#include "limit/envelope_car.hpp"
#include "limit/lap_nlp.hpp"
#include "limit/starting_line.hpp"
#include "limit/true_plant.hpp"

namespace gripline {
namespace {

constexpr int most_refinements = 4;

std::size_t coarse_nodes(const WorldSpec& spec) {
  const double wheelbase = spec.car.car.lf + spec.car.car.lr;
  return static_cast<std::size_t>(std::clamp(0.7 * spec.track->length() / wheelbase, 100.0, 1000.0));
}

/// Stations of nodes with those added where a patch begins or ends; nodes that are close to such a place give way.
std::vector<double> with_edges(const std::vector<double>& stations, const std::vector<FrictionSpec::Patch>& patches,
                               double length) {
  std::vector<double> nodes;
  const auto add = [&](double s, double close) {
    const auto near = [&](double other) { return std::abs(std::remainder(s - other, length)) < close; };
    if (std::none_of(nodes.begin(), nodes.end(), near)) nodes.push_back(s);
  };
  for (const FrictionSpec::Patch& patch : patches)
    for (const double edge : {patch.from_s, patch.to_s}) add(edge < length ? edge : 0.0, 1e-6 * length);
  const std::vector<double> edges = nodes;
  const double close = 0.3 * length / static_cast<double>(stations.size());
  for (const double s : stations) {
    const auto near = [&](double edge) { return std::abs(std::remainder(s - edge, length)) < close; };
    if (std::none_of(edges.begin(), edges.end(), near)) nodes.push_back(s);
  }
  std::sort(nodes.begin(), nodes.end());
  return nodes;
}

std::unique_ptr<LapCar> car_of(const WorldSpec& spec, const LapCase& of) {
  if (spec.plant.empty()) return std::make_unique<TruePlant>(spec, of.factor, of.patches);
  return std::make_unique<EnvelopeCar>(spec, of.factor, of.patches);
}

}  // namespace

LapLimit find_lap_limit(const WorldSpec& spec, const LapCase& of) { return find_fastest_lap(spec, of).limit; }

FastestLap find_fastest_lap(const WorldSpec& spec, const LapCase& of) {
  return find_fastest_lap(spec, *car_of(spec, of), of);
}

FastestLap find_fastest_lap(const WorldSpec& spec, const LapCar& plant, const LapCase& of) {
  const Track& track = *spec.track;
  const std::vector<StartingLine> lines = starting_lines(track, spec.car.car);
  std::vector<double> stations = stations_on(track, lines.front(), plant, coarse_nodes(spec));
  if (of.patches) stations = with_edges(stations, spec.friction.patches, track.length());
  LapMesh mesh = make_mesh(track, std::move(stations));
  Lap best;
  for (const StartingLine& line : lines) {
    const Lap found = solve_lap({plant, mesh, of.body}, drive_along(track, mesh, line, plant), LapStart::cold);
    if (found.solved && (!best.solved || found.time < best.time)) best = found;
  }
  const std::string where = " at friction factor " + number_text(of.factor);
  if (!best.solved) throw std::runtime_error("found no time-optimal lap" + where + " from any starting line");
  LapLimit limit{of, best.time, best.time, static_cast<int>(mesh.size())};
  for (int i = 0; i < most_refinements; ++i) {
    mesh = halved(track, mesh);
    const LapProblem problem{plant, mesh, of.body};
    Lap finer = solve_lap(problem, halved(best), LapStart::warm);
    if (!finer.solved) finer = solve_lap(problem, halved(best), LapStart::cold);
    if (!finer.solved) throw std::runtime_error("lost the time-optimal lap on a finer mesh" + where);
    limit.error_s = std::abs(finer.time - best.time);
    best = std::move(finer);
    limit.lap_s = best.time;
    limit.nodes = static_cast<int>(mesh.size());
    if (limit.error_s <= lap_limit_tolerance * limit.lap_s) return {limit, std::move(best), std::move(mesh)};
  }
  throw std::runtime_error("time-optimal laps on two meshes still differ by " + number_text(limit.error_s) + " s" +
                           where);
}

}  // namespace gripline
