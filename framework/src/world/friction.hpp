// How the road's friction factor changes with time and with place.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace gripline {

/// The factor f multiplies the tyres' peak force; 1 is fresh. Plain data, as written in a world.
struct FrictionSpec {
  struct PointInTime {
    double t = 0.0;       ///< [s]
    double factor = 1.0;  ///< > 0
  };
  /// From control step `start_step` on, once per step: f -= f / divide. `end_step`, if given, is the last such step.
  struct PerStep {
    std::int64_t start_step = 0;
    double divide = 0.0;  ///< > 1
    std::optional<std::int64_t> end_step;
  };
  /// Multiplies the factor between two stations [m] from time from_t
  /// [s] on; from_s > to_s: through the road's first station.
  struct Patch {
    double from_s = 0.0, to_s = 0.0;
    double factor = 1.0;  ///< > 0
    double from_t = 0.0;
  };
  std::vector<PointInTime> points;  ///< linear between, the first and last values hold; empty means 1
  std::optional<PerStep> per_step;  ///< beside points: multiplies
  std::vector<Patch> patches;
  double shift_per_seed = 0.0;  ///< [s] seed k sees every time later by (k - 1) times this
};

/// One line saying why the schedule makes no sense; empty if it does. `track_length` 0 leaves stations unchecked.
std::string check_friction(const FrictionSpec& spec, double track_length = 0.0);
/// One line saying that shift_per_seed is not a multiple of the control step although steps are counted; else empty.
std::string check_shift_per_seed(const FrictionSpec& spec, double dt);

class FrictionSchedule {
 public:
  /// Fresh everywhere and always.
  FrictionSchedule() = default;
  /// Throws std::invalid_argument with check_friction's line, or if the seed's shift is not a whole number of control
  /// steps although steps are counted.
  FrictionSchedule(FrictionSpec spec, double dt, std::uint64_t seed = 1);

  /// Factor held over control step `step`, which begins at time t = step * dt, with the car at station s [m].
  double factor(std::int64_t step, double t, double s) const;
  /// Factor over control step `step`, which begins at time t, without patches.
  double base(std::int64_t step, double t) const;

 private:
  FrictionSpec spec_;
  double near_ = 0.0;  ///< [s] instants so near are the same
};

}  // namespace gripline
