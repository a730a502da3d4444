#include "controllers/mpc_sqp/interior_point.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace gripline::mpc_sqp {
namespace {

constexpr int bounds_per_stage = 2 * con_count;

/// Calls f(index of the bound) for every soft bound.
template <class F>
void for_soft_bounds(int N, F f) {
  for (int k = 1; k <= N; ++k) {
    f(bounds_per_stage * k + con_g);
    f(bounds_per_stage * k + con_count + con_g);
  }
}

}  // namespace

InteriorPoint::InteriorPoint(int N, int nx)
    : iterate_(N, nx), terms_(N), last_status_(terms_.Gamma.size(), BoundStatus::inactive), N_(N) {
  const std::size_t size = static_cast<std::size_t>(bounds_per_stage) * static_cast<std::size_t>(N + 1);
  for (Buffer* buffer : {&c_, &d_, &t_, &lam_, &t_next_, &lam_next_, &rho_, &sigma_, &s_, &nu_, &s_next_, &nu_next_,
                         &Gamma_, &offset_, &t_unit_, &lam_unit_}) {
    *buffer = Buffer(size);
  }
}

void InteriorPoint::start(const OcpQp& qp, Riccati& riccati, QpPoint& point) {
  Z_ = qp.Z;
  z_ = qp.z;
  set_bounds(qp, point);
  // A barrier with the curvature of the problem itself, aimed at its centre ...
  const double mu = set_pairs(point);
  mu_ = mean_complementarity(0);
  const auto take_point = [&] {
    std::copy_n(point.ux.data(), point.ux.size(), iterate_.ux.data());
    std::copy_n(point.v.data(), point.v.size(), iterate_.v.data());
  };
  take_point();
  // ... shows what the problem asks for; the pairs start there, as far inside as the worst of them lies outside.
  if (solve(qp, riccati, point, mu, 0)) {
    take_point();
    shift_inside();
  }
  iterations_ = 0;
  repeated_ = false;
  std::fill(last_status_.begin(), last_status_.end(), BoundStatus::inactive);
  mu_ = mean_complementarity(0);
  infeasibility_ = 1;
}

/// Pairs after a full step, shifted by half as much again as the worst of them is negative.
void InteriorPoint::shift_inside() {
  double outside_t = 0, outside_lam = 0;
  for (std::size_t i = 0; i < t_.size(); ++i) {
    if (c_.data()[i] == 0) continue;
    outside_t = std::max(outside_t, -t_next_.data()[i] / t_unit_.data()[i]);
    outside_lam = std::max(outside_lam, -lam_next_.data()[i] / lam_unit_.data()[i]);
  }
  for (std::size_t i = 0; i < t_.size(); ++i) {
    if (c_.data()[i] == 0) continue;
    t_.data()[i] = t_next_.data()[i] + (0.1 + 1.5 * outside_t) * t_unit_.data()[i];
    lam_.data()[i] = lam_next_.data()[i] + (0.1 + 1.5 * outside_lam) * lam_unit_.data()[i];
  }
}

/// The bounds of `qp` with their units; distances from the point's v, no less than a share of the bounds' range.
void InteriorPoint::set_bounds(const OcpQp& qp, QpPoint& point) {
  if (!point.finite()) {
    std::fill_n(point.ux.data() + point.ldux, point.ux.size() - static_cast<std::size_t>(point.ldux), 0.0);
    std::fill_n(point.v.data(), point.v.size(), 0.0);
  }
  pairs_ = 0;
  for (int k = 0; k <= N_; ++k) {
    for (int con = 0; con < con_count; ++con) {
      const int row = con_count * k + con;
      const double range = bound_range(qp.lb(k)[con], qp.ub(k)[con]);
      for (const bool is_upper : {false, true}) {
        const int i = bounds_per_stage * k + (is_upper ? con_count : 0) + con;
        // A constraint with equal bounds has no interior; it is given one too small to matter.
        const double room = qp.ub(k)[con] - qp.lb(k)[con] < 1e-7 ? 1e-7 : 0.0;
        const double bound = (is_upper ? qp.ub(k)[con] : -qp.lb(k)[con]) + room;
        const bool exists = has_constraint(k, N_, con) && std::isfinite(bound);
        c_.data()[i] = exists ? (is_upper ? 1.0 : -1.0) : 0.0;
        d_.data()[i] = exists ? bound : 1.0;
        t_unit_.data()[i] = range;
        lam_unit_.data()[i] = point.curvature.data()[row] * range;
        t_.data()[i] = exists ? std::max(bound - c_.data()[i] * point.v.data()[row], 0.05 * range) : 1.0;
        lam_.data()[i] = 1;
        rho_.data()[i] = exists && con == con_g ? 1.0 / Z_ : 0.0;
        sigma_.data()[i] = 0;
        if (exists) ++pairs_;
      }
    }
  }
}

