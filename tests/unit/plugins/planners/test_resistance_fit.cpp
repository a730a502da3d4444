#include "planners/time_optimal/resistance_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace test_resistance_fit
}  // namespace gripline
