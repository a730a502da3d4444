#include "common/learning/generic_tyres.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <vector>

namespace gripline::learning {
namespace test_generic_tyres {

TEST(GenericTyres, PriorIsTheMixtureItClaims) {
  SplitMix64 random(1);
  const TyrePrior prior;
  const GenericTyres tyres(40, prior, random);
  std::vector<double> h(40, 0.0), slope(40, 0.0), lo(40, 0.0), hi(40, 0.0);
  tyres.add(0.3, 1.0, h);
  tyres.add_slope(0.3, 1.0, slope);
  tyres.add(0.3 - 1e-6, 1.0, lo);
  tyres.add(0.3 + 1e-6, 1.0, hi);
  const Eigen::MatrixXd covariance = tyres.prior_covariance();
  double mean = 0, square = 0, implied = 0;
  for (int a = 0; a < 40; ++a) {
    EXPECT_NEAR(slope[a], (hi[a] - lo[a]) / 2e-6, 1e-6);
    EXPECT_GT(h[a], 0.0);
    EXPECT_LE(h[a], 1.0);
    mean += prior.friction * h[a] / 40;
    square += prior.friction * prior.friction * (1 + 0.09) * h[a] * h[a] / 40;
    for (int b = 0; b < 40; ++b) implied += h[a] * covariance(a, b) * h[b];
  }
  EXPECT_NEAR(implied, square - mean * mean, 1e-12);
}

}  // namespace test_generic_tyres
}  // namespace gripline::learning
