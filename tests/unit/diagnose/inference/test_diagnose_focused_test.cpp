#include <gtest/gtest.h>

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>

#include "diagnose/inference/focused_test.hpp"

namespace gripline::diagnose {
namespace test_diagnose_focused_test {

/// The cube root of a chi-square against its exact distribution, in the upper tail: only large values decide.
TEST(FocusedTest, ChiSquaresBecomeNormals) {
  namespace bm = boost::math;
  for (const double dof : {2.0, 8.0, 9.0, 20.0})
    for (const double z : {0.0, 2.0, 3.5}) {
      const double tail = bm::cdf(bm::complement(bm::normal(), z));
      const double chi_square = bm::quantile(bm::complement(bm::chi_squared(dof), tail));
      EXPECT_NEAR(wilson_hilferty(chi_square, dof), z, 0.12) << dof;
    }
}

ScoreSystem two_regressors(double second) {
  ScoreSystem system;
  system.normal.N = 100.0 * Eigen::MatrixXd::Identity(3, 3);
  system.normal.g = Eigen::Vector3d(0.0, 1.0, 10.0 * second);
  system.own_params = 1;
  return system;
}

TEST(FocusedTest, OnlyTheChosenFunctionsCount) {
  const Eigen::Index first[] = {0, 1}, both[] = {0, 1, 2};
  const ScoreSystem system = two_regressors(8.0);
  const ResidualTest one = focused_test(system, first, Where::state, false);
  const ResidualTest two = focused_test(system, both, Where::state, false);
  EXPECT_TRUE(one.focused);
  EXPECT_EQ(one.dof, 1U);
  EXPECT_LT(one.statistic, thresholds::misfit);
  EXPECT_EQ(two.dof, 2U);
  EXPECT_GT(two.statistic, thresholds::misfit);
}

TEST(FocusedTest, ProcessNoiseAsksForMore) {
  const Eigen::Index both[] = {0, 1, 2};
  const ScoreSystem system = two_regressors(5.0);
  EXPECT_GT(focused_test(system, both, Where::time, false).statistic, thresholds::misfit);
  EXPECT_LT(focused_test(system, both, Where::time, true).statistic, thresholds::misfit);
}

}  // namespace test_diagnose_focused_test
}  // namespace gripline::diagnose
