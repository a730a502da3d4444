#include <gtest/gtest.h>

#include "diagnose/inference/hold_out.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_hold_out {

using test::DiagnoseRig;

constexpr std::array<double, 2> horizons = {0.5, 1.0};

Fit of(const DiagnoseRig& rig, const Problem& problem, const ModelSpec& model) {
  Fit f;
  f.model = model;
  f.noise = rig.noise(problem, 0.1);
  f.theta = std::vector<double>(1, 0.0);
  return f;
}

/// Root mean squares of predictions over the horizons [sensor standard deviations].
std::vector<double> errors(const HoldOut& hold_out, const Fit& fitted) {
  std::vector<double> out;
  for (const StartErrors& one : hold_out.predict(fitted, horizons)) out.push_back(one.rms());
  return out;
}

/// On another log the true model is left with the sensors' noise, the nominal one is not.
TEST(HoldOut, TheTrueModelPredictsBest) {
  const DiagnoseRig rig;
  const ModelSpec truth = rig.with("drive_gain", {0.15});
  const Problem problem = rig.problem({rig.simulate(truth, {10, 93, 1})});
  LogFile other;
  other.stretches.push_back(rig.simulate(truth, {10, 94, 1}));
  const HoldOut hold_out(problem, rig.road(), {&other, 1});
  const auto with = errors(hold_out, of(rig, problem, truth));
  const auto without = errors(hold_out, of(rig, problem, rig.catalogue().null_model()));
  EXPECT_LT(with[1], 1.3);
  EXPECT_GT(without[0], with[0]);
  EXPECT_GT(without[1], 1.5 * with[1]);
  EXPECT_GT(without[1], without[0]) << "errors grow with the horizon";
}

/// Of 2.5 s held out there are three starts, which make no interval: the data fitted are asked.
TEST(HoldOut, WhereTooLittleIsHeldOutTheDataFittedAreAsked) {
  const DiagnoseRig rig;
  const ModelSpec truth = rig.with("drive_gain", {0.15});
  const Problem problem = rig.problem({rig.simulate(truth, {14, 93, 1})});
  LogFile brief;
  brief.stretches.push_back(rig.simulate(truth, {2.5, 94, 1}));
  const HoldOut hold_out(problem, rig.road(), {&brief, 1});
  const Fit with = of(rig, problem, truth), without = of(rig, problem, rig.catalogue().null_model());
  ASSERT_FALSE(compare(hold_out.predict_refitted(with), hold_out.predict_refitted(without)).measured());
  EXPECT_TRUE(hold_out.change(with, without).helps());
  EXPECT_TRUE(hold_out.change(without, with).harms());
}

/// Without another log the last part is held out: what it shows changes no refit.
TEST(HoldOut, RefitsReadNothingOfWhatIsHeldOut) {
  const DiagnoseRig rig;
  const ModelSpec truth = rig.with("drive_gain", {0.15});
  const Log log = rig.simulate(truth, {12, 95, 1});
  Log spoilt = log;
  for (std::size_t k = log.size() - log.size() / 3 + 10; k < log.size(); ++k)
    for (std::size_t c = 3; c < channels; ++c) spoilt.reading[k * channels + c] *= 1.2;
  const auto refitted = [&](const Log& one) {
    const Problem problem = rig.problem({one});
    return HoldOut(problem, rig.road(), {}).refit(fit(problem, truth, rig.noise(problem, 0.1), 1)).theta;
  };
  const std::vector<double> known = refitted(log);
  EXPECT_NEAR(known.front(), 0.15, 0.02);
  EXPECT_EQ(refitted(spoilt), known);
}

/// At 10 Hz a stretch of 3.5 s has 36 samples, of 6.2 s 63. Nothing of the short one can be predicted, and all of it is
/// fitted: every second of it from its tenth sample on, and no more. Of the other 42 samples are, and none of the rest.
TEST(HoldOut, StretchesOfALogAtALowRateAreNeitherLengthenedNorFittedWhereTheyAreHeldOut) {
  const DiagnoseRig rig;
  const ModelSpec truth = rig.catalogue().null_model();
  const auto drive = [&](double seconds, std::uint64_t seed) {
    return DiagnoseRig::thinned(rig.simulate(truth, {.seconds = seconds, .seed = seed}), 5);
  };
  const auto starts = [&](std::vector<Log> logs) {
    Problem problem = rig.problem(std::move(logs));
    problem.substeps = 8;
    const HoldOut hold_out(problem, rig.road(), {});
    const Fit fitted = of(rig, problem, truth);
    const std::size_t judged = hold_out.predict(fitted, std::span(horizons).last(1)).front().square.size();
    EXPECT_EQ(hold_out.empty(), judged == 0);
    return std::pair(hold_out.predict_training(fitted).square.size(), judged);
  };
  const Log just_enough = drive(6.2, 98), less = drive(3.5, 99);
  ASSERT_EQ(just_enough.size(), 63U);
  ASSERT_EQ(less.size(), 36U);
  EXPECT_EQ(starts({just_enough}), (std::pair<std::size_t, std::size_t>(5, 1)));
  EXPECT_EQ(starts({less}), (std::pair<std::size_t, std::size_t>(4, 0)));
  EXPECT_EQ(starts({just_enough, less}), (std::pair<std::size_t, std::size_t>(9, 1)));
}

/// The step of a log is a measured median: one recorder gives 0.020001 s and 0.020002 s. Of a log at another rate how
/// commands bend is not known.
TEST(HoldOut, CommandsBendLikeThoseOfTheFittedLogAtAboutItsRate) {
  const DiagnoseRig rig;
  const Log log = rig.simulate(rig.catalogue().null_model(), {.seconds = 10, .seed = 97});
  Problem problem = rig.problem({log});
  problem.bend = {-0.1, -0.125};
  const auto bent = [&](double dt) {
    Log other = log;
    other.dt = dt;
    const Trace trace = as_fitted(other, problem, rig.road());
    return trace.log.fine.size() == 2 * other.size() - 1;
  };
  EXPECT_TRUE(bent(log.dt));
  EXPECT_TRUE(bent(log.dt * (1.0 + 1e-4)));
  EXPECT_TRUE(bent(log.dt * (1.0 - 1e-4)));
  EXPECT_FALSE(bent(2.0 * log.dt));
  EXPECT_FALSE(bent(0.9 * log.dt));
}

/// What the recorder rounded to is told by the fitted log: one value between the steps in another log hides it there.
TEST(HoldOut, LogsHeldOutAreRoundedAsTheFittedOneIs) {
  const DiagnoseRig rig;
  constexpr double step = 0.03;
  const ModelSpec truth = rig.catalogue().null_model();
  const auto drive = [&](std::uint64_t seed) {
    return DiagnoseRig::rounded(rig.simulate(truth, {.seconds = 20, .seed = seed, .unsteady = 1}), step);
  };
  Problem problem = rig.problem({drive(96)});
  const auto error = [&](const Log& log) {
    LogFile other;
    other.stretches.push_back(log);
    const HoldOut hold_out(problem, rig.road(), {&other, 1});
    return errors(hold_out, of(rig, problem, truth))[1];
  };
  const Log log = drive(97);
  Log glitch = log;
  glitch.command[glitch.size() / 2].delta += 1e-4;
  const double written = error(glitch);
  problem.command_step[1] = step;
  problem.unround_commands();
  EXPECT_GT(std::abs(error(log) - written), 0.04 * written) << "the commands are others than those written";
  EXPECT_NEAR(error(glitch), error(log), 0.01 * written);
}

}  // namespace test_diagnose_hold_out
}  // namespace gripline::diagnose
