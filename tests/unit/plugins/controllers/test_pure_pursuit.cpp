#include <gtest/gtest.h>

#include "geometry/lap_counter.hpp"
#include "support/planner_support.hpp"

namespace gripline {
namespace test_pure_pursuit {

using namespace testing_support;
using Changes = std::vector<std::pair<std::string, double>>;

struct Drive {
  std::vector<double> laps;  // [s]
  double beyond_edge = -1;   // largest distance of the centre of gravity outside the track [m]
  double speed_error = 0;    // rms against the reference after the first lap [m/s]
  double deviation = 0;      // mean distance to the line [m]
};

/// Races pure_pursuit behind fixed_speed on the plant until `laps` laps or 60 s.
Drive race(const Track& track, double pace, int laps, const Changes& changes = {}) {
  const Registry registry = plugins();
  const Car car = car_1_43();
  const TrackCourse course(track, car);
  DynamicCar plant(registry, 0.02);
  PluginContext context;
  context.car = car;
  context.dt = 0.02;
  context.course = &course;
  context.nominal = &plant.prediction();
  context.mu_init = 0.9;
  const PluginEntry& planner_entry = registry.find(abi::Kind::planner, "fixed_speed");
  const Changes planner_changes{{"pace", pace}, {"margin", 0.02}};
  const auto planner = create<SpeedPlanner>(planner_entry, context, values_of(planner_entry, planner_changes));
  const PluginEntry& entry = registry.find(abi::Kind::controller, "pure_pursuit");
  const auto controller = create<Controller>(entry, context, values_of(entry, changes));

  Drive result;
  std::vector<RefPoint> horizon(static_cast<std::size_t>(controller->horizon()));
  Observation now;
  now.x = start_state(track);
  LapCounter counter(track, track.start());
  double started = 0, squares = 0, deviation = 0;
  int counted = 0, steps = 0;
  while (counter.laps() < laps && now.t < 60.0) {
    planner->plan(now, {}, nullptr, horizon);
    const Command command = controller->control(now, horizon, plant.prediction());
    if (counter.laps() > 0) {
      squares += (now.x.vx - horizon[0].v) * (now.x.vx - horizon[0].v);
      ++counted;
    }
    deviation += std::hypot(now.x.x - horizon[0].x, now.x.y - horizon[0].y);
    ++steps;
    now.x = plant.advance(now.x, command.u);
    now.t += 0.02;
    now.d = command.u.d;
    if (const auto ended = counter.advance(now.t, now.x.x, now.x.y)) {
      result.laps.push_back(*ended - started);
      started = *ended;
    }
    result.beyond_edge = std::max(result.beyond_edge, track.beyond_edge(counter.place()));
  }
  result.speed_error = counted > 0 ? std::sqrt(squares / counted) : 0;
  result.deviation = deviation / steps;
  return result;
}

// One decision for a car on a straight reference.
Command decide(const State& x, double v_ref, const Changes& changes = {}) {
  const Registry registry = plugins();
  DynamicCar model(registry, 0.02);
  PluginContext context;
  context.car = car_1_43();
  context.dt = 0.02;
  const PluginEntry& entry = registry.find(abi::Kind::controller, "pure_pursuit");
  const auto controller = create<Controller>(entry, context, values_of(entry, changes));
  std::vector<RefPoint> horizon(static_cast<std::size_t>(controller->horizon()));
  for (std::size_t k = 0; k < horizon.size(); ++k) {
    horizon[k].x = v_ref * 0.02 * static_cast<double>(k);
    horizon[k].v = v_ref;
  }
  Observation now;
  now.x = x;
  return controller->control(now, horizon, model.prediction());
}

TEST(PurePursuit, SteersTowardsTheLineWithinTheRate) {
  State x;
  x.vx = 1.0;
  x.y = 0.05;  // left of the line
  EXPECT_LT(decide(x, 1.0).u.ddelta, 0.0);
  x.y = -0.05;
  EXPECT_GT(decide(x, 1.0).u.ddelta, 0.0);
  x.y = -1.0;
  EXPECT_DOUBLE_EQ(decide(x, 1.0).u.ddelta, 5.0);
  x.y = 0.0;
  EXPECT_NEAR(decide(x, 1.0).u.ddelta, 0.0, 1e-12);
}

TEST(PurePursuit, ThrottleHoldsTheSpeedThatTheModelSays) {
  State x;
  x.vx = 2.0;
  const double d = decide(x, 2.0).u.d;
  EXPECT_NEAR((0.287 - 0.0545 * 2) * d, 0.0518 + 0.00035 * 4, 1e-9);  // drive against resistance
  EXPECT_DOUBLE_EQ(decide(x, 4.0).u.d, 1.0);
  EXPECT_DOUBLE_EQ(decide(x, 0.5).u.d, -0.1);
}

/// Too fast without brakes it can only coast: that is no error to sum up, or it would fall far below what is asked.
TEST(PurePursuit, TheIntegralWaitsWhereThePedalHasNoEffect) {
  const Registry registry = plugins();
  DynamicCar plant(registry, 0.02);
  PluginContext context;
  context.car = car_1_43();
  context.car.d_min = 0.0;
  context.dt = 0.02;
  const PluginEntry& entry = registry.find(abi::Kind::controller, "pure_pursuit");
  const auto controller = create<Controller>(entry, context, values_of(entry, {}));
  std::vector<RefPoint> horizon(static_cast<std::size_t>(controller->horizon()));
  Observation now;
  now.x.vx = 3.0;
  double slowest = 3.0;
  for (int i = 0; i < 400; ++i) {
    for (std::size_t k = 0; k < horizon.size(); ++k) {
      horizon[k].x = now.x.x + 0.02 * static_cast<double>(k);
      horizon[k].v = 1.0;
    }
    now.x = plant.advance(now.x, controller->control(now, horizon, plant.prediction()).u);
    slowest = std::min(slowest, now.x.vx);
  }
  EXPECT_GT(slowest, 0.95);
  EXPECT_NEAR(now.x.vx, 1.0, 0.02);
}

TEST(PurePursuit, TurnsAroundForATargetBehind) {
  State x;
  x.vx = 1.0;
  x.yaw = 3.0;
  EXPECT_DOUBLE_EQ(std::abs(decide(x, 1.0).u.ddelta), 5.0);
}

class PurePursuitLaps : public ::testing::TestWithParam<std::pair<const char*, double>> {};

TEST_P(PurePursuitLaps, StayInsideAtModerateSpeedFromStandstill) {
  const auto [name, pace] = GetParam();
  const Track track = std::string(name) == "ethz" ? ethz() : ethz_mobil();
  const Drive drive = race(track, pace, 2);
  ASSERT_EQ(drive.laps.size(), 2u);
  EXPECT_GT(drive.laps[0], drive.laps[1]);  // the standing start
  EXPECT_LT(drive.beyond_edge, 0.0);
  EXPECT_LT(drive.deviation, 0.03);
  EXPECT_LT(drive.speed_error, 0.15);
}
INSTANTIATE_TEST_SUITE_P(Tracks, PurePursuitLaps,
                         ::testing::Values(std::pair{"ethz", 0.5}, std::pair{"ethz", 0.75}, std::pair{"mobil", 0.5},
                                           std::pair{"mobil", 0.75}));

}  // namespace test_pure_pursuit
}  // namespace gripline
