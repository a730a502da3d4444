#include "support/vehicle_checks.hpp"

namespace gripline {
namespace test_kinematic {

using namespace rig;

TEST(Kinematic, HasTheStagesOfACarWithoutTyres) {
  const TestedModel tested("kinematic");
  EXPECT_FALSE(tested.model->stages() & (stage_bit(Stage::tyre) | stage_bit(Stage::force)));
  EXPECT_TRUE(tested.model->stages() & stage_bit(Stage::drive));
}

TEST(Kinematic, StaysOnItsMapWhileItSteers) {
  Nominal nominal("kinematic");
  StagedCar car = nominal.car();
  StepOptions options = Nominal::options("rk6");
  options.hold = Hold::rate;  // the angle moves as its rate says
  CorrectedModel model(car, options);
  const Car small = small_car();
  State x;
  x.vx = 1.0;
  for (int i = 0; i < 60; ++i) {
    const Input u{0.4, i < 30 ? 0.8 : -1.2};
    x = model.advance(x, u, {});
    EXPECT_NEAR(x.vy, x.vx * small.lr / (small.lf + small.lr) * std::tan(x.delta), 1e-9);
    EXPECT_NEAR(x.omega, x.vx * std::tan(x.delta) / (small.lf + small.lr), 1e-8);
  }
  EXPECT_GT(x.vx, 1.0);
}

TEST(Kinematic, DrivesTheCircleItsSteeringPointsAt) {
  Nominal nominal("kinematic", {{"Cm1", 0.0}, {"Cm2", 0.0}});
  const Car small = small_car();
  const double delta = 0.3, L = small.lf + small.lr, share = small.lr / L * std::tan(delta);
  State x;
  x.delta = delta;
  x.vx = 1.0;
  x.vy = share;
  x.omega = std::tan(delta) / L;
  const double radius = std::hypot(1.0, share) / x.omega;  // of the centre of gravity
  const double cx = -radius * std::sin(std::atan(share)), cy = radius * std::cos(std::atan(share));
  for (int i = 0; i < 100; ++i) {
    x = nominal.prediction().advance(x, {0, 0}, {});
    EXPECT_NEAR(std::hypot(x.x - cx, x.y - cy), radius, 1e-6);
  }
}

TEST(Kinematic, SpeedChangesByTheDriveAlone) {
  const TestedModel tested("kinematic");
  const TrueCar truth;
  const double share = truth.car.lr / (truth.car.lf + truth.car.lr);
  for (const Instant& one : instants(50)) {
    Instant at = one;
    at[1] = at[0] * share * std::tan(at[4]);  // on the map
    at[2] = at[1] / truth.car.lr;
    const Quantities<double> q = tested.at(at);
    const double v = std::hypot(at[0], at[1]);
    EXPECT_NEAR((at[0] * q.ax + at[1] * q.ay) / v, (truth.Cm1 - truth.Cm2 * at[0]) * at[3] / truth.car.m, 1e-10);
  }
}

TEST(Kinematic, AgreesWithEKinematicForSmallAngles) {
  const TestedModel exact("kinematic"), linear("ekinematic");
  const Instant at{1.5, 0, 0, 0.3, 1e-4, 0.01};
  const Quantities<double> a = exact.at(at), b = linear.at(at);
  EXPECT_NEAR(a.ax, b.ax, 1e-6);
  EXPECT_NEAR(a.ay, b.ay, 1e-6);
  EXPECT_NEAR(a.aw, b.aw, 1e-5);
}

TEST(Kinematic, DerivativesAgreeWithDifferences) {
  const TestedModel tested("kinematic");
  for (const Instant& at : instants(20, false)) EXPECT_LT(derivative_error(*tested.model, at, tested.params), 2e-6);
}

}  // namespace test_kinematic
}  // namespace gripline
