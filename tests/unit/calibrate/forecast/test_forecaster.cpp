#include "calibrate/forecast/forecaster.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <vector>

#include <gripline/plugin.hpp>

#include "support/calibrate_rig.hpp"
#include "support/forecast_checks.hpp"

namespace gripline::calibrate {
namespace test_forecaster {

using test::CalibrateRig;
using test::drive;
using test::some_starts;
using test::worst;

TEST(Forecaster, TheTrueModelPredictsItsOwnLog) {
  const CalibrateRig rig;
  const Session s = drive(rig.vehicle.car(), {.seconds = 30});
  const Starts starts = some_starts(s);
  const auto predicted = rig.predict(s, rig.forecaster.defaults(), starts);
  EXPECT_LT(worst(s, starts, predicted, 0), 2e-3);
  EXPECT_LT(worst(s, starts, predicted, 2), 2e-3);
  EXPECT_LT(worst(s, starts, predicted, 3), 2e-3);
  EXPECT_LT(worst(s, starts, predicted, 5), 2e-2);
}

TEST(Forecaster, PredictsWhatLateChannelsWillShow) {
  const CalibrateRig rig;
  const std::array<double, 4> delay{-0.06, 0.05, 0.1, 0.31};
  const Session s = drive(rig.vehicle.car(), {.seconds = 30, .delay = delay});
  const Starts starts = some_starts(s);
  auto params = rig.forecaster.defaults();
  const auto blind = rig.predict(s, params, starts);
  for (std::size_t g = 0; g < 4; ++g) params[rig.forecaster.index(ForecastParameter::delay_position) + g] = delay[g];
  const auto predicted = rig.predict(s, params, starts);
  for (const std::size_t c : {0u, 2u, 3u, 5u})
    EXPECT_LT(worst(s, starts, predicted, c), 0.25 * worst(s, starts, blind, c)) << c;
  // A position that leads shows what commands after the last one known will do: they are taken as held.
  EXPECT_LT(worst(s, starts, predicted, 5), 0.03);
}

TEST(Forecaster, StepsThatAreToldLeaveThePredictionsAsTheyAre) {
  const CalibrateRig rig;
  const Session s = drive(rig.vehicle.car(), {.seconds = 30});
  Starts starts = some_starts(s);
  starts.time.erase(starts.time.begin() + 8, starts.time.begin() + 12);  // observers end at different steps
  const auto params = rig.forecaster.defaults();
  const measured::CommandGrid commands(s, 0.02);
  ObserverSteps steps;
  std::vector<double> first, told;
  rig.forecaster.run<double>(s, commands, nullptr, params, starts, first, &steps);
  ASSERT_FALSE(steps.empty());
  ASSERT_FALSE(steps[0].empty());
  const ObserverSteps taken = steps;
  rig.forecaster.run<double>(s, commands, nullptr, params, starts, told, &steps);
  EXPECT_EQ(steps, taken);
  ASSERT_EQ(told.size(), first.size());
  const auto told_of = [](std::vector<double> all) {  // what is not predicted is not a number
    std::erase_if(all, [](double x) { return std::isnan(x); });
    return all;
  };
  ASSERT_GT(told_of(first).size(), first.size() / 2);
  EXPECT_EQ(told_of(told), told_of(first));
  // They are followed, not found again.
  for (std::vector<int>& group : steps)
    for (int& substeps : group) ++substeps;
  rig.forecaster.run<double>(s, commands, nullptr, params, starts, told, &steps);
  EXPECT_NE(told_of(told), told_of(first));
}

TEST(Forecaster, ALagShorterThanAStepIsNearlyNone) {
  // Steps of 20 ms: integrated by steps longer than itself, a lag of 7 ms would swing on.
  const char* const lag = R"({"plant": {"effects": [{"plugin": "steer_lag", "params": {"tau": 0.0071}}]}})";
  const CalibrateRig without, with(test::small_car_world(lag));
  const Session s =
      drive(without.vehicle.car(), {.seconds = 14, .command = [](double t) {
                                      return CommandSample<double>{0.35, std::fmod(t, 1.0) < 0.5 ? 0.2 : -0.2};
                                    }});
  const Starts starts = some_starts(s);
  const auto plain = without.predict(s, without.forecaster.defaults(), starts),
             lagging = with.predict(s, with.forecaster.defaults(), starts);
  double most = 0.0;
  for (std::size_t k = 2; k < plain.size(); k += channels) most = std::max(most, std::abs(lagging[k] - plain[k]));
  EXPECT_GT(most, 0.001);
  EXPECT_LT(most, 0.05);  // [rad] 7 ms of the yaw rate make 0.03
}

TEST(Forecaster, ALagThatGoesWithTheSpeedIsFollowedAtFiveTimesTheUsualOne) {
  const CalibrateRig rig(test::small_car_world(R"({"car": {"v_ref": 1},
    "plant": {"effects": [{"plugin": "relaxation", "params": {"sigma": 0.02}}]}})"));
  const Session s = drive(rig.vehicle.car(), {.seconds = 14,
                                              .command =
                                                  [](double t) {
                                                    return CommandSample<double>{0.9, 0.05 * std::sin(2 * t)};
                                                  },
                                              .speed = 5});
  ASSERT_GT(s.at(s.rows() / 2, 3), 4.5);
  const Starts starts = some_starts(s);
  const auto predicted = rig.predict(s, rig.forecaster.defaults(), starts);
  EXPECT_LT(worst(s, starts, predicted, 2), 5e-3);
  EXPECT_LT(worst(s, starts, predicted, 5), 5e-2);
}

TEST(Forecaster, ASpeedThatIsPrescribedIsFollowed) {
  const CalibrateRig rig;
  Session s = drive(rig.vehicle.car(), {.seconds = 20});
  s.prescribed_speed = true;
  for (auto& command : s.command) command.d = 0.0;  // nobody recorded it
  const Starts starts = some_starts(s);
  const auto predicted = rig.predict(s, rig.forecaster.defaults(), starts);
  EXPECT_LT(worst(s, starts, predicted, 3), 5e-3);
  EXPECT_LT(worst(s, starts, predicted, 2), 5e-3);
}

TEST(Forecaster, ASpeedThatIsPrescribedIsBridgedWhereItIsReadNowAndThen) {
  const CalibrateRig rig;
  const Session good = drive(rig.vehicle.car(), {.seconds = 20});
  Session s = good;
  s.prescribed_speed = true;
  for (auto& command : s.command) command.d = 0.0;
  for (std::size_t i = 0; i < s.rows(); ++i)
    if (i % 5 != 0) s.reading[i * channels + 3] = NAN;
  Starts starts;
  starts.horizons = {1.0};  // starts and ends on readings
  for (std::size_t i = 200; i + 60 < s.rows(); i += 65) starts.time.push_back(s.t[i]);
  const auto predicted = rig.predict(s, rig.forecaster.defaults(), starts);
  EXPECT_LT(worst(good, starts, predicted, 3), 5e-3);
  EXPECT_LT(worst(good, starts, predicted, 2), 2e-2);
}

TEST(Forecaster, AChannelThatIsMissingIsDoneWithout) {
  const CalibrateRig rig;
  Session s = drive(rig.vehicle.car(), {.seconds = 20});
  for (std::size_t i = 0; i < s.rows(); ++i) s.reading[i * channels + 4] = s.reading[i * channels + 5] = NAN;
  s.has[4] = s.has[5] = false;
  Starts starts = some_starts(s);
  auto params = rig.forecaster.defaults();
  params[rig.forecaster.index(ForecastParameter::gain_turn)] = 5.0;
  const auto predicted = rig.predict(s, params, starts);
  EXPECT_LT(worst(s, starts, predicted, 0), 0.02);
  EXPECT_TRUE(std::isfinite(predicted[4]));
}

TEST(Forecaster, StepsNeedNotBeEqual) {
  const CalibrateRig rig;
  const Session even = drive(rig.vehicle.car(), {.seconds = 20, .dt = 0.01});
  Session s = even;
  s.t.clear(), s.reading.clear(), s.command.clear(), s.written_yaw.clear();
  for (std::size_t i = 0; i < even.rows(); i += 1 + i * 7919 % 4) {  // 10 to 40 ms
    s.t.push_back(even.t[i]);
    for (std::size_t c = 0; c < channels; ++c) s.reading.push_back(even.at(i, c));
    s.command.push_back(even.command[i]);
    s.written_yaw.push_back(even.written_yaw[i]);
  }
  ASSERT_LT(s.rows(), even.rows() / 2);
  const Starts starts = some_starts(s);
  const auto predicted = rig.predict(s, rig.forecaster.defaults(), starts);
  EXPECT_LT(worst(even, starts, predicted, 0), 5e-3);
  EXPECT_LT(worst(even, starts, predicted, 2), 5e-3);
  EXPECT_LT(worst(even, starts, predicted, 3), 5e-3);
}

TEST(Forecaster, SpeedsAndYawRateAreEnough) {
  const CalibrateRig rig;
  Session s = drive(rig.vehicle.car(), {.seconds = 20});
  for (std::size_t i = 0; i < s.rows(); ++i)
    for (const std::size_t c : {0u, 1u, 2u}) s.reading[i * channels + c] = NAN;
  s.has[0] = s.has[1] = s.has[2] = false;
  const Starts starts = some_starts(s);
  const auto predicted = rig.predict(s, rig.forecaster.defaults(), starts);
  EXPECT_LT(worst(s, starts, predicted, 3), 5e-3);
  EXPECT_LT(worst(s, starts, predicted, 5), 2e-2);
}

TEST(Forecaster, GapsBeginAnewAndNoStartInAHoleIsPredicted) {
  const CalibrateRig rig;
  Session s = drive(rig.vehicle.car(), {.seconds = 20});
  const double hole = s.t[500];
  for (std::size_t i = 500; i < s.rows(); ++i) s.t[i] += 3.0;
  Starts starts;
  starts.horizons = {0.5};
  starts.time = {hole - 1.0, hole + 1.5, hole + 3.0 + 2.0};
  const auto predicted = rig.predict(s, rig.forecaster.defaults(), starts);
  EXPECT_TRUE(std::isfinite(predicted[0]));
  EXPECT_TRUE(std::isnan(predicted[channels]));
  EXPECT_NEAR(predicted[2 * channels + 3], s.interpolate(3, starts.time[2] + 0.5), 0.02);
}

TEST(Forecaster, ACarThatStopsStaysFinite) {
  const CalibrateRig rig;
  const Session s = drive(rig.vehicle.car(), {.seconds = 20, .command = [](double t) {
                                                return CommandSample<double>{t < 5 ? 0.4 : 0.0, 0.2 * std::sin(2 * t)};
                                              }});
  Starts starts;
  starts.horizons = {1.0};
  for (std::size_t i = 50; i + 60 < s.rows(); i += 10) starts.time.push_back(s.t[i]);
  const auto predicted = rig.predict(s, rig.forecaster.defaults(), starts);
  ASSERT_FALSE(predicted.empty());
  for (const double v : predicted) EXPECT_TRUE(std::isfinite(v));
}

/// Counts how often what the car shows is asked for. Units of a real log take as much time as the car itself.
class Counted final : public AutoDiffReading<Counted> {
 public:
  template <class T>
  struct Params {
    T nothing = T(0);
  };
  static constexpr auto parameters() {
    return std::tuple{param("nothing", &Params<double>::nothing, "1", {0, 1}, "changes nothing")};
  }
  template <class T>
  void sense(Reading<T>&, const Place&, const Params<T>&) const {
    ++asked;
  }
  mutable std::size_t asked = 0;
};

TEST(Forecaster, ReadingsAreAskedForWhereRowsAreSeenAndPredictionsShown) {
  const CalibrateRig rig;
  const Session s = drive(rig.vehicle.car(), {.seconds = 30});
  const Counted counted;
  StagedCar car = rig.vehicle.car();
  car.add(counted, {0.0}, "counted");
  const Forecaster forecaster(car, rig.forecaster.options());
  const auto asked = [&](std::size_t row, double horizon) {
    const Starts starts{{s.t[row]}, {horizon}};
    std::vector<double> predicted;
    counted.asked = 0;
    forecaster.run<double>(s, measured::CommandGrid(s, 0.02), nullptr, forecaster.defaults(), starts, predicted);
    EXPECT_TRUE(std::isfinite(predicted[3]));
    return counted.asked;
  };
  // Predictions see no rows: how far they go does not matter.
  EXPECT_EQ(asked(500, 2.0), asked(500, 0.5));
  // A row, one in each step: where it was seen, before and after the states are moved, and twice to find where to.
  const auto per_row = static_cast<double>(asked(1000, 0.5)) / (forecaster.options().pre_roll / 0.02);
  EXPECT_GT(per_row, 3.0);
  EXPECT_LT(per_row, 6.0);
}

}  // namespace test_forecaster
}  // namespace gripline::calibrate
