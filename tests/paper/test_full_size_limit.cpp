// The laps that a full-size world states as its limit are those of the plant's own quasi-steady states.
#include <gtest/gtest.h>

#include "config/json_file.hpp"
#include "support/full_size_limit.hpp"
#include "support/paths.hpp"
#include "support/whole_world.hpp"
#include "world/world_spec.hpp"

namespace gripline {
namespace {

TEST(FullSizeLimit, SteadyTurnsOfThePlantReachIt) {
  const double_track::Params p;
  const testing_support::FullSizeLimit limit(p, 1.0);
  double_track::DoubleTrackCar car(p);
  struct Plane final : Ground {
    Patch at(double, double, double) const override { return {}; }
  };
  const Plane plane;
  const double radius = 80.0;
  // speed rises slowly on the circle until it can no longer be held
  State start;
  start.vx = 20.0;
  car.reset(start, plane);
  double delta = 2.64 / radius;
  double d = 0.0;
  double best = 0.0;  // share of the limit
  for (int k = 0; k < 6000; ++k) {
    const double wanted = 20.0 + 0.1 * 0.02 * k;
    const auto& z = car.motion();
    d = std::clamp(d + 0.004 * (wanted - z.vx), -0.2, 1.0);
    delta = std::clamp(delta + 0.002 * (wanted / radius - z.omega), 0.0, 0.2);
    car.advance(std::clamp(d + 0.3 * (wanted - z.vx), -1.0, 1.0), delta, 0.02, plane);
    const double v = z.vx;
    const double most = testing_support::FullSizeLimit::largest(
        20.0, [&](double a) { return limit.holds(v, a, limit.resistance(v), {}); });
    best = std::max(best, v * z.omega / most);
  }
  EXPECT_LT(best, 1.02);  // steered drive forces push sideways too
  EXPECT_GT(best, 0.97);  // slip losses are left out of the limit
}

TEST(FullSizeLimit, WorldsStateTheirLimit) {
  const WorldSpec world =
      testing_support::world_from(load_json(testing_support::source_dir() / "worlds/full_size_wear.json"));
  ASSERT_GE(world.time_optimal.laps.size(), 4u);
  const auto line = testing_support::line_of_the_centre_of_gravity(*world.track, world.car.car);
  for (const auto& [factor, lap] : world.time_optimal.laps) {
    const double computed = testing_support::FullSizeLimit({}, factor).lap(line, *world.track);
    EXPECT_NEAR(computed, lap, 0.02) << factor;
  }
}

}  // namespace
}  // namespace gripline
