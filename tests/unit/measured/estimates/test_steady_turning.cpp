#include "measured/estimates/steady_turning.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <utility>

#include "support/calibrate_rig.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {
namespace test_steady_turning {

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

TurningByLogs answer_of(const Session& log, const TurningLateness& late = {}) {
  const Session* const one = &log;
  return steady_turning({&one, 1}, wheelbase, v_ref, late);
}
std::optional<SteadyTurning> turning_of(const Session& log, const TurningLateness& late = {}) {
  return answer_of(log, late).turning;
}
/// Why a log does not tell; empty where it does.
std::string why_not(const Session& log, const TurningLateness& late = {}) { return answer_of(log, late).why_not; }

/// The same log without its yaw rate.
Session by_yaw(Session log) {
  log.has[5] = false;
  for (std::size_t row = 0; row < log.rows(); ++row)
    log.reading[row * channels + 5] = std::numeric_limits<double>::quiet_NaN();
  return log;
}

/// Errors that are alike for seconds.
class SlowNoise {
 public:
  SlowNoise(double size, unsigned seed) : size_(size), random_(seed) {}
  double next() {
    constexpr double dt = 0.02, time = 3.0;
    return slow_ += -dt / time * slow_ + size_ * std::sqrt(2.0 * dt / time) * normal_(random_);
  }

 private:
  double size_, slow_ = 0.0;
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

/// Of the steering, as of wind or a road that leans.
void add_slow_noise(Session& log, double size, unsigned seed) {
  SlowNoise noise(size, seed);
  for (CommandSample<double>& c : log.command) c.delta += noise.next();
}

/// What becomes of logs of a car with steering errors of this size [rad].
struct Coverage {
  int held = 0, missed = 0;
  double widest = 0;
};
Coverage coverage_of(const Session& clean, double truth, double size, unsigned logs) {
  Coverage out;
  for (unsigned seed = 1; seed <= logs; ++seed) {
    Session log = clean;
    add_slow_noise(log, size, seed);
    const auto found = turning_of(log);
    if (!found) continue;
    ++(found->low <= truth && truth <= found->high ? out.held : out.missed);
    out.widest = std::max(out.widest, found->high - found->low);
  }
  return out;
}

TEST(SteadyTurning, IsThatOfTheCarThatDrove) {
  for (const auto& [front, rear] : {std::pair{3, 9}, {9, 4}}) {
    const SmallCar car(front, rear);
    const auto found = turning_of(log_of(car));
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->gradient, car.gradient, 0.1 * std::abs(car.gradient)) << front;
    EXPECT_GT(found->low * found->high, 0.0) << front;  // significantly one of both
    EXPECT_EQ(found->blocks, 9u);
  }
}

TEST(SteadyTurning, AWrongSteeringRatioAndOffsetAreNone) {
  const SmallCar car(3, 9);
  Session log = log_of(car);
  for (CommandSample<double>& c : log.command) c.delta = 1.25 * c.delta + 0.05;
  const auto found = turning_of(log), plain = turning_of(log_of(car));
  ASSERT_TRUE(found && plain);
  EXPECT_NEAR(found->gradient, plain->gradient, 1e-9);
}

/// Two logs with bends of their own whose steering is off to either side.
TEST(SteadyTurning, OffsetsOfLogsAreTheirOwn) {
  const SmallCar car(3, 9);
  const auto turning = [&](double side) {
    Session log = test::drive(car.vehicle.car(), {.seconds = 90, .noise = 1, .command = [=](double t) {
                                                    CommandSample<double> c = gentle(t);
                                                    c.delta = 0.7 * c.delta + 0.03 * side;
                                                    return c;
                                                  }});
    for (CommandSample<double>& c : log.command) c.delta += 0.05 * side;
    return log;
  };
  const Session left = turning(1.0), right = turning(-1.0);
  const Session* const both[] = {&left, &right};
  const auto found = steady_turning(both, wheelbase, v_ref).turning;
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->gradient, car.gradient, 0.1 * car.gradient);
  EXPECT_EQ(found->blocks, 18u);
}

