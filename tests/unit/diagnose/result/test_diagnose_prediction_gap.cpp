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
  Diagnosis d;
  d.null_model.model = rig.catalogue().null_model();
  d.null_model.noise = rig.noise(problem, 0.1);
  d.fit = fit(problem, truth, rig.noise(problem, 0.1), 1);
  measure_gap(hold_out, rig.catalogue(), d);
  ASSERT_EQ(d.horizons.size(), 5U);
  EXPECT_EQ(d.horizons[3].seconds, d.gap.horizon);
  EXPECT_EQ(d.horizons[3].before, d.gap.before);
  EXPECT_EQ(d.horizons[3].after, d.gap.after);
  EXPECT_GT(d.gap.before, 1.5 * d.gap.after);
  EXPECT_TRUE(d.gap.change.helps());
  EXPECT_GT(d.gap.closure, 0.7);
  EXPECT_LE(d.gap.closure_low, d.gap.closure);
  EXPECT_GE(d.gap.closure_high, d.gap.closure);
  EXPECT_EQ(d.named_gap.before, d.gap.before) << "no parameter is refitted";
  leave_gap_open(d);
  for (const PredictionError& row : d.horizons) EXPECT_EQ(row.after, row.before);
  EXPECT_EQ(d.gap.after, d.gap.before);
  EXPECT_EQ(d.gap.closure, 0.0);
  EXPECT_EQ(d.named_gap.closure, 0.0);
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
  Diagnosis d;
  d.null_model = fit(problem, rig.catalogue().null_model(), noise, 3);
  d.fit = fit(problem, truth, noise, 3);
  measure_gap(hold_out, rig.catalogue(), d);
  const StartErrors stated = hold_out.predict_refitted(nominal_as_stated(rig.catalogue(), d.null_model)),
                    refitted = hold_out.predict_refitted(d.null_model), found = hold_out.predict_refitted(d.fit);
  EXPECT_EQ(d.gap.before, stated.rms());
  EXPECT_EQ(d.named_gap.before, refitted.rms());
  EXPECT_LT(d.named_gap.before, 0.9 * d.gap.before);
  EXPECT_EQ(d.gap.after, found.rms());
  EXPECT_EQ(d.named_gap.after, found.rms());
  EXPECT_EQ(d.gap.change.change, compare(found, stated).change);
  EXPECT_EQ(d.named_gap.change.change, compare(found, refitted).change);
  const double least = std::min(1.0, found.rms());  // what a perfect model leaves
  EXPECT_DOUBLE_EQ(d.named_gap.closure, (refitted.rms() - found.rms()) / (refitted.rms() - least));
}

}  // namespace test_diagnose_prediction_gap
}  // namespace gripline::diagnose
