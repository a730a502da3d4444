#include "calibrate/forecast/forecaster.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <span>
#include <stdexcept>
#include <string>

#include <gripline/plugin.hpp>

#include "calibrate/fit/unknowns.hpp"
#include "support/calibrate_rig.hpp"
#include "util/numbers.hpp"

namespace gripline::calibrate {
namespace test_forecaster {

using test::CalibrateRig;
using test::drive;

Starts some_starts(const Session& s, std::vector<double> horizons = {0.5, 1.0}) {
  Starts starts;
  starts.horizons = std::move(horizons);
  for (double t = s.t.front() + 4.0; t + 1.0 < s.t.back(); t += 1.3) starts.time.push_back(s.t[s.row_before(t)]);
  return starts;
}

double worst(const Session& s, const Starts& starts, const std::vector<double>& predicted, std::size_t channel) {
  double most = 0.0;
  const std::size_t h = starts.horizons.size();
  for (std::size_t i = 0; i < starts.time.size(); ++i)
    for (std::size_t j = 0; j < h; ++j)
      most = std::max(most, std::abs(predicted[(i * h + j) * channels + channel] -
                                     s.interpolate(channel, starts.time[i] + starts.horizons[j])));
  return most;
}

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
  for (std::size_t g = 0; g < 4; ++g) params[rig.forecaster.index(Extra::delay_position) + g] = delay[g];
  const auto predicted = rig.predict(s, params, starts);
  for (const std::size_t c : {0u, 2u, 3u, 5u})
    EXPECT_LT(worst(s, starts, predicted, c), 0.25 * worst(s, starts, blind, c)) << c;
  // A position that leads shows what commands after the last one known will do: they are taken as held.
  EXPECT_LT(worst(s, starts, predicted, 5), 0.03);
}

/// Changes what a prediction must not read, for several ends of what is known, and compares: rows after a start, and
/// commands (and a prescribed speed) after the time of each horizon.
void expect_nothing_later_read(const CalibrateRig& rig, const Session& s, const std::vector<double>& horizons) {
  auto params = rig.forecaster.defaults();
  params[rig.forecaster.index(Extra::delay_position)] = 0.03;
  params[rig.forecaster.index(Extra::delay_velocity)] = -0.02;
  params[rig.forecaster.index(Extra::delay_yaw_rate)] = 0.2;
  Starts starts;
  starts.horizons = horizons;
  for (std::size_t i = 10; i < 600; i += 17) starts.time.push_back(s.t[i]);
  const auto before = rig.predict(s, params, starts);
  std::size_t compared = 0;
  for (const std::size_t last : {20ul, 203ul, 557ul})
    for (std::size_t j = 0; j < horizons.size(); ++j) {
      const double end = s.t[last] + horizons[j] + 1e-9;
      Session changed = s;
      for (std::size_t i = last + 1; i < s.rows(); ++i)
        for (std::size_t c = 0; c < channels; ++c)
          if (c != 3 || !s.prescribed_speed || s.t[i] > end) changed.reading[i * channels + c] = c % 2 == 0 ? NAN : 1e3;
      for (std::size_t i = 0; i < s.rows(); ++i)
        if (s.t[i] > end) changed.command[i] = {-1.0, 0.4};
      const auto after = rig.predict(changed, params, starts);
      for (std::size_t i = 0; i < starts.time.size(); ++i) {
        if (starts.time[i] > s.t[last]) continue;
        for (std::size_t c = 0; c < channels; ++c, ++compared) {
          const std::size_t k = (i * horizons.size() + j) * channels + c;
          ASSERT_EQ(after[k], before[k]) << "start " << starts.time[i] << " + " << horizons[j] << ", channel " << c;
        }
      }
    }
  EXPECT_GT(compared, 100u * horizons.size());
}

/// Commands of loggers that read throttle and steering at paces of their own.
CommandSample<double> commands_in_steps(double t) {
  return {test::weave(0.1 * std::floor(t / 0.1 + 1e-6)).d, test::weave(0.14 * std::floor(t / 0.14 + 1e-6)).delta};
}

TEST(Forecaster, ReadsTheLogBeforeTheStartAndCommandsUpToItsTimeAndNothingElse) {
  const CalibrateRig rig;
  const Session s = drive(rig.vehicle.car(), {.seconds = 20, .noise = 1, .delay = {0.03, 0.0, 0.02, 0.2}});
  expect_nothing_later_read(rig, s, {1.0});
  expect_nothing_later_read(rig, s, {0.02, 0.5, 1.0});
}

measured::BetweenRows read_every(double seconds) {
  return {.used = measured::BetweenRows::Kind::paced, .every = seconds};
}

TEST(Forecaster, ReadsNothingLaterOfCommandsThatAreReadEverySoOften) {
  const CalibrateRig rig;
  Session s = drive(rig.vehicle.car(), {.seconds = 20, .noise = 1, .command = commands_in_steps});
  s.throttle_between = read_every(0.1);
  s.steering_between = read_every(0.14);
  expect_nothing_later_read(rig, s, {0.06, 0.5, 1.0});
}

TEST(Forecaster, ReadsNothingLaterOfASpeedThatIsPrescribed) {
  const CalibrateRig rig;
  Session s = drive(rig.vehicle.car(), {.seconds = 20, .noise = 1, .command = commands_in_steps});
  s.prescribed_speed = true;
  s.steering_between = read_every(0.14);
  for (auto& command : s.command) command.d = 0.0;
  expect_nothing_later_read(rig, s, {0.06, 0.5, 1.0});
  for (std::size_t i = 0; i < s.rows(); ++i)
    if (i % 5 != 0) s.reading[i * channels + 3] = NAN;
  expect_nothing_later_read(rig, s, {0.06, 0.5, 1.0});
}

CommandSample<double> stop_and_go(double t) { return {std::fmod(t, 6.0) < 1.0 ? 0.3 : 0.0, 0.2 * std::sin(2 * t)}; }

TEST(Forecaster, ReadsNothingLaterWhereTheCarStands) {
  const CalibrateRig rig;
  Session s = drive(rig.vehicle.car(), {.seconds = 20, .noise = 1, .command = stop_and_go});
  ASSERT_LT(std::abs(s.at(250, 3)), 0.1);
  expect_nothing_later_read(rig, s, {0.06, 0.5, 1.0});
  for (std::size_t i = 0; i < s.rows(); ++i)
    if (i % 5 != 0) s.reading[i * channels] = s.reading[i * channels + 3] = NAN;
  expect_nothing_later_read(rig, s, {0.06, 0.5, 1.0});
}

/// Where the car has stood for a while: predictions 0.1 s ahead by an observer that follows no reading otherwise.
double worst_of_standing(const Session& s, const Session& truth, std::size_t channel) {
  const CalibrateRig rig(test::small_car_world(R"({"plant": {"params": {"Cm1": 10}}})"));
  std::vector<double> params = rig.forecaster.defaults();
  for (const Extra gain : {Extra::gain_position, Extra::gain_yaw, Extra::gain_speed, Extra::gain_lateral,
                           Extra::gain_yaw_rate, Extra::gain_turn, Extra::gain_force, Extra::gain_steer})
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

TEST(Forecaster, DerivativesAreThoseOfThePredictions) {
  const CalibrateRig rig;
  const Session s = drive(rig.vehicle.car(), {.seconds = 12, .noise = 1, .delay = {0.0, 0.0, 0.0, 0.1}});
  const Starts starts = some_starts(s);
  std::vector<double> params = rig.forecaster.defaults();
  for (std::size_t g = 0; g < 4; ++g) params[rig.forecaster.index(Extra::delay_position) + g] = 0.007;
  params[rig.forecaster.index(Extra::delay_yaw_rate)] = 0.093;
  params[4] *= 1.1;
  const measured::CommandGrid commands(s, 0.02);
  for (std::size_t first = 0; first < params.size(); first += 8) {
    std::vector<Dual8> seeded(params.begin(), params.end()), predicted;
    const std::size_t last = std::min(first + 8, params.size());
    for (std::size_t p = first; p < last; ++p) seeded[p].d[p - first] = 1.0;
    rig.forecaster.run<Dual8>(s, commands, nullptr, seeded, starts, predicted);
    for (std::size_t p = first; p < last; ++p) {
      const double step = 1e-5 * std::max(0.1, std::abs(params[p]));
      std::vector<double> up = params, down = params;
      up[p] += step;
      down[p] -= step;
      const auto high = rig.predict(s, up, starts), low = rig.predict(s, down, starts);
      for (std::size_t k = 0; k < predicted.size(); ++k) {
        const double slope = (high[k] - low[k]) / (2 * step);
        EXPECT_NEAR(predicted[k].d[p - first], slope, 1e-4 * (1.0 + std::abs(slope))) << "parameter " << p << ", " << k;
      }
    }
  }
}

constexpr const char* frames_and_delay = R"({"plant": {"effects": [{"plugin": "input_delay", "params": {"T": 0.03}},
  {"plugin": "pose_lever", "params": {"px": 0.05, "py": 0.01}}, {"plugin": "pose_yaw", "params": {"a": 0.04}},
  {"plugin": "velocity_lever", "params": {"px": 0.03, "py": -0.02}},
  {"plugin": "velocity_yaw", "params": {"a": -0.03}}]}})";

