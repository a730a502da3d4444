// Globalization of the SQP method, for convergence from any start: a merit function with backtracking, and damping of
// the steps that follow a shortened one.
//
// Merit: cost + sum_i weight_i |defect_i| (Han 1977). It is exact, and the quadratic program's solution a descent of
// it, when a weight exceeds the multipliers of its defects. The cost is convex and the linearised defects vanish at a
// full step, so the predicted decrease of a step of length alpha is alpha times that of the full one.
#pragma once

#include <span>
#include <vector>

#include "controllers/mpc_sqp/ocp_nlp.hpp"

namespace gripline::mpc_sqp {

class MeritFunction {
 public:
  MeritFunction(int N, int nx) : N_(N), weights_(static_cast<std::size_t>(nx)) {}

  /// All weights zero.
  void reset();
  /// Raises the weights above the multipliers pi_k at pi + k ldpi, k = 1 .. N; falls half-way towards them where they
  /// are lower.
  void update_weights(const double* pi, int ldpi);
  double operator()(const NlpIterate& at) const { return at.cost + defects(at); }
  std::span<const double> weights() const { return weights_; }

 private:
  double defects(const NlpIterate& at) const;

  int N_;
  std::vector<double> weights_;  // of a unit of defect, per state
};

/// Backtracking: the share of the predicted fall of the merit that a step must bring, and halvings before it is given
/// up.
inline constexpr double sufficient_decrease = 0.1;
inline constexpr int max_backtracks = 7;

/// A cost of squared input steps, raised after every shortened step and lowered after every full one (Levenberg 1944).
class LevenbergMarquardt {
 public:
  void reset() { *this = {}; }
  /// Cost of a squared step of the inputs in units of their ranges.
  double damping() const { return damping_; }
  bool at_largest() const { return relative_ >= largest; }
  /// After a step of length `alpha` (0: none was found) that was to lower the merit by `predicted_decrease`, with the
  /// sum of squares `squared_step` of its inputs in units of their ranges.
  void update(double alpha, double predicted_decrease, double squared_step);

 private:
  static constexpr double first = 0.1, factor = 10, largest = 1e4;  // relative to the curvature that the last step met
  double relative_ = 0, damping_ = 0;
};

}  // namespace gripline::mpc_sqp
