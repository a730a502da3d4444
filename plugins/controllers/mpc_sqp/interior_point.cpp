#include "controllers/mpc_sqp/interior_point.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gripline::ocp {
namespace {

constexpr int bounds_per_stage = 2 * row_count;

/// Calls f(index of the bound) for every soft bound.
template <class F>
void for_soft_bounds(int horizon, F f) {
  for (int k = 1; k <= horizon; ++k) {
    f(bounds_per_stage * k + row_soft);
    f(bounds_per_stage * k + row_count + row_soft);
  }
}

}  // namespace

InteriorPoint::InteriorPoint(int horizon, int states)
    : iterate_(horizon, states), terms_(horizon), side_(terms_.weight.size(), Side::free), horizon_(horizon) {
  const std::size_t size = static_cast<std::size_t>(bounds_per_stage) * static_cast<std::size_t>(horizon + 1);
  for (Buffer* buffer : {&sign_, &bound_, &t_, &l_, &t_next_, &l_next_, &rho_, &e_, &eps_, &n_, &eps_next_, &n_next_,
                         &w_, &g_, &width_, &force_}) {
    *buffer = Buffer(size);
  }
}

void InteriorPoint::start(const OcpQp& qp, Riccati& riccati, Point& point) {
  soft_quadratic_ = qp.soft_quadratic;
  soft_linear_ = qp.soft_linear;
  kinked_ = soft_linear_ > 0;
  set_bounds(qp, point);
  // A barrier as stiff as the problem itself, aimed at its centre ...
  const double mean = set_pairs(point);
  complementarity_ = complementarity(0);
  std::copy_n(point.z.data(), point.z.size(), iterate_.z.data());
  std::copy_n(point.v.data(), point.v.size(), iterate_.v.data());
  // ... shows what the problem asks for; the pairs start there, as far inside as the worst of them lies outside.
  if (solve(qp, riccati, point, mean, 0)) {
    std::copy_n(point.z.data(), point.z.size(), iterate_.z.data());
    std::copy_n(point.v.data(), point.v.size(), iterate_.v.data());
    double outside_t = 0, outside_l = 0;
    for (std::size_t i = 0; i < t_.size(); ++i) {
      if (sign_.data()[i] == 0) continue;
      outside_t = std::max(outside_t, -t_next_.data()[i] / width_.data()[i]);
      outside_l = std::max(outside_l, -l_next_.data()[i] / force_.data()[i]);
    }
    for (std::size_t i = 0; i < t_.size(); ++i) {
      if (sign_.data()[i] == 0) continue;
      t_.data()[i] = t_next_.data()[i] + (0.1 + 1.5 * outside_t) * width_.data()[i];
      l_.data()[i] = l_next_.data()[i] + (0.1 + 1.5 * outside_l) * force_.data()[i];
    }
  }
  iterations_ = 0;
  suggested_ = false;
  std::fill(side_.begin(), side_.end(), Side::free);
  complementarity_ = complementarity(0);
  infeasibility_ = 1;
}

/// The bounds of `qp` with their units; distances from the point's rows, no less than a share of a row's width.
void InteriorPoint::set_bounds(const OcpQp& qp, Point& point) {
  if (!point.finite()) {
    std::fill_n(point.z.data() + point.width, point.z.size() - static_cast<std::size_t>(point.width), 0.0);
    std::fill_n(point.v.data(), point.v.size(), 0.0);
  }
  pairs_ = 0;
  for (int k = 0; k <= horizon_; ++k) {
    for (int r = 0; r < row_count; ++r) {
      const int row = row_count * k + r;
      const double width = row_width(qp.lower(k)[r], qp.upper(k)[r]);
      for (const bool is_upper : {false, true}) {
        const int i = bounds_per_stage * k + (is_upper ? row_count : 0) + r;
        // A row that is fixed has no interior; it is given one too small to matter.
        const double room = qp.upper(k)[r] - qp.lower(k)[r] < 1e-7 ? 1e-7 : 0.0;
        const double bound = (is_upper ? qp.upper(k)[r] : -qp.lower(k)[r]) + room;
        const bool exists = has_row(k, horizon_, r) && std::isfinite(bound);
        sign_.data()[i] = exists ? (is_upper ? 1.0 : -1.0) : 0.0;
        bound_.data()[i] = exists ? bound : 1.0;
        width_.data()[i] = width;
        force_.data()[i] = point.stiffness.data()[row] * width;
        t_.data()[i] = exists ? std::max(bound - sign_.data()[i] * point.v.data()[row], 0.05 * width) : 1.0;
        l_.data()[i] = 1;
        rho_.data()[i] = exists && r == row_soft ? 0.5 / soft_quadratic_ : 0.0;
        e_.data()[i] = 0;
        if (exists) ++pairs_;
      }
    }
  }
}

