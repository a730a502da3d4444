#include "planners/time_optimal/tyre_belief.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "planners/time_optimal/lap_dynamics.hpp"
#include "support/planner_support.hpp"

namespace gripline {
namespace test_tyre_belief {

using namespace time_optimal;
using namespace testing_support;

class TyreBeliefTest : public ::testing::Test {
 protected:
  const Car car_ = car_1_43();
  TyreBelief tyres_{car_, LapParams{.front_B = 5.0, .rear_C = 1.5}};
};

TEST_F(TyreBeliefTest, WithoutALearnedCurveShapesAreTheParameters) {
  Belief belief;
  belief.mu_front = 0.6;
  belief.mu_rear = 0.9;
  const AxleTyres tyres = tyres_.tyres(belief, nullptr);
  EXPECT_EQ(tyres.front.B, 5.0);
  EXPECT_EQ(tyres.rear.C, 1.5);
  // An axle's peak is its friction times the load that stands on it.
  const double weight = gravity / (car_.lf + car_.lr);
  EXPECT_DOUBLE_EQ(tyres.front.D, 0.6 * weight * car_.lr);
  EXPECT_DOUBLE_EQ(tyres.rear.D, 0.9 * weight * car_.lf);
  EXPECT_DOUBLE_EQ(mu_of(tyres_.generic()), 1.0);
}

TEST_F(TyreBeliefTest, ASlipIsVisitedOnceOneStepInTwoHundredHadMore) {
  State straight, slide;
  straight.vx = slide.vx = 1.0;
  slide.vy = -0.5;  // the rear axle slips by 0.46 rad
  for (int i = 0; i < 300; ++i) tyres_.see(straight);
  tyres_.see(slide);
  EXPECT_LT(tyres_.visited_slip(), 0.05);
  for (int i = 0; i < 5; ++i) tyres_.see(slide);
  EXPECT_NEAR(tyres_.visited_slip(), 0.46, 0.02);
}

/// Backwards around a circle, as a car that spun does for a while: its wheels roll where they point.
TEST_F(TyreBeliefTest, WheelsOfACarThatRollsBackwardsDoNotSlip) {
  State back;
  back.vx = -1.0;
  back.delta = 0.3;
  back.omega = back.vx * std::tan(back.delta) / (car_.lf + car_.lr);
  back.vy = back.omega * car_.lr;
  for (int i = 0; i < 300; ++i) tyres_.see(back);
  EXPECT_LT(tyres_.visited_slip(), 0.02);
}

}  // namespace test_tyre_belief
}  // namespace gripline