/// A yaw rate that is late by more than a window: the gradient is off where nobody knows of it, and the interval holds
/// what is not known.
TEST(SteadyTurning, TheLatenessOfTheYawRateCounts) {
  const SmallCar car(3, 9);
  const Session late =
      test::drive(car.vehicle.car(), {.seconds = 90, .noise = 1, .delay = {0, 0, 0, 0.5}, .command = [](double t) {
                                        return CommandSample<double>{gentle(t).d, 0.06 * std::sin(1.3 * t)};
                                      }});
  const auto known = turning_of(late, {.yaw_rate = {0.5, 0.5, 0.5}, .yaw = {}}), wrong = turning_of(late),
             unsure = turning_of(late, {.yaw_rate = {0.5, 0.0, 0.5}, .yaw = {}});
  ASSERT_TRUE(known && wrong && unsure);
  EXPECT_NEAR(known->gradient, car.gradient, 0.1 * car.gradient);
  EXPECT_GT(std::abs(wrong->gradient - car.gradient), 0.15 * car.gradient);
  EXPECT_EQ(unsure->gradient, known->gradient);
  EXPECT_TRUE(unsure->low < wrong->gradient && wrong->gradient < unsure->high);
}

/// It may be so late that the weaves are lost: then nothing is told.
TEST(SteadyTurning, ALatenessWithWhichNothingCanBeToldIsNotLeftOut) {
  const SmallCar car(3, 9);
  const Session log = log_of(car);
  EXPECT_EQ(why_not(log), "");
  const TurningLateness any = {.yaw_rate = {0.0, 0.0, 60.0}, .yaw = {}};
  EXPECT_FALSE(turning_of(log, any));
  EXPECT_EQ(why_not(log, any), "the delay of yaw rate or yaw is not known well enough");
}

/// Of a car that is nearly neutral, with errors that are alike for seconds: the noise makes the interval.
TEST(SteadyTurning, ItsIntervalHoldsTheTruthAboutAsOftenAsItSays) {
  const SmallCar car(5, 6);
  const Session clean = log_of(car, 0.0);
  const double truth = turning_of(clean)->gradient;
  const Coverage found = coverage_of(clean, truth, 0.006, 100);
  EXPECT_EQ(found.held + found.missed, 100);
  EXPECT_GE(found.held, 88);
  EXPECT_LE(found.held, 99);
  const double floor = 2.0 * 1.96 * std::hypot(0.05 * truth, 0.025 * wheelbase / (v_ref * v_ref));
  EXPECT_GT(found.widest, 2.0 * floor);
}

/// With large errors the steering ratio is hardly known: logs in which it came out too large must not be the ones
/// chosen.
TEST(SteadyTurning, AnIntervalHoldsWhereTheRatioIsHardlyKnown) {
  const SmallCar car(3, 9);
  const Session clean =
      test::drive(car.vehicle.car(), {.seconds = 90, .command = [](double t) {
                                        return CommandSample<double>{0.32 + 0.2 * std::sin(0.31 * t), gentle(t).delta};
                                      }});
  const double truth = turning_of(clean)->gradient;
  for (const double size : {0.01, 0.02, 0.03}) {
    const Coverage found = coverage_of(clean, truth, size, 100);
    EXPECT_GE(found.held, 10) << size;
    EXPECT_GE(found.held, 7 * found.missed) << size;
  }
}

/// Straights are no evidence: an interval of two corners is wide.
TEST(SteadyTurning, BlocksCountByWhatTheyTell) {
  const SmallCar car(3, 9);
  const auto corners = [&](double every) {
    return test::drive(car.vehicle.car(),
                       {.seconds = 120, .noise = 1, .command = [=](double t) {
                          const bool turns = std::fmod(t, every) < 5.0;
                          return CommandSample<double>{0.30 + 0.12 * std::sin(0.31 * t), turns ? gentle(t).delta : 0.0};
                        }});
  };
  EXPECT_TRUE(turning_of(corners(12.0)));
  EXPECT_FALSE(turning_of(corners(100.0)));  // two
}

TEST(SteadyTurning, ItIsNeverSurerThanCornersAreSteady) {
  const SmallCar car(3, 9);
  const auto found = turning_of(log_of(car, 0.0));
  ASSERT_TRUE(found);
  EXPECT_GE(found->high - found->gradient, 1.96 * 0.05 * found->gradient);
  const auto neutral = turning_of(log_of(SmallCar(5, 5.6), 0.0));
  ASSERT_TRUE(neutral);
  EXPECT_GE(neutral->high - neutral->gradient, 1.95 * 0.025 * wheelbase / (v_ref * v_ref));
}

