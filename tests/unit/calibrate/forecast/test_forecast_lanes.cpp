// How the log's rows move the states of a car that stands, whose readings jump or are missing for long.
#include "calibrate/forecast/forecast_lanes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "support/calibrate_rig.hpp"
#include "support/forecast_checks.hpp"
#include "util/numbers.hpp"

namespace gripline::calibrate {
namespace test_forecast_lanes {

using test::CalibrateRig;
using test::drive;
using test::stop_and_go;
using test::worst;

/// Where the car has stood for a while: predictions 0.1 s ahead by an observer that follows no reading otherwise.
double worst_of_standing(const Session& s, const Session& truth, std::size_t channel) {
  const CalibrateRig rig(test::small_car_world(R"({"plant": {"params": {"Cm1": 10}}})"));
  std::vector<double> params = rig.forecaster.defaults();
  for (const ForecastParameter gain :
       {ForecastParameter::gain_position, ForecastParameter::gain_yaw, ForecastParameter::gain_speed,
        ForecastParameter::gain_lateral, ForecastParameter::gain_yaw_rate, ForecastParameter::gain_turn,
        ForecastParameter::gain_force, ForecastParameter::gain_steer})
    params[rig.forecaster.index(gain)] = 0.0;
  Starts starts{{}, {0.1}};
  for (std::size_t i = 200; i + 60 < s.rows(); ++i)
    if (std::fmod(s.t[i], 6.0) > 5.2 && std::fmod(s.t[i], 6.0) < 5.8) starts.time.push_back(s.t[i]);
  EXPECT_GT(starts.time.size(), 30u);
  return worst(truth, starts, rig.predict(s, params, starts), channel);
}

TEST(Forecaster, ACarThatStandsIsWhereTheLogShowsItHoweverOftenItsSpeedIsRead) {
  const CalibrateRig rig;
  const Session s = drive(rig.vehicle.car(), {.seconds = 26, .command = stop_and_go});
  EXPECT_LT(worst_of_standing(s, s, 1), 1e-3);
  const auto without = [&](std::size_t channel, auto unread) {
    Session less = s;
    for (std::size_t i = 0; i < s.rows(); ++i)
      if (unread(i)) less.reading[i * channels + channel] = NAN;
    return less;
  };
  EXPECT_LT(worst_of_standing(without(3, [](std::size_t i) { return i % 7 != 0; }), s, 1), 1e-3);
  EXPECT_LT(worst_of_standing(without(3, [&](std::size_t i) { return std::abs(s.at(i, 3)) < 0.2; }), s, 1), 1e-3);
  EXPECT_LT(worst_of_standing(without(0, [](std::size_t i) { return i % 7 != 0; }), s, 0), 2e-3);
}

TEST(Forecaster, APoseThatJumpsWhileTheCarStandsIsDoubtedToo) {
  const CalibrateRig rig;
  Session s = drive(rig.vehicle.car(), {.seconds = 26, .command = stop_and_go});
  const Session good = s;
  Starts starts{{}, {0.1}};
  for (std::size_t i = 250; i + 80 < s.rows(); ++i) {
    if (std::fmod(s.t[i], 6.0) < 5.2 || std::fmod(s.t[i], 6.0) > 5.3 || !(std::abs(s.at(i, 3)) < 0.05)) continue;
    for (std::size_t k = i; k < i + 5; ++k) s.reading[k * channels + 2] -= 0.5;  // another marker for 0.1 s
    starts.time.push_back(s.t[i + 4]);
    i += 100;
  }
  ASSERT_GT(starts.time.size(), 2u);
  EXPECT_LT(worst(good, starts, rig.predict(s, rig.forecaster.defaults(), starts), 2), 0.2);
}

TEST(Forecaster, APoseThatJumpsAsNoCarDoesIsHardlyFollowed) {
  const CalibrateRig rig;
  const Session good = drive(rig.vehicle.car(), {.seconds = 20});
  Session s = good;
  Starts starts{{}, {1.0}};
  for (std::size_t i = 250; i + 80 < s.rows(); i += 100) {  // another marker for 0.1 s, and what differences make of it
    for (std::size_t k = i; k < i + 5; ++k) {
      double* const r = s.reading.data() + k * channels;
      r[0] += 0.05, r[2] -= 0.5;
      if (k == i || k == i + 4) r[4] -= 2.0, r[5] += k == i ? -12.0 : 12.0;
    }
    starts.time.push_back(s.t[i + 7]);
  }
  const auto predicted = rig.predict(s, rig.forecaster.defaults(), starts);
  EXPECT_LT(worst(good, starts, predicted, 0), 0.1);
  EXPECT_LT(worst(good, starts, predicted, 2), 0.1);
}

/// Nothing begins at 0, where the car never was.
TEST(Forecaster, APoseThatIsReadLateBeginsWithItsFirstReading) {
  const CalibrateRig rig;
  Session s = drive(rig.vehicle.car(), {.seconds = 30});
  for (std::size_t i = 0; i < s.rows(); ++i) s.reading[i * channels] += 300.0;
  const Session whole = s;
  for (std::size_t i = 0; i < 100; ++i)
    for (const std::size_t c : {0u, 1u, 2u}) s.reading[i * channels + c] = not_a_number;
  Starts starts;
  starts.horizons = {0.5};
  starts.time = {s.t[103], s.t[200]};
  const auto predicted = rig.predict(s, rig.forecaster.defaults(), starts);
  EXPECT_LT(worst(whole, starts, predicted, 0), 0.05);
  EXPECT_LT(worst(whole, starts, predicted, 2), 0.05);
}

/// Whatever the model made of the way: what it is off by does not wear off reading by reading.
TEST(Forecaster, AfterALongTimeWithoutAPlaceTheNextReadingIsTaken) {
  const CalibrateRig rig;
  Session s = drive(rig.vehicle.car(), {.seconds = 40});
  std::size_t first = 0;
  for (std::size_t i = 0; i < s.rows(); ++i) {
    const bool hidden = s.t[i] - s.t[0] > 10.0 && s.t[i] - s.t[0] < 15.0;
    if (hidden) first = i + 1;
    if (s.t[i] - s.t[0] > 10.0) s.reading[i * channels] += 40.0;  // as if the model had lost its way
    if (hidden) s.reading[i * channels] = s.reading[i * channels + 1] = not_a_number;
  }
  Starts starts;
  starts.horizons = {0.5};
  starts.time = {s.t[first + 2]};
  const auto predicted = rig.predict(s, rig.forecaster.defaults(), starts);
  EXPECT_LT(worst(s, starts, predicted, 0), 0.1);
}

/// A receiver that writes rows of its own, beside those of the wheels: its first fix comes while the car stands.
TEST(Forecaster, AParkedCarIsWhereItsFirstFixShowsIt) {
  const CalibrateRig rig;
  Session s;
  s.has.fill(true);
  for (int i = 0; i < 400; ++i) {
    s.t.push_back(0.02 * i);
    const bool fix = i > 200 && i % 10 == 0;
    for (const double v : {30.0, 40.0, 0.5}) s.reading.push_back(fix ? v : not_a_number);
    for (int c = 0; c < 3; ++c) s.reading.push_back(fix ? not_a_number : 0.0);
    s.command.push_back({0.0, 0.0});
    s.written_yaw.push_back(fix ? 0.5 : not_a_number);
  }
  Starts starts;
  starts.horizons = {0.1};
  for (int i = 211; i < 219; ++i) starts.time.push_back(s.t[static_cast<std::size_t>(i)]);
  const auto predicted = rig.predict(s, rig.forecaster.defaults(), starts);
  ASSERT_EQ(predicted.size(), starts.time.size() * channels);
  for (std::size_t k = 0; k < predicted.size(); k += channels) {
    EXPECT_NEAR(predicted[k], 30.0, 1e-3);
    EXPECT_NEAR(predicted[k + 1], 40.0, 1e-3);
  }
}

TEST(Forecaster, ATurnOfMoreThanHalfARoundWithoutAHeadingIsNoInnovation) {
  const CalibrateRig rig;
  const Session good = drive(rig.vehicle.car(), {.seconds = 14, .command = [](double) {
                                                   return CommandSample<double>{0.35, 0.25};
                                                 }});
  constexpr std::size_t first = 300, last = 380;
  ASSERT_GT(std::abs(good.at(last, 2) - good.at(first, 2)), std::numbers::pi);
  Session s = good;
  for (std::size_t i = first; i < s.rows(); ++i) {
    double& yaw = s.reading[i * channels + 2];
    yaw = i < last ? NAN : yaw - 2.0 * std::numbers::pi;  // as headings are unwrapped
  }
  Starts starts{{}, {0.5, 1.0}};
  for (std::size_t i = last + 1; i < last + 50; i += 4) starts.time.push_back(s.t[i]);
  const auto predicted = rig.predict(s, rig.forecaster.defaults(), starts);
  EXPECT_LT(worst(good, starts, predicted, 0), 0.01);
  EXPECT_LT(worst(good, starts, predicted, 5), 0.02);
}

}  // namespace test_forecast_lanes
}  // namespace gripline::calibrate
