#include "limit/plant_envelope.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "car/staged_car.hpp"
#include "support/host_support.hpp"

namespace gripline {
namespace test_plant_envelope {

using testing::HasSubstr;
using namespace testing_support;

/// A point that turns as it is steered until a friction circle ends it.
class CircleCar final : public Plant {
 public:
  double mu_ = 1.0, throttle_ = 5.0, brakes_ = 30.0, drag_ = 0.001, lock_ = 1.0;
  double least_factor_ = 0.0;  // of friction, on which it can be driven
  bool fails_turning_on_brakes_ = false;
  void reset(const State& x, const Ground&) override { x_ = x; }
  State advance(double d, double delta, double dt, const Ground& ground) override {
    const double factor = ground.at(x_.x, x_.y, x_.yaw).factor;
    if (factor < least_factor_) throw std::runtime_error("too slippery");
    if (fails_turning_on_brakes_ && d < 0 && delta > 0) throw std::runtime_error("spun");
    const double v = x_.vx, hold = factor * mu_ * gravity;
    const double along = std::clamp(d >= 0 ? d * throttle_ : d * brakes_, -hold, hold);
    const double side = std::sqrt(hold * hold - along * along);
    const double across = std::clamp(lock_ * v * v * delta / 2.5, -side, side);
    x_.omega = across / std::max(v, 0.1);
    x_.yaw += dt * x_.omega;
    x_.vx = v + dt * (along - 0.1 - drag_ * v * v);
    if (x_.vx < 0.0) x_.vx = 0.0;
    return x_;
  }
  double mu(Axle) const override { return mu_; }
  double tyre_force(Axle, double) const override { return 0; }
  double axle_force(Axle) const override { return 0; }

