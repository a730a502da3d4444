#include "geometry/cyclic_box_qp.hpp"

#include <algorithm>
#include <cmath>

namespace gripline {

std::vector<double> CyclicPentadiagonal::multiply(std::span<const double> x) const {
  const std::size_t n = size();
  std::vector<double> y(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = (i + 1) % n, k = (i + 2) % n;
    y[i] += diagonal[i] * x[i] + next[i] * x[j] + second[i] * x[k];
    y[j] += next[i] * x[i];
    y[k] += second[i] * x[i];
  }
  return y;
}

CyclicPentadiagonalFactor::CyclicPentadiagonalFactor(const CyclicPentadiagonal& a) {
  const std::size_t n = a.size(), m = n - 2;
  pivot_.resize(m);
  first_.assign(m, 0.0);
  second_.assign(m, 0.0);
  for (std::size_t i = 0; i < m; ++i) {
    double pivot = a.diagonal[i];
    if (i >= 2) {
      second_[i] = a.second[i - 2] / pivot_[i - 2];
      pivot -= second_[i] * second_[i] * pivot_[i - 2];
    }
    if (i >= 1) {
      first_[i] = a.next[i - 1];
      if (i >= 2) first_[i] -= second_[i] * pivot_[i - 2] * first_[i - 1];
      first_[i] /= pivot_[i - 1];
      pivot -= first_[i] * first_[i] * pivot_[i - 1];
    }
    pivot_[i] = pivot;
  }
  column_u_.assign(m, 0.0);
  column_v_.assign(m, 0.0);
  column_u_[m - 1] = a.next[m - 1];
  column_u_[m - 2] = a.second[m - 2];
  column_u_[0] += a.second[n - 2];
  column_v_[m - 1] = a.second[m - 1];
  column_v_[0] += a.next[n - 1];
  column_v_[1] += a.second[n - 1];
  border_u_ = column_u_;
  border_v_ = column_v_;
  solve_band(border_u_, border_v_);
  schur_uu_ = a.diagonal[n - 2];
  schur_uv_ = a.next[n - 2];
  schur_vv_ = a.diagonal[n - 1];
  for (std::size_t i = 0; i < m; ++i) {
    schur_uu_ -= column_u_[i] * border_u_[i];
    schur_uv_ -= column_u_[i] * border_v_[i];
    schur_vv_ -= column_v_[i] * border_v_[i];
  }
}

void CyclicPentadiagonalFactor::solve_band(std::span<double> x) const {
  const std::size_t m = pivot_.size();
  for (std::size_t i = 1; i < m; ++i) {
    x[i] -= first_[i] * x[i - 1];
    if (i >= 2) x[i] -= second_[i] * x[i - 2];
  }
  for (std::size_t i = 0; i < m; ++i) x[i] /= pivot_[i];
  for (std::size_t i = m; i-- > 0;) {
    if (i + 1 < m) x[i] -= first_[i + 1] * x[i + 1];
    if (i + 2 < m) x[i] -= second_[i + 2] * x[i + 2];
  }
}

/// Solves for two right-hand sides at once: a CPU works on one while the other waits for its previous element.
void CyclicPentadiagonalFactor::solve_band(std::span<double> x, std::span<double> y) const {
  const std::size_t m = pivot_.size();
  for (std::size_t i = 1; i < m; ++i) {
    x[i] -= first_[i] * x[i - 1];
    y[i] -= first_[i] * y[i - 1];
    if (i < 2) continue;
    x[i] -= second_[i] * x[i - 2];
    y[i] -= second_[i] * y[i - 2];
  }
  for (std::size_t i = 0; i < m; ++i) {
    x[i] /= pivot_[i];
    y[i] /= pivot_[i];
  }
  for (std::size_t i = m; i-- > 0;) {
    if (i + 1 < m) {
      x[i] -= first_[i + 1] * x[i + 1];
      y[i] -= first_[i + 1] * y[i + 1];
    }
    if (i + 2 < m) {
      x[i] -= second_[i + 2] * x[i + 2];
      y[i] -= second_[i + 2] * y[i + 2];
    }
  }
}

void CyclicPentadiagonalFactor::solve(std::span<double> x) const {
  const std::size_t m = pivot_.size();
  solve_band(x.first(m));
  double u = x[m], v = x[m + 1];
  for (std::size_t i = 0; i < m; ++i) {
    u -= column_u_[i] * x[i];
    v -= column_v_[i] * x[i];
  }
  const double determinant = schur_uu_ * schur_vv_ - schur_uv_ * schur_uv_;
  x[m] = (schur_vv_ * u - schur_uv_ * v) / determinant;
  x[m + 1] = (schur_uu_ * v - schur_uv_ * u) / determinant;
  for (std::size_t i = 0; i < m; ++i) x[i] -= border_u_[i] * x[m] + border_v_[i] * x[m + 1];
}

namespace {

/// Iterate of the interior point method: slack to both bounds, and their multipliers.
struct Interior {
  std::vector<double> x, low, high, force_low, force_high;

