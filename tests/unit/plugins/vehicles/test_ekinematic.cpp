#include "support/vehicle_checks.hpp"

namespace gripline {
namespace test_ekinematic {

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

TEST(EKinematic, AnEnginesMapTakesThePlaceOfItsStraightLine) {
  const TestedModel tested(
      "ekinematic", {{"m", 1000},       {"Cr0", 50},        {"Cd", 0.5},        {"Cb", 8000},       {"v_1", 10},
                     {"v_2", 15},       {"v_3", 25},        {"v_4", 30},        {"v_5", 50},        {"full_0", 9000},
                     {"full_1", 9500},  {"full_2", 6500},   {"full_3", 6700},   {"full_4", 5000},   {"full_5", 4500},
                     {"closed_0", 0},   {"closed_1", -500}, {"closed_2", -300}, {"closed_3", -400}, {"closed_4", -200},
                     {"closed_5", -300}});
  const auto rate = [&](double v, double d) { return tested.at({v, 0, 0, d, 0, 0}).ax; };
  const auto expected = [](double v, double full, double closed, double d) {
    return ((full - closed) * d + closed - 50 - 0.5 * v * v) / 1000;
  };
  EXPECT_NEAR(rate(10, 1.0), expected(10, 9500, -500, 1.0), 1e-12);
  EXPECT_NEAR(rate(20, 1.0), expected(20, 6600, -350, 1.0), 1e-12);
  EXPECT_NEAR(rate(20, 0.4), expected(20, 6600, -350, 0.4), 1e-12);
  EXPECT_NEAR(rate(28, 0.0), expected(28, 0, -280, 0.0), 1e-12);
  EXPECT_NEAR(rate(40, 1.0), expected(40, 4750, -250, 1.0), 1e-12);
  EXPECT_NEAR(rate(70, 1.0), expected(70, 4500, -300, 1.0), 1e-12);
  EXPECT_NEAR(rate(5, 1.0), expected(5, 9250, -250, 1.0), 1e-12);
  EXPECT_NEAR(rate(20, -0.5), (-8000 * 0.5 - 350 - 50 - 200) / 1000.0, 1e-12);
  const double h = 1e-4;
  EXPECT_NEAR(rate(25 + h, 1.0), rate(25 - h, 1.0), 1e-3);
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

}  // namespace test_ekinematic
}  // namespace gripline
