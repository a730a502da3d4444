// What a window asks of one interval of a lap (window_solver.hpp) at z = ((x_k + x_k+1) / 2, u_k): cost, rates of the
// states and constraints, for a car that changes as it is learned, and their first and second derivatives.
//
// Values are templates, so that they can be differentiated automatically; cost and friction circle are those of
// lap_solver.hpp. Derivatives are written out: an interval's functions depend on two axles, each of which depends on
// three numbers (speed forward, lateral speed at the axle, steering angle), and on the time per metre; by hand, they
// cost a tenth of second-order numbers with eight directions. The tests hold the two against each other.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "planners/time_optimal/cubic_spline.hpp"
#include "planners/time_optimal/lap_dynamics.hpp"
#include "planners/time_optimal/lap_solver.hpp"
#include "planners/time_optimal/second_order_dual.hpp"

namespace gripline::time_optimal {

/// The constraints of an interval, all "<= 0" in typical sizes. The linear ones come first.
enum IntervalRow : int {
  n_most,
  n_least,
  mid_most,
  mid_least,
  delta_most,
  delta_least,
  rate_most,
  rate_least,
  xi_most,
  xi_least,
  v_least,
  drive_most,
  brake_most,
  front_most,
  front_least,
  rear_most,
  rear_least,
  interval_rows,
  // Where side forces share friction with drive and brakes, one row bounds an axle's slip to both sides, and the other
  // holds what it shares: of each axle, or of the whole car.
  front_both_ways = front_most,
  rear_both_ways = rear_most,
  front_shared = front_least,
  rear_shared = rear_least,
  car_shared = rear_least
};
inline constexpr int first_curved_row = drive_most, curved_rows = interval_rows - first_curved_row;

/// A linear constraint's variable and its slope, both in typical sizes; of n_most and n_least it is n at the next node.
struct LinearRow {
  int variable;
  double slope;
};
inline constexpr std::array<LinearRow, first_curved_row> linear_row{{{lap_n, 1.0},
                                                                     {lap_n, -1.0},
                                                                     {lap_n, 1.0},
                                                                     {lap_n, -1.0},
                                                                     {lap_delta, 1.0},
                                                                     {lap_delta, -1.0},
                                                                     {lap_rate, 1.0},
                                                                     {lap_rate, -1.0},
                                                                     {lap_xi, 1.0},
                                                                     {lap_xi, -1.0},
                                                                     {lap_vx, -1.0}}};

/// Cost, rates and curved constraints of one interval with their derivatives by z. z, cost and rates are in SI units,
/// constraints in typical sizes.
struct IntervalDerivatives {
  static constexpr int V = lap_variables;
  double cost = 0;
  std::array<double, V> cost_by{};                          // its gradient
  std::array<double, lap_states> rate{};                    // d(state)/ds
  std::array<std::array<double, V>, lap_states> rate_by{};  // their gradients
  std::array<double, curved_rows> row{};                    // constraints from drive_most on
  std::array<std::array<double, V>, curved_rows> row_by{};  // their gradients
  std::array<double, SecondOrderDual<V>::entries>
      lagrangian_by{};  // Hessian of the weighted sum, lower triangle by rows
};

/// The largest slip that is planned, over the forward speed: `when_slow` up to `slow_until`, from `fast_from` on
/// `when_fast` where that is less, smooth between. A slide at speed leaves no side force to correct it, over a way that
/// grows with the square of the speed.
struct SlipBound {
  double when_slow = 0.6, when_fast = 0.6;  // [rad]
  double slow_until = 0, fast_from = 0;     // [m/s]; fast_from 0: `when_slow` at all speeds
  CubicSpline::Value at(double v) const {
    const double fall = std::min(0.0, when_fast - when_slow);
    if (fast_from <= slow_until || fall == 0.0 || v <= slow_until) return {when_slow, 0.0, 0.0};
    if (v >= fast_from) return {when_slow + fall, 0.0, 0.0};
    const double per = 1.0 / (fast_from - slow_until), u = (v - slow_until) * per;
    return {when_slow + fall * u * u * (3.0 - 2.0 * u), 6.0 * fall * u * (1.0 - u) * per,
            6.0 * fall * (1.0 - 2.0 * u) * per * per};
  }
};

class IntervalProgram {
 public:
  explicit IntervalProgram(const LapProblem& problem);

