#include "diagnose/result/judgement.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "diagnose/result/verdict.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_judgement {

using test::DiagnoseRig;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

/// A log of a gyroscope that is out by this much [rad/s].
Log with_offset(Log log, double offset) {
  for (std::size_t k = 0; k < log.size(); ++k) log.reading[k * channels + 5] += offset;
  return log;
}

/// A first explanation by one log, to be judged by predictions of another.
struct Case {
  std::vector<std::string> named;          // in the order of the model's members
  ModelSpec truth;                         // of both logs
  double offset = 0, offset_of_other = 0;  // of their gyroscopes [rad/s]
  double seconds_of_other = 20;
  bool delays_taken_off = false;
};

/// What is said of effects that were named with a confidence of 0.9 beside others that could not be told apart, once
/// the other log has been predicted with them.
Judgement judged(const DiagnoseRig& rig, const Case& c) {
  const Catalogue& catalogue = rig.catalogue();
  const Problem problem = rig.problem({with_offset(rig.simulate(c.truth, {.seconds = 12, .seed = 95}), c.offset)});
  const Noise noise = rig.noise(problem, 0.1);
  ModelPool pool(problem);
  const Fit null_model = pool.fit_once(catalogue.null_model(), noise);
  Explanation e;
  ModelSpec model = catalogue.null_model();
  for (const std::string& effect : c.named) {
    model = catalogue.with(model, catalogue.find(effect));
    e.named.emplace_back().effect = effect;
    e.named.back().confidence = 0.9;
  }
  e.fit = pool.fit_once(model, noise);
  e.equivalent = {c.named, {"load_transfer"}};
  e.manoeuvre = "drive straight on";
  SearchResult found{.pool = std::move(pool), .null_model = null_model, .best = e.fit};
  LogFile other;
  other.stretches.push_back(
      with_offset(rig.simulate(c.truth, {.seconds = c.seconds_of_other, .seed = 96}), c.offset_of_other));
  const HoldOut hold_out(problem, rig.road(), {&other, 1});
  return judge_by_predictions(found, hold_out, {.delays_taken_off = c.delays_taken_off}, e);
}

TEST(Judgement, KeepsWhatPredictsOtherLogs) {
  const DiagnoseRig rig;
  const Judgement d = judged(
      rig, {.named = {"yawrate_bias"}, .truth = rig.catalogue().null_model(), .offset = 0.3, .offset_of_other = 0.3});
  EXPECT_EQ(verdict_of(d, {}), Verdict::indistinguishable);
  ASSERT_THAT(d.named, SizeIs(1));
  EXPECT_EQ(d.named.front().confidence, 0.9);
  EXPECT_TRUE(d.named.front().rollout.helps());
  EXPECT_EQ(d.named.front().rollout.change, d.gap.change.change);
  EXPECT_THAT(d.equivalent, SizeIs(2));
  EXPECT_FALSE(d.manoeuvre.empty());
  EXPECT_GT(d.gap.closure, 0.5);
}

/// Whatever its evidence in the log that it was found in. What it was named beside is judged anew, without it.
TEST(Judgement, DropsWhatMakesPredictionsWorseAndKeepsWhatHelps) {
  const DiagnoseRig rig;
  const Judgement d =
      judged(rig, {.named = {"drive_gain", "yawrate_bias"}, .truth = rig.with("drive_gain", {0.15}), .offset = 0.3});
  EXPECT_EQ(verdict_of(d, {}), Verdict::unknown);
  EXPECT_TRUE(d.unknown.has_value());
  EXPECT_THAT(d.equivalent, IsEmpty());
  EXPECT_THAT(d.manoeuvre, IsEmpty());
  ASSERT_THAT(d.named, SizeIs(1));
  const NamedEffect& kept = d.named.front();
  EXPECT_EQ(kept.effect, "drive_gain");
  EXPECT_THAT(d.fit.model.members, ElementsAre(rig.catalogue().find("drive_gain")));
  EXPECT_LE(kept.confidence, thresholds::most_beside_unknown);
  ASSERT_THAT(kept.params, SizeIs(1));
  EXPECT_NEAR(kept.params.front().value, 0.15, 0.01);
  EXPECT_TRUE(kept.rollout.helps());
  EXPECT_EQ(kept.rollout.change, d.gap.change.change) << "it is alone now";
}

/// A name that closes nothing goes, though it does no harm; what is missing then depends on what the bare model leaves.
TEST(Judgement, WithdrawsWhatChangesNoPrediction) {
  const DiagnoseRig rig;
  for (const double offset : {0.0, 0.3}) {
    const Judgement d = judged(
        rig,
        {.named = {"drive_gain"}, .truth = rig.catalogue().null_model(), .offset = offset, .offset_of_other = offset});
    EXPECT_EQ(verdict_of(d, {}), offset > 0.0 ? Verdict::unknown : Verdict::nothing_missing);
    EXPECT_EQ(d.unknown.has_value(), offset > 0.0);
    EXPECT_THAT(d.named, IsEmpty());
    EXPECT_THAT(d.equivalent, IsEmpty());
    EXPECT_THAT(d.manoeuvre, IsEmpty());
    EXPECT_THAT(d.fit.model.members, IsEmpty());
    EXPECT_EQ(d.gap.after, d.gap.before);
    EXPECT_FALSE(d.gap.change.measured()) << "nothing is compared with the nominal model any more";
  }
}

/// Delays that were taken off are not known exactly: too little data for an interval do not say that a name closes more
/// than they are wrong by, and fitted data, which show such errors of delays alike, are not asked instead, unless it
/// closes most of the gap.
TEST(Judgement, IsStricterWhereDelaysWereTakenOff) {
  const DiagnoseRig rig;
  for (const double offset : {0.03, 0.3})
    for (const bool delays_taken_off : {false, true}) {
      const Judgement d = judged(rig, {.named = {"yawrate_bias"},
                                       .truth = rig.catalogue().null_model(),
                                       .offset = offset,
                                       .offset_of_other = offset,
                                       .seconds_of_other = 4,
                                       .delays_taken_off = delays_taken_off});
      const bool withdrawn = delays_taken_off && offset < 0.1;
      EXPECT_EQ(verdict_of(d, {}), withdrawn ? Verdict::nothing_missing : Verdict::indistinguishable) << offset;
      EXPECT_THAT(d.named, SizeIs(withdrawn ? 0 : 1)) << offset;
    }
}

}  // namespace test_diagnose_judgement
}  // namespace gripline::diagnose
