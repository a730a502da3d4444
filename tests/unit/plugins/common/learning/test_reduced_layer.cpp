#include "common/learning/reduced_layer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/learning/generic_tyres.hpp"

namespace gripline::learning {
namespace {

constexpr double least_share = 1e-12;  // as elm_rls has it

GenericTyres drawn_tyres(int nodes, std::uint64_t seed, const TyrePrior& prior = {}) {
  SplitMix64 random(seed);
  return GenericTyres(nodes, prior, random);
}

ReducedLayer<GenericTyres> reduce(const GenericTyres& tyres, double share) {
  const CurveDirections directions(tyres);
  return {tyres, directions.leading(directions.above(share))};
}

/// The curve of these weights, of the layer itself and in the coordinates of the reduced one.
struct Curves {
  double full = 0, reduced = 0, full_slope = 0, reduced_slope = 0;
};
Curves curves_at(double slip, const GenericTyres& tyres, const ReducedLayer<GenericTyres>& reduced,
                 const Eigen::VectorXd& weights) {
  const Eigen::VectorXd theta = reduced.reduced(weights);
  std::vector<double> h(static_cast<std::size_t>(tyres.nodes()), 0.0), slope(h.size(), 0.0);
  std::vector<double> g(static_cast<std::size_t>(reduced.nodes()), 0.0), g_slope(g.size(), 0.0);
  tyres.add(slip, 1.0, h);
  tyres.add_slope(slip, 1.0, slope);
  reduced.add(slip, 1.0, g);
  reduced.add_slope(slip, 1.0, g_slope);
  const auto dot = [](const std::vector<double>& a, const Eigen::VectorXd& b) {
    return Eigen::Map<const Eigen::VectorXd>(a.data(), b.size()).dot(b);
  };
  return {dot(h, weights), dot(g, theta), dot(slope, weights), dot(g_slope, theta)};
}

TEST(ReducedLayer, KeepsTheCurvesOfFortyGenericTyresInAThirdOfTheCoordinates) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const GenericTyres tyres = drawn_tyres(40, seed);
    const ReducedLayer<GenericTyres> reduced = reduce(tyres, least_share);
    EXPECT_LE(reduced.nodes(), 14);
    Eigen::VectorXd weights(40);
    for (int j = 0; j < 40; ++j) weights[j] = (1.0 + 0.5 * std::cos(j)) / 40;
    for (const double slip : {-1.93, -0.4, -0.031, 0.0, 0.007, 0.06, 0.22, 0.9, 1.7}) {
      const Curves curves = curves_at(slip, tyres, reduced, weights);
      EXPECT_NEAR(curves.reduced, curves.full, 5e-6) << slip;
      EXPECT_NEAR(curves.reduced_slope, curves.full_slope, 1e-3) << slip;
    }
  }
}

TEST(ReducedLayer, AWiderPriorKeepsMoreDirections) {
  TyrePrior wide;
  wide.stiffness_spread = 1.8;
  const CurveDirections usual(drawn_tyres(40, 1)), varied(drawn_tyres(40, 1, wide));
  EXPECT_GT(varied.above(least_share), usual.above(least_share));
}

TEST(ReducedLayer, HasThePriorVarianceOfEveryCurve) {
  const GenericTyres tyres = drawn_tyres(40, 5);
  const ReducedLayer<GenericTyres> reduced = reduce(tyres, least_share);
  const Eigen::MatrixXd full = tyres.prior_covariance(), small = reduced.reduced_covariance(full);
  for (const double slip : {0.02, 0.3, 1.2}) {
    Eigen::VectorXd h = Eigen::VectorXd::Zero(40), g = Eigen::VectorXd::Zero(reduced.nodes());
    tyres.add(slip, 1.0, {h.data(), 40});
    reduced.add(slip, 1.0, {g.data(), static_cast<std::size_t>(g.size())});
    const double expected = h.dot(full * h);
    EXPECT_NEAR(g.dot(small * g), expected, 1e-5 * expected) << slip;
  }
}

TEST(ReducedLayer, AddsToWhatIsThere) {
  const ReducedLayer<GenericTyres> reduced = reduce(drawn_tyres(12, 7), least_share);
  const auto count = static_cast<std::size_t>(reduced.nodes());
  std::vector<double> once(count, 0.0), twice(count, 0.0);
  reduced.add(0.1, 3.0, once);
  reduced.add(0.1, 1.0, twice);
  reduced.add(0.1, 2.0, twice);
  for (std::size_t i = 0; i < count; ++i) EXPECT_NEAR(once[i], twice[i], 1e-14);
}

}  // namespace
}  // namespace gripline::learning
