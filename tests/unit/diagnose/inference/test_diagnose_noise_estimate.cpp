#include "diagnose/inference/noise_estimate.hpp"

#include <gtest/gtest.h>

#include "diagnose/inference/adequacy.hpp"
#include "diagnose/inference/reference.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_noise_estimate {

using test::DiagnoseRig;

/// A problem with the bare car fitted to it, as a search begins.
struct Begun {
  Begun(const DiagnoseRig& rig, const DiagnoseRig::Drive& drive)
      : problem(rig.problem({rig.simulate(rig.catalogue().null_model(), drive)})) {
    fitted = fit(problem, rig.catalogue().null_model(), rig.noise(problem, 5.0), 4);
    iterate_reference(problem, rig.road(), fitted);
  }
  Problem problem;
  Fit fitted;
};

/// A problem of logs, `model` fitted to them and again along their own reference.
struct Fitted {
  Fitted(const DiagnoseRig& rig, const std::vector<Log>& logs, const ModelSpec& model) : problem(rig.problem(logs)) {
    problem.substeps = 6;
    fitted = fit(problem, model, rig.noise(problem, 0.2), 6);
    iterate_reference(problem, rig.road(), fitted);
    fitted = fit(problem, fitted.model, fitted.noise, 8);
  }
  MeasuredNoise commands_measured() const {
    return measure_noise(problem, fitted, {.sensors = false, .commands = true});
  }
  Problem problem;
  Fit fitted;
};

double size_of_effect(const ModelSpec& model) { return model.values.front().front(); }

/// Logs of cars with these gains of the steering.
std::vector<Log> steered(const DiagnoseRig& rig, const std::vector<double>& gains, DiagnoseRig::Drive drive) {
  std::vector<Log> logs;
  for (const double gain : gains) {
    logs.push_back(rig.simulate(rig.with("steer_gain", {gain}), drive));
    ++drive.seed;
  }
  return logs;
}

/// Level and colour of each sensor, together with a rough road.
TEST(NoiseEstimate, MeasuresLevelAndColourOfEverySensor) {
  const DiagnoseRig rig;
  const Channels colour = {0.8, 0.8, 0.5, 0.3, 0.0, 0.9};
  Begun log(rig, {.seconds = 40, .seed = 711, .noise = 1.5, .rough = {1, 1, 1}, .colour = colour});
  EXPECT_GT(colour_statistic(log.problem, log.fitted), thresholds::coloured_innovations);
  const MeasuredNoise found = measure_noise(log.problem, log.fitted, {});
  EXPECT_GT(found.gain, 100.0);
  for (std::size_t c = 0; c < channels; ++c) {
    EXPECT_NEAR(found.noise.colour[c], colour[c], 0.12) << c;
    EXPECT_NEAR(found.noise.sensor[c] / rig.world().sensors.channels[c].sigma, 1.5, 0.3) << c;
  }
  EXPECT_EQ(found.noise.colour[4], 0.0);
}

TEST(NoiseEstimate, WhiteNoiseIsWhite) {
  const DiagnoseRig rig;
  for (const std::uint64_t seed : {712, 713}) {
    Begun log(rig, {.seconds = 30, .seed = seed});
    EXPECT_LT(colour_statistic(log.problem, log.fitted), thresholds::coloured_innovations);
    const MeasuredNoise found = measure_noise(log.problem, log.fitted, {});
    EXPECT_LT(found.gain, 25.0);
    for (const double rho : found.noise.colour) EXPECT_LT(std::abs(rho), 0.15);
  }
}

TEST(NoiseEstimate, MeasuresTheCorrelationTimeOfARoughRoad) {
  const DiagnoseRig rig;
  for (const double truth : {0.1, 0.25, 1.0}) {
    Begun log(rig, {.seconds = 60, .seed = 714, .rough = {2, 2, 2}, .noise_time = truth});
    const MeasuredNoise found = measure_noise(log.problem, log.fitted, {.sensors = false, .correlation_time = true});
    EXPECT_GT(found.noise_time, 0.6 * truth);
    EXPECT_LT(found.noise_time, 1.7 * truth);
    EXPECT_EQ(differs_from_assumed(log.problem, found), truth != 0.25);
  }
}

