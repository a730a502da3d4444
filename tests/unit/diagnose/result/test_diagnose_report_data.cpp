#include "diagnose/result/report_data.hpp"

#include <gtest/gtest.h>

#include "diagnose/inference/hold_out.hpp"
#include "diagnose/inference/reference.hpp"
#include "measured/rollout.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace {

using test::DiagnoseRig;

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
  const auto predicted = [&](bool as_written) {
    Fit nominal;
    nominal.model = diagnoser.catalogue().null_model();
    nominal.noise = d.null_model.noise;
    Problem own = diagnoser.problem();
    Problem taken = own;
    taken.unrounded = !as_written;
    own.traces.assign(1, as_fitted(other.stretches.front(), taken, diagnoser.road()));
    smooth_reference(own, diagnoser.road(), nominal);
    return measured::roll_out(diagnoser.catalogue().build(nominal.model), own.traces.front(), diagnoser.road(), {})
        .predicted;
  };
  const std::vector<double> expected = predicted(false), written = predicted(true);
  const Node report = report_data(d, diagnoser, {&other, 1}, "log", "world", Node::empty_object());
  const Node& yaw_rate = report.find("traces")->array().back();
  const Node::Array& before = yaw_rate.find("before")->array();
  double off_expected = 0.0, off_written = 0.0;
  constexpr std::size_t samples = 50;  // of the first prediction
  for (std::size_t j = 0; j < samples; ++j) {
    off_expected = std::max(off_expected, std::abs(before[j].number() - expected[j * channels + 5]));
    off_written = std::max(off_written, std::abs(before[j].number() - written[j * channels + 5]));
  }
  EXPECT_LT(off_expected, 1e-4) << "six digits are written [rad/s]";
  EXPECT_GT(off_written, 100.0 * off_expected);
}

}  // namespace
}  // namespace gripline::diagnose