/// Multipliers for the distances, all pairs at one complementarity, which is returned. Its scale is a logarithmic mean,
/// since curvatures may differ by orders of magnitude along the horizon.
double InteriorPoint::set_pairs(const QpPoint& point) {
  double total = 0;
  for (std::size_t i = 0; i < t_.size(); ++i) {
    if (c_.data()[i] != 0) total += std::log(lam_unit_.data()[i] / t_unit_.data()[i] * t_.data()[i] * t_.data()[i]);
  }
  const double mu = pairs_ > 0 ? std::exp(total / pairs_) : 1.0;
  for (std::size_t i = 0; i < t_.size(); ++i) {
    if (c_.data()[i] == 0) continue;
    if (i % con_count == con_g && !(z_ > 0)) {
      // t lam = mu and t = d - c v + lam / Z at once.
      const double v = point.v.data()[i / bounds_per_stage * con_count + con_g];
      const double excess = c_.data()[i] * v - d_.data()[i];
      const double root = std::sqrt(excess * excess + 4 * mu / Z_);
      t_.data()[i] = excess > 0 ? mu / (0.5 * Z_ * (excess + root)) : 0.5 * (root - excess);
    }
    lam_.data()[i] = mu / t_.data()[i];
  }
  if (z_ > 0) set_soft_pairs(mu);
  // No predictor yet.
  for (const auto& [next, now] : {std::pair{&t_next_, &t_}, {&lam_next_, &lam_}, {&s_next_, &s_}, {&nu_next_, &nu_}}) {
    std::copy_n(now->data(), now->size(), next->data());
  }
  return mu;
}

/// s nu = mu with nu = z + Z s, of which lam takes at most half.
void InteriorPoint::set_soft_pairs(double mu) {
  for_soft_bounds(N_, [&](int i) {
    if (c_.data()[i] == 0) return;
    const double s = 2 * mu / (z_ + std::sqrt(z_ * z_ + 4 * Z_ * mu));
    lam_.data()[i] = std::min(lam_.data()[i], 0.5 * (z_ + Z_ * s));
    s_.data()[i] = s;
    nu_.data()[i] = z_ + Z_ * s - lam_.data()[i];
    ++pairs_;
  });
}

/// s+ = rho lam+ + sigma from the linearised conditions Z s+ + z - lam+ - nu+ = 0 and s nu+ + nu s+ = m + s nu.
void InteriorPoint::set_slack_terms(double target, double second_order) {
  for_soft_bounds(N_, [&](int i) {
    if (c_.data()[i] == 0) return;
    const double s = s_.data()[i], nu = nu_.data()[i];
    const double m = target - second_order * (s_next_.data()[i] - s) * (nu_next_.data()[i] - nu);
    const double scale = 1.0 / (nu + Z_ * s);
    rho_.data()[i] = s * scale;
    sigma_.data()[i] = (m + s * (nu - z_)) * scale;
  });
}

void InteriorPoint::set_terms(double target, double second_order) {
  if (z_ > 0) set_slack_terms(target, second_order);
  const Vec4 aim = all(target), share = all(second_order);
  for (int k = 0; k <= N_; ++k) {
    Vec4 Gamma_sum{}, gamma_sum{};
    for (int i = bounds_per_stage * k; i < bounds_per_stage * (k + 1); i += con_count) {
      const Vec4 t = vec4(t_.data() + i), lam = vec4(lam_.data() + i), c = vec4(c_.data() + i);
      const Vec4 m = aim - share * (vec4(t_next_.data() + i) - t) * (vec4(lam_next_.data() + i) - lam);
      const Vec4 scale = 1.0 / (t + vec4(rho_.data() + i) * lam);
      const Vec4 Gamma = c * c * lam * scale;
      const Vec4 offset = Gamma * (t - vec4(d_.data() + i) - vec4(sigma_.data() + i)) + m * scale;
      vec4(Gamma_.data() + i) = Gamma;
      vec4(offset_.data() + i) = c != 0.0 ? offset : all(1.0);
      Gamma_sum += Gamma;
      gamma_sum += c * offset;
    }
    vec4(terms_.Gamma.data() + con_count * k) = Gamma_sum;
    vec4(terms_.gamma.data() + con_count * k) = gamma_sum;
  }
}