/// Under the noise that is there, innovations are white and of their stated size; under white noise they are not.
TEST(NoiseEstimate, TheFilterWhitensColouredReadings) {
  const DiagnoseRig rig;
  Channels colour;
  colour.fill(0.7);
  Begun log(rig, {.seconds = 30, .seed = 715, .rough = {1, 1, 1}, .colour = colour});
  Fit told = log.fitted;
  told.noise = rig.noise(log.problem, 1.0);
  EXPECT_GT(colour_statistic(log.problem, told), 15.0);
  told.noise.colour = colour;
  EXPECT_LT(colour_statistic(log.problem, told), 4.0);
  FilterOptions options;
  options.innovations = true;
  const LinearModel lm =
      linearise(rig.catalogue().build(told.model), log.problem.traces.front(), log.problem.stepping());
  double sum = 0.0;
  const Likelihood l = filter(lm, told.noise, options);
  for (const auto& one : l.innovations) sum += one.error * one.error / one.variance;
  EXPECT_NEAR(sum / static_cast<double>(l.innovations.size()), 1.0, 0.06);
}

/// A problem of a log of which every second sample was left out, or not, with the bare car fitted to it.
Begun unsteady_hands(const DiagnoseRig& rig, const DiagnoseRig::Drive& drive, bool thinned, Log& whole) {
  Begun log(rig, drive);
  whole = log.problem.traces.front().log;
  if (!thinned) return log;
  log.problem = rig.problem({DiagnoseRig::thinned(whole)});
  log.problem.substeps = 4;
  log.fitted = fit(log.problem, rig.catalogue().null_model(), rig.noise(log.problem, 5.0), 4);
  iterate_reference(log.problem, rig.road(), log.fitted);
  return log;
}

/// What the driver did at the samples left out of a log, off bent lines.
std::vector<Commands> left_out(const Log& thinned, const Log& whole, const Commands& bend) {
  Log bent = thinned;
  measured::bend_commands(bent, bend);
  std::vector<Commands> off;
  for (std::size_t k = 0; k + 1 < bent.size(); ++k) {
    const ActingCommand<double> guess = measured::command_at(bent, k, 0.5);
    const CommandSample<double>& truth = whole.command[2 * k + 1];
    off.push_back({guess.d - truth.d, guess.delta - truth.delta});
  }
  return off;
}

double mean_square(const std::vector<Commands>& all, std::size_t which) {
  double sum = 0.0;
  for (const Commands& one : all) sum += one[which] * one[which];
  return sum / static_cast<double>(all.size());
}

/// Root mean square over a log of what is found to be unknown of a command.
double size_of(const UnknownCommands& unknown, const Log& log, std::size_t which) {
  const double moving = std::pow(unknown.moving[which], 2) * mean_square(measured::command_variation(log), which);
  return std::sqrt(std::pow(unknown.steady[which], 2) + moving);
}

/// It is found as noise of about its size, from hands that shake all the time and from such as move by jumps. What
/// comes in every step and what comes with moves is hard to tell apart where both are small.
TEST(NoiseEstimate, MeasuresWhatALogLeavesOutOfTheCommands) {
  const DiagnoseRig rig;
  for (const bool by_jumps : {false, true}) {
    DiagnoseRig::Drive drive{.seconds = 30, .seed = 717};
    (by_jumps ? drive.jumps : drive.unsteady) = by_jumps ? 0.03 : 1.0;
    Log whole;
    const Begun log = unsteady_hands(rig, drive, true, whole);
    const Log& thinned = log.problem.traces.front().log;
    const MeasuredNoise found = measure_noise(log.problem, log.fitted, {.sensors = false, .commands = true});
    EXPECT_GT(found.gain, 100.0);
    EXPECT_TRUE(differs_from_assumed(log.problem, found));
    const std::vector<Commands> truth = left_out(thinned, whole, found.bend);
    for (std::size_t i = 0; i < 2; ++i) {
      const double ratio = size_of(found.noise.command, thinned, i) / std::sqrt(mean_square(truth, i));
      EXPECT_NEAR(std::log(ratio), 0.0, std::log(1.6)) << by_jumps << i;
      EXPECT_LT(found.bend[i], 0.06) << by_jumps << i;
      EXPECT_GT(found.bend[i], -0.3) << by_jumps << i;
    }
  }
}

