#include "diagnose/result/judgement.hpp"

#include <gtest/gtest.h>

#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_judgement {

using test::DiagnoseRig;

/// A log of a gyroscope that is out by this much [rad/s].
Log with_offset(Log log, double offset) {
  for (std::size_t k = 0; k < log.size(); ++k) log.reading[k * channels + 5] += offset;
  return log;
}

/// What is said of a gyroscope's offset, found in one log, once another has been predicted with it.
Diagnosis judged(const DiagnoseRig& rig, double offset_of_other) {
  const Catalogue& catalogue = rig.catalogue();
  const ModelSpec bare = catalogue.null_model();
  const Problem problem = rig.problem({with_offset(rig.simulate(bare, {.seconds = 12, .seed = 95}), 0.3)});
  const Noise noise = rig.noise(problem, 0.1);
  ModelPool pool(problem);
  Diagnosis d;
  d.null_model = pool.fit_once(bare, noise);
  d.fit = pool.fit_once(rig.with("yawrate_bias", {0.0}), noise);
  d.verdict = Verdict::named;
  d.named.resize(1);
  d.named.front().effect = "yawrate_bias";
  SearchResult found{std::move(pool), d.null_model, d.fit, false, {}, {}};
  LogFile other;
  other.stretches.push_back(with_offset(rig.simulate(bare, {.seconds = 20, .seed = 96}), offset_of_other));
  const HoldOut hold_out(problem, rig.road(), {&other, 1});
  judge_by_predictions(hold_out, problem, false, found, d);
  return d;
}

TEST(Judgement, KeepsWhatPredictsOtherLogs) {
  const Diagnosis d = judged(DiagnoseRig(), 0.3);
  EXPECT_EQ(d.verdict, Verdict::named);
  ASSERT_EQ(d.named.size(), 1U);
  EXPECT_TRUE(d.named.front().rollout.helps());
  EXPECT_EQ(d.named.front().rollout.change, d.gap.change.change);
  EXPECT_GT(d.gap.closure, 0.5);
}

/// Whatever its evidence in the log that it was found in.
TEST(Judgement, DropsWhatMakesPredictionsWorse) {
  const Diagnosis d = judged(DiagnoseRig(), 0.0);
  EXPECT_EQ(d.verdict, Verdict::unknown);
  EXPECT_TRUE(d.unknown.has_value());
  EXPECT_TRUE(d.named.empty());
  EXPECT_TRUE(d.fit.model.members.empty());
  EXPECT_EQ(d.gap.after, d.gap.before);
}

}  // namespace test_diagnose_judgement
}  // namespace gripline::diagnose
