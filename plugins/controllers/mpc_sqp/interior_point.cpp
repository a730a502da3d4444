#include "controllers/mpc_sqp/interior_point.hpp"

#include <algorithm>
#include <cmath>

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
  const Buffer zeros(static_cast<std::size_t>(bounds_per_stage) * static_cast<std::size_t>(N + 1));
  bounds_ = {zeros, zeros, zeros, zeros};
  now_ = next_ = {zeros, zeros, zeros, zeros};
  step_ = {zeros, zeros, zeros, zeros};
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
  for (std::size_t i = 0; i < now_.t.size(); ++i) {
    if (bounds_.c[i] == 0) continue;
    outside_t = std::max(outside_t, -next_.t[i] / bounds_.t_unit[i]);
    outside_lam = std::max(outside_lam, -next_.lam[i] / bounds_.lam_unit[i]);
  }
  for (std::size_t i = 0; i < now_.t.size(); ++i) {
    if (bounds_.c[i] == 0) continue;
    now_.t[i] = next_.t[i] + (0.1 + 1.5 * outside_t) * bounds_.t_unit[i];
    now_.lam[i] = next_.lam[i] + (0.1 + 1.5 * outside_lam) * bounds_.lam_unit[i];
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
        bounds_.c[i] = exists ? (is_upper ? 1.0 : -1.0) : 0.0;
        bounds_.d[i] = exists ? bound : 1.0;
        bounds_.t_unit[i] = range;
        bounds_.lam_unit[i] = point.curvature[row] * range;
        now_.t[i] = exists ? std::max(bound - bounds_.c[i] * point.v[row], 0.05 * range) : 1.0;
        now_.lam[i] = 1;
        step_.rho[i] = exists && con == con_g ? 1.0 / Z_ : 0.0;
        step_.sigma[i] = 0;
        if (exists) ++pairs_;
      }
    }
  }
}

/// Multipliers for the distances, all pairs at one complementarity, which is returned. Its scale is a logarithmic mean,
/// since curvatures may differ by orders of magnitude along the horizon.
double InteriorPoint::set_pairs(const QpPoint& point) {
  double total = 0;
  for (std::size_t i = 0; i < now_.t.size(); ++i) {
    if (bounds_.c[i] != 0) total += std::log(bounds_.lam_unit[i] / bounds_.t_unit[i] * now_.t[i] * now_.t[i]);
  }
  const double mu = pairs_ > 0 ? std::exp(total / pairs_) : 1.0;
  for (std::size_t i = 0; i < now_.t.size(); ++i) {
    if (bounds_.c[i] == 0) continue;
    if (i % con_count == con_g && !(z_ > 0)) {
      // t lam = mu and t = d - c v + lam / Z at once.
      const double v = point.v[i / bounds_per_stage * con_count + con_g];
      const double excess = bounds_.c[i] * v - bounds_.d[i];
      const double root = std::sqrt(excess * excess + 4 * mu / Z_);
      now_.t[i] = excess > 0 ? mu / (0.5 * Z_ * (excess + root)) : 0.5 * (root - excess);
    }
    now_.lam[i] = mu / now_.t[i];
  }
  if (z_ > 0) set_soft_pairs(mu);
  next_ = now_;  // no predictor yet
  return mu;
}

/// s nu = mu with nu = z + Z s, of which lam takes at most half.
void InteriorPoint::set_soft_pairs(double mu) {
  for_soft_bounds(N_, [&](int i) {
    if (bounds_.c[i] == 0) return;
    const double s = 2 * mu / (z_ + std::sqrt(z_ * z_ + 4 * Z_ * mu));
    now_.lam[i] = std::min(now_.lam[i], 0.5 * (z_ + Z_ * s));
    now_.s[i] = s;
    now_.nu[i] = z_ + Z_ * s - now_.lam[i];
    ++pairs_;
  });
}

/// s+ = rho lam+ + sigma from the linearised conditions Z s+ + z - lam+ - nu+ = 0 and s nu+ + nu s+ = m + s nu.
void InteriorPoint::set_slack_terms(double target, double second_order) {
  for_soft_bounds(N_, [&](int i) {
    if (bounds_.c[i] == 0) return;
    const double s = now_.s[i], nu = now_.nu[i];
    const double m = target - second_order * (next_.s[i] - s) * (next_.nu[i] - nu);
    const double scale = 1.0 / (nu + Z_ * s);
    step_.rho[i] = s * scale;
    step_.sigma[i] = (m + s * (nu - z_)) * scale;
  });
}