  /// What is believed of the car from now on. `more` is resistance beyond that of the problem's coasting curve.
  void set_car(const AxleTyres& tyres, const SpecificResistance& more);
  void set_grip(std::size_t node, double grip) { p_.places[node].grip = grip; }
  /// The largest slip of slow cars, where that is more than the problem's slip_bound; from the next set_car() on [rad].
  void set_slip_bound_slow_car(double slip) { slip_bound_slow_car_ = slip; }
  double slip_bound_slow_car() const { return slip_bound_slow_car_; }
  double largest_slip() const { return std::max(slip_front_.when_slow, slip_rear_.when_slow); }
  /// Whether side forces and drive or brakes share friction: constraints are then curved along a step.
  bool shares_friction() const { return p_.use.combined > 0 || p_.use.sharing.ratio > 0; }
  const LapProblem& problem() const { return p_; }
  /// Typical sizes of the variables.
  const std::array<double, lap_variables>& scales() const { return scale_; }

  template <class T>
  LapRates<T> rates(std::size_t i, const T (&z)[lap_variables]) const;
  template <class T>
  T cost(std::size_t i, const T (&z)[lap_variables], const LapRates<T>& r) const {
    return interval_cost(p_, i, z, r);
  }
  /// put(row, value) for each row that is linear (linear_row).
  template <class Put>
  void linear_rows(std::size_t i, const double (&z)[lap_variables], double n_next, const Put& put) const;
  /// put(row, value) for the rows from drive_most on: drive, brakes, slips and the sharing of friction.
  template <class T, class Put>
  void curved_rows_of(std::size_t i, const T (&z)[lap_variables], const LapRates<T>& r, const Put& put) const;

  /// Derivatives of interval i at z. The weighted sum is cost + sum_j rate_weight_j rate_j + sum_m row_weight_m row_m.
  void differentiate(std::size_t i, const double (&z)[lap_variables], const std::array<double, lap_states>& rate_weight,
                     const std::array<double, curved_rows>& row_weight, IntervalDerivatives& out) const;

 private:
  struct Parts;
  struct Motion;
  Motion motion_at(std::size_t i, const double (&z)[lap_variables], const Parts& parts) const;
  std::array<std::array<double, lap_variables>, lap_states> gradients_by_time(const double (&z)[lap_variables],
                                                                              const Parts& parts,
                                                                              const Motion& motion) const;
  void differentiate_rates(std::size_t i, const double (&z)[lap_variables],
                           const std::array<double, lap_states>& weight, Parts& parts, IntervalDerivatives& out) const;
  void add_hessian_of_rates(std::size_t i, const std::array<double, lap_states>& weight, const Motion& motion,
                            Parts& parts, IntervalDerivatives& out) const;
  void differentiate_rows(std::size_t i, const double (&z)[lap_variables],
                          const std::array<double, curved_rows>& weight, Parts& parts, IntervalDerivatives& out) const;
  void differentiate_circle(const double (&z)[lap_variables], const std::array<double, curved_rows>& weight,
                            Parts& parts, IntervalDerivatives& out) const;
  void differentiate_sharing(std::size_t i, const double (&z)[lap_variables],
                             const std::array<double, curved_rows>& weight, Parts& parts,
                             IntervalDerivatives& out) const;
  template <class T, class Put>
  void share_friction(double grip, const T& a, const LapRates<T>& r, const Put& put) const;

  /// The factor of the squared steering rate in rad/s in the cost: w over its typical size squared [s2/rad2].
  double smoothness() const {
    const double unit = 1.0 / scale_[lap_rate];
    return p_.smoothness * unit * unit;
  }

