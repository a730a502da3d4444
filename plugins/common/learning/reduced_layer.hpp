// The curves of a hidden layer in fewer coordinates. Many overlapping nodes h_j(slip) span few directions to any
// accuracy that matters: with E the leading eigenvectors of sum_slip h h^T,
//
//   sum_j w_j h_j(slip)  =  g(slip)^T theta,     g = E^T h,   theta = E^T w
//
// up to the part of h outside of E, 1e-5 of a node's peak for the tyres of the experiments. The mean and the covariance
// that w has before anything is learned become those of theta, so that learning theta is learning w. Recursive least
// squares costs the square of the number of directions, 9 to 13 for 40 generic tyres.
// Source: the Karhunen-Loeve expansion; for Gaussian processes Rasmussen, Williams (2006), section 8.1.
#pragma once

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <span>
#include <stdexcept>
#include <utility>

#include "common/learning/axle_table.hpp"

namespace gripline::learning {

/// The eigenvectors of a layer's Gram matrix over the slips of a table, the largest eigenvalue first. Stiff tyres bend
/// between two of its knots, so that more slips than those count. Layer: nodes(), add(slip, factor, span).
class CurveDirections {
 public:
  static constexpr double negligible = 1e-12;  // share of the largest eigenvalue below which a direction is left out
  template <class Layer>
  explicit CurveDirections(const Layer& layer) {
    const Eigen::Index n = layer.nodes();
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd h(n);
    constexpr std::ptrdiff_t per_knot = 10;
    for (std::ptrdiff_t i = 0; i <= (table_knots - 1) * per_knot; ++i) {
      h.setZero();
      const double slip = -table_reach + table_step * static_cast<double>(i) / per_knot;
      layer.add(slip, 1.0, {h.data(), static_cast<std::size_t>(n)});
      gram.selfadjointView<Eigen::Lower>().rankUpdate(h);
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(gram);
    vectors_ = eigen.eigenvectors().rowwise().reverse();
    values_ = eigen.eigenvalues().reverse();
  }

  /// How many are not negligible.
  Eigen::Index count() const { return (values_.array() > negligible * values_[0]).count(); }
  /// The first `count` of them [nodes][count].
  auto leading(Eigen::Index count) const { return vectors_.leftCols(count); }

 private:
  Eigen::MatrixXd vectors_;
  Eigen::VectorXd values_;
};

/// A layer whose nodes are the given directions of another one's: itself a layer.
template <class Layer>
class ReducedLayer {
 public:
  static constexpr std::size_t most_nodes = 400;  // of the layer that is reduced

  /// `directions` [nodes][count] has orthonormal columns. Throws std::invalid_argument where there are more nodes than
  /// most_nodes.
  ReducedLayer(Layer layer, const Eigen::MatrixXd& directions) : layer_(std::move(layer)), directions_(directions) {
    if (static_cast<std::size_t>(layer_.nodes()) > most_nodes) throw std::invalid_argument("too many hidden nodes");
  }

  int nodes() const { return static_cast<int>(directions_.cols()); }

  /// g += factor * g(slip); the span has nodes() elements. Allocates nothing.
  void add(double slip, double factor, std::span<double> g) const {
    project(g, [&](std::span<double> h) { layer_.add(slip, factor, h); });
  }
  /// g += factor * dg/dslip.
  void add_slope(double slip, double factor, std::span<double> g) const {
    project(g, [&](std::span<double> h) { layer_.add_slope(slip, factor, h); });
  }

  /// Weights of the layer in these coordinates, and their covariance.
  Eigen::VectorXd reduced(const Eigen::VectorXd& weights) const { return directions_.transpose() * weights; }
  Eigen::MatrixXd reduced_covariance(const Eigen::MatrixXd& covariance) const {
    return directions_.transpose() * covariance * directions_;
  }
  const Layer& layer() const { return layer_; }

 private:
  template <class Fill>
  void project(std::span<double> g, const Fill& fill) const {
    std::array<double, most_nodes> values;
    const auto n = static_cast<std::size_t>(layer_.nodes());
    std::fill_n(values.begin(), n, 0.0);
    fill(std::span(values).first(n));
    Eigen::Map<Eigen::VectorXd>(g.data(), nodes()).noalias() +=
        directions_.transpose() * Eigen::Map<const Eigen::VectorXd>(values.data(), layer_.nodes());
  }

  Layer layer_;
  Eigen::MatrixXd directions_;
};

}  // namespace gripline::learning
