#include "planners/time_optimal/lap_window.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "planners/time_optimal/lap_setup.hpp"
#include "support/planner_support.hpp"

namespace gripline {
namespace test_lap_window {

using namespace time_optimal;
using namespace testing_support;

/// Windows of a lap that is driven at 1 m/s, 0.4 s behind the car and `ahead` seconds before it.
class LapWindowTest : public ::testing::Test, protected PlannerRig {
 protected:
  LapWindowTest() : lap_(setup_.nodes().s.size()) {
    for (WindowNode& node : lap_) node.z[lap_vx] = 1.0;
  }
  std::size_t size() const { return lap_.size(); }
  double station_of(std::size_t node) const { return setup_.nodes().s[node % size()]; }
  /// Along the lap from one node to another [m].
  double way(std::size_t from, std::size_t to) const {
    return wrap_periodic(station_of(to) - station_of(from), setup_.base().length());
  }

  static constexpr double ahead = 4.0;
  const CarBelief typical_{planning::equal_friction(0.8, car_, 4.0, 1.3), {}};
  PluginContext context_ = context_on(mobil_);
  LapSetup setup_{context_, SetupOptions{.margin = 0.4 * car_.width, .spacing = 0.1, .use = {.slip_bound = 0.7}},
                  typical_};
  std::vector<WindowNode> lap_;
  LapWindow window_{setup_, size() - 2, ahead};
};

TEST_F(LapWindowTest, ReachesFromBehindTheCarToSoFarAheadAlsoRoundTheEndOfTheLap) {
  for (const double station : {3.0, 0.1, setup_.base().length() - 1.0}) {
    window_.place(window_.first_behind(station, lap_), lap_);
    const double behind = wrap_periodic(station - station_of(window_.first()), setup_.base().length());
    EXPECT_GE(behind, 0.4);
    EXPECT_LT(behind, 0.4 + 0.3);
    EXPECT_NEAR(way(window_.first(), window_.last()), 0.4 + ahead, 0.2);
    EXPECT_EQ(window_.node(window_.count()), window_.last());
    EXPECT_EQ(window_.nodes_to(window_.last()), window_.count());
  }
}

TEST_F(LapWindowTest, StaysUntilTheCarIsATenthOfASecondFurther) {
  EXPECT_FALSE(window_.may_stay(0, lap_));  // not placed yet
  const std::size_t first = size() - 2;
  window_.place(first, lap_);
  EXPECT_TRUE(window_.may_stay(first, lap_));
  std::size_t node = first;
  while (way(first, node % size()) < 0.1) EXPECT_TRUE(window_.may_stay(node++ % size(), lap_)) << node;
  EXPECT_FALSE(window_.may_stay((node + 1) % size(), lap_));
  EXPECT_FALSE(window_.may_stay(first - 1, lap_));  // a car that went back
}

TEST_F(LapWindowTest, SaysHowManyNodesItHadBefore) {
  const std::size_t first = size() - 5;
  EXPECT_EQ(window_.place(first, lap_), 0U);
  const std::size_t count = window_.count();
  EXPECT_TRUE(window_.reaches(3));
  EXPECT_EQ(window_.place(3, lap_), count - 8);
  EXPECT_FALSE(window_.reaches(first));
  EXPECT_EQ(window_.place(first, lap_), 0U);
}

TEST_F(LapWindowTest, IsNotLongerThanItMayBe) {
  LapWindow window{setup_, 35, ahead};
  window.place(7, lap_);
  EXPECT_EQ(window.count(), 35U);
  for (WindowNode& node : lap_) node.z[lap_vx] = 0.0;  // a lap that stands still has an end, too
  window_.place(7, lap_);
  EXPECT_GE(window_.count(), 30U);
  EXPECT_LE(window_.count(), size() - 2);
}

// A car on a circle passed the node behind it on that circle, with the heading that it had there.
TEST_F(LapWindowTest, ACarPassedTheNodeBehindItAlongItsArc) {
  const LinePoint line = setup_.base().at(2.0);
  const std::size_t node = setup_.node_at(2.0);
  const double left = 0.02, askew = 0.1, radius = 1.5;
  State car;
  car.x = line.x - left * std::sin(line.yaw);
  car.y = line.y + left * std::cos(line.yaw);
  car.yaw = line.yaw + askew;
  car.vx = 1.2;
  car.omega = car.vx / radius;
  EXPECT_EQ(node_behind(setup_, car, 2.0), node);
  const auto z = passed_with(setup_, car, node);
  const LinePoint at = setup_.base().at(setup_.nodes().s[node]);
  const double x = at.x - z[lap_n] * std::sin(at.yaw), y = at.y + z[lap_n] * std::cos(at.yaw);
  const double centre_x = car.x - radius * std::sin(car.yaw), centre_y = car.y + radius * std::cos(car.yaw);
  EXPECT_NEAR(std::hypot(x - centre_x, y - centre_y), radius, 1e-3);
  EXPECT_NEAR(z[lap_xi], std::remainder(std::atan2(x - centre_x, centre_y - y) - at.yaw, 2.0 * std::numbers::pi), 1e-2);
  EXPECT_EQ(z[lap_vx], car.vx);
  EXPECT_EQ(z[lap_omega], car.omega);
}

}  // namespace test_lap_window
}  // namespace gripline