/// Of hands that move by jumps, what is unknown is unknown where they jumped, and nothing else is missing.
TEST(NoiseEstimate, JumpsBetweenSamplesAreNoEffect) {
  const DiagnoseRig rig;
  for (const std::uint64_t seed : {719, 720}) {
    Log whole;
    Begun log = unsteady_hands(rig, {.seconds = 40, .seed = seed, .jumps = 0.03}, true, whole);
    const auto by_input = [&] { return residual_tests(log.problem, log.fitted)[3].statistic; };
    EXPECT_GT(by_input(), thresholds::misfit) << "as known as linear commands would be";
    const MeasuredNoise found = measure_noise(log.problem, log.fitted, {.sensors = false, .commands = true});
    for (std::size_t i = 0; i < 2; ++i) {
      const double all = size_of(found.noise.command, log.problem.traces.front().log, i);
      EXPECT_LT(found.noise.command.steady[i], 0.5 * all) << i;
    }
    assume(log.problem, found);
    log.fitted = fit(log.problem, rig.catalogue().null_model(), found.noise, 6);
    iterate_reference(log.problem, rig.road(), log.fitted);
    EXPECT_LT(by_input(), thresholds::misfit);
  }
}

/// What bent commands would bring is predicted: much where three of four samples of smooth hands are missing, little
/// where none is, and less where they are assumed.
TEST(NoiseEstimate, PredictsWhatBentCommandsWouldBring) {
  const DiagnoseRig rig;
  const auto gain = [&](const Log& log, bool measured) {
    Problem problem = rig.problem({log});
    problem.substeps = 6;
    Fit f = fit(problem, rig.catalogue().null_model(), rig.noise(problem, 5.0), 4);
    iterate_reference(problem, rig.road(), f);
    f.noise = rig.noise(problem, 0.2);
    if (!measured) return gain_of_bends(problem, f);
    const MeasuredNoise found = measure_noise(problem, f, {.sensors = false, .commands = true});
    EXPECT_LT(found.bend[1], -0.05);
    assume(problem, found);
    f.noise = found.noise;
    return gain_of_bends(problem, f);
  };
  const Log whole = rig.simulate(rig.catalogue().null_model(), {.seconds = 60, .seed = 721, .steer = 2});
  const Log few = DiagnoseRig::thinned(DiagnoseRig::thinned(whole));
  const double asked = gain(few, false);
  EXPECT_GT(asked, 20.0);
  EXPECT_LT(gain(whole, false), 5.0);
  EXPECT_LT(gain(few, true), 0.5 * asked);
}

/// An offset of one channel passes for noise that hardly changes. Once the effect is found, white noise is far
/// likelier, and reached from white noise, down to the scatter from sample to sample.
TEST(NoiseEstimate, FindsWhiteNoiseAgainBesideTheEffect) {
  const DiagnoseRig rig;
  Problem problem = rig.problem({rig.simulate(rig.with("vx_bias", {0.2}), {.seconds = 30, .seed = 723})});
  Fit f = fit(problem, rig.with("vx_bias", {0.2}), rig.noise(problem, 1.0), 6);
  iterate_reference(problem, rig.road(), f);
  const double truth = problem.sensor[3];
  problem.sensor[3] = f.noise.sensor[3] = 10.0 * truth;
  problem.colour[3] = f.noise.colour[3] = 0.97;
  const MeasuredNoise found = measure_noise(problem, f, {.begin_white = true});
  EXPECT_GT(found.gain, 300.0);
  EXPECT_NEAR(found.noise.sensor[3] / truth, 1.0, 0.1);
  EXPECT_LT(std::abs(found.noise.colour[3]), 0.1);
  EXPECT_TRUE(is_simpler(problem, found));
}

