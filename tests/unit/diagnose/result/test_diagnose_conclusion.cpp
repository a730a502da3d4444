#include "diagnose/result/conclusion.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "diagnose/result/verdict.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_conclusion {

using test::DiagnoseRig;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;
using Ids = std::vector<std::string>;

/// A search of one log that tried some effects alone and took the model with `best` for the best.
struct Case {
  ModelSpec truth;
  DiagnoseRig::Drive drive{.seconds = 20, .seed = 93};
  Ids alone = {"drive_gain", "back_emf"};
  Ids best = {"drive_gain"};
  bool exhausted = false;
  Ids synonyms{};  // of the first of them
};

struct Concluded : Conclusion {
  Fit null_model;
};

Concluded concluded(const DiagnoseRig& rig, const Case& c) {
  const Catalogue& catalogue = rig.catalogue();
  const auto model = [&](const Ids& effects) {
    ModelSpec all = catalogue.null_model();
    for (const std::string& effect : effects) all = catalogue.with(all, catalogue.find(effect));
    return all;
  };
  const Problem problem = rig.problem({rig.simulate(c.truth, c.drive)});
  const Noise noise = rig.noise(problem, 0.1);
  ModelPool pool(problem);
  const Fit null_model = pool.fit_once(catalogue.null_model(), noise);
  for (const std::string& effect : c.alone) pool.fit_once(model({effect}), noise);
  const Fit best = pool.fit_once(model(c.best), noise);
  SearchResult found{
      .pool = std::move(pool), .null_model = null_model, .best = best, .exhausted = c.exhausted, .synonyms = {}};
  for (const std::string& id : c.synonyms) found.synonyms[catalogue.find(c.best.front())].push_back(catalogue.find(id));
  const HoldOut hold_out(problem, rig.road(), {});
  return {conclude(found, hold_out), null_model};
}

TEST(Conclusion, NothingIsMissingWhereNoEffectWasFoundAndNothingIsLeft) {
  const DiagnoseRig rig;
  const Concluded d = concluded(rig, {.truth = rig.catalogue().null_model(), .best = {}});
  EXPECT_EQ(verdict_of(d, {}), Verdict::nothing_missing);
  EXPECT_THAT(d.named, IsEmpty());
  EXPECT_FALSE(d.unknown.has_value());
  EXPECT_THAT(d.equivalent, IsEmpty());
}

TEST(Conclusion, NamesWhatLeadsByFar) {
  const DiagnoseRig rig;
  const Concluded d = concluded(rig, {.truth = rig.with("drive_gain", {0.15})});
  EXPECT_EQ(verdict_of(d, {}), Verdict::named);
  ASSERT_THAT(d.named, SizeIs(1));
  EXPECT_EQ(d.named.front().effect, "drive_gain");
  EXPECT_FALSE(d.named.front().measurement);
  EXPECT_EQ(d.named.front().confidence, thresholds::most_confidence);
  EXPECT_FALSE(d.unknown.has_value());
  EXPECT_THAT(d.equivalent, IsEmpty());
  EXPECT_THAT(d.manoeuvre, IsEmpty());
  EXPECT_THAT(d.tests, Not(IsEmpty()));
  EXPECT_THAT(d.fit.model.members, ElementsAre(rig.catalogue().find("drive_gain")));
  ASSERT_THAT(d.ranking, Not(IsEmpty()));
  EXPECT_EQ(d.ranking.front().effect, "drive_gain");
  EXPECT_NEAR(d.ranking.front().selected_fraction, 1.0, 1e-9);
  EXPECT_NEAR(d.ranking.front().gain.value(), d.fit.evidence - d.null_model.evidence, 1e-6);
}

/// An error of the readings is said to be one.
TEST(Conclusion, TellsEffectsOfReadingsFromThoseOfTheCar) {
  const DiagnoseRig rig;
  const Concluded d =
      concluded(rig, {.truth = rig.with("yawrate_bias", {0.3}), .alone = {"yawrate_bias"}, .best = {"yawrate_bias"}});
  ASSERT_THAT(d.named, SizeIs(1));
  EXPECT_TRUE(d.named.front().measurement);
}

/// Beside something that nothing explains a name is at best as likely as not, and nobody asks what else it could be.
TEST(Conclusion, IsUnknownWhereMoreIsLeftThanAnyEffectExplains) {
  const DiagnoseRig rig;
  const Concluded exhausted =
      concluded(rig, {.truth = rig.with("drive_gain", {0.15}), .exhausted = true, .synonyms = {"back_emf"}});
  const Concluded left = concluded(
      rig, {.truth = rig.with(rig.with("drive_gain", {0.15}), "steer_gain", {0.1}), .synonyms = {"back_emf"}});
  for (const Concluded* d : {&exhausted, &left}) {
    EXPECT_EQ(verdict_of(*d, {}), Verdict::unknown);
    EXPECT_TRUE(d->unknown.has_value());
    ASSERT_THAT(d->named, SizeIs(1));
    EXPECT_EQ(d->named.front().effect, "drive_gain");
    EXPECT_EQ(d->named.front().confidence, thresholds::most_beside_unknown);
    EXPECT_THAT(d->equivalent, IsEmpty());
  }
  EXPECT_GT(left.unknown.value().statistic, thresholds::misfit);
}

/// Two that explain a noisy log nearly as well are both listed, the selected one first.
TEST(Conclusion, ListsWhatCannotBeToldApart) {
  const DiagnoseRig rig;
  const Concluded d = concluded(
      rig, {.truth = rig.with("drive_gain", {0.03}), .drive = {.seconds = 20, .seed = 303, .rough = {1, 1, 1}}});
  EXPECT_EQ(verdict_of(d, {}), Verdict::indistinguishable);
  ASSERT_THAT(d.named, SizeIs(1));
  EXPECT_EQ(d.named.front().effect, "drive_gain");
  ASSERT_THAT(d.ranking, SizeIs(testing::Gt(1)));
  EXPECT_EQ(d.ranking[0].effect, "back_emf");
  EXPECT_EQ(d.ranking[1].effect, "drive_gain");
  EXPECT_EQ(d.named.front().confidence, d.ranking[1].selected_fraction) << "of resampled logs, less than the posterior";
  EXPECT_THAT(d.equivalent, ElementsAre(Ids{"drive_gain"}, Ids{"back_emf"}));
  EXPECT_THAT(d.manoeuvre, Not(IsEmpty()));
}

/// Two names for one and the same thing are no two explanations.
TEST(Conclusion, ListsSynonymsBesideAName) {
  const DiagnoseRig rig;
  const Concluded d = concluded(rig, {.truth = rig.with("drive_gain", {0.15}), .synonyms = {"motor_lag"}});
  EXPECT_EQ(verdict_of(d, {}), Verdict::named);
  EXPECT_THAT(d.equivalent, ElementsAre(Ids{"drive_gain"}, Ids{"motor_lag"}));
  EXPECT_THAT(d.manoeuvre, IsEmpty());
}

}  // namespace test_diagnose_conclusion
}  // namespace gripline::diagnose