/// Multipliers for the distances, all pairs at one complementarity, which is returned. Its scale is a logarithmic mean,
/// since stiffness may differ by orders of magnitude along the horizon.
double InteriorPoint::set_pairs(const Point& point) {
  double total = 0;
  for (std::size_t i = 0; i < t_.size(); ++i) {
    if (sign_.data()[i] != 0) total += std::log(force_.data()[i] / width_.data()[i] * t_.data()[i] * t_.data()[i]);
  }
  const double mean = pairs_ > 0 ? std::exp(total / pairs_) : 1.0;
  for (std::size_t i = 0; i < t_.size(); ++i) {
    if (sign_.data()[i] == 0) continue;
    if (i % row_count == row_soft && !kinked_) {
      // t l = mean and t = b - c v + l / 2S at once.
      const double v = point.v.data()[i / bounds_per_stage * row_count + row_soft];
      const double excess = sign_.data()[i] * v - bound_.data()[i];
      const double root = std::sqrt(excess * excess + 2 * mean / soft_quadratic_);
      t_.data()[i] = excess > 0 ? mean / (soft_quadratic_ * (excess + root)) : 0.5 * (root - excess);
    }
    l_.data()[i] = mean / t_.data()[i];
  }
  if (kinked_) {
    for_soft_bounds(horizon_, [&](int i) {
      if (sign_.data()[i] == 0) return;
      // eps n = mean with n = s + 2 S eps, of which the multiplier takes at most half.
      const double s = soft_linear_, q = 2 * soft_quadratic_;
      const double eps = 2 * mean / (s + std::sqrt(s * s + 4 * q * mean));
      l_.data()[i] = std::min(l_.data()[i], 0.5 * (s + q * eps));
      eps_.data()[i] = eps;
      n_.data()[i] = s + q * eps - l_.data()[i];
      ++pairs_;
    });
  }
  // No predictor yet.
  for (const auto& [next, now] : {std::pair{&t_next_, &t_}, {&l_next_, &l_}, {&eps_next_, &eps_}, {&n_next_, &n_}}) {
    std::copy_n(now->data(), now->size(), next->data());
  }
  return mean;
}

/// eps+ = rho l+ + e from the linearised conditions 2 S eps+ + s - l+ - n+ = 0 and eps n+ + n eps+ = r + eps n.
void InteriorPoint::set_slack_terms(double target, double second_order) {
  for_soft_bounds(horizon_, [&](int i) {
    if (sign_.data()[i] == 0) return;
    const double eps = eps_.data()[i], n = n_.data()[i];
    const double r = target - second_order * (eps_next_.data()[i] - eps) * (n_next_.data()[i] - n);
    const double scale = 1.0 / (n + 2 * soft_quadratic_ * eps);
    rho_.data()[i] = eps * scale;
    e_.data()[i] = (r + eps * (n - soft_linear_)) * scale;
  });
}

void InteriorPoint::set_terms(double target, double second_order) {
  if (kinked_) set_slack_terms(target, second_order);
  const Vec4 aim = all(target), share = all(second_order);
  for (int k = 0; k <= horizon_; ++k) {
    Vec4 weight{}, shift{};
    for (int i = bounds_per_stage * k; i < bounds_per_stage * (k + 1); i += row_count) {
      const Vec4 t = vec4(t_.data() + i), l = vec4(l_.data() + i), c = vec4(sign_.data() + i);
      const Vec4 r = aim - share * (vec4(t_next_.data() + i) - t) * (vec4(l_next_.data() + i) - l);
      const Vec4 scale = 1.0 / (t + vec4(rho_.data() + i) * l);
      const Vec4 w = c * c * l * scale;
      const Vec4 g = w * (t - vec4(bound_.data() + i) - vec4(e_.data() + i)) + r * scale;
      vec4(w_.data() + i) = w;
      vec4(g_.data() + i) = c != 0.0 ? g : all(1.0);
      weight += w;
      shift += c * g;
    }
    vec4(terms_.weight.data() + row_count * k) = weight;
    vec4(terms_.shift.data() + row_count * k) = shift;
  }
}