  static constexpr double from_brake_to_drive = 0.5;  // [m/s2] over which the front share changes
  LapProblem p_;
  SpecificResistance more_;
  double slip_bound_slow_car_ = 0;  // [rad]
  SlipBound slip_front_, slip_rear_;
  std::array<double, lap_variables> scale_{};
};

template <class T>
LapRates<T> IntervalProgram::rates(std::size_t i, const T (&z)[lap_variables]) const {
  LapRates<T> r = lap_rates(p_.car, p_.tyres, p_.drive.coast, p_.places[i], z);
  r.state[lap_vx] -= (more_.rolling + more_.drag * (z[lap_vx] * z[lap_vx])) * r.time;
  return r;
}

/// AxleSharing of both axles. Known limit: the square of what an axle carries has no sign, so that an axle with a
/// negative load would pass as one that carries as much. On a flat road the full-size car would have to drive with
/// 27.8 m/s2 to lift its front axle, or to brake with 28.6 to lift the rear one, and it is planned with 7.8 and 5.9 at
/// most; with these it takes a crest that relieves it of 72 % of its weight, and the sharpest crest of
/// worlds/tracks (hill.json, a radius of 1100 m) relieves it of 23 % at 50 m/s.
template <class T, class Put>
void IntervalProgram::share_friction(double grip, const T& a, const LapRates<T>& r, const Put& put) const {
  using std::atan;
  const AxleSharing& own = p_.use.sharing;
  const double mean = 0.5 * (own.drive_front + own.brake_front), rise = own.drive_front - own.brake_front;
  const T front = mean + (rise / std::numbers::pi) * atan(a * (1.0 / from_brake_to_drive));
  const auto axle = [&](int row, const T& force, const T& share, double load, double D) {
    const T across = force * (1.0 / D), along = share * a * (1.0 / (own.ratio * D)),
            carried = r.load + (grip * load) * a;
    put(row, across * across + along * along - carried * carried);
  };
  axle(front_shared, r.front, front, own.load_front, p_.tyres.front.D);
  axle(rear_shared, r.rear, 1.0 - front, own.load_rear, p_.tyres.rear.D);
}

template <class T, class Put>
void IntervalProgram::curved_rows_of(std::size_t i, const T (&z)[lap_variables], const LapRates<T>& r,
                                     const Put& put) const {
  const double unit = 1.0 / scale_[lap_a];
  put(drive_most, unit * (z[lap_a] - apply(p_.drive.drive, z[lap_vx])));
  put(brake_most, -unit * (z[lap_a] + apply(p_.drive.brake, z[lap_vx])));
  const T& v = z[lap_vx];
  const auto both_ways = [&](int row, const T& slip, const SlipBound& bound) {
    const T relative = slip * (1.0 / bound.when_slow), share = apply(bound, v) * (1.0 / bound.when_slow);
    put(row, relative * relative - share * share);
  };
  if (p_.use.sharing.ratio > 0) {
    both_ways(front_both_ways, r.slip_front, slip_front_);
    both_ways(rear_both_ways, r.slip_rear, slip_rear_);
    share_friction(p_.places[i].grip, z[lap_a], r, put);
    return;
  }
  put(front_most, r.slip_front - apply(slip_front_, v));
  put(front_least, -1.0 * r.slip_front - apply(slip_front_, v));
  if (p_.use.combined > 0) {
    both_ways(rear_both_ways, r.slip_rear, slip_rear_);
    put(car_shared, friction_used(p_, z, r) - r.load * r.load);
  } else {
    put(rear_most, r.slip_rear - apply(slip_rear_, v));
    put(rear_least, -1.0 * r.slip_rear - apply(slip_rear_, v));
  }
}

template <class Put>
void IntervalProgram::linear_rows(std::size_t i, const double (&z)[lap_variables], double n_next,
                                  const Put& put) const {
  const std::size_t j = i + 1 < p_.size() ? i + 1 : 0;
  const double w = scale_[lap_n], lock = p_.car.delta_max / scale_[lap_delta];
  put(n_most, (n_next - p_.n_hi[j]) / w);
  put(n_least, (p_.n_lo[j] - n_next) / w);
  put(mid_most, (z[lap_n] - p_.mid_hi[i]) / w);
  put(mid_least, (p_.mid_lo[i] - z[lap_n]) / w);
  put(delta_most, z[lap_delta] / scale_[lap_delta] - lock);
  put(delta_least, -z[lap_delta] / scale_[lap_delta] - lock);
  put(rate_most, z[lap_rate] / scale_[lap_rate] - 1.0);
  put(rate_least, -z[lap_rate] / scale_[lap_rate] - 1.0);
  put(xi_most, (z[lap_xi] - most_askew) / scale_[lap_xi]);
  put(xi_least, (-z[lap_xi] - most_askew) / scale_[lap_xi]);
  put(v_least, (p_.least_speed() - z[lap_vx]) / scale_[lap_vx]);
}

}  // namespace gripline::time_optimal
