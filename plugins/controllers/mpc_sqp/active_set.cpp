#include "controllers/mpc_sqp/active_set.hpp"

#include <algorithm>
#include <cmath>

namespace gripline::ocp {
namespace {

// A held row is a spring this much stiffer than the problem along it: stiff enough that a multiplier step or two bring it to
// its bound, soft enough to leave twelve digits to the recursion.
constexpr double first_spring = 1e4;

bool is_upper(Side side) { return static_cast<int>(side) > 0; }
bool is_held(Side side) { return side == Side::at_lower || side == Side::at_upper; }

}  // namespace

Point::Point(int horizon, int states)
    : width(4 + padded(states)),
      z(static_cast<std::size_t>(horizon + 1) * static_cast<std::size_t>(width)),
      v(static_cast<std::size_t>(horizon + 1) * row_count),
      multiplier(v.size()),
      stiffness(v.size()),
      side(v.size(), Side::free) {}

void Point::start(const double* x0, int states) {
  if (x0 != nullptr) {
    std::copy_n(x0, states, stage(0) + 4);
  } else {
    std::fill_n(stage(0) + 4, states, 0.0);
  }
}

void Point::forget_guess() {
  std::fill(side.begin(), side.end(), Side::free);
  std::fill_n(multiplier.data(), multiplier.size(), 0.0);
  measured_past = -1;
}

bool Point::finite() const {
  const double* last = z.data() + z.size() - static_cast<std::size_t>(width);
  double total = 0;
  for (int i = 4; i < width; ++i) total += last[i];
  return std::isfinite(total);
}

double row_width(double lower, double upper) {
  const double width = upper - lower;
  return std::isfinite(width) && width > 0 ? width : 1.0;
}

bool ActiveSet::measure_stiffness(const OcpQp& qp, Riccati& riccati, Point& point) {
  int past = 0;
  for (std::size_t i = 0; i < point.side.size(); ++i) {
    const bool is_past = point.side[i] == Side::past_lower || point.side[i] == Side::past_upper;
    terms_.weight.data()[i] = is_past ? 2 * qp.soft_quadratic : 0.0;
    past += is_past ? 1 : 0;
  }
  if (past == point.measured_past) return true;
  // Not convex while no row is held, it may still be with some held; then an older measure has to do.
  if (!riccati.factor(qp.links, terms_)) return point.measured_past >= 0;
  point.measured_past = past;
  Buffer& stiffness = point.stiffness;
  riccati.curvatures(qp.links, stiffness.data());
  // Toward the end of the horizon little depends on a row; a share of the largest stands in for next to nothing.
  for (int r = 0; r < row_count; ++r) {
    double most = 0;
    for (int k = 0; k <= qp.horizon(); ++k) most = std::max(most, stiffness.data()[row_count * k + r]);
    const double least = most > 0 ? 1e-3 * most : 1.0;
    for (int k = 0; k <= qp.horizon(); ++k) {
      double& one = stiffness.data()[row_count * k + r];
      one = std::max(one, least);
    }
  }
  return true;
}

void ActiveSet::set_weights(const OcpQp& qp, const Point& point, double spring) {
  for (int k = 0; k <= qp.horizon(); ++k) {
    for (int r = 0; r < row_count; ++r) {
      const int i = row_count * k + r;
      const Side side = has_row(k, qp.horizon(), r) ? point.side[i] : Side::free;
      const double past = 2.0 * qp.soft_quadratic;
      terms_.weight.data()[i] = side == Side::free ? 0.0 : is_held(side) ? spring * point.stiffness.data()[i] : past;
    }
  }
}

/// A held row: multiplier y + w (v - bound); a soft row that is past: +-linear + 2 quadratic (v - bound).
void ActiveSet::set_shifts(const OcpQp& qp, const Point& point) {
  for (int k = 0; k <= qp.horizon(); ++k) {
    for (int r = 0; r < row_count; ++r) {
      const int i = row_count * k + r;
      const Side side = has_row(k, qp.horizon(), r) ? point.side[i] : Side::free;
      double shift = 0;
      if (side != Side::free) {
        const double bound = is_upper(side) ? qp.upper(k)[r] : qp.lower(k)[r];
        const double constant = is_held(side)    ? point.multiplier.data()[i]
                                : is_upper(side) ? qp.soft_linear
                                                 : -qp.soft_linear;
        shift = constant - terms_.weight.data()[i] * bound;
      }
      terms_.shift.data()[i] = shift;
    }
  }
}

double ActiveSet::update_multipliers(const OcpQp& qp, Point& point) const {
  double worst = 0;
  for (int k = 0; k <= qp.horizon(); ++k) {
    for (int r = 0; r < row_count; ++r) {
      const int i = row_count * k + r;
      double& y = point.multiplier.data()[i];
      const Side side = has_row(k, qp.horizon(), r) ? point.side[i] : Side::free;
      if (side == Side::free) {
        y = 0;
        continue;
      }
      const double v = point.v.data()[i];
      y = terms_.weight.data()[i] * v + terms_.shift.data()[i];
      if (!is_held(side)) continue;
      const double bound = is_upper(side) ? qp.upper(k)[r] : qp.lower(k)[r];
      worst = std::max(worst, std::abs(v - bound) / row_width(qp.lower(k)[r], qp.upper(k)[r]));
    }
  }
  return worst;
}

/// Whether any row changed its side.
bool ActiveSet::update_sides(const OcpQp& qp, Point& point, double tolerance) const {
  bool changed = false;
  for (int k = 0; k <= qp.horizon(); ++k) {
    for (int r = 0; r < row_count; ++r) {
      if (!has_row(k, qp.horizon(), r)) continue;
      const int i = row_count * k + r;
      const double lower = qp.lower(k)[r], upper = qp.upper(k)[r];
      const double v = point.v.data()[i], y = point.multiplier.data()[i];
      const double width = row_width(lower, upper), slack = tolerance * width;
      const bool soft = r == row_soft;
      const bool kinked = soft && qp.soft_linear > 0;  // a soft row can rest at its bound only if leaving costs at once
      const Side before = point.side[i];
      Side after = before;
      if (before == Side::free) {
        const bool hold = !soft || kinked;
        if (v > upper + slack) after = hold ? Side::at_upper : Side::past_upper;
        if (v < lower - slack) after = hold ? Side::at_lower : Side::past_lower;
      } else if (is_held(before)) {
        const double sign = is_upper(before) ? 1.0 : -1.0;
        const double noise = slack * point.stiffness.data()[i];
        if (sign * y < -noise) after = Side::free;
        if (kinked && sign * y > qp.soft_linear + noise) after = is_upper(before) ? Side::past_upper : Side::past_lower;
      } else {
        const double beyond = is_upper(before) ? v - upper : lower - v;
        if (beyond < -slack) {
          after = !kinked ? Side::free : is_upper(before) ? Side::at_upper : Side::at_lower;
        }
      }
      changed = changed || after != before;
      point.side[i] = after;
    }
  }
  return changed;
}

ActiveSetResult ActiveSet::settle(const OcpQp& qp, Riccati& riccati, Point& point, int iterations, double tolerance) {
  ActiveSetResult result;
  double spring = first_spring;
  while (result.iterations < iterations) {
    ++result.iterations;
    set_weights(qp, point, spring);
    if (!riccati.factor(qp.links, terms_)) return result;
    // The first solve uses the multipliers of the guess; a second or third brings held rows to their bounds.
    bool changed = false;
    for (int pass = 0; pass < 3 && !changed; ++pass) {
      set_shifts(qp, point);
      riccati.solve(qp.links, terms_, point.z.data(), point.v.data());
      if (!point.finite()) return result;
      const double distance = update_multipliers(qp, point);
      changed = update_sides(qp, point, tolerance);
      result.settled = !changed && distance <= tolerance;
      if (result.settled) return result;
    }
    // Still off their bounds: rows work against each other, stiffer than each alone.
    if (!changed) spring *= 10;
  }
  return result;
}

}  // namespace gripline::ocp
