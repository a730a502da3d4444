#include <gtest/gtest.h>

#include "diagnose/inference/constancy.hpp"
#include "diagnose/inference/reference.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_constancy {

using test::DiagnoseRig;

/// A friction that falls is no smaller friction.
TEST(Constancy, TellsADriftFromAConstant) {
  DiagnoseRig rig({"friction_drift"});
  const auto most = [&](const ModelSpec& truth) {
    Problem problem = rig.problem({rig.simulate(truth, {40, 47, 1})});
    Fit f = fit(problem, rig.with("friction_scale", {-0.05}), rig.noise(problem, 1.0), 10);
    iterate_reference(problem, rig.road(), f);
    f = fit(problem, f.model, f.noise, 10);
    double statistic = 0.0;
    for (const ResidualTest& test : constancy(problem, f, linearise_all(problem, f.model)))
      statistic = std::max(statistic, test.statistic);
    return statistic;
  };
  EXPECT_LT(most(rig.with("friction_scale", {-0.1})), thresholds::misfit);
  EXPECT_GT(most(rig.with("friction_drift", {-0.1})), thresholds::misfit);
}

/// An offset of the steering is no other ratio, which would be larger to one side and smaller to the other.
TEST(Constancy, TellsAnOffsetFromAGainByTheSide) {
  DiagnoseRig rig({"steer_offset"});
  const auto most = [&](const ModelSpec& truth) {
    Problem problem = rig.problem({rig.simulate(truth, {40, 48, 1})});
    Fit f = fit(problem, rig.with("steer_gain", {0.01}), rig.noise(problem, 1.0), 10);
    iterate_reference(problem, rig.road(), f);
    f = fit(problem, f.model, f.noise, 10);
    return constancy_by_member(problem, f, linearise_all(problem, f.model)).front();
  };
  EXPECT_LT(most(rig.with("steer_gain", {0.06})), thresholds::misfit);
  EXPECT_GT(most(rig.with("steer_offset", {0.01})), thresholds::misfit);
}

}  // namespace test_diagnose_constancy
}  // namespace gripline::diagnose