/// The gain of the steering, fitted to linear commands, has taken up a part of what bent ones do. Both are found only
/// when it may move.
TEST(NoiseEstimate, EffectsMoveWithBends) {
  const DiagnoseRig rig;
  const Log whole = steered(rig, {0.05}, {.seconds = 60, .seed = 724, .steer = 2, .unsteady = 0.3}).front();
  const Fitted log(rig, {DiagnoseRig::thinned(DiagnoseRig::thinned(whole))}, rig.with("steer_gain", {0.05}));
  const MeasuredNoise found = log.commands_measured();
  const auto error = [](const ModelSpec& model) { return std::abs(size_of_effect(model) - 0.05); };
  EXPECT_NEAR(found.bend[1], -0.125, 0.03);
  EXPECT_GT(error(log.fitted.model), 0.002);
  EXPECT_LT(error(found.model), 0.5 * error(log.fitted.model));
}

/// Two logs of which nothing is left out, with another gain of the steering each. Noise is measured on the first, for
/// which the common gain is wrong: what it would gain there by itself is no gain of bends.
TEST(NoiseEstimate, ParametersOfTheFirstSamplesAreNoGain) {
  const DiagnoseRig rig;
  const std::vector<Log> logs = steered(rig, {0.05, 0.03}, {.seconds = 60, .seed = 901, .steer = 2});
  const Fitted both(rig, logs, rig.with("steer_gain", {0.04}));
  const MeasuredNoise found = both.commands_measured();
  EXPECT_LT(found.gain, thresholds::noise_gain);
  EXPECT_GT(found.gain, -1.0);
  EXPECT_EQ(found.bend, Commands{});
  EXPECT_EQ(found.noise.command, UnknownCommands{});
  EXPECT_EQ(found.model.values, both.fitted.model.values);
  EXPECT_LT(gain_of_bends(both.problem, both.fitted), 5.0);
}

/// Where such logs bend, the common gain moves by what bends change of it, not to that of the first log.
TEST(NoiseEstimate, BendsMoveTheParametersOfAllLogs) {
  const DiagnoseRig rig;
  std::vector<Log> logs = steered(rig, {0.05, 0.03}, {.seconds = 240, .seed = 911, .steer = 2, .unsteady = 0.3});
  for (Log& log : logs) log = DiagnoseRig::thinned(DiagnoseRig::thinned(log));
  const MeasuredNoise found = Fitted(rig, logs, rig.with("steer_gain", {0.04})).commands_measured();
  EXPECT_NEAR(found.bend[1], -0.125, 0.03);
  EXPECT_NEAR(size_of_effect(found.model), 0.04, 0.004);
}

/// At the upper end of its range an unknown can be told to go down.
TEST(NoiseEstimate, LeavesTheUpperEndOfARange) {
  const DiagnoseRig rig;
  Problem problem = rig.problem(
      {DiagnoseRig::thinned(rig.simulate(rig.catalogue().null_model(), {.seconds = 40, .seed = 725, .unsteady = 1}))});
  problem.substeps = 4;
  problem.bend[1] = thresholds::most_bend;
  for (Trace& trace : problem.traces) trace.bend_commands(problem.bend);
  Fit f = fit(problem, rig.catalogue().null_model(), rig.noise(problem, 5.0), 4);
  iterate_reference(problem, rig.road(), f);
  EXPECT_GT(gain_of_bends(problem, f), 20.0);
  const MeasuredNoise found = measure_noise(problem, f, {.sensors = false, .commands = true});
  EXPECT_LT(found.bend[1], 0.06);
  EXPECT_GT(found.bend[1], -0.3);
  EXPECT_GT(found.gain, 20.0);
}

