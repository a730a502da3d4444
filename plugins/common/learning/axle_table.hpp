// A tyre curve as a table: cubic Hermite segments over the slip angle, once continuously differentiable.
//
// Evaluating it costs the same whatever was learned, which keeps a horizon of predictions cheap. The range covers the
// slips of a car that drives forward and steers by up to 0.43 rad, so that they stay off its ends, where the slope
// jumps: beyond it the curve is level.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include <gripline/dual.hpp>
#include <gripline/types.hpp>

namespace gripline::learning {

inline constexpr double table_reach = 2.0;  // [rad]: pi/2 and a steering angle of 0.43
inline constexpr std::ptrdiff_t table_knots = 161;
inline constexpr double table_step = 2 * table_reach / static_cast<double>(table_knots - 1);  // [rad]

/// Slip angle at a knot [rad].
constexpr double table_slip(std::ptrdiff_t knot) { return -table_reach + static_cast<double>(knot) * table_step; }

/// Where a slip angle lies in a table: the knot before it, and the share of the step to the next, which is NaN where
/// the slip is.
struct TablePlace {
  std::ptrdiff_t knot;
  double share;
};
inline TablePlace table_place(double slip) {
  const double position = std::clamp((slip + table_reach) / table_step, 0.0, table_knots - 1.0);
  constexpr std::ptrdiff_t last = table_knots - 2;
  const auto knot = position < static_cast<double>(last) ? static_cast<std::ptrdiff_t>(position) : last;
  return {knot, position - static_cast<double>(knot)};
}

class AxleTable {
 public:
  AxleTable() : value_(table_knots, 0.0), slope_(table_knots, 0.0) {}

  /// Force [N] and its slope [N/rad] at the knots; fill both, then evaluate.
  std::vector<double>& values() { return value_; }
  std::vector<double>& slopes() { return slope_; }

  struct Value {
    double force, slope;  // [N, N/rad]
  };
  Value at(double slip) const {
    const auto [i, w] = table_place(slip);
    const double f0 = value_[i], f1 = value_[i + 1];
    const double s0 = slope_[i] * table_step, s1 = slope_[i + 1] * table_step;
    const double c2 = 3 * (f1 - f0) - 2 * s0 - s1;
    const double c3 = 2 * (f0 - f1) + s0 + s1;
    const double force = f0 + w * (s0 + w * (c2 + w * c3));
    if (std::abs(slip) > table_reach) return {force, 0.0};
    return {force, (s0 + w * (2 * c2 + w * 3 * c3)) / table_step};
  }

  template <class T>
  T force(const T& slip) const {
    const Value v = at(value(slip));
    return chain(v.force, v.slope, slip);
  }

  /// Half the distance from the largest to the smallest force within |slip| <= reach: the peak of an odd curve, and
  /// the mean of both sides' peaks of one that is not quite odd.
  double peak(double reach) const {
    double lo = std::min(at(reach).force, at(-reach).force), hi = std::max(at(reach).force, at(-reach).force);
    for (std::ptrdiff_t i = 0; i < table_knots; ++i) {
      if (std::abs(table_slip(i)) > reach) continue;
      lo = std::min(lo, value_[i]);
      hi = std::max(hi, value_[i]);
    }
    return 0.5 * (hi - lo);
  }

  /// The knot in 0..reach with the largest force.
  double peak_slip(double reach) const {
    std::ptrdiff_t best = table_knots / 2;
    for (std::ptrdiff_t i = best; i < table_knots && table_slip(i) <= reach; ++i)
      if (value_[i] > value_[best]) best = i;
    return table_slip(best);
  }

 private:
  std::vector<double> value_, slope_;
};

/// The curves of both axles.
struct AxleTables {
  AxleTable front, rear;

  const AxleTable& of(Axle axle) const { return axle == Axle::front ? front : rear; }
  /// Forces [N] at these slip angles [rad].
  void forces(Axle axle, std::span<const double> slip, std::span<double> force) const {
    for (std::size_t i = 0; i < force.size(); ++i) force[i] = of(axle).at(slip[i]).force;
  }
};

/// The nodes of a hidden layer and their slopes at the knots of a table, so that the table of any output weights is one
/// product of a matrix with a vector. Layer: nodes(), add(slip, factor, span), add_slope(slip, factor, span).
class TabulatedLayer {
 public:
  template <class Layer>
  explicit TabulatedLayer(const Layer& layer) : rows_(2 * table_knots, layer.nodes()), knots_(2 * table_knots) {
    const auto n = static_cast<std::size_t>(layer.nodes());
    Eigen::VectorXd h(layer.nodes());
    for (std::ptrdiff_t i = 0; i < table_knots; ++i) {
      h.setZero();
      layer.add(table_slip(i), 1.0, {h.data(), n});
      rows_.row(i) = h;
      h.setZero();
      layer.add_slope(table_slip(i), 1.0, {h.data(), n});
      rows_.row(table_knots + i) = h;
    }
  }

  /// Slopes of the nodes at a knot.
  auto slopes(std::ptrdiff_t knot) const { return rows_.row(table_knots + knot); }
  /// The nodes at a slip angle, between the knots as AxleTable; nodes [nodes] is the caller's.
  template <class Nodes>
  void read(double slip, Nodes&& nodes) const {
    const auto [i, w] = table_place(slip);
    const double rise = w * w * (3.0 - 2.0 * w);
    const double bend0 = table_step * w * square(1.0 - w), bend1 = table_step * w * w * (w - 1.0);
    nodes = (1.0 - rise) * rows_.row(i).transpose() + rise * rows_.row(i + 1).transpose() +
            bend0 * slopes(i).transpose() + bend1 * slopes(i + 1).transpose();
  }
  /// Fills the table of the curve factor * sum_j weights_j h_j(slip). Allocates nothing.
  template <class Weights>
  void fill(AxleTable& table, const Weights& weights, double factor) {
    knots_.noalias() = rows_ * weights;
    for (std::ptrdiff_t i = 0; i < table_knots; ++i) {
      table.values()[i] = factor * knots_[i];
      table.slopes()[i] = factor * knots_[table_knots + i];
    }
  }

 private:
  Eigen::MatrixXd rows_;  // values at the knots, then slopes [2 table_knots][nodes]
  Eigen::VectorXd knots_;
};

}  // namespace gripline::learning
