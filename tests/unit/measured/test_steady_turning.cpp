#include "measured/steady_turning.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "support/calibrate_rig.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {
namespace {

using test::CalibrateRig;
using test::small_car_world;

constexpr double wheelbase = 0.17, v_ref = 2.0;

/// A car of the rig's, without a forecaster; the gradient of its linear tyres.
struct SmallCar {
  SmallCar(double front, double rear)
      : spec(
            CalibrateRig::read(small_car_world(format(R"({"plant": {"params": {"Bf": %g, "Br": %g}}})", front, rear)))),
        vehicle(spec.vehicle, CalibrateRig::context(spec)),
        gradient(1.6 / wheelbase * (0.09 / (front * 1.4 * 6) - 0.08 / (rear * 1.4 * 6))) {}
  WorldSpec spec;
  Vehicle vehicle;
  double gradient;
};

/// Slow weaves at speeds that change, by an amount that keeps lateral accelerations gentle.
CommandSample<double> gentle(double t) {
  return {0.30 + 0.12 * std::sin(0.31 * t), 0.05 * std::sin(0.9 * t) + 0.03 * std::sin(0.37 * t + 1.0)};
}

Session log_of(const SmallCar& car, double noise = 1.0, double yaw_rate_late = 0.0, unsigned seed = 1) {
  return test::drive(car.vehicle.car(), {.seconds = 90,
                                         .noise = noise,
                                         .delay = {0, 0, 0, yaw_rate_late},
                                         .seed = seed,
                                         .command = gentle,
                                         .speed = 1.5});
}

std::optional<SteadyTurning> turning_of(const Session& log, double yaw_rate_late = 0.0) {
  const Session* const one = &log;
  return steady_turning({&one, 1}, wheelbase, v_ref, yaw_rate_late);
}

TEST(SteadyTurning, IsThatOfTheCarThatDrove) {
  for (const auto& [front, rear] : {std::pair{3, 9}, {9, 4}}) {
    const SmallCar car(front, rear);
    const auto found = turning_of(log_of(car));
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->gradient, car.gradient, 0.1 * std::abs(car.gradient)) << front;
    EXPECT_NEAR(found->ratio, 1.0, 0.03) << front;
    EXPECT_GT(found->low * found->high, 0.0) << front;  // surely one of both
  }
}

TEST(SteadyTurning, AWrongSteeringRatioAndOffsetAreNoUndersteer) {
  const SmallCar car(3, 9);
  Session log = log_of(car);
  for (CommandSample<double>& c : log.command) c.delta = 1.2 * c.delta + 0.05;
  const auto found = turning_of(log), plain = turning_of(log_of(car));
  ASSERT_TRUE(found && plain);
  EXPECT_NEAR(found->ratio, 1.2 * plain->ratio, 1e-6);
  EXPECT_NEAR(found->gradient, 1.2 * plain->gradient, 1e-6);  // of the angles that the log has
}

TEST(SteadyTurning, OffsetsOfLogsAreTheirOwn) {
  const SmallCar car(3, 9);
  Session left = log_of(car, 1.0, 0.0, 1), right = log_of(car, 1.0, 0.0, 2);
  for (CommandSample<double>& c : left.command) c.delta += 0.03;
  for (CommandSample<double>& c : right.command) c.delta -= 0.03;
  const Session* const both[] = {&left, &right};
  const auto found = steady_turning(both, wheelbase, v_ref, 0.0);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->gradient, car.gradient, 0.1 * car.gradient);
  EXPECT_EQ(found->stretches, 18u);
}

TEST(SteadyTurning, AChannelMayBeLateWhetherThatIsKnownOrNot) {
  const SmallCar car(3, 9);
  const Session late = log_of(car, 1.0, 0.15);
  for (const double known : {0.15, 0.05}) {
    const auto found = turning_of(late, known);
    ASSERT_TRUE(found) << known;
    EXPECT_NEAR(found->gradient, car.gradient, 0.2 * car.gradient) << known;
  }
}

TEST(SteadyTurning, ItsIntervalHoldsTheTruthAboutAsOftenAsItSays) {
  const SmallCar car(3, 9);
  // What the windows themselves get wrong shows without noise; intervals are of noise.
  const double without_noise = turning_of(log_of(car, 0.0))->gradient;
  int covered = 0;
  constexpr int logs = 40;
  for (int seed = 1; seed <= logs; ++seed) {
    const auto found = turning_of(log_of(car, 20.0, 0.0, static_cast<unsigned>(seed)));
    ASSERT_TRUE(found);
    covered += found->low <= without_noise && without_noise <= found->high;
  }
  EXPECT_GE(covered, 33);  // of 40 at 95 %, less than one time in a hundred thousand fewer
}

TEST(SteadyTurning, YawServesWhereNoYawRateIsRead) {
  const SmallCar car(3, 9);
  Session log = log_of(car);
  log.has[5] = false;
  for (std::size_t row = 0; row < log.rows(); ++row)
    log.reading[row * channels + 5] = std::numeric_limits<double>::quiet_NaN();
  const auto found = turning_of(log);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->gradient, car.gradient, 0.15 * car.gradient);
}

TEST(SteadyTurning, SaysNothingOfWhatIsNotThere) {
  const SmallCar car(3, 9);
  Session no_speed = log_of(car);
  no_speed.has[3] = false;
  EXPECT_FALSE(turning_of(no_speed));
  Session no_turning = log_of(car);
  no_turning.has[2] = no_turning.has[5] = false;
  EXPECT_FALSE(turning_of(no_turning));
  const Session* const one = &no_speed;
  EXPECT_FALSE(steady_turning({&one, 1}, wheelbase, 20.0, 0.0));  // nowhere so fast
  const Session brief = test::drive(car.vehicle.car(), {.seconds = 15, .command = gentle});
  EXPECT_FALSE(turning_of(brief));
  EXPECT_FALSE(steady_turning({}, wheelbase, v_ref, 0.0));
}

TEST(SteadyTurning, JumpsOfALogDoNotCount) {
  const SmallCar car(3, 9);
  Session log = log_of(car);
  for (std::size_t row = 500; row < 520; ++row) log.reading[row * channels + 5] += 3.0;
  const auto found = turning_of(log);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->gradient, car.gradient, 0.1 * car.gradient);
}

TEST(SteadyTurning, IsToldInTheFieldsUnit) {
  SteadyTurning one;
  one.gradient = 0.001, one.low = 0.0008, one.high = 0.0012;
  EXPECT_NEAR(degrees_per_g(0.001), 0.562, 1e-3);
  EXPECT_EQ(one.text(), "understeers by 0.56 deg/g (0.45 to 0.67)");
  one.gradient = -0.001, one.low = -0.0012, one.high = -0.0008;
  EXPECT_EQ(one.text(), "oversteers by 0.56 deg/g (0.45 to 0.67)");
  one.high = 0.0001;
  EXPECT_EQ(one.text(), "neither surely understeers nor oversteers (-0.67 to 0.056 deg/g)");
}

}  // namespace
}  // namespace gripline::measured