 private:
  State x_;
};

Car full_size() {
  Car car;
  car.m = 1265;
  car.lf = car.lr = 1.25;
  car.d_min = -1;
  car.d_max = 1;
  car.delta_max = 0.5;
  car.ddelta_max = 1;
  car.v_ref = 20;
  return car;
}

TEST(PlantEnvelope, OfACarThatIsKnown) {
  CircleCar plant;
  const PlantEnvelope e = measure_envelope(plant, full_size(), 0.02, 0.8);
  const double hold = 0.8 * gravity;
  EXPECT_NEAR(e.top, std::sqrt(4.9 / 0.001), 3.0);
  for (const double v : {10.0, 25.0, 45.0}) {
    EXPECT_NEAR(e.side.at(v, 1.0), hold, 0.02 * hold) << v;
    EXPECT_NEAR(e.brake.at(v, 1.0), hold, 0.02 * hold) << v;
    EXPECT_NEAR(e.throttle.at(v), 5.0, 0.1) << v;
    EXPECT_NEAR(e.brakes.at(v), hold, 0.1) << v;
    EXPECT_NEAR(e.rolling.at(v), -0.1 - 0.001 * v * v, 0.02) << v;
  }
  EXPECT_NEAR(e.bend, 0.0, 1e-3);
  EXPECT_NEAR(e.shape, 2.0, 0.2);
}

/// What tyres hold along is known also where brakes and drive ask for less.
TEST(PlantEnvelope, WeakBrakesDoNotHideTheTyres) {
  CircleCar plant;
  plant.brakes_ = 4.0;
  const PlantEnvelope e = measure_envelope(plant, full_size(), 0.02, 1.0);
  EXPECT_NEAR(e.brakes.at(20.0), 4.0, 0.1);
  EXPECT_NEAR(e.brake.at(20.0, 1.0), gravity, 0.05 * gravity);
  EXPECT_NEAR(e.shape, 2.0, 0.2);
}

/// Speeds of a curve then lie further apart than the slowest is from standstill.
TEST(PlantEnvelope, OfACarThatIsFastForItsReferenceSpeed) {
  for (const double drag : {2e-4, 1.5e-5}) {
    CircleCar plant;
    plant.drag_ = drag;
    const PlantEnvelope e = measure_envelope(plant, full_size(), 0.02, 1.0);
    EXPECT_GT(e.top, 7.0 * full_size().v_ref);
    EXPECT_NEAR(e.top, std::sqrt(4.9 / drag), 0.1 * e.top);
    for (const double v : {e.throttle.v0, 20.0, 100.0}) {
      EXPECT_NEAR(e.throttle.at(v), 5.0, 0.1) << v;
      EXPECT_NEAR(e.brakes.at(v), gravity, 0.1) << v;
    }
  }
}

/// It is past the slowest speed of a curve after one step.
TEST(PlantEnvelope, OfACarThatIsQuickForItsReferenceSpeed) {
  CircleCar plant;
  Car car = full_size();
  car.v_ref = 0.7;
  const PlantEnvelope e = measure_envelope(plant, car, 0.02, 1.0);
  EXPECT_NEAR(e.throttle.at(e.throttle.v0), 5.0, 0.2);
}

/// Where brakes are too weak for the tyres and no road is slippery enough, what brakes gave is what is known.
TEST(PlantEnvelope, OfACarThatCannotBeDrivenWhereItIsSlippery) {
  for (const double brakes : {30.0, 4.0}) {
    CircleCar plant;
    plant.brakes_ = brakes;
    plant.least_factor_ = 0.9;
    const PlantEnvelope e = measure_envelope(plant, full_size(), 0.02, 1.0);
    const double known = std::min(brakes, gravity);
    EXPECT_NEAR(e.side.at(20.0, 1.0), gravity, 0.02 * gravity);
    EXPECT_NEAR(e.brakes.at(20.0), known, 0.1);
    EXPECT_NEAR(e.brake.at(20.0, 1.0), known, 0.05 * known);
  }
}

/// No turn on the brakes shows a limit here.
TEST(PlantEnvelope, IsACircleWhereNothingSaysOtherwise) {
  CircleCar plant;
  plant.fails_turning_on_brakes_ = true;
  EXPECT_EQ(measure_envelope(plant, full_size(), 0.02, 1.0).shape, 2.0);
}

TEST(PlantEnvelope, SaysWhatAPlantCannotDo) {
  const auto reason = [](auto&& change) {
    CircleCar plant;
    change(plant);
    try {
      measure_envelope(plant, full_size(), 0.02, 1.0);
    } catch (const std::runtime_error& e) {
      return std::string(e.what());
    }
    return std::string("nothing");
  };
  EXPECT_THAT(reason([](CircleCar& c) { c.throttle_ = 0; }), HasSubstr("does not gain speed"));
  EXPECT_THAT(reason([](CircleCar& c) { c.brakes_ = 0; }), HasSubstr("does not stop"));
  EXPECT_THAT(reason([](CircleCar& c) { c.brakes_ = 0.05; }), HasSubstr("does not stop"));
  EXPECT_EQ(reason([](CircleCar& c) { c.brakes_ = 0.2; }), "nothing");
  EXPECT_THAT(reason([](CircleCar& c) { c.lock_ = 1e-3; }), HasSubstr("steering"));
  EXPECT_THAT(reason([](CircleCar& c) { c.drag_ = NAN; }), HasSubstr("not a number"));
}

TEST(SpeedCurve, IsSmoothAndStraightBeyondItsEnds) {
  const SpeedCurve curve{5, 2, {1, 2, 4, 3, 3.5}};
  const SpeedCurve line{5, 2, {1, 2, 3, 4}};
  for (double v = -3; v < 20; v += 0.37) EXPECT_NEAR(line.at(v), 1 + 0.5 * (v - 5), 1e-12) << v;
  for (double v = -3; v < 20; v += 0.5) {
    EXPECT_NEAR(curve.at(v - 1e-9), curve.at(v + 1e-9), 1e-7) << v;
    const double slope = curve.at(Dual8::variable(v, 0)).d[0];
    EXPECT_NEAR(slope, (curve.at(v + 1e-5) - curve.at(v - 1e-5)) / 2e-5, 1e-4) << v;
  }
}

}  // namespace test_plant_envelope
}  // namespace gripline
