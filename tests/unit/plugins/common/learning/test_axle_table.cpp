#include "common/learning/axle_table.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <vector>

#include "common/learning/generic_tyres.hpp"

namespace gripline::learning {
namespace test_axle_table {

constexpr int nodes = 12;

GenericTyres drawn_tyres() {
  SplitMix64 random(7);
  return GenericTyres(nodes, {}, random);
}

TEST(TabulatedLayer, ReadsTheNodesAtAndBetweenItsKnots) {
  const GenericTyres tyres = drawn_tyres();
  const TabulatedLayer table(tyres);
  for (const double slip : {-1.9, -0.33, -0.0251, 0.0, 0.01, 0.0125, 0.2, 0.777, 2.0}) {
    std::vector<double> exact(nodes);
    tyres.add(slip, 1.0, exact);
    Eigen::VectorXd read(nodes);
    table.read(slip, read);
    for (int j = 0; j < nodes; ++j) EXPECT_NEAR(read[j], exact[static_cast<std::size_t>(j)], 2e-3) << slip;
  }
}

// Both interpolate in the same way, so that a force and its uncertainty belong to one curve.
TEST(TabulatedLayer, ReadsWhatTheTableOfACurveSays) {
  const GenericTyres tyres = drawn_tyres();
  TabulatedLayer layer(tyres);
  Eigen::VectorXd weights(nodes), read(nodes);
  for (int j = 0; j < nodes; ++j) weights[j] = std::cos(j);
  AxleTable curve;
  layer.fill(curve, weights, 3.0);
  for (const double slip : {-2.5, -0.4, 0.013, 0.6, 1.99, 2.5}) {  // beyond the table: its end
    layer.read(slip, read);
    EXPECT_NEAR(3.0 * weights.dot(read), curve.at(slip).force, 1e-12) << slip;
  }
}

// Of a car that steers by more than the table reaches, sliding sideways. A solver that followed another slope than the
// force's would not converge.
TEST(AxleTable, BeyondItsLastKnotTheCurveIsLevel) {
  AxleTable curve;
  for (std::ptrdiff_t i = 0; i < table_knots; ++i) {
    curve.values()[static_cast<std::size_t>(i)] = 3.0 * table_slip(i);
    curve.slopes()[static_cast<std::size_t>(i)] = 3.0;
  }
  for (const double side : {-1.0, 1.0}) {
    EXPECT_NEAR(curve.at(side * 1.999).slope, 3.0, 1e-9);
    EXPECT_EQ(curve.at(side * 2.001).slope, 0.0);
    EXPECT_NEAR(curve.at(side * 2.1).force, side * 6.0, 1e-12);
  }
}

TEST(AxleTable, ForceAtASlipThatIsNoNumberIsNone) {
  AxleTable curve;
  for (std::ptrdiff_t i = 0; i < table_knots; ++i) curve.values()[static_cast<std::size_t>(i)] = table_slip(i);
  const double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(curve.at(none).force));
  EXPECT_TRUE(std::isnan(curve.at(none).slope));
  EXPECT_NEAR(curve.at(5.0).force, table_reach, 1e-12);
  EXPECT_NEAR(curve.at(-5.0).force, -table_reach, 1e-12);
}

}  // namespace test_axle_table
}  // namespace gripline::learning
