#include "planners/time_optimal/driven_plan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>

#include "planners/time_optimal/kept_lap.hpp"
#include "planners/time_optimal/lap_setup.hpp"
#include "support/planner_support.hpp"

namespace gripline {
namespace test_driven_plan {

using namespace time_optimal;
using namespace testing_support;

/// The plan that is driven, of a lap at friction 0.8 that moves aside by 1 cm within a window.
class DrivenPlanTest : public ::testing::Test, protected PlannerRig {
 protected:
  void SetUp() override {
    plan_ = driven_.whole(kept_.nodes());
    before_ = plan_;
    window_.place(20, kept_.nodes());
    for (std::size_t k = 0; k <= window_.count(); ++k) kept_.nodes()[window_.node(k)].z[lap_n] += aside;
  }
  const LapPlan::Node& now(std::size_t k) const { return plan_.nodes[window_.node(k)]; }
  const LapPlan::Node& then(std::size_t k) const { return before_.nodes[window_.node(k)]; }

  static constexpr double aside = 0.01, mu = 0.8;
  const CarBelief typical_{planning::equal_friction(mu, car_, 4.0, 1.3), {}};
  PluginContext context_ = context_on(mobil_);
  LapSetup setup_{context_, SetupOptions{.margin = 0.4 * car_.width, .spacing = 0.1, .use = {.slip_bound = 0.7}},
                  typical_};
  KeptLap kept_{setup_, typical_.tyres};
  LapWindow window_{setup_, 60, 2.0};
  DrivenPlan driven_{setup_, mu};
  LapPlan plan_, before_;
};

TEST_F(DrivenPlanTest, GoesAShareOfTheWayToTheNearPartOfAWindow) {
  driven_.follow(window_, kept_.nodes(), 1, 0.25, mu, plan_);
  for (std::size_t k = 1; k < window_.near_count(); ++k) EXPECT_NEAR(now(k).n, then(k).n + 0.25 * aside, 1e-12) << k;
  EXPECT_EQ(now(0).n, then(0).n);
  for (std::size_t k = window_.near_count(); k <= window_.count(); ++k) EXPECT_EQ(now(k).n, then(k).n) << k;
}

// There is no node before the one behind a car that left its plan: the plan before it is of another way.
TEST_F(DrivenPlanTest, BeginsAtItsFirstNodeForACarThatLeftIt) {
  driven_.follow(window_, kept_.nodes(), 0, 1.0, mu, plan_);
  EXPECT_NEAR(now(0).n, then(0).n + aside, 1e-12);
  EXPECT_EQ(now(0).kappa, now(1).kappa);
  // Its slope is that of the way to the next node, not of the jump from the node before.
  const double ds = setup_.nodes().ds[window_.first()];
  EXPECT_NEAR(now(0).slope, (now(1).n - now(0).n) / ds, 1e-9);
}

TEST_F(DrivenPlanTest, IsDrivenMoreSlowlyForLessFrictionAndNoFasterForMore) {
  driven_.set_speeds(window_, 0.25 * mu, plan_);
  for (std::size_t k = 0; k < window_.count(); ++k) EXPECT_NEAR(now(k).v, 0.5 * then(k).v, 1e-12) << k;
  EXPECT_EQ(now(window_.count()).v, then(window_.count()).v);
  driven_.set_speeds(window_, 2.0 * mu, plan_);
  for (std::size_t k = 0; k < window_.count(); ++k) EXPECT_EQ(now(k).v, then(k).v) << k;
}

TEST_F(DrivenPlanTest, OneNodeIsSlowedDownForAShareOfItsFriction) {
  driven_.slow_down(window_.node(3), 0.25);
  driven_.set_speeds(window_, mu, plan_);
  EXPECT_NEAR(now(3).v, 0.5 * then(3).v, 1e-12);
  EXPECT_EQ(now(4).v, then(4).v);
}

TEST(ShareOfWay, GoesAsFastAtAnyControlStep) {
  for (const double share : {0.01, 0.05, 0.15, 0.5, 1.0}) {
    EXPECT_EQ(share_of_way_in(0.02, share), share);
    const double left = 1.0 - share_of_way_in(0.01, share);
    EXPECT_NEAR(left * left, 1.0 - share, 1e-12);  // after two steps
    EXPECT_NEAR(1.0 - share_of_way_in(0.04, share), (1.0 - share) * (1.0 - share), 1e-12);
  }
}

}  // namespace test_driven_plan
}  // namespace gripline