TEST(NoiseEstimate, WholeLogsLeaveNothingOutOfTheCommands) {
  const DiagnoseRig rig;
  Log whole;
  const Begun log = unsteady_hands(rig, {.seconds = 30, .seed = 718, .unsteady = 1}, false, whole);
  const MeasuredNoise found = measure_noise(log.problem, log.fitted, {.sensors = false, .commands = true});
  const Commands curvature = measured::command_curvature({&whole, 1});
  for (std::size_t i = 0; i < 2; ++i) EXPECT_LT(size_of(found.noise.command, whole, i), 0.15 * curvature[i]) << i;
  EXPECT_LT(found.gain, 20.0);
}

/// What is forgotten takes nothing with it: the rest is measured again without.
TEST(NoiseEstimate, WholeLogsAreNoLessLikely) {
  const DiagnoseRig rig;
  for (const std::uint64_t seed : {901, 902}) {
    const std::vector<Log> whole = steered(rig, {0.05}, {.seconds = 60, .seed = seed, .steer = 2});
    const MeasuredNoise found = Fitted(rig, whole, rig.with("steer_gain", {0.05})).commands_measured();
    EXPECT_GE(found.gain, -1.0) << seed;
    EXPECT_EQ(found.bend, Commands{}) << seed;
  }
}

/// Derivatives by parameters, of motion and of readings, go through the differences too.
TEST(NoiseEstimate, GradientUnderColourAgreesWithDifferences) {
  DiagnoseRig rig;
  Channels colour;
  colour.fill(0.6);
  for (const auto& [id, value] :
       {std::pair("aero_drag", 0.3), std::pair("vx_scale", 0.02), std::pair("steer_lag", 0.04)}) {
    const ModelSpec truth = rig.with(id, {value});
    Problem problem = rig.problem({rig.simulate(truth, {.seconds = 10, .seed = 716, .colour = colour})});
    Noise noise = rig.noise(problem, 0.02);
    noise.colour = colour;
    Fit at_truth;
    at_truth.model = truth;
    at_truth.noise = noise;
    smooth_reference(problem, rig.road(), at_truth);
    const auto cost_at = [&](double v) {
      return filter(linearise(rig.catalogue().build(rig.with(id, {v})), problem.traces.front(), 3), noise, {}).cost;
    };
    const double moved = 1.01 * value, step = 1e-3 * value;
    const auto [lm, regressors, work] =
        linearise_with_regressors(rig.catalogue(), rig.with(id, {moved}), problem.traces.front(), 3);
    const Likelihood l = filter_along(lm, noise, regressors);
    const double slope = (cost_at(moved + step) - cost_at(moved - step)) / (2.0 * step);
    EXPECT_NEAR(-l.g.front(), slope, 0.05 * std::abs(slope) + 0.02 * std::sqrt(l.N.front())) << id;
  }
}

/// What smoothing finds is nearer to the truth when the colour is known.
TEST(NoiseEstimate, SmoothingUnderTheRightColourIsBetter) {
  const DiagnoseRig rig;
  Channels colour;
  colour.fill(0.9);
  const ModelSpec bare = rig.catalogue().null_model();
  const Log clean = rig.simulate(bare, {10, 7, 0});
  const auto error = [&](const Channels& assumed) {
    Problem problem = rig.problem({rig.simulate(bare, {.seconds = 10, .seed = 7, .colour = colour})});
    Fit f;
    f.model = bare;
    f.noise = rig.noise(problem, 0.5);
    f.noise.colour = assumed;
    for (int i = 0; i < 2; ++i) smooth_reference(problem, rig.road(), f);
    double sum = 0.0;
    for (std::size_t i = 0; i < clean.reading.size(); ++i) {
      const double off = (problem.traces.front().motion[i] - clean.reading[i]) / problem.sensor[i % channels];
      sum += off * off;
    }
    return std::sqrt(sum / static_cast<double>(clean.reading.size()));
  };
  EXPECT_LT(error(colour), 0.9 * error({}));
}

}  // namespace test_diagnose_noise_estimate
}  // namespace gripline::diagnose
