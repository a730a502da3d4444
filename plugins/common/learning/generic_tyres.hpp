// A hidden layer of generic tyres: node j is the odd, saturating curve sin(C_j atan(B_j slip)) of a tyre drawn from
// commonly known ranges. The prior of the output weights states that the tyre is one of these, at about a given
// friction.
//
// With weights w the force over the axle's load is sum_j w_j h_j(slip). If the tyre is node j with friction D, and j is
// equally likely for all n nodes, the weights have mean E(D)/n each and covariance E(D^2)/n I - E(D)^2/n^2 1 1^T. This
// prior carries what is measured at the slips a car visits over to the others: the peak is extrapolated as the generic
// tyres suggest, with a standard deviation. The nodes are drawn from general knowledge of tyres, never from the true
// tyre.
//
// Source of the curve: Bakker, Nyborg, Pacejka (1987), with E = 0.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <span>

#include "common/learning/hidden_layer.hpp"

namespace gripline::learning {

struct TyrePrior {
  double stiffness = 6.0, stiffness_spread = 0.7;  // median of B [1/rad] and standard deviation of its logarithm
  double shape = 1.4, shape_spread = 0.2;          // mean and standard deviation of C, at least 1.05
  double friction = 1.0, friction_spread = 0.3;    // mean of D over load, standard deviation relative to it
};

class GenericTyres {
 public:
  /// Nodes spread evenly over the prior (an additive recurrence), shifted by the seed.
  GenericTyres(int nodes, const TyrePrior& prior, SplitMix64& random) : B_(nodes), C_(nodes), prior_(prior) {
    double u = random.uniform(0, 1), v = random.uniform(0, 1);
    for (int j = 0; j < nodes; ++j) {
      u = std::fmod(u + 0.7548776662466927, 1.0);
      v = std::fmod(v + 0.5698402909980532, 1.0);
      B_[j] = prior.stiffness * std::exp(prior.stiffness_spread * normal_quantile(u));
      C_[j] = std::max(1.05, prior.shape + prior.shape_spread * normal_quantile(v));
    }
  }

  int nodes() const { return static_cast<int>(B_.size()); }

  /// h += factor * h(slip).
  void add(double slip, double factor, std::span<double> h) const {
    for (std::size_t j = 0; j < h.size(); ++j) h[j] += factor * std::sin(C_[j] * std::atan(B_[j] * slip));
  }
  /// h += factor * dh/dslip.
  void add_slope(double slip, double factor, std::span<double> h) const {
    for (std::size_t j = 0; j < h.size(); ++j) {
      const double x = B_[j] * slip;
      h[j] += factor * std::cos(C_[j] * std::atan(x)) * C_[j] * B_[j] / (1.0 + x * x);
    }
  }

  double prior_mean() const { return prior_.friction / nodes(); }
  Eigen::MatrixXd prior_covariance() const {
    const double n = nodes(), mean = prior_.friction;
    const double square = mean * mean * (1.0 + prior_.friction_spread * prior_.friction_spread);
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Constant(nodes(), nodes(), -mean * mean / (n * n));
    covariance.diagonal().array() += square / n;
    return covariance;
  }

 private:
  /// Inverse of the normal distribution function, to 4.5e-4 (Abramowitz, Stegun 26.2.23), which suffices for drawing
  /// nodes.
  static double normal_quantile(double p) {
    const double q = std::min(std::max(p, 1e-4), 1 - 1e-4);
    const double t = std::sqrt(-2.0 * std::log(std::min(q, 1.0 - q)));
    const double x =
        t - (2.515517 + t * (0.802853 + t * 0.010328)) / (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
    return q < 0.5 ? -x : x;
  }

  std::vector<double> B_, C_;
  TyrePrior prior_;
};

}  // namespace gripline::learning