TEST(SteadyTurning, YawServesWhereNoYawRateIsRead) {
  const SmallCar car(3, 9);
  const auto found = turning_of(by_yaw(log_of(car)));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->gradient, car.gradient, 0.15 * car.gradient);
}

TEST(SteadyTurning, TheLatenessOfYawCountsWhereYawServes) {
  const SmallCar car(3, 9);
  const Session late = by_yaw(
      test::drive(car.vehicle.car(), {.seconds = 90, .noise = 1, .delay = {0, 0.5, 0, 0}, .command = [](double t) {
                                        return CommandSample<double>{gentle(t).d, 0.06 * std::sin(1.3 * t)};
                                      }}));
  const auto known = turning_of(late, {.yaw_rate = {}, .yaw = {0.5, 0.5, 0.5}}), wrong = turning_of(late);
  ASSERT_TRUE(known && wrong);
  EXPECT_NEAR(known->gradient, car.gradient, 0.15 * car.gradient);
  EXPECT_GT(std::abs(wrong->gradient - car.gradient), 0.15 * car.gradient);
}

TEST(SteadyTurning, ChannelsNeedNotBeReadInEveryRow) {
  const SmallCar car(3, 9);
  Session log = log_of(car);
  for (std::size_t row = 0; row < log.rows(); ++row)
    log.reading[row * channels + (row % 2 == 0 ? 3 : 5)] = std::numeric_limits<double>::quiet_NaN();
  const auto found = turning_of(log);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->gradient, car.gradient, 0.1 * car.gradient);
}

TEST(SteadyTurning, GapsAreNotBridged) {
  const SmallCar car(3, 9);
  Session log = log_of(car);
  const std::size_t corners = turning_of(log)->corners.size();
  for (std::size_t row = 1000; row < log.rows(); ++row) log.t[row] += 5.0;
  const auto found = turning_of(log);
  ASSERT_TRUE(found);
  EXPECT_LT(found->corners.size(), corners);
  EXPECT_NEAR(found->gradient, car.gradient, 0.1 * car.gradient);
}

TEST(SteadyTurning, SaysNothingOfWhatIsNotThere) {
  const SmallCar car(3, 9);
  Session no_speed = log_of(car);
  no_speed.has[3] = false;
  EXPECT_FALSE(turning_of(no_speed));
  Session no_turning = log_of(car);
  no_turning.has[2] = no_turning.has[5] = false;
  EXPECT_FALSE(turning_of(no_turning));
  const Session whole = log_of(car), *one = &whole;
  EXPECT_FALSE(steady_turning({&one, 1}, wheelbase, 20.0).turning);  // nowhere so fast
  EXPECT_FALSE(turning_of(test::drive(car.vehicle.car(), {.seconds = 15, .command = gentle})));
  EXPECT_FALSE(steady_turning({}, wheelbase, v_ref).turning);
}

using OverTime = std::function<double(double)>;

/// A log made up of a speed [m/s], a yaw rate [rad/s] and a steering [rad] over time.
Session made_up(double seconds, const OverTime& vx, const OverTime& rate, const OverTime& delta) {
  constexpr double dt = 0.02;
  Session log;
  log.has[Channel::vx] = log.has[Channel::yaw_rate] = true;
  for (std::size_t row = 0; row < static_cast<std::size_t>(seconds / dt); ++row) {
    const double t = static_cast<double>(row) * dt;
    log.t.push_back(t);
    log.command.push_back({0.0, delta(t)});
    log.reading.insert(log.reading.end(), {not_a_number, not_a_number, not_a_number, vx(t), not_a_number, rate(t)});
  }
  return log;
}
/// With the steering of a car that understeers.
Session made_up(double seconds, const OverTime& vx, const OverTime& rate) {
  return made_up(seconds, vx, rate, [&](double t) { return wheelbase * rate(t) / vx(t) + 0.002 * vx(t) * rate(t); });
}

