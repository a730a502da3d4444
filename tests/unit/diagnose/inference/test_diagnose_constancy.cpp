#include <gtest/gtest.h>

#include "diagnose/inference/constancy.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace {

using test::DiagnoseRig;

/// A grip that falls is no smaller grip: what is named must be the same throughout the log.
TEST(Remainder, WhatIsNamedIsConstant) {
  DiagnoseRig rig({"friction_drift"});
  const auto most = [&](const ModelSpec& truth) {
    Problem problem = rig.problem({rig.simulate(truth, {40, 47, 1})});
    Fit f = fit(problem, rig.with("friction_scale", {-0.05}), rig.noise(problem, 1.0), 10);
    settle_reference(problem, rig.road(), f);
    f = fit(problem, f.model, f.noise, 10);
    double excess = 0.0;
    for (const BasisTest& test : constancy(problem, f, linearise_all(problem, f.model)))
      excess = std::max(excess, test.excess);
    return excess;
  };
  EXPECT_LT(most(rig.with("friction_scale", {-0.1})), structured);
  EXPECT_GT(most(rig.with("friction_drift", {-0.1})), structured);
}

/// Wheels that stand askew are no change of the steering's ratio: that would be larger to one side and smaller to the other.
TEST(Remainder, WhatIsNamedIsTheSameToBothSides) {
  DiagnoseRig rig({"steer_offset"});
  const auto most = [&](const ModelSpec& truth) {
    Problem problem = rig.problem({rig.simulate(truth, {40, 48, 1})});
    Fit f = fit(problem, rig.with("steer_gain", {0.01}), rig.noise(problem, 1.0), 10);
    settle_reference(problem, rig.road(), f);
    f = fit(problem, f.model, f.noise, 10);
    return inconstancy(problem, f, linearise_all(problem, f.model)).front();
  };
  EXPECT_LT(most(rig.with("steer_gain", {0.06})), structured);
  EXPECT_GT(most(rig.with("steer_offset", {0.01})), structured);
}

}  // namespace
}  // namespace gripline::diagnose
