#include "diagnose/result/report_data.hpp"

#include <gtest/gtest.h>

#include "diagnose/inference/hold_out.hpp"
#include "diagnose/inference/reference.hpp"
#include "measured/replay/rollout.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_report_data {

using test::DiagnoseRig;

/// The yaw rates that a report draws under this name, null between predictions.
Node::Array drawn(const Diagnosis& d, const Diagnoser& diagnoser, const char* name) {
  const Node report = report_data(d, diagnoser, "log", "world", Node::empty_object());
  const Node& traces = *report.find("traces");
  return traces.array().back().find(name)->array();
}

/// Yaw rates that a model predicts along a log, one prediction after the other, with NaN between them.
std::vector<double> predicted(const Diagnoser& diagnoser, const Fit& fitted, const Trace& along,
                              measured::RolloutOptions options) {
  Problem own = diagnoser.problem();
  own.traces.assign(1, along);
  iterate_reference(own, diagnoser.road(), fitted);
  const Trace& trace = own.traces.front();
  options.every = static_cast<std::size_t>(std::round(1.0 / trace.log.dt));
  const measured::Rollouts all =
      measured::roll_out(diagnoser.catalogue().build(fitted.model), trace, diagnoser.road(), options);
  std::vector<double> out;
  for (std::size_t i = 0; i < all.start.size(); ++i) {
    for (std::size_t j = 0; j < all.samples; ++j) out.push_back(all.predicted[(i * all.samples + j) * channels + 5]);
    out.push_back(std::nan(""));
  }
  return out;
}

/// The largest difference [rad/s]; what is drawn has six digits.
double off(const Node::Array& shown, const std::vector<double>& expected) {
  EXPECT_LE(shown.size(), expected.size());
  double most = 0.0;
  for (std::size_t i = 0; i < std::min(shown.size(), expected.size()); ++i) {
    EXPECT_EQ(shown[i].is_null(), std::isnan(expected[i])) << i;
    if (!shown[i].is_null()) most = std::max(most, std::abs(shown[i].number() - expected[i]));
  }
  return most;
}

/// Predictions that are drawn of a log held out begin with the commands that are expected of rounded ones, as the fit
/// took those of its own log, and not with those that were written.
TEST(DiagnoseReportData, TracesOfLogsHeldOutHaveTheCommandsThatTheFitTook) {
  DiagnoseRig rig;
  const auto drive = [&](std::uint64_t seed) {
    LogFile log;
    log.stretches.push_back(DiagnoseRig::rounded(
        rig.simulate(rig.catalogue().null_model(), {.seconds = 20, .seed = seed, .unsteady = 1}), 0.03));
    return log;
  };
  const LogFile log = drive(64), other = drive(65);
  Diagnoser diagnoser(rig.world(), rig.registry(), {});
  const Diagnosis d = diagnoser.run({&log, 1}, {&other, 1});
  ASSERT_TRUE(diagnoser.problem().unrounded) << d.sentence;
  const auto by = [&](bool as_written) {
    Problem taken = diagnoser.problem();
    taken.unrounded = !as_written;
    return predicted(diagnoser, diagnoser.nominal(d), as_fitted(other.stretches.front(), taken, diagnoser.road()),
                     {.first = 10, .substeps = diagnoser.problem().substeps});
  };
  const Node::Array before = drawn(d, diagnoser, "before");
  const double off_expected = off(before, by(false));
  EXPECT_LT(off_expected, 1e-4);
  EXPECT_GT(off(before, by(true)), 100.0 * off_expected);
}

