#include "vehicle_checks.hpp"

namespace gripline {
namespace {

using namespace rig;

TEST(EKinematic, HasTheStagesOfACarWithoutTyres) {
  const TestedModel tested("ekinematic");
  const unsigned expected = stage_bit(Stage::command) | stage_bit(Stage::drive) | stage_bit(Stage::load) |
                            stage_bit(Stage::body) | stage_bit(Stage::reading);
  EXPECT_EQ(tested.model->stages(), expected);
}

TEST(EKinematic, FollowsThePaperWithTheRightFactors) {
  const TestedModel tested("ekinematic");
  const TrueCar truth;
  const double L = truth.car.lf + truth.car.lr;
  for (const Instant& at : instants(50)) {
    const auto [vx, vy, omega, d, delta, rate] = at;
    const double ax = (truth.Cm1 - truth.Cm2 * vx) * d / truth.car.m;
    const Quantities<double> q = tested.at(at);
    EXPECT_NEAR(q.ax, ax, 1e-12);
    EXPECT_NEAR(q.ay, truth.car.lr / L * (rate * vx + delta * ax), 1e-12);
    EXPECT_NEAR(q.aw, (rate * vx + delta * ax) / L, 1e-10);
  }
}

TEST(EKinematic, ResistanceAndBrakesAreParameters) {
  const TestedModel tested("ekinematic", {{"Cr0", 0.0518}, {"Cd", 0.01}, {"Cb", 0.2}});
  const Quantities<double> braking = tested.at({2.0, 0, 0, -0.1, 0, 0});
  EXPECT_NEAR(braking.ax, (-0.02 - 0.0518 - 0.04) / 0.041, 1e-12);
  const Quantities<double> driving = tested.at({2.0, 0, 0, 0.5, 0, 0});
  EXPECT_NEAR(driving.ax, ((0.287 - 0.109) * 0.5 - 0.0518 - 0.04) / 0.041, 1e-12);
}

TEST(EKinematic, FeelsTheGradeAndIsHeldOnABank) {
  Place place;
  place.grade = 0.03;
  place.bank = 0.05;
  const Quantities<double> q = TestedModel("ekinematic").at({2, 0, 0, 0, 0, 0}, place);
  EXPECT_EQ(q.grade, 0.03);
  EXPECT_EQ(q.bank, 0.0);
}

TEST(EKinematic, DerivativesAgreeWithDifferences) {
  for (const Settings& settings : {Settings{}, Settings{{"Cr0", 0.05}, {"Cd", 0.01}, {"Cb", 0.2}}}) {
    const TestedModel tested("ekinematic", settings);
    for (const Instant& at : instants(20, !settings.empty()))
      EXPECT_LT(derivative_error(*tested.model, at, tested.params), 2e-6);
  }
}

TEST(EKinematic, StepJacobianAgreesWithDifferences) {
  Nominal nominal("ekinematic");
  for (const Instant& at : instants(10)) {
    const State x{0.1, -0.2, 0.3, at[0], at[1], at[2], at[4]};
    EXPECT_LT(jacobian_error(nominal.prediction(), x, {at[3], at[5]}), 1e-6);
  }
}

}  // namespace
}  // namespace gripline