void InteriorPoint::set_full_step(const QpPoint& point) {
  for (int k = 0; k <= N_; ++k) {
    const Vec4 v = vec4(point.v.data() + con_count * k);
    for (int i = bounds_per_stage * k; i < bounds_per_stage * (k + 1); i += con_count) {
      const Vec4 cv = vec4(c_.data() + i) * v;
      const Vec4 lam = vec4(Gamma_.data() + i) * cv + vec4(offset_.data() + i);
      vec4(lam_next_.data() + i) = lam;
      vec4(t_next_.data() + i) = vec4(d_.data() + i) + vec4(sigma_.data() + i) + vec4(rho_.data() + i) * lam - cv;
    }
  }
  if (!(z_ > 0)) return;
  for_soft_bounds(N_, [&](int i) {
    if (c_.data()[i] == 0) return;
    s_next_.data()[i] = rho_.data()[i] * lam_next_.data()[i] + sigma_.data()[i];
    nu_next_.data()[i] = Z_ * s_next_.data()[i] + z_ - lam_next_.data()[i];
  });
}

/// The longest step that keeps every pair positive, at most 1.
double InteriorPoint::step_length() const {
  Vec4 worst{};
  for (std::size_t i = 0; i < t_.size(); i += 4) {
    const Vec4 t = vec4(t_.data() + i), lam = vec4(lam_.data() + i);
    worst = max(worst, max(1.0 - vec4(t_next_.data() + i) / t, 1.0 - vec4(lam_next_.data() + i) / lam));
  }
  double ratio = largest(worst);
  if (z_ > 0) {
    for_soft_bounds(N_, [&](int i) {
      if (c_.data()[i] == 0) return;
      ratio = std::max({ratio, 1.0 - s_next_.data()[i] / s_.data()[i], 1.0 - nu_next_.data()[i] / nu_.data()[i]});
    });
  }
  return ratio > 1.0 ? 1.0 / ratio : 1.0;
}

/// The mean product of the pairs after a step.
double InteriorPoint::mean_complementarity(double alpha) const {
  const auto after = [alpha](double now, double next) { return now + alpha * (next - now); };
  Vec4 total{};
  for (std::size_t i = 0; i < t_.size(); i += 4) {
    const Vec4 t = vec4(t_.data() + i), lam = vec4(lam_.data() + i), c = vec4(c_.data() + i);
    total += c * c * (t + alpha * (vec4(t_next_.data() + i) - t)) * (lam + alpha * (vec4(lam_next_.data() + i) - lam));
  }
  double slacks = 0;
  if (z_ > 0) {
    for_soft_bounds(N_, [&](int i) {
      if (c_.data()[i] == 0) return;
      slacks += after(s_.data()[i], s_next_.data()[i]) * after(nu_.data()[i], nu_next_.data()[i]);
    });
  }
  return pairs_ > 0 ? (sum(total) + slacks) / pairs_ : 0.0;
}

/// The largest distance, or multiplier if that is smaller, in the constraint's units.
double InteriorPoint::worst_pair() const {
  double worst = 0;
  for (std::size_t i = 0; i < t_.size(); ++i) {
    const double t = t_.data()[i] / t_unit_.data()[i], lam = lam_.data()[i] / lam_unit_.data()[i];
    if (c_.data()[i] != 0) worst = std::max(worst, std::min(t, lam));
  }
  return worst;
}

void InteriorPoint::advance(const QpPoint& point, double alpha) {
  const auto move = [alpha](Buffer& now, const Buffer& next) {
    for (std::size_t i = 0; i < now.size(); i += 4) {
      vec4(now.data() + i) += alpha * (vec4(next.data() + i) - vec4(now.data() + i));
    }
  };
  move(iterate_.ux, point.ux);
  move(iterate_.v, point.v);
  move(t_, t_next_);
  move(lam_, lam_next_);
  if (z_ > 0) {
    move(s_, s_next_);
    move(nu_, nu_next_);
  }
}

