#include "controllers/mpc_sqp/active_set.hpp"

#include <algorithm>
#include <cmath>

namespace gripline::mpc_sqp {
namespace {

// The penalty of an active constraint, relative to the problem's curvature along it: large enough that a multiplier
// step or two bring it to its bound, small enough to leave twelve digits to the recursion.
constexpr double initial_penalty = 1e4;

bool is_upper(BoundStatus status) { return static_cast<int>(status) > 0; }
bool is_active(BoundStatus status) {
  return status == BoundStatus::lower_active || status == BoundStatus::upper_active;
}
bool is_violated(BoundStatus status) {
  return status == BoundStatus::lower_violated || status == BoundStatus::upper_violated;
}

/// A constraint at the solution of one Newton step.
struct Constrained {
  double lower, upper, v, lam;
  double tolerance;      // of v
  double lam_tolerance;  // of lam
  bool soft;
  double z;  // weight of a slack, if soft
};

/// The status that agrees with v and lam.
BoundStatus next_status(BoundStatus status, const Constrained& c) {
  // A soft constraint can rest at its bound only if its violation costs at once.
  const bool kinked = c.soft && c.z > 0;
  BoundStatus next = status;
  if (status == BoundStatus::inactive) {
    const bool hold = !c.soft || kinked;
    if (c.v > c.upper + c.tolerance) next = hold ? BoundStatus::upper_active : BoundStatus::upper_violated;
    if (c.v < c.lower - c.tolerance) next = hold ? BoundStatus::lower_active : BoundStatus::lower_violated;
  } else if (is_active(status)) {
    const double outward = is_upper(status) ? c.lam : -c.lam;
    if (outward < -c.lam_tolerance) next = BoundStatus::inactive;
    if (kinked && outward > c.z + c.lam_tolerance)
      next = is_upper(status) ? BoundStatus::upper_violated : BoundStatus::lower_violated;
  } else {
    const double violation = is_upper(status) ? c.v - c.upper : c.lower - c.v;
    if (violation < -c.tolerance) {
      next = !kinked ? BoundStatus::inactive : is_upper(status) ? BoundStatus::upper_active : BoundStatus::lower_active;
    }
  }
  return next;
}

}  // namespace

QpPoint::QpPoint(int N, int nx)
    : ldux(4 + padded(nx)),
      ux(static_cast<std::size_t>(N + 1) * static_cast<std::size_t>(ldux)),
      v(static_cast<std::size_t>(N + 1) * con_count),
      lam(v.size()),
      curvature(v.size()),
      status(v.size(), BoundStatus::inactive) {}

void QpPoint::set_x0(const double* x0, int nx) {
  if (x0 != nullptr) {
    std::copy_n(x0, nx, stage(0) + 4);
  } else {
    std::fill_n(stage(0) + 4, nx, 0.0);
  }
}

void QpPoint::reset() {
  std::fill(status.begin(), status.end(), BoundStatus::inactive);
  std::fill_n(lam.data(), lam.size(), 0.0);
  curvature_at = -1;
}

bool QpPoint::finite() const {
  const double* last = ux.data() + ux.size() - static_cast<std::size_t>(ldux);
  double total = 0;
  for (int i = 4; i < ldux; ++i) total += last[i];
  return std::isfinite(total);
}

double bound_range(double lower, double upper) {
  const double width = upper - lower;
  return std::isfinite(width) && width > 0 ? width : 1.0;
}

bool ActiveSet::update_curvature(const OcpQp& qp, Riccati& riccati, QpPoint& point) {
  int violated = 0;
  for (std::size_t i = 0; i < point.status.size(); ++i) {
    const bool one = is_violated(point.status[i]);
    terms_.Gamma[i] = one ? qp.Z : 0.0;
    violated += one ? 1 : 0;
  }
  if (violated == point.curvature_at) return true;
  // A program that is not convex while nothing is active may be so with some constraints active: then an older
  // curvature serves.
  if (!riccati.factorize(qp, terms_)) return point.curvature_at >= 0;
  point.curvature_at = violated;
  double* curvature = point.curvature.data();
  riccati.curvatures(qp, curvature);
  // Toward the end of the horizon the cost hardly depends on a constraint's value: a share of the largest curvature
  // stands in for one near zero.
  for (int c = 0; c < con_count; ++c) {
    double most = 0;
    for (int k = 0; k <= qp.dims.N; ++k) most = std::max(most, curvature[con_count * k + c]);
    const double least = most > 0 ? 1e-3 * most : 1.0;
    for (int k = 0; k <= qp.dims.N; ++k) {
      double& one = curvature[con_count * k + c];
      one = std::max(one, least);
    }
  }
  return true;
}

void ActiveSet::set_Gamma(const OcpQp& qp, const QpPoint& point, double penalty) {
  for (int k = 0; k <= qp.dims.N; ++k) {
    for (int c = 0; c < con_count; ++c) {
      const int i = con_count * k + c;
      const BoundStatus status = has_constraint(k, qp.dims.N, c) ? point.status[i] : BoundStatus::inactive;
      double Gamma = 0;
      if (is_active(status)) Gamma = penalty * point.curvature[i];
      if (is_violated(status)) Gamma = qp.Z;
      terms_.Gamma[i] = Gamma;
    }
  }
}

/// An active constraint has the slope lam + Gamma (v - bound), a violated soft one +-z + Z (v - bound).
void ActiveSet::set_gamma(const OcpQp& qp, const QpPoint& point) {
  for (int k = 0; k <= qp.dims.N; ++k) {
    for (int c = 0; c < con_count; ++c) {
      const int i = con_count * k + c;
      const BoundStatus status = has_constraint(k, qp.dims.N, c) ? point.status[i] : BoundStatus::inactive;
      double gamma = 0;
      if (status != BoundStatus::inactive) {
        const double bound = is_upper(status) ? qp.ub(k)[c] : qp.lb(k)[c];
        const double at_bound = is_active(status) ? point.lam[i] : is_upper(status) ? qp.z : -qp.z;
        gamma = at_bound - terms_.Gamma[i] * bound;
      }
      terms_.gamma[i] = gamma;
    }
  }
}

double ActiveSet::update_lam(const OcpQp& qp, QpPoint& point) const {
  double worst = 0;
  for (int k = 0; k <= qp.dims.N; ++k) {
    for (int c = 0; c < con_count; ++c) {
      const int i = con_count * k + c;
      double& lam = point.lam[i];
      const BoundStatus status = has_constraint(k, qp.dims.N, c) ? point.status[i] : BoundStatus::inactive;
      if (status == BoundStatus::inactive) {
        lam = 0;
        continue;
      }
      const double v = point.v[i];
      lam = terms_.Gamma[i] * v + terms_.gamma[i];
      if (!is_active(status)) continue;
      const double bound = is_upper(status) ? qp.ub(k)[c] : qp.lb(k)[c];
      worst = std::max(worst, std::abs(v - bound) / bound_range(qp.lb(k)[c], qp.ub(k)[c]));
    }
  }
  return worst;
}

/// Whether any constraint changed its status.
bool ActiveSet::update_status(const OcpQp& qp, QpPoint& point, double tolerance) const {
  bool changed = false;
  for (int k = 0; k <= qp.dims.N; ++k) {
    for (int c = 0; c < con_count; ++c) {
      if (!has_constraint(k, qp.dims.N, c)) continue;
      const int i = con_count * k + c;
      const double lower = qp.lb(k)[c], upper = qp.ub(k)[c];
      const double slack = tolerance * bound_range(lower, upper);
      const Constrained at = {.lower = lower,
                              .upper = upper,
                              .v = point.v[i],
                              .lam = point.lam[i],
                              .tolerance = slack,
                              .lam_tolerance = slack * point.curvature[i],
                              .soft = c == con_g,
                              .z = qp.z};
      const BoundStatus next = next_status(point.status[i], at);
      changed = changed || next != point.status[i];
      point.status[i] = next;
    }
  }
  return changed;
}

ActiveSetResult ActiveSet::settle(const OcpQp& qp, Riccati& riccati, QpPoint& point, int iterations, double tolerance) {
  ActiveSetResult result;
  double penalty = initial_penalty;
  while (result.iterations < iterations) {
    ++result.iterations;
    set_Gamma(qp, point, penalty);
    if (!riccati.factorize(qp, terms_)) return result;
    // The first solve uses the multipliers of the guess; a second or third brings active constraints to their bounds.
    bool changed = false;
    for (int pass = 0; pass < 3 && !changed; ++pass) {
      set_gamma(qp, point);
      riccati.solve(qp, terms_, point.ux.data(), point.v.data());
      if (!point.finite()) return result;
      const double distance = update_lam(qp, point);
      changed = update_status(qp, point, tolerance);
      result.settled = !changed && distance <= tolerance;
      if (result.settled) return result;
    }
    // Still off their bounds: constraints work against each other, with more curvature than each has alone.
    if (!changed) penalty *= 10;
  }
  return result;
}

}  // namespace gripline::mpc_sqp
