#include "planners/time_optimal/tyre_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gripline::time_optimal {
namespace {

constexpr int grid = 24;
constexpr double floor_share = 0.02;  // no curve is trusted better than this share of the peak

MagicFormula shape_of(const Eigen::Vector3d& p) { return {std::exp(p[0]), p[1], std::exp(p[2])}; }

/// Residual and its gradient by (ln B, C, ln D) of one point.
struct Residual {
  double r = 0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};
Residual residual(const MagicFormula& t, double slip, double force, double scale) {
  const double angle = std::atan(t.B * slip), sine = std::sin(t.C * angle), cosine = std::cos(t.C * angle);
  const double by_log_B = t.D * cosine * t.C * t.B * slip / (1.0 + square(t.B * slip));
  return {(t.D * sine - force) / scale, Eigen::Vector3d(by_log_B, t.D * cosine * angle, t.D * sine) / scale};
}

/// A sum of squares, its Gauss-Newton matrix and half its gradient.
struct SquareSum {
  double total = 0;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

/// What fit_axle() minimises: residuals of the points and of the prior on (ln B, C, ln D).
class AxleFitCost {
 public:
  /// Of at most `grid` points.
  AxleFitCost(std::span<const double> slip, std::span<const double> force, std::span<const double> sigma,
              const AxlePrior& prior)
      : slip_(slip),
        force_(force),
        start_(std::log(prior.shape.B), prior.shape.C, std::log(prior.shape.D)),
        spread_(0.5, 0.2, prior.sigma_D) {
    if (slip_.size() > scale_.size()) throw std::invalid_argument("fit_axle() takes at most 24 points");
    for (std::size_t i = 0; i < slip_.size(); ++i)
      scale_[i] = std::hypot(i < sigma.size() ? sigma[i] : 0.0, floor_share * prior.shape.D);
  }

  const Eigen::Vector3d& start() const { return start_; }
  SquareSum at(const Eigen::Vector3d& p) const {
    const MagicFormula shape = shape_of(p);
    SquareSum sum;
    for (std::size_t i = 0; i < slip_.size(); ++i) {
      const Residual one = residual(shape, slip_[i], force_[i], scale_[i]);
      sum.total += one.r * one.r;
      sum.normal += one.gradient * one.gradient.transpose();
      sum.gradient += one.gradient * one.r;
    }
    const Eigen::Vector3d off = (p - start_).cwiseQuotient(spread_);
    sum.normal.diagonal() += spread_.cwiseProduct(spread_).cwiseInverse();
    sum.gradient += off.cwiseQuotient(spread_);
    sum.total += off.squaredNorm();
    return sum;
  }

 private:
  std::span<const double> slip_, force_;
  std::array<double, grid> scale_{};  // of the points' residuals
  Eigen::Vector3d start_, spread_;
};

}  // namespace

void SlipRange::add(double slip) {
  const auto i = static_cast<std::size_t>(std::min(std::abs(slip) / bin, static_cast<double>(counts_.size() - 1)));
  counts_[i] += 1.0;
  total_ += 1.0;
}

double SlipRange::visited() const {
  double below = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    below += counts_[i];
    if (below >= 0.995 * total_) return bin * static_cast<double>(i + 1);
  }
  return bin * static_cast<double>(counts_.size());
}

MagicFormula fit_axle(std::span<const double> slip, std::span<const double> force, std::span<const double> sigma,
                      const AxlePrior& prior) {
  const AxleFitCost cost(slip, force, sigma, prior);
  Eigen::Vector3d p = cost.start();
  SquareSum here = cost.at(p);
  // Beyond 2 a curve turns negative at large slips: only as far as the prior says so.
  const double largest_C = std::max(2.0, prior.shape.C);
  double damping = 1e-3;
  for (int iteration = 0; iteration < 20; ++iteration) {
    Eigen::Matrix3d normal = here.normal;
    normal.diagonal() *= 1.0 + damping;
    Eigen::Vector3d trial = p - normal.ldlt().solve(here.gradient);
    trial[1] = std::clamp(trial[1], 1.0, largest_C);
    trial[0] = std::clamp(trial[0], cost.start()[0] - 2.0, cost.start()[0] + 2.0);
    const SquareSum tried = cost.at(trial);
    if (tried.total < here.total) {
      constexpr double settled = 1e-9;  // of the sum of squares
      if (damping <= 1.0 && here.total - tried.total < settled * here.total) return shape_of(trial);
      p = trial;
      here = tried;
      damping *= 0.3;
    } else {
      damping *= 10.0;
    }
  }
  return shape_of(p);
}

MagicFormula fit_learned(const TyreCurve& learned, Axle axle, double mass, double visited, const AxlePrior& prior) {
  std::array<double, 2 * grid> slip{}, force{}, sigma{};
  for (std::size_t i = 0; i < grid; ++i) {
    slip[i] = visited * static_cast<double>(i + 1) / grid;
    slip[grid + i] = -slip[i];
  }
  if (!learned.tyre_force(axle, slip, force, sigma)) return prior.shape;
  for (std::size_t i = 0; i < grid; ++i) {
    force[i] = 0.5 * (force[i] - force[grid + i]) / mass;
    sigma[i] = 0.5 * std::hypot(sigma[i], sigma[grid + i]) / mass;
    if (!std::isfinite(force[i]) || !std::isfinite(sigma[i])) return prior.shape;
  }
  return fit_axle(std::span(slip).first(grid), std::span(force).first(grid), std::span(sigma).first(grid), prior);
}

double difference(const AxleTyres& a, const AxleTyres& b, double range) {
  double largest = 0;
  for (int i = 1; i <= grid; ++i) {
    const double slip = range * i / grid;
    largest = std::max(largest, std::abs(a.front.force(slip) - b.front.force(slip)) / a.front.D);
    largest = std::max(largest, std::abs(a.rear.force(slip) - b.rear.force(slip)) / a.rear.D);
  }
  return largest;
}

}  // namespace gripline::time_optimal
