#include "controllers/mpc_sqp/globalization.hpp"

#include <algorithm>
#include <cmath>

namespace gripline::mpc_sqp {

void MeritFunction::reset() { std::fill(weights_.begin(), weights_.end(), 0.0); }

void MeritFunction::update_weights(const double* pi, int ldpi) {
  for (std::size_t i = 0; i < weights_.size(); ++i) {
    double largest = 0;
    for (int k = 1; k <= N_; ++k) largest = std::max(largest, std::abs(pi[static_cast<std::size_t>(k * ldpi) + i]));
    double& weight = weights_[i];
    weight = std::max(0.5 * (weight + 1.5 * largest), 1.5 * largest);
  }
}

double MeritFunction::defects(const NlpIterate& at) const {
  const std::size_t n = weights_.size();
  double total = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(N_); ++k) {
    for (std::size_t i = 0; i < n; ++i) total += weights_[i] * std::abs(at.x_next[k * n + i] - at.x[(k + 1) * n + i]);
  }
  return total;
}

void LevenbergMarquardt::update(double alpha, double predicted_decrease, double squared_step) {
  if (alpha == 1) {
    // Not from this step: a damped one is short, and would ask for more damping.
    relative_ = relative_ < 0.1 * first ? 0 : relative_ / factor;
    damping_ = relative_ > 0 ? damping_ / factor : 0;
    return;
  }
  relative_ = std::max(first, relative_ * factor);
  damping_ = std::max(damping_, relative_ * std::abs(predicted_decrease) / std::max(squared_step, 1e-12));
}

}  // namespace gripline::mpc_sqp
