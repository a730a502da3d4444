#include "race/race_end.hpp"

#include <cmath>

namespace gripline {
namespace {

/// A car that moves by less than this share of its length in this time is stuck: the stack sees no more changes.
constexpr double standing_share = 0.1, standing_s = 5.0;

}  // namespace

RaceEnd::RaceEnd(const World& world) : world_(world), moved_{world.state().x, world.state().y, world.time()} {}

void RaceEnd::watch() {
  if (!world_.finite()) return;
  const State& x = world_.state();
  if (std::hypot(x.x - moved_.x, x.y - moved_.y) > standing_share * world_.spec().car.car.length)
    moved_ = {x.x, x.y, world_.time()};
}

std::optional<Status> RaceEnd::status() const {
  const WorldSpec& spec = world_.spec();
  // Of the instants of the steps, the one nearest to t is meant, whatever rounding makes of either.
  const auto reached = [&](double t) { return world_.time() >= t - 0.5 * spec.dt; };
  if (!world_.finite()) return Status::error;
  if (world_.crashed()) return Status::crashed;
  if (spec.laps > 0 && world_.laps() >= spec.laps) return Status::finished;
  if (spec.duration && reached(*spec.duration)) return Status::finished;
  if (world_.time() - moved_.t >= standing_s - 0.5 * spec.dt) return Status::stuck;
  if (reached(spec.timeout)) return Status::timeout;
  return std::nullopt;
}

}  // namespace gripline
