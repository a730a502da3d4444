#include "planners/time_optimal/lap_plan.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/road_table.hpp"
#include "planners/time_optimal/lap_setup.hpp"
#include "support/planner_support.hpp"
#include "support/sample_roads.hpp"

namespace gripline {
namespace test_lap_plan {

using namespace time_optimal;
using namespace testing_support;

class LapPlanTest : public ::testing::Test, protected PlannerRig {
 protected:
  /// The figure of eight, 4 m by 2 m.
  static Track small_eight() {
    RoadTable road = test::figure_of_eight(11.0, 0.0, 0.3);
    road.height.clear();
    road.bridges = true;
    scale(road, 1.0 / 75.0);
    return to_track(road);
  }

  Track eight_ = small_eight();
  LapSetup setup_{context_on(eight_),
                  SetupOptions{.margin = 0.4 * car_.width, .spacing = 0.05, .use = {.slip_bound = 0.7}},
                  {planning::equal_friction(0.8, car_, 4.0, 1.3), {}}};
};

TEST_F(LapPlanTest, OnABridgeACarBeginsOnThePassThatItFollows) {
  PlanFollower follower(setup_);
  LapPlan plan;
  plan.nodes.assign(setup_.nodes().s.size(), {0.0, 0.0, 1.0, 0.0, 0.0});
  follower.set(plan);
  const double length = setup_.base().length();
  for (double s = -0.2; s < length; s += 0.021) {
    for (const double n : {-0.06, 0.0, 0.06}) {
      const PlanPoint p = follower.at(s);
      PlanFollower fresh = follower;
      const double found = fresh.locate(p.x - n * std::sin(p.yaw), p.y + n * std::cos(p.yaw), p.yaw + 0.2);
      EXPECT_NEAR(std::remainder(found - s, length), 0.0, 0.02) << "s = " << s << ", n = " << n;
    }
  }
}

// A part of the plan that moves, also one across the start of the base line, moves what lies behind it along the path.
TEST_F(LapPlanTest, StationsOfTheSamplesAreTheWayAlongThem) {
  PlanFollower follower(setup_);
  LapPlan plan;
  const std::size_t n = setup_.nodes().s.size();
  plan.nodes.assign(n, {0.0, 0.0, 1.0, 0.0, 0.0});
  follower.set(plan);
  for (const auto& [first, count] : {std::pair(n / 3, std::size_t{6}), std::pair(n - 3, std::size_t{6})}) {
    for (std::size_t k = 1; k + 1 < count; ++k) plan.nodes[(first + k) % n].n = k % 2 == 0 ? 0.05 : -0.05;
    follower.set(plan, first, count);
    double way = 0;
    const std::span<const LinePoint> line = follower.samples();
    for (std::size_t i = 0; i < line.size(); ++i) {
      if (i > 0) way += std::hypot(line[i].x - line[i - 1].x, line[i].y - line[i - 1].y);
      ASSERT_NEAR(line[i].s, way, 1e-12) << i;
    }
    PlanFollower whole(setup_);
    whole.set(plan);
    EXPECT_EQ(whole.samples().back().s, line.back().s);
  }
}

}  // namespace test_lap_plan
}  // namespace gripline