void InteriorPoint::set_candidate(const Point& point) {
  for (int k = 0; k <= horizon_; ++k) {
    const Vec4 v = vec4(point.v.data() + row_count * k);
    for (int i = bounds_per_stage * k; i < bounds_per_stage * (k + 1); i += row_count) {
      const Vec4 cv = vec4(sign_.data() + i) * v;
      const Vec4 l = vec4(w_.data() + i) * cv + vec4(g_.data() + i);
      vec4(l_next_.data() + i) = l;
      vec4(t_next_.data() + i) = vec4(bound_.data() + i) + vec4(e_.data() + i) + vec4(rho_.data() + i) * l - cv;
    }
  }
  if (!kinked_) return;
  for_soft_bounds(horizon_, [&](int i) {
    if (sign_.data()[i] == 0) return;
    eps_next_.data()[i] = rho_.data()[i] * l_next_.data()[i] + e_.data()[i];
    n_next_.data()[i] = 2 * soft_quadratic_ * eps_next_.data()[i] + soft_linear_ - l_next_.data()[i];
  });
}

/// The longest step that keeps every pair positive, at most 1.
double InteriorPoint::step_length() const {
  Vec4 worst{};
  for (std::size_t i = 0; i < t_.size(); i += 4) {
    const Vec4 t = vec4(t_.data() + i), l = vec4(l_.data() + i);
    worst = max(worst, max(1.0 - vec4(t_next_.data() + i) / t, 1.0 - vec4(l_next_.data() + i) / l));
  }
  double ratio = largest(worst);
  if (kinked_) {
    for_soft_bounds(horizon_, [&](int i) {
      if (sign_.data()[i] == 0) return;
      ratio = std::max({ratio, 1.0 - eps_next_.data()[i] / eps_.data()[i], 1.0 - n_next_.data()[i] / n_.data()[i]});
    });
  }
  return ratio > 1.0 ? 1.0 / ratio : 1.0;
}

/// The mean product of the pairs after a step.
double InteriorPoint::complementarity(double step) const {
  const auto after = [step](double now, double next) { return now + step * (next - now); };
  Vec4 total{};
  for (std::size_t i = 0; i < t_.size(); i += 4) {
    const Vec4 t = vec4(t_.data() + i), l = vec4(l_.data() + i), c = vec4(sign_.data() + i);
    total += c * c * (t + step * (vec4(t_next_.data() + i) - t)) * (l + step * (vec4(l_next_.data() + i) - l));
  }
  double kinks = 0;
  if (kinked_) {
    for_soft_bounds(horizon_, [&](int i) {
      if (sign_.data()[i] == 0) return;
      kinks += after(eps_.data()[i], eps_next_.data()[i]) * after(n_.data()[i], n_next_.data()[i]);
    });
  }
  return pairs_ > 0 ? (sum(total) + kinks) / pairs_ : 0.0;
}

/// The largest distance, or multiplier if that is smaller, in the row's units.
double InteriorPoint::worst_pair() const {
  double worst = 0;
  for (std::size_t i = 0; i < t_.size(); ++i) {
    const double t = t_.data()[i] / width_.data()[i], l = l_.data()[i] / force_.data()[i];
    if (sign_.data()[i] != 0) worst = std::max(worst, std::min(t, l));
  }
  return worst;
}

void InteriorPoint::advance(const Point& point, double step) {
  const auto move = [step](Buffer& now, const Buffer& next) {
    for (std::size_t i = 0; i < now.size(); i += 4) {
      vec4(now.data() + i) += step * (vec4(next.data() + i) - vec4(now.data() + i));
    }
  };
  move(iterate_.z, point.z);
  move(iterate_.v, point.v);
  move(t_, t_next_);
  move(l_, l_next_);
  if (kinked_) {
    move(eps_, eps_next_);
    move(n_, n_next_);
  }
}

