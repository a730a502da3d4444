#include "planners/time_optimal/resistance_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/planner_support.hpp"

namespace gripline {
namespace test_resistance_fit {

using namespace time_optimal;
using namespace testing_support;

class ResistanceFitTest : public ::testing::Test {
 protected:
  /// Steps of dt straight ahead at `speed`, for so many seconds, of a car that lacks `resistance` of its nominal rate.
  void drive(ResistanceFit& fit, double dt, double seconds, double resistance) {
    State x;
    x.vx = speed;
    const double rate = model_.prediction().rates(x, {throttle, 0.0}, {}).vx - resistance;
    Observation before, now;
    before.x.vx = speed - 0.5 * dt * rate;
    now.x.vx = speed + 0.5 * dt * rate;
    now.d = throttle;
    for (double t = 0.5 * dt; t < seconds; t += dt) fit.learn(before, now, dt, front_, car_, model_.prediction());
  }

  static constexpr double speed = 2.0, throttle = 0.3;
  const Registry registry_ = plugins();
  const Car car_ = car_1_43();
  const MagicFormula front_{4.0, 1.3, 5.0};
  DynamicCar model_{registry_, 0.02};
};

TEST_F(ResistanceFitTest, FindsWhatTheNominalModelLacks) {
  ResistanceFit fit({}, car_.v_ref);
  drive(fit, 0.02, 20.0, 0.7);
  EXPECT_NEAR(fit.value().at(speed), 0.7, 1e-3);
}

// A thousandth is forgotten in 20 ms, whatever a step lasts: 1 - 1/e^0.5 of a change is learned in ten seconds.
TEST_F(ResistanceFitTest, RemembersAsLongAtAnyStep) {
  for (const double dt : {0.01, 0.02, 0.04}) {
    ResistanceFit fit({}, car_.v_ref);
    drive(fit, dt, 200.0, 1.0);
    drive(fit, dt, 10.0, 2.0);
    EXPECT_NEAR(fit.value().at(speed), 2.0 - std::pow(0.999, 500), 0.01) << dt;
  }
}

TEST_F(ResistanceFitTest, LeavesOutWhatIsNoNumber) {
  ResistanceFit fit({}, car_.v_ref);
  drive(fit, 0.005, 20.0, 0.7);
  Observation before, now;
  before.x.vx = now.x.vx = speed;
  now.x.omega = std::nan("");
  fit.learn(before, now, 0.005, front_, car_, model_.prediction());
  drive(fit, 0.005, 1.0, 0.7);
  EXPECT_NEAR(fit.value().at(speed), 0.7, 1e-3);
}

// Over one step of 5 ms the difference of two readings is off by 14 m/s2, which is no resistance.
TEST_F(ResistanceFitTest, FindsItUnderNoiseAtShortSteps) {
  constexpr double sigma = 0.05, pushed = 0.5;  // of a reading of vx [m/s]; throttle
  for (const double dt : {0.02, 0.007, 0.005, 0.002}) {
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    ResistanceFit fit({}, car_.v_ref);
    Observation before, now;
    now.d = pushed;
    const auto read = [&] { return speed + sigma * normal(random); };
    before.x.vx = read();
    for (double t = 0; t < 20.0; t += dt) {
      // The car keeps its speed, though it should gain some.
      now.x.vx = read();
      fit.learn(before, now, dt, front_, car_, model_.prediction());
      before = now;
    }
    State straight;
    straight.vx = speed;
    const double lacking = model_.prediction().rates(straight, {pushed, 0.0}, {}).vx;
    EXPECT_GT(lacking, 0.3);
    EXPECT_NEAR(fit.value().at(speed), lacking, 0.1 * lacking) << dt;
  }
}

}  // namespace test_resistance_fit
}  // namespace gripline