/// At 10 Hz predictions of 1 s have ten samples, and the next begins where one ends. Those drawn are of the last third
/// of the log from its tenth sample on, integrated as finely as those of the gap.
TEST(DiagnoseReportData, TracesAreThePredictionsOfTheGapAtAnyRate) {
  DiagnoseRig rig;
  LogFile log;
  log.stretches.push_back(
      DiagnoseRig::thinned(rig.simulate(rig.catalogue().null_model(), {.seconds = 12, .seed = 66}), 5));
  ASSERT_EQ(log.stretches.front().size(), 121U);
  Diagnoser diagnoser(rig.world(), rig.registry(), {});
  const Diagnosis d = diagnoser.run({&log, 1}, {});
  ASSERT_GT(diagnoser.problem().substeps, 4);
  const Node::Array time = drawn(d, diagnoser, "t_s");
  ASSERT_EQ(time.size(), 22U) << "two predictions, and nothing after each";
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_NEAR(time[i].number(), 9.2 + 0.1 * static_cast<double>(i), 1e-9) << "81 samples are known";
    EXPECT_NEAR(time[11 + i].number(), 10.2 + 0.1 * static_cast<double>(i), 1e-9);
  }
  EXPECT_TRUE(time[10].is_null());
  const Node::Array before = drawn(d, diagnoser, "before");
  const auto integrated = [&](int substeps) {
    return predicted(diagnoser, diagnoser.nominal(d), diagnoser.hold_out().traces().front(),
                     {.first = 91, .substeps = substeps});
  };
  const double off_expected = off(before, integrated(diagnoser.problem().substeps));
  EXPECT_LT(off_expected, 1e-4);
  EXPECT_GT(off(before, integrated(2)), 10.0 * off_expected);
}

/// What is drawn as not fitted was not: the model found is that of what comes before.
TEST(DiagnoseReportData, TracesOfTheLogFittedAreOfARefitWithoutThem) {
  DiagnoseRig rig;
  LogFile log;
  log.stretches.push_back(rig.simulate(rig.with("drive_gain", {0.12}), {.seconds = 30, .seed = 61}));
  Diagnoser diagnoser(rig.world(), rig.registry(), {});
  const Diagnosis d = diagnoser.run({&log, 1}, {});
  ASSERT_EQ(d.named.size(), 1U) << d.sentence;
  const Fit refitted = diagnoser.hold_out().refit(d.fit);
  const double begin = drawn(d, diagnoser, "t_s").front().number();  // one sample after the first start
  const auto by = [&](const Fit& fitted) {
    const auto first = static_cast<std::size_t>(std::lround(begin / log.stretches.front().dt)) - 1;
    return predicted(diagnoser, fitted, diagnoser.hold_out().traces().front(),
                     {.first = first, .substeps = diagnoser.problem().substeps});
  };
  const Node::Array after = drawn(d, diagnoser, "after");
  const double off_expected = off(after, by(refitted));
  EXPECT_LT(off_expected, 1e-4);
  EXPECT_GT(off(after, by(d.fit)), 5.0 * off_expected);
}

/// Parameters that were refitted stand with what the world gave and an interval around what was found.
TEST(DiagnoseReportData, RefittedParametersStandBesideTheGivenOnes) {
  DiagnoseRig rig;
  CaseOptions options;
  options.uncertainty = {{"Df", 0.02}};
  LogFile log;
  log.stretches.push_back(rig.simulate(rig.with("drive_gain", {0.12}), {.seconds = 20, .seed = 61}));
  Diagnoser diagnoser(rig.world(), rig.registry(), options);
  const Diagnosis d = diagnoser.run({&log, 1}, {});
  const Node report = report_data(d, diagnoser, "log", "world", Node::empty_object());
  ASSERT_EQ(d.nominal_fit.size(), 1U) << d.sentence;
  ASSERT_EQ(report.find("calibrated")->array().size(), 1U);
  EXPECT_EQ(find_pointer(report, "/calibrated/0/param")->text(), "Df");
  const auto number = [&](const char* key) {
    return find_pointer(report, std::string("/calibrated/0/") + key)->number();
  };
  EXPECT_NEAR(number("given"), rig.catalogue().nominal("Df"), 1e-5 * number("given"));
  EXPECT_NEAR(number("found"), d.nominal_fit.front().second, 1e-5 * number("found"));
  EXPECT_LT(number("ci95/0"), number("found"));
  EXPECT_GT(number("ci95/1"), number("found"));
}

}  // namespace test_diagnose_report_data
}  // namespace gripline::diagnose