TEST(SteadyTurning, SaysWhyItSaysNothing) {
  const auto weave = [](double t) { return 0.4 * std::sin(0.9 * t); };
  const auto speed = [](double t) { return 1.6 + 0.3 * std::sin(0.31 * t); };
  EXPECT_EQ(why_not(made_up(90, speed, weave)), "");
  Session no_speed = made_up(90, speed, weave), no_turning = no_speed;
  no_speed.has[Channel::vx] = no_turning.has[Channel::yaw_rate] = false;
  for (const Session& log : {no_speed, no_turning})
    EXPECT_EQ(why_not(log), "none of them has a speed and a yaw rate or yaw");
  EXPECT_EQ(why_not(made_up(
                90, [&](double t) { return speed(t) - 1.0; }, weave)),
            "too little of them is gentle driving at 1 m/s or faster");
  EXPECT_EQ(why_not(made_up(
                90, [](double) { return 1.6; }, weave)),
            "speeds in their corners vary too little to separate it from the steering ratio");
  const auto two_corners = [](double t) {
    const double since = std::fmod(t, 100.0) - 2.0;
    return since > 0.0 && since < 6.0 ? 0.5 * std::sin(std::numbers::pi / 3.0 * since) : 0.0;
  };
  EXPECT_EQ(why_not(made_up(
                120, [](double t) { return t < 50.0 ? 1.2 : 1.9; }, two_corners)),
            "fewer than three stretches of 10 s with corners determine it");
  for (const double size : {0.0, 0.05})
    EXPECT_EQ(why_not(made_up(90, speed, weave, [=](double t) { return size * std::sin(2.3 * t); })),
              "the steering in them hardly explains how the car turns, so that its ratio is not known")
        << size;
}

TEST(SteadyTurning, SaysNothingWhereTheGradientCannotBeTold) {
  const SmallCar car(3, 9);
  Session steady = log_of(car);  // of a steering that stays, and of one that is only noise
  for (CommandSample<double>& c : steady.command) c.delta = 0.05;
  EXPECT_FALSE(turning_of(steady));
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal(0.05, 1e-5);
  for (CommandSample<double>& c : steady.command) c.delta = normal(random);
  EXPECT_FALSE(turning_of(steady));
}

/// At one speed ratio and gradient are one, and an error of what is read of it would pass for a gradient of L / vx^2.
TEST(SteadyTurning, SaysNothingAtOneSpeed) {
  for (const auto& [front, rear] : {std::pair{3, 9}, {9, 4}}) {
    const SmallCar car(front, rear);
    Session log = log_of(car);
    for (const double error : {0.0, 0.01}) {
      SlowNoise noise(error, 1);
      for (std::size_t row = 0; row < log.rows(); ++row) log.reading[row * channels + 3] = 1.7 * (1.0 + noise.next());
      EXPECT_FALSE(turning_of(log)) << front << ' ' << error;
    }
  }
}

/// Half of the log is straight, and nothing is noise: corners are not far off for that.
TEST(SteadyTurning, LogsWithoutNoiseAreReadToo) {
  const SmallCar car(3, 9);
  const auto found = turning_of(test::drive(
      car.vehicle.car(), {.seconds = 120, .command = [](double t) {
                            const bool turns = std::fmod(t, 15.0) < 5.0;
                            return CommandSample<double>{0.30 + 0.12 * std::sin(0.31 * t), turns ? 0.06 : 0.0};
                          }}));
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->gradient, car.gradient, 0.15 * car.gradient);
}

/// A clock that begins below 0, and a gap at once.
TEST(SteadyTurning, TheClockMayBeginAnywhere) {
  const SmallCar car(3, 9);
  Session log = log_of(car);
  for (std::size_t row = 0; row < log.rows(); ++row) log.t[row] -= row < 5 ? 1000.0 : 300.0;
  const auto found = turning_of(log);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->blocks, 9u);
  EXPECT_NEAR(found->gradient, car.gradient, 0.1 * car.gradient);
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
  EXPECT_EQ(cornering_text(one.gradient), "oversteers by 0.56 deg/g");
  one.high = 0.0001;
  EXPECT_EQ(one.text(), "neither understeers nor oversteers significantly (-0.67 to 0.056 deg/g)");
}

}  // namespace test_steady_turning
}  // namespace gripline::measured
