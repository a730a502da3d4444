#include "calibrate/forecaster.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/calibrate_rig.hpp"

namespace gripline::calibrate {
namespace {

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

TEST(Forecaster, ReadsTheLogBeforeTheStartAndCommandsUpToItsTimeAndNothingElse) {
  const CalibrateRig rig;
  const Session s = drive(rig.vehicle.car(), {.seconds = 20, .noise = 1, .delay = {0.03, 0.0, 0.02, 0.2}});
  auto params = rig.forecaster.defaults();
  params[rig.forecaster.index(Extra::delay_position)] = 0.03;
  params[rig.forecaster.index(Extra::delay_yaw_rate)] = 0.2;
  Starts starts;
  starts.horizons = {1.0};
  for (std::size_t i = 10; i < 600; i += 13) starts.time.push_back(s.t[i]);
  const auto before = rig.predict(s, params, starts);
  for (const std::size_t last : {20ul, 300ul, 557ul}) {
    Session changed = s;
    for (std::size_t i = last + 1; i < s.rows(); ++i)
      for (std::size_t c = 0; c < channels; ++c) changed.reading[i * channels + c] = c % 2 == 0 ? NAN : 1e3;
    for (std::size_t i = 0; i < s.rows(); ++i)
      if (s.t[i] > s.t[last] + 1.0 + 1e-9) changed.command[i] = {-1.0, 0.4};
    const auto after = rig.predict(changed, params, starts);
    for (std::size_t i = 0; i < starts.time.size(); ++i) {
      if (starts.time[i] > s.t[last]) continue;
      for (std::size_t c = 0; c < channels; ++c)
        EXPECT_EQ(after[i * channels + c], before[i * channels + c]) << "start " << starts.time[i] << " channel " << c;
    }
  }
}

TEST(Forecaster, DerivativesAreThoseOfThePredictions) {
  const CalibrateRig rig;
  const Session s = drive(rig.vehicle.car(), {.seconds = 12, .noise = 1, .delay = {0.0, 0.0, 0.0, 0.1}});
  const Starts starts = some_starts(s);
  std::vector<double> params = rig.forecaster.defaults();
  // Rows that fall between steps: on a step both sides differ a little.
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

TEST(Forecaster, ADisturbanceIsCarriedOn) {
  // The log's car rolls with more resistance than the model knows: without the disturbance every prediction is too fast.
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
  for (const double v : rig.predict(s, rig.forecaster.defaults(), starts)) EXPECT_TRUE(std::isfinite(v));
}

TEST(Forecaster, FramesThatTheMapStatesAreShown) {
  CalibrateRig rig;
  Session s = drive(rig.vehicle.car(), {.seconds = 20});
  auto options = rig.forecaster.options();
  options.pose = {0.3, 0.1, 0.2, true, true};
  options.velocity = {0.2, 0.0, 0.1, true, true};
  const Forecaster shown(rig.vehicle.car(), options);
  for (std::size_t i = 0; i < s.rows(); ++i) {
    double* const r = s.reading.data() + i * channels;
    const double c = std::cos(r[2]), q = std::sin(r[2]);
    r[0] += 0.3 * c - 0.1 * q, r[1] += 0.3 * q + 0.1 * c, r[2] += 0.2;
    const double vy = r[4] + 0.2 * r[5], vx = r[3];
    r[3] = vx * std::cos(0.1) + vy * std::sin(0.1), r[4] = vy * std::cos(0.1) - vx * std::sin(0.1);
  }
  const Starts starts = some_starts(s);
  std::vector<double> predicted;
  shown.run<double>(s, measured::CommandGrid(s, 0.02), nullptr, shown.defaults(), starts, predicted);
  EXPECT_LT(worst(s, starts, predicted, 0), 3e-3);
  EXPECT_LT(worst(s, starts, predicted, 2), 3e-3);
  EXPECT_LT(worst(s, starts, predicted, 4), 1e-2);
}

}  // namespace
}  // namespace gripline::calibrate