  double complementarity() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += low[i] * force_low[i] + high[i] * force_high[i];
    return sum / (2.0 * static_cast<double>(x.size()));
  }
};

struct Direction {
  std::vector<double> x, force_low, force_high;
};

/// Newton direction towards complementarity `target`, with Mehrotra's second-order terms from `predictor` if given.
Direction newton(const Interior& at, const CyclicPentadiagonalFactor& factor, std::span<const double> dual_residual,
                 double target, const Direction* predictor) {
  const std::size_t n = at.x.size();
  Direction step{std::vector<double>(n), std::vector<double>(n), std::vector<double>(n)};
  for (std::size_t i = 0; i < n; ++i) {
    const double second_low = predictor ? predictor->x[i] * predictor->force_low[i] : 0.0;
    const double second_high = predictor ? -predictor->x[i] * predictor->force_high[i] : 0.0;
    step.force_low[i] = (target - second_low) / at.low[i] - at.force_low[i];
    step.force_high[i] = (target - second_high) / at.high[i] - at.force_high[i];
    step.x[i] = -dual_residual[i] + step.force_low[i] - step.force_high[i];
  }
  factor.solve(step.x);
  for (std::size_t i = 0; i < n; ++i) {
    step.force_low[i] -= at.force_low[i] / at.low[i] * step.x[i];
    step.force_high[i] += at.force_high[i] / at.high[i] * step.x[i];
  }
  return step;
}

double longest_step(const Interior& at, const Direction& step) {
  double longest = 1.0;
  const auto limit = [&longest](double value, double change) {
    if (change < 0.0) longest = std::min(longest, -value / change);
  };
  for (std::size_t i = 0; i < at.x.size(); ++i) {
    limit(at.low[i], step.x[i]);
    limit(at.high[i], -step.x[i]);
    limit(at.force_low[i], step.force_low[i]);
    limit(at.force_high[i], step.force_high[i]);
  }
  return longest;
}

void advance(Interior& at, const Direction& step, double share) {
  for (std::size_t i = 0; i < at.x.size(); ++i) {
    at.x[i] += share * step.x[i];
    at.low[i] += share * step.x[i];
    at.high[i] -= share * step.x[i];
    at.force_low[i] += share * step.force_low[i];
    at.force_high[i] += share * step.force_high[i];
  }
}

Interior starting_point(std::span<const double> gradient, std::span<const double> lower,
                        std::span<const double> upper) {
  const std::size_t n = gradient.size();
  double force = 0.0;
  for (const double g : gradient) force = std::max(force, std::abs(g));
  Interior at{std::vector<double>(n), std::vector<double>(n), std::vector<double>(n), std::vector<double>(n),
              std::vector<double>(n)};
  for (std::size_t i = 0; i < n; ++i) {
    const double room = 0.1 * (upper[i] - lower[i]);
    at.x[i] = std::clamp(0.0, lower[i] + room, upper[i] - room);
    at.low[i] = at.x[i] - lower[i];
    at.high[i] = upper[i] - at.x[i];
    at.force_low[i] = at.force_high[i] = std::max(force, 1e-12);
  }
  return at;
}

}  // namespace

std::vector<double> solve_cyclic_box_qp(const CyclicPentadiagonal& hessian, std::span<const double> gradient,
                                        std::span<const double> lower, std::span<const double> upper,
                                        double tolerance) {
  constexpr int most_iterations = 80;
  const std::size_t n = gradient.size();
  Interior at = starting_point(gradient, lower, upper);
  const double scale = at.complementarity();
  CyclicPentadiagonal matrix(n);
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    std::vector<double> residual = hessian.multiply(at.x);
    double worst = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      residual[i] += gradient[i] - at.force_low[i] + at.force_high[i];
      worst = std::max(worst, std::abs(residual[i]));
    }
    const double mu = at.complementarity();
    if (mu <= tolerance * scale &&
        worst <= std::sqrt(tolerance) * (1e-30 + *std::max_element(at.force_low.begin(), at.force_low.end())))
      break;
    if (mu <= 1e-6 * tolerance * scale) break;  // rounding keeps the residual up: no better answer will come

    matrix = hessian;
    for (std::size_t i = 0; i < n; ++i)
      matrix.diagonal[i] += at.force_low[i] / at.low[i] + at.force_high[i] / at.high[i];
    const CyclicPentadiagonalFactor factor(matrix);
    const Direction predictor = newton(at, factor, residual, 0.0, nullptr);
    Interior probe = at;
    advance(probe, predictor, longest_step(at, predictor));
    const double ratio = probe.complementarity() / mu;
    const Direction step = newton(at, factor, residual, ratio * ratio * ratio * mu, &predictor);
    advance(at, step, std::min(1.0, 0.995 * longest_step(at, step)));
  }
  return at.x;
}

}  // namespace gripline