bool InteriorPoint::solve(const OcpQp& qp, Riccati& riccati, QpPoint& point, double target, double second_order) {
  set_terms(target, second_order);
  if (second_order == 0 && !riccati.factorize(qp, terms_)) return false;
  riccati.solve(qp, terms_, point.ux.data(), point.v.data());
  set_full_step(point);
  return point.finite();
}

InteriorPoint::Status InteriorPoint::iterate(const OcpQp& qp, Riccati& riccati, QpPoint& point, double tolerance,
                                             int iterations) {
  const auto solve = [&](double target, double second_order) {
    return this->solve(qp, riccati, point, target, second_order);
  };
  for (int left = iterations; left > 0; --left) {
    if (!solve(0, 0)) return Status::failed;
    if (infeasibility_ <= tolerance && worst_pair() <= tolerance) return Status::converged;
    if (infeasibility_ < 0.1 && active_set_repeats()) return Status::active_set_repeats;
    ++iterations_;
    const double ratio = mean_complementarity(step_length()) / mu_;
    if (!solve(ratio * ratio * ratio * mu_, 1)) return Status::failed;
    const double alpha = std::min(1.0, 0.995 * step_length());
    if (!(alpha > 1e-2) && stalled() == Status::converged) return Status::converged;
    if (!(alpha > 1e-8)) return Status::failed;
    advance(point, alpha);
    infeasibility_ *= 1 - alpha;
    mu_ = mean_complementarity(0);
  }
  return stalled();
}

/// Rounding ends the progress of programs whose multipliers span many orders of magnitude. Well inside a thousandth of
/// a constraint's units that is a solution, if a coarse one.
InteriorPoint::Status InteriorPoint::stalled() const {
  return infeasibility_ <= 1e-6 && worst_pair() <= 1e-4 ? Status::converged : Status::failed;
}

/// Whether the predictor moves every constraint to the same status as the predictor before it did, and does so for the
/// first time: of a pair, the one that tends to zero shrinks more.
bool InteriorPoint::active_set_repeats() {
  int changes = 0;
  for (int k = 0; k <= N_; ++k) {
    for (int con = 0; con < con_count; ++con) {
      BoundStatus now = BoundStatus::inactive;
      for (const bool is_upper : {false, true}) {
        const int i = bounds_per_stage * k + (is_upper ? con_count : 0) + con;
        if (c_.data()[i] == 0) continue;
        const bool active = lam_next_.data()[i] * t_.data()[i] > t_next_.data()[i] * lam_.data()[i];
        if (!active) continue;
        now = is_upper ? BoundStatus::upper_active : BoundStatus::lower_active;
        if (con == con_g && (!(z_ > 0) || s_next_.data()[i] * nu_.data()[i] > nu_next_.data()[i] * s_.data()[i])) {
          now = is_upper ? BoundStatus::upper_violated : BoundStatus::lower_violated;
        }
      }
      BoundStatus& before = last_status_[con_count * k + con];
      changes += before != now;
      before = now;
    }
  }
  const bool repeats = changes == 0 && !repeated_;
  repeated_ = changes == 0;
  return repeats;
}

void InteriorPoint::get_active_set(QpPoint& point) const {
  point.status = last_status_;
  for (std::size_t i = 0; i < last_status_.size(); ++i) {
    const std::size_t lower = i / con_count * bounds_per_stage + i % con_count, upper = lower + con_count;
    const int side = static_cast<int>(last_status_[i]);
    point.lam.data()[i] = side > 0 ? lam_next_.data()[upper] : side < 0 ? -lam_next_.data()[lower] : 0.0;
  }
}

void InteriorPoint::get_solution(QpPoint& point) const {
  std::copy_n(iterate_.ux.data(), iterate_.ux.size(), point.ux.data());
  std::copy_n(iterate_.v.data(), iterate_.v.size(), point.v.data());
  for (int k = 0; k <= N_; ++k) {
    for (int con = 0; con < con_count; ++con) {
      const int lower = bounds_per_stage * k + con, upper = lower + con_count;
      point.lam.data()[con_count * k + con] =
          std::abs(c_.data()[upper]) * lam_.data()[upper] - std::abs(c_.data()[lower]) * lam_.data()[lower];
    }
  }
}

}  // namespace gripline::mpc_sqp