bool InteriorPoint::solve(const OcpQp& qp, Riccati& riccati, Point& point, double target, double second_order) {
  set_terms(target, second_order);
  if (second_order == 0 && !riccati.factor(qp.links, terms_)) return false;
  riccati.solve(qp.links, terms_, point.z.data(), point.v.data());
  set_candidate(point);
  return point.finite();
}

InteriorPoint::State InteriorPoint::iterate(const OcpQp& qp, Riccati& riccati, Point& point, double tolerance,
                                            int iterations) {
  const auto solve = [&](double target, double second_order) {
    return this->solve(qp, riccati, point, target, second_order);
  };
  for (int left = iterations; left > 0; --left) {
    if (!solve(0, 0)) return State::failed;
    if (infeasibility_ <= tolerance && worst_pair() <= tolerance) return State::converged;
    if (infeasibility_ < 0.1 && sides_repeat()) return State::suggests;
    ++iterations_;
    const double ratio = complementarity(step_length()) / complementarity_;
    if (!solve(ratio * ratio * ratio * complementarity_, 1)) return State::failed;
    const double step = std::min(1.0, 0.995 * step_length());
    if (!(step > 1e-2) && stalled() == State::converged) return State::converged;
    if (!(step > 1e-8)) return State::failed;
    advance(point, step);
    infeasibility_ *= 1 - step;
    complementarity_ = complementarity(0);
  }
  return stalled();
}

/// Rounding ends the progress of programs whose multipliers span many orders of magnitude. Well inside a thousandth of a
/// row's width and force that is a solution, if a coarse one.
InteriorPoint::State InteriorPoint::stalled() const {
  return infeasibility_ <= 1e-6 && worst_pair() <= 1e-4 ? State::converged : State::failed;
}

/// Whether the predictor moves a row to the same side as the predictor before it did, for all rows, and so for the first
/// time: of a pair, the one that tends to zero shrinks more.
bool InteriorPoint::sides_repeat() {
  int changes = 0;
  for (int k = 0; k <= horizon_; ++k) {
    for (int r = 0; r < row_count; ++r) {
      Side now = Side::free;
      for (const bool is_upper : {false, true}) {
        const int i = bounds_per_stage * k + (is_upper ? row_count : 0) + r;
        if (sign_.data()[i] == 0) continue;
        const bool held = l_next_.data()[i] * t_.data()[i] > t_next_.data()[i] * l_.data()[i];
        if (!held) continue;
        now = is_upper ? Side::at_upper : Side::at_lower;
        if (r == row_soft && (!kinked_ || eps_next_.data()[i] * n_.data()[i] > n_next_.data()[i] * eps_.data()[i])) {
          now = is_upper ? Side::past_upper : Side::past_lower;
        }
      }
      Side& before = side_[row_count * k + r];
      changes += before != now;
      before = now;
    }
  }
  const bool repeated = changes == 0 && !suggested_;
  suggested_ = changes == 0;
  return repeated;
}

void InteriorPoint::suggestion(Point& point) const {
  point.side = side_;
  for (std::size_t i = 0; i < side_.size(); ++i) {
    const std::size_t bound = i / row_count * bounds_per_stage + i % row_count;
    const int side = static_cast<int>(side_[i]);
    point.multiplier.data()[i] = side > 0 ? l_next_.data()[bound + row_count] : side < 0 ? -l_next_.data()[bound] : 0.0;
  }
}

void InteriorPoint::solution(Point& point) const {
  std::copy_n(iterate_.z.data(), iterate_.z.size(), point.z.data());
  std::copy_n(iterate_.v.data(), iterate_.v.size(), point.v.data());
  for (int k = 0; k <= horizon_; ++k) {
    for (int r = 0; r < row_count; ++r) {
      const int lower = bounds_per_stage * k + r, upper = lower + row_count;
      point.multiplier.data()[row_count * k + r] =
          std::abs(sign_.data()[upper]) * l_.data()[upper] - std::abs(sign_.data()[lower]) * l_.data()[lower];
    }
  }
}

}  // namespace gripline::ocp