void InteriorPoint::set_terms(double target, double second_order) {
  if (z_ > 0) set_slack_terms(target, second_order);
  const Vec4 aim = all(target), share = all(second_order);
  for (int k = 0; k <= N_; ++k) {
    Vec4 Gamma_sum{}, gamma_sum{};
    for (int i = bounds_per_stage * k; i < bounds_per_stage * (k + 1); i += con_count) {
      const Vec4 t = vec4(now_.t.data() + i), lam = vec4(now_.lam.data() + i), c = vec4(bounds_.c.data() + i);
      const Vec4 m = aim - share * (vec4(next_.t.data() + i) - t) * (vec4(next_.lam.data() + i) - lam);
      const Vec4 scale = 1.0 / (t + vec4(step_.rho.data() + i) * lam);
      const Vec4 Gamma = c * c * lam * scale;
      const Vec4 offset = Gamma * (t - vec4(bounds_.d.data() + i) - vec4(step_.sigma.data() + i)) + m * scale;
      vec4(step_.Gamma.data() + i) = Gamma;
      vec4(step_.offset.data() + i) = c != 0.0 ? offset : all(1.0);
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
      const Vec4 cv = vec4(bounds_.c.data() + i) * v;
      const Vec4 lam = vec4(step_.Gamma.data() + i) * cv + vec4(step_.offset.data() + i);
      vec4(next_.lam.data() + i) = lam;
      vec4(next_.t.data() + i) =
          vec4(bounds_.d.data() + i) + vec4(step_.sigma.data() + i) + vec4(step_.rho.data() + i) * lam - cv;
    }
  }
  if (!(z_ > 0)) return;
  for_soft_bounds(N_, [&](int i) {
    if (bounds_.c[i] == 0) return;
    next_.s[i] = step_.rho[i] * next_.lam[i] + step_.sigma[i];
    next_.nu[i] = Z_ * next_.s[i] + z_ - next_.lam[i];
  });
}

/// The longest step that keeps every pair positive, at most 1.
double InteriorPoint::step_length() const {
  Vec4 worst{};
  for (std::size_t i = 0; i < now_.t.size(); i += 4) {
    const Vec4 t = vec4(now_.t.data() + i), lam = vec4(now_.lam.data() + i);
    worst = max(worst, max(1.0 - vec4(next_.t.data() + i) / t, 1.0 - vec4(next_.lam.data() + i) / lam));
  }
  double ratio = largest(worst);
  if (z_ > 0) {
    for_soft_bounds(N_, [&](int i) {
      if (bounds_.c[i] == 0) return;
      ratio = std::max({ratio, 1.0 - next_.s[i] / now_.s[i], 1.0 - next_.nu[i] / now_.nu[i]});
    });
  }
  return ratio > 1.0 ? 1.0 / ratio : 1.0;
}

/// The mean product of the pairs after a step.
double InteriorPoint::mean_complementarity(double alpha) const {
  const auto after = [alpha](double now, double next) { return now + alpha * (next - now); };
  Vec4 total{};
  for (std::size_t i = 0; i < now_.t.size(); i += 4) {
    const Vec4 t = vec4(now_.t.data() + i), lam = vec4(now_.lam.data() + i), c = vec4(bounds_.c.data() + i);
    total += c * c * (t + alpha * (vec4(next_.t.data() + i) - t)) * (lam + alpha * (vec4(next_.lam.data() + i) - lam));
  }
  double slacks = 0;
  if (z_ > 0) {
    for_soft_bounds(N_, [&](int i) {
      if (bounds_.c[i] == 0) return;
      slacks += after(now_.s[i], next_.s[i]) * after(now_.nu[i], next_.nu[i]);
    });
  }
  return pairs_ > 0 ? (sum(total) + slacks) / pairs_ : 0.0;
}

/// The largest distance, or multiplier if that is smaller, in the constraint's units.
double InteriorPoint::worst_pair() const {
  double worst = 0;
  for (std::size_t i = 0; i < now_.t.size(); ++i) {
    const double t = now_.t[i] / bounds_.t_unit[i], lam = now_.lam[i] / bounds_.lam_unit[i];
    if (bounds_.c[i] != 0) worst = std::max(worst, std::min(t, lam));
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
  move(now_.t, next_.t);
  move(now_.lam, next_.lam);
  if (z_ > 0) {
    move(now_.s, next_.s);
    move(now_.nu, next_.nu);
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
        if (bounds_.c[i] == 0) continue;
        const bool active = next_.lam[i] * now_.t[i] > next_.t[i] * now_.lam[i];
        if (!active) continue;
        now = is_upper ? BoundStatus::upper_active : BoundStatus::lower_active;
        if (con == con_g && (!(z_ > 0) || next_.s[i] * now_.nu[i] > next_.nu[i] * now_.s[i])) {
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
    point.lam[i] = side > 0 ? next_.lam[upper] : side < 0 ? -next_.lam[lower] : 0.0;
  }
}

void InteriorPoint::get_solution(QpPoint& point) const {
  std::copy_n(iterate_.ux.data(), iterate_.ux.size(), point.ux.data());
  std::copy_n(iterate_.v.data(), iterate_.v.size(), point.v.data());
  for (int k = 0; k <= N_; ++k) {
    for (int con = 0; con < con_count; ++con) {
      const int lower = bounds_per_stage * k + con, upper = lower + con_count;
      point.lam[con_count * k + con] =
          std::abs(bounds_.c[upper]) * now_.lam[upper] - std::abs(bounds_.c[lower]) * now_.lam[lower];
    }
  }
}

}  // namespace gripline::mpc_sqp
