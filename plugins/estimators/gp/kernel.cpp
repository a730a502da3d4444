#include "estimators/gp/kernel.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace gripline::gp {
namespace {

HyperVector to_logs(const Kernel& kernel) {
  HyperVector logs;
  for (int i = 0; i < inputs; ++i) logs[i] = std::log(kernel.length[i]);
  logs[inputs] = std::log(kernel.signal);
  logs[inputs + 1] = std::log(kernel.constant);
  logs[inputs + 2] = std::log(kernel.noise);
  return logs;
}

Kernel from_logs(const HyperVector& logs) {
  Kernel kernel;
  for (int i = 0; i < inputs; ++i) kernel.length[i] = std::exp(logs[i]);
  kernel.signal = std::exp(logs[inputs]);
  kernel.constant = std::exp(logs[inputs + 1]);
  kernel.noise = std::exp(logs[inputs + 2]);
  return kernel;
}

struct Bounds {
  HyperVector lo, hi;
};

Bounds bounds() {
  Kernel lo, hi;
  lo.length.fill(0.1);
  hi.length.fill(100.0);
  lo.signal = 1e-2;
  hi.signal = 1e3;
  lo.constant = 1e-3;
  hi.constant = 1e2;
  lo.noise = 1e-3;
  hi.noise = 1.0;
  return {to_logs(lo), to_logs(hi)};
}

/// Pairs (step, change of gradient) of the last few iterations: the two-loop recursion of Nocedal (1980).
class LimitedMemory {
 public:
  void remember(const HyperVector& step, const HyperVector& change) {
    const double curvature = step.dot(change);
    if (curvature <= 1e-10 * step.norm() * change.norm()) return;
    if (pairs_.size() == 8) pairs_.erase(pairs_.begin());
    pairs_.push_back({step, change, 1.0 / curvature});
  }
  HyperVector descent(const HyperVector& gradient) const {
    HyperVector q = -gradient;
    std::vector<double> a(pairs_.size());
    for (std::size_t i = pairs_.size(); i-- > 0;) {
      a[i] = pairs_[i].inverse * pairs_[i].step.dot(q);
      q -= a[i] * pairs_[i].change;
    }
    if (pairs_.empty())
      q *= std::min(1.0, 1.0 / gradient.norm());
    else
      q /= pairs_.back().inverse * pairs_.back().change.squaredNorm();
    for (std::size_t i = 0; i < pairs_.size(); ++i)
      q += pairs_[i].step * (a[i] - pairs_[i].inverse * pairs_[i].change.dot(q));
    return q;
  }
  void forget() { pairs_.clear(); }

 private:
  struct Pair {
    HyperVector step, change;
    double inverse;
  };
  std::vector<Pair> pairs_;
};

}  // namespace

double log_likelihood(const Kernel& kernel, const Eigen::MatrixXd& x, const Eigen::VectorXd& y, HyperVector* gradient) {
  const Eigen::Index n = x.rows();
  Eigen::MatrixXd scaled = x;
  for (int i = 0; i < inputs; ++i) scaled.col(i) /= kernel.length[i];
  Eigen::MatrixXd rbf = (2.0 * scaled * scaled.transpose()).eval();
  const Eigen::VectorXd squares = scaled.rowwise().squaredNorm();
  rbf.colwise() -= squares;
  rbf.rowwise() -= squares.transpose();
  rbf = kernel.signal * (0.5 * rbf.array().min(0.0)).exp().matrix();

  Eigen::MatrixXd covariance = rbf;
  covariance.array() += kernel.constant;
  covariance.diagonal().array() += kernel.noise;
  const Eigen::LLT<Eigen::MatrixXd> factors(covariance);
  if (factors.info() != Eigen::Success) return -std::numeric_limits<double>::infinity();
  const Eigen::VectorXd weights = factors.solve(y);
  const double half_log_determinant = factors.matrixLLT().diagonal().array().log().sum();
  if (gradient != nullptr) {
    // dL/dp = 1/2 tr((w w^T - K^-1) dK/dp)
    Eigen::MatrixXd inner = weights * weights.transpose() - factors.solve(Eigen::MatrixXd::Identity(n, n));
    (*gradient)[inputs + 1] = 0.5 * kernel.constant * inner.sum();
    (*gradient)[inputs + 2] = 0.5 * kernel.noise * inner.diagonal().sum();
    inner.array() *= rbf.array();
    (*gradient)[inputs] = 0.5 * inner.sum();
    // sum_ab M_ab (z_a - z_b)^2 = 2 (sum_a z_a^2 row_a - z^T M z) for symmetric M
    const Eigen::VectorXd rows = inner.rowwise().sum();
    const Eigen::MatrixXd product = inner * scaled;
    for (int i = 0; i < inputs; ++i)
      (*gradient)[i] = scaled.col(i).cwiseAbs2().dot(rows) - scaled.col(i).dot(product.col(i));
  }
  return -0.5 * y.dot(weights) - half_log_determinant - 0.5 * static_cast<double>(n) * std::log(2.0 * std::numbers::pi);
}

Kernel fit_kernel(const Kernel& start, const Eigen::MatrixXd& x, const Eigen::VectorXd& y, int iterations) {
  const auto [lo, hi] = bounds();
  const auto inside = [&, lo = lo, hi = hi](const HyperVector& p) -> HyperVector {
    return p.cwiseMax(lo).cwiseMin(hi);
  };
  HyperVector at = inside(to_logs(start)), slope;
  double best = log_likelihood(from_logs(at), x, y, &slope);
  slope = -slope;
  LimitedMemory memory;
  for (int i = 0; i < iterations && std::isfinite(best); ++i) {
    HyperVector direction = memory.descent(slope);
    for (int j = 0; j < hyper_count; ++j)  // a bound that is pushed against stays
      if ((at[j] <= lo[j] && direction[j] < 0) || (at[j] >= hi[j] && direction[j] > 0)) direction[j] = 0;
    if (direction.dot(slope) >= 0.0) {
      memory.forget();
      direction = memory.descent(slope);
    }
    bool moved = false;
    double length = 1.0;
    for (int shorter = 0; shorter < 10; ++shorter, length *= 0.4) {
      const HyperVector next = inside(at + length * direction);
      HyperVector next_slope;
      const double value = log_likelihood(from_logs(next), x, y, &next_slope);
      if (!(value > best + 1e-4 * std::abs(slope.dot(next - at)))) continue;
      next_slope = -next_slope;
      memory.remember(next - at, next_slope - slope);
      moved = value > best + 1e-6 * std::abs(best);
      at = next;
      slope = next_slope;
      best = value;
      break;
    }
    if (!moved) break;
  }
  return from_logs(at);
}

}  // namespace gripline::gp
