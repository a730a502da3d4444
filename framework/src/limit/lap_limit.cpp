#include "limit/lap_limit.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "config/node.hpp"
#include "limit/lap_nlp.hpp"
#include "limit/starting_line.hpp"

namespace gripline {
namespace {

constexpr int most_refinements = 4;

std::size_t coarse_nodes(const WorldSpec& spec) {
  const double wheelbase = spec.car.car.lf + spec.car.car.lr;
  return static_cast<std::size_t>(std::clamp(0.7 * spec.track->length() / wheelbase, 100.0, 1000.0));
}

}  // namespace

LapLimit find_lap_limit(const WorldSpec& spec, double factor, bool body, Lap* lap, LapMesh* mesh_out) {
  const Track& track = *spec.track;
  const TruePlant plant(spec, factor);
  const std::vector<StartingLine> lines = starting_lines(track, spec.car.car);
  LapMesh mesh = make_mesh(track, stations_on(track, lines.front(), plant, coarse_nodes(spec)));
  Lap best;
  for (const StartingLine& line : lines) {
    const Lap found = solve_lap({plant, mesh, body}, drive_along(track, mesh, line, plant), false);
    if (found.solved && (!best.solved || found.time < best.time)) best = found;
  }
  const std::string where = " at friction factor " + number_text(factor);
  if (!best.solved) throw std::runtime_error("found no time-optimal lap" + where + " from any starting line");
  LapLimit limit{factor, body, best.time, best.time, static_cast<int>(mesh.size())};
  for (int i = 0; i < most_refinements; ++i) {
    mesh = halved(track, mesh);
    const LapProblem problem{plant, mesh, body};
    Lap finer = solve_lap(problem, halved(best), true);
    if (!finer.solved) finer = solve_lap(problem, halved(best), false);
    if (!finer.solved) throw std::runtime_error("lost the time-optimal lap on a finer mesh" + where);
    limit.error_s = std::abs(finer.time - best.time);
    best = std::move(finer);
    limit.lap_s = best.time;
    limit.nodes = static_cast<int>(mesh.size());
    if (limit.error_s <= lap_limit_tolerance * limit.lap_s) {
      if (lap != nullptr) *lap = best;
      if (mesh_out != nullptr) *mesh_out = mesh;
      return limit;
    }
  }
  throw std::runtime_error("time-optimal laps on two meshes still differ by " + number_text(limit.error_s) + " s" +
                           where);
}

}  // namespace gripline