std::size_t index_of(const CalibrateRig& rig, const std::string& pointer) {
  for (const ParameterPlace& place : parameter_places(rig.spec, rig.forecaster))
    if (place.pointer == pointer) return place.index;
  throw std::invalid_argument(pointer);
}

/// Predictions with their derivatives by one parameter.
std::vector<Dual8> differentiate(const CalibrateRig& rig, const Session& s, const std::vector<double>& params,
                                 std::span<const std::size_t> by, const Starts& starts) {
  std::vector<Dual8> seeded(params.begin(), params.end()), predicted;
  for (const std::size_t index : by) seeded[index].d[0] = 1.0;
  rig.forecaster.run<Dual8>(s, measured::CommandGrid(s, 0.02), nullptr, seeded, starts, predicted);
  return predicted;
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

TEST(Forecaster, DerivativesByFramesHoldWhereTheCarHardlyMoves) {
  const CalibrateRig rig(test::small_car_world(frames_and_delay));
  const Session s = drive(rig.vehicle.car(),
                          {.seconds = 14, .noise = 1, .command = [](double t) {
                             return CommandSample<double>{std::fmod(t, 6.0) < 3.0 ? 0.4 : -0.2, 0.2 * std::sin(2 * t)};
                           }});
  Starts slow{{}, {0.25, 0.5}}, fast{{}, {0.25, 0.5}};
  for (std::size_t i = 150; i + 60 < s.rows(); i += 9) (s.at(i, 3) < 0.3 ? slow : fast).time.push_back(s.t[i]);
  ASSERT_GT(slow.time.size(), 5u);
  ASSERT_GT(fast.time.size(), 5u);
  const std::vector<double> params = rig.forecaster.defaults();
  const std::size_t velocities = index_of(rig, "/plant/effects/velocity_lever/params/px");
  std::size_t compared = 0, off = 0;
  for (const char* name : {"pose_lever/params/px", "pose_lever/params/py", "pose_yaw/params/a",
                           "velocity_lever/params/px", "velocity_lever/params/py", "velocity_yaw/params/a"}) {
    const std::size_t p = index_of(rig, std::string("/plant/effects/").append(name));
    for (const Starts& starts : {slow, fast}) {
      const auto predicted = differentiate(rig, s, params, std::span(&p, 1), starts);
      constexpr double step = 1e-5;
      std::vector<double> up = params, down = params;
      up[p] += step;
      down[p] -= step;
      const auto high = rig.predict(s, up, starts), low = rig.predict(s, down, starts);
      for (std::size_t k = 0; k < predicted.size(); ++k, ++compared) {
        const double slope = (high[k] - low[k]) / (2 * step);
        const bool close = std::abs(predicted[k].d[0] - slope) < 1e-3 * (1.0 + std::abs(slope));
        off += !close;
        if (p < velocities) {
          EXPECT_TRUE(close) << name << ", " << k;
        }
      }
    }
  }
  // A sideways velocity that a car near standstill starts with grows stiffly: some predictions have a kink there, up to
  // one in twenty by the last digits of the states. Without the derivatives six in ten are off.
  EXPECT_LT(off, compared / 10);
}

/// The cost moves as its derivative says: a jump would be a move that no slope explains.
TEST(Forecaster, NothingJumpsWhereADelayChanges) {
  const CalibrateRig rig(test::small_car_world(frames_and_delay));
  const Session s = drive(rig.vehicle.car(), {.seconds = 14, .noise = 1, .delay = {0.02, 0.02, 0.02, 0.06}});
  const Starts starts = some_starts(s);
  const auto extra = [&](Extra e) { return rig.forecaster.index(e); };
  const std::vector<std::vector<std::size_t>> delays = {{extra(Extra::delay_position), extra(Extra::delay_yaw),
                                                         extra(Extra::delay_velocity), extra(Extra::delay_yaw_rate)},
                                                        {extra(Extra::delay_position)},
                                                        {extra(Extra::delay_velocity)},
                                                        {extra(Extra::delay_yaw_rate)},
                                                        {index_of(rig, "/plant/effects/input_delay/params/T")}};
  for (const auto& moved : delays) {
    constexpr double step = 5e-4;  // [s], over two steps of the car and two rows
    double worst = 0.0, steepest = 0.0, cost_before = 0.0, slope_before = 0.0;
    for (int i = 0; i <= 90; ++i) {
      std::vector<double> params = rig.forecaster.defaults();
      for (const std::size_t p : moved) params[p] = 2e-4 + i * step;
      const auto predicted = differentiate(rig, s, params, moved, starts);
      double cost = 0.0, slope = 0.0;
      for (std::size_t k = 0; k < predicted.size(); ++k) {
        const double off = predicted[k].v - s.interpolate(k % channels, starts.time[k / channels / 2] +
                                                                            starts.horizons[k / channels % 2]);
        cost += off * off;
        slope += 2.0 * off * predicted[k].d[0];
      }
      if (i > 0) worst = std::max(worst, std::abs(cost - cost_before - 0.5 * step * (slope + slope_before)));
      steepest = std::max(steepest, step * std::abs(slope));
      cost_before = cost, slope_before = slope;
    }
    EXPECT_LT(worst, 0.05 * steepest) << "delay " << moved.front() << ", " << moved.size() << " together";
  }
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

TEST(Forecaster, ADisturbanceIsCarriedOn) {
  // The log's car rolls with more resistance than the model knows: without the disturbance every prediction is too
  // fast.
  const CalibrateRig truth(test::small_car_world(R"({"plant": {"params": {"Cr0": 1.8}}})")), rig;
  const Session s = drive(truth.vehicle.car(), {.seconds = 30});
  const Starts starts = some_starts(s, {1.0});
  auto params = rig.forecaster.defaults();
  params[rig.forecaster.index(Extra::gain_force)] = 0.0;
  const double without = worst(s, starts, rig.predict(s, params, starts), 3);
  params[rig.forecaster.index(Extra::gain_force)] = 2.0;
  params[rig.forecaster.index(Extra::force_tau)] = 30.0;
  EXPECT_LT(worst(s, starts, rig.predict(s, params, starts), 3), 0.3 * without);
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
  params[rig.forecaster.index(Extra::gain_turn)] = 5.0;
  const auto predicted = rig.predict(s, params, starts);
  EXPECT_LT(worst(s, starts, predicted, 0), 0.02);
  EXPECT_TRUE(std::isfinite(predicted[4]));
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
  for (std::size_t k = 0; k < predicted.size(); k += channels) {
    EXPECT_NEAR(predicted[k], 30.0, 1e-3);
    EXPECT_NEAR(predicted[k + 1], 40.0, 1e-3);
  }
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
  for (const double v : rig.predict(s, rig.forecaster.defaults(), starts)) EXPECT_TRUE(std::isfinite(v));
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

/// A log of units at these points, turned so.
Session seen_by(Session s, const measured::Frame& pose, const measured::Frame& velocity) {
  const double turned_c = std::cos(velocity.yaw), turned_s = std::sin(velocity.yaw);
  for (std::size_t i = 0; i < s.rows(); ++i) {
    double* const r = s.reading.data() + i * channels;
    const double c = std::cos(r[2]), q = std::sin(r[2]);
    r[0] += pose.x * c - pose.y * q, r[1] += pose.x * q + pose.y * c, r[2] += pose.yaw;
    const double vx = r[3] - velocity.y * r[5], vy = r[4] + velocity.x * r[5];
    r[3] = vx * turned_c + vy * turned_s, r[4] = vy * turned_c - vx * turned_s;
  }
  return s;
}

TEST(Forecaster, FramesThatTheMapStatesAreShown) {
  CalibrateRig rig;
  const Session own = drive(rig.vehicle.car(), {.seconds = 20});
  auto options = rig.forecaster.options();
  options.pose = {0.3, 0.1, 0.2, true, true, true};
  for (const double turned : {0.1, 0.9, -2.0, 3.1}) {
    options.velocity = {0.2, 0.0, turned, true, true, true};
    const Forecaster shown(rig.vehicle.car(), options);
    const Session s = seen_by(own, options.pose, options.velocity);
    const Starts starts = some_starts(s);
    std::vector<double> predicted;
    shown.run<double>(s, measured::CommandGrid(s, 0.02), nullptr, shown.defaults(), starts, predicted);
    EXPECT_LT(worst(s, starts, predicted, 0), 3e-3) << turned;
    EXPECT_LT(worst(s, starts, predicted, 2), 3e-3) << turned;
    EXPECT_LT(worst(s, starts, predicted, 4), 1e-2) << turned;
  }
}

TEST(Forecaster, ASpeedThatIsPrescribedIsReadThroughTheFrameOfItsUnit) {
  const CalibrateRig rig;
  const Session own = drive(rig.vehicle.car(), {.seconds = 20});
  for (const double turned : {0.5, std::numbers::pi}) {
    auto options = rig.forecaster.options();
    options.velocity = {0.0, 0.0, turned, false, false, true};
    const Forecaster shown(rig.vehicle.car(), options);
    Session s = seen_by(own, {}, options.velocity);
    s.prescribed_speed = true;
    for (auto& command : s.command) command.d = 0.0;
    const Starts starts = some_starts(s);
    std::vector<double> predicted;
    shown.run<double>(s, measured::CommandGrid(s, 0.02), nullptr, shown.defaults(), starts, predicted);
    EXPECT_LT(worst(s, starts, predicted, 2), 5e-3) << turned;
    EXPECT_LT(worst(s, starts, predicted, 3), 2e-2) << turned;
  }
}

}  // namespace test_forecaster
}  // namespace gripline::calibrate
