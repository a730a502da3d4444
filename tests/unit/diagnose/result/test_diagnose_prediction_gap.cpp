#include "diagnose/result/prediction_gap.hpp"

#include <gtest/gtest.h>

#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_prediction_gap {

using test::DiagnoseRig;

/// What is left of a delay is no part of the car, whatever the car's parameters are stated to be.
TEST(PredictionGap, BeginsWithTheParametersThatAreStated) {
  DiagnoseRig rig;
  rig.trust({"Df"}, 0.02);
  rig.catalogue().allow_for_late_pose(0, 0.01, 0.002);
  Fit refitted;
  refitted.model = rig.catalogue().null_model();
  refitted.model.nuisance = {0.2, 0.013};
  refitted.theta = refitted.model.nuisance;
  refitted.covariance.assign(4, 1e-6);
  const Fit stated = nominal_as_stated(rig.catalogue(), refitted);
  ASSERT_EQ(stated.model.nuisance.size(), 2U);
  EXPECT_DOUBLE_EQ(stated.model.nuisance[0], 0.192);
  EXPECT_EQ(stated.model.nuisance[1], 0.013);
  EXPECT_TRUE(stated.theta.empty());
  EXPECT_TRUE(stated.covariance.empty());
}

TEST(PredictionGap, IsWhatTheNominalModelMissesAndTheFoundOneCloses) {
  const DiagnoseRig rig;
  const ModelSpec truth = rig.with("drive_gain", {0.15});
  const Problem problem = rig.problem({rig.simulate(truth, {10, 93, 1})});
  LogFile other;
  other.stretches.push_back(rig.simulate(truth, {20, 94, 1}));
  const HoldOut hold_out(problem, rig.road(), {&other, 1});
  Fit null_model;
  null_model.model = rig.catalogue().null_model();
  null_model.noise = rig.noise(problem, 0.1);
  const Fit found = fit(problem, truth, rig.noise(problem, 0.1), 1);
  const PredictionGaps gaps = measure_gaps(hold_out, rig.catalogue(), null_model, found);
  ASSERT_EQ(gaps.horizons.size(), 5U);
  EXPECT_EQ(gaps.horizons[3].seconds, gaps.gap.horizon);
  EXPECT_EQ(gaps.horizons[3].before, gaps.gap.before);
  EXPECT_EQ(gaps.horizons[3].after, gaps.gap.after);
  EXPECT_GT(gaps.gap.before, 1.5 * gaps.gap.after);
  EXPECT_TRUE(gaps.gap.change.helps());
  EXPECT_GT(gaps.gap.closure, 0.7);
  EXPECT_LE(gaps.gap.closure_low, gaps.gap.closure);
  EXPECT_GE(gaps.gap.closure_high, gaps.gap.closure);
  EXPECT_EQ(gaps.named_gap.before, gaps.gap.before) << "no parameter is refitted";
  const PredictionGaps open = left_open(gaps);
  ASSERT_EQ(open.horizons.size(), gaps.horizons.size());
  for (std::size_t i = 0; i < open.horizons.size(); ++i) {
    EXPECT_EQ(open.horizons[i].seconds, gaps.horizons[i].seconds);
    EXPECT_EQ(open.horizons[i].before, gaps.horizons[i].before);
    EXPECT_EQ(open.horizons[i].after, gaps.horizons[i].before);
  }
  EXPECT_EQ(open.gap.before, gaps.gap.before);
  EXPECT_EQ(open.gap.after, gaps.gap.before);
  EXPECT_EQ(open.gap.closure, 0.0);
  EXPECT_EQ(open.named_gap.closure, 0.0);
}

/// Of a car whose parameters are stated wrongly an effect is credited with what it closes beside refitted ones only.
TEST(PredictionGap, OfANameBeginsWithTheParametersRefitted) {
  DiagnoseRig rig;
  rig.trust({"Df"}, 0.05);
  ModelSpec truth = rig.with("drive_gain", {0.15});
  truth.nuisance = {0.17};
  const Problem problem = rig.problem({rig.simulate(truth, {.seconds = 10, .seed = 93})});
  LogFile other;
  other.stretches.push_back(rig.simulate(truth, {.seconds = 20, .seed = 94}));
  const HoldOut hold_out(problem, rig.road(), {&other, 1});
  const Noise noise = rig.noise(problem, 0.1);
  const Fit null_model = fit(problem, rig.catalogue().null_model(), noise, 3);
  const Fit with_effect = fit(problem, truth, noise, 3);
  const PredictionGaps gaps = measure_gaps(hold_out, rig.catalogue(), null_model, with_effect);
  const StartErrors stated = hold_out.predict_refitted(nominal_as_stated(rig.catalogue(), null_model)),
                    refitted = hold_out.predict_refitted(null_model), found = hold_out.predict_refitted(with_effect);
  EXPECT_EQ(gaps.gap.before, stated.rms());
  EXPECT_EQ(gaps.named_gap.before, refitted.rms());
  EXPECT_LT(gaps.named_gap.before, 0.9 * gaps.gap.before);
  EXPECT_EQ(gaps.gap.after, found.rms());
  EXPECT_EQ(gaps.named_gap.after, found.rms());
  EXPECT_EQ(gaps.gap.change.change, compare(found, stated).change);
  EXPECT_EQ(gaps.named_gap.change.change, compare(found, refitted).change);
  const double least = std::min(1.0, found.rms());  // what a perfect model leaves
  EXPECT_DOUBLE_EQ(gaps.named_gap.closure, (refitted.rms() - found.rms()) / (refitted.rms() - least));
}

}  // namespace test_diagnose_prediction_gap
}  // namespace gripline::diagnose
