#include "common/learning/reduced_layer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "common/learning/generic_tyres.hpp"

namespace gripline::learning {
namespace test_reduced_layer {

GenericTyres drawn_tyres(int nodes, std::uint64_t seed, const TyrePrior& prior = {}) {
  SplitMix64 random(seed);
  return GenericTyres(nodes, prior, random);
}

ReducedLayer<GenericTyres> reduce(const GenericTyres& tyres) {
  const CurveDirections directions(tyres);
  return {tyres, directions.leading(directions.count())};
}

/// A node's value or slope, of the layer and of the reduced one's coordinates taken back to the layer's.
struct Node {
  double full, reduced;
};
template <class Add>
Node node_at(int node, const GenericTyres& tyres, const ReducedLayer<GenericTyres>& reduced, const Add& add) {
  std::vector<double> h(static_cast<std::size_t>(tyres.nodes()), 0.0);
  std::vector<double> g(static_cast<std::size_t>(reduced.nodes()), 0.0);
  add(tyres, h);
  add(reduced, g);
  const Eigen::VectorXd theta = reduced.reduced(Eigen::VectorXd::Unit(tyres.nodes(), node));
  return {h[static_cast<std::size_t>(node)], Eigen::Map<const Eigen::VectorXd>(g.data(), theta.size()).dot(theta)};
}

/// Every node of the priors of the shipped experiments, between the knots of the table too, where stiff tyres bend.
TEST(ReducedLayer, KeepsEveryGenericTyreInAThirdOfTheCoordinates) {
  const TyrePrior usual, stiff{15.0, 0.7, 1.4, 0.1, 1.0, 0.3}, full_size{17.0, 0.3, 1.6, 0.15, 1.0, 0.3};
  for (const TyrePrior& prior : {usual, stiff, full_size}) {
    const GenericTyres tyres = drawn_tyres(40, 1, prior);
    const ReducedLayer<GenericTyres> reduced = reduce(tyres);
    EXPECT_LE(reduced.nodes(), 14);
    for (int node = 0; node < 40; ++node)
      for (const double slip : {-1.93, -0.4, -0.031, 0.003, 0.007, 0.0125, 0.06, 0.22, 0.9, 1.7}) {
        const Node value =
            node_at(node, tyres, reduced, [&](const auto& layer, std::vector<double>& h) { layer.add(slip, 1.0, h); });
        EXPECT_NEAR(value.reduced, value.full, 5e-5) << prior.stiffness << ", node " << node << ", " << slip;
        const Node slope = node_at(node, tyres, reduced,
                                   [&](const auto& layer, std::vector<double>& h) { layer.add_slope(slip, 1.0, h); });
        EXPECT_NEAR(slope.reduced, slope.full, 2e-3 * prior.stiffness) << prior.stiffness << ", node " << node;
      }
  }
}

TEST(ReducedLayer, RefusesMoreNodesThanItHasRoomFor) {
  const GenericTyres tyres = drawn_tyres(401, 1);
  EXPECT_THROW(ReducedLayer<GenericTyres>(tyres, Eigen::MatrixXd::Identity(401, 3)), std::invalid_argument);
}

TEST(ReducedLayer, AWiderPriorKeepsMoreDirections) {
  TyrePrior wide;
  wide.stiffness_spread = 1.8;
  const CurveDirections usual(drawn_tyres(40, 1)), varied(drawn_tyres(40, 1, wide));
  EXPECT_GT(varied.count(), usual.count());
}

TEST(ReducedLayer, HasThePriorVarianceOfEveryCurve) {
  const GenericTyres tyres = drawn_tyres(40, 5);
  const ReducedLayer<GenericTyres> reduced = reduce(tyres);
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
  const ReducedLayer<GenericTyres> reduced = reduce(drawn_tyres(12, 7));
  const auto count = static_cast<std::size_t>(reduced.nodes());
  std::vector<double> once(count, 0.0), twice(count, 0.0);
  reduced.add(0.1, 3.0, once);
  reduced.add(0.1, 1.0, twice);
  reduced.add(0.1, 2.0, twice);
  for (std::size_t i = 0; i < count; ++i) EXPECT_NEAR(once[i], twice[i], 1e-14);
}

}  // namespace test_reduced_layer
}  // namespace gripline::learning
