#include "diagnose/result/fitted_parameters.hpp"

#include <gtest/gtest.h>

#include "support/diagnose_rig.hpp"
#include "util/statistics.hpp"

namespace gripline::diagnose {
namespace test_diagnose_fitted_parameters {

using test::DiagnoseRig;

/// Free values come as the fit has them: nuisances, then the members' in order. What a delay is still wrong by is one
/// of them, but no parameter that anybody stated.
TEST(FittedParameters, EachHasItsNameAndItsInterval) {
  DiagnoseRig rig;
  rig.trust({"Df"}, 0.02);
  rig.catalogue().allow_for_late_pose(0, 0.01, 0.002);
  Fit fitted;
  fitted.model = rig.with("drive_gain", {0.03});
  fitted.theta = {0.19, 0.011, 0.03};
  fitted.covariance = {1e-6, 0, 0, 0, 1e-6, 0, 0, 0, 1e-4};
  Explanation without_numbers;
  without_numbers.named.resize(1);
  const Explanation d = with_fit(rig.catalogue(), fitted, without_numbers);
  EXPECT_EQ(d.fit.theta, fitted.theta);
  ASSERT_EQ(d.nominal_fit.size(), 1U);
  EXPECT_EQ(d.nominal_fit.front(), std::pair(std::string("Df"), 0.19));
  ASSERT_EQ(d.named.front().params.size(), 1U);
  const NamedEffect::Value& gain = d.named.front().params.front();
  const Candidate& effect = rig.catalogue().candidates()[d.fit.model.members.front()];
  EXPECT_EQ(gain.name, effect.decl(0).name);
  EXPECT_EQ(gain.value, 0.03);
  EXPECT_DOUBLE_EQ(gain.low, 0.03 - normal_95 * 0.01);
  EXPECT_DOUBLE_EQ(gain.high, 0.03 + normal_95 * 0.01);
}

}  // namespace test_diagnose_fitted_parameters
}  // namespace gripline::diagnose
