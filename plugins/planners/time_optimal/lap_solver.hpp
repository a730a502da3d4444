// The fastest lap as a nonlinear program: direct collocation along a base line, solved by Ipopt.
//
//   minimise  sum_k ds_k time(z_k) (1 + w (rate_k / rate_max)^2),      z_k = ((x_k + x_k+1) / 2, u_k)
//   subject to  x_k+1 - x_k = ds_k dx/ds(z_k)   (implicit midpoint, x_N = x_0),  n_lo <= n <= n_hi at nodes and
//               half-way between them,
//               |delta_k| <= delta_max, |rate_k| <= rate_max,  -brake(vx) <= a_k <= drive(vx),  |slips| <= slip_bound
//
// The controls are constant over an interval. Jacobian and Hessian of the Lagrangian are exact: an interval depends on
// eight numbers only.
#pragma once

#include <array>
#include <cstddef>
#include <numbers>
#include <vector>

#include "planners/time_optimal/lap_dynamics.hpp"

namespace gripline::time_optimal {

/// Bounds of every lap: the least speed forward over the top speed, and the largest angle between car and base line.
inline constexpr double least_speed_share = 0.05;
inline constexpr double most_askew = 0.45 * std::numbers::pi;  // [rad]

/// Drive, brakes and free rolling over speed [m/s2], twice differentiable.
struct DriveCurves {
  CubicSpline coast, drive, brake;
};

/// How an axle's side force and its part of the drive and brake force a (over mass) share friction:
///   (F / D)^2 + (share a / (ratio D))^2 <= (N + load a)^2
struct AxleSharing {
  double ratio = 0;  // largest force along over largest across; 0: they do not share friction
  double drive_front = 0.5, brake_front = 0.5;  // front shares of drive and brake force
  double load_front = 0, load_rear = 0;         // change of the relative load with a [s2/m]
};

/// How far a lap may use the tyres.
struct TyreUse {
  double combined = 0;      // > 0: (combined a)^2 + (Ff + Fr)^2 <= (N (Df + Dr))^2
  double slip_bound = 0.6;  // of both axles: beyond it a tyre is a brake, and the plan a drift [rad]
  // For window_solver.hpp only; solve_lap() refuses a problem where the ratio of `sharing` or small_slip_from_speed is
  // above 0.
  AxleSharing sharing{};             // in the place of `combined` where its ratio is above 0
  double full_slip_until_speed = 0;  // up to it IntervalProgram::set_slip_bound_slow_car() bounds slips [m/s]
  double small_slip_from_speed = 0;  // from it on slip_bound does, between them both in part; 0: from none on [m/s]
};

/// Interval k leads from node k to node k + 1, the last back to node 0.
struct LapProblem {
  Car car;
  AxleTyres tyres;
  DriveCurves drive;
  double top_speed = 0;  // [m/s]
  TyreUse use;
  double smoothness = 1e-4;            // the weight w
  std::vector<LapPlace> places;        // of the intervals
  std::vector<double> ds;              // their lengths [m]
  std::vector<double> n_lo, n_hi;      // at the nodes [m]
  std::vector<double> mid_lo, mid_hi;  // and half-way through the intervals

  std::size_t size() const { return ds.size(); }
  double least_speed() const { return least_speed_share * top_speed; }
  /// Typical sizes of the variables: solvers see variables and constraints of order one.
  std::array<double, lap_variables> typical_sizes() const;
};

/// The cost of interval i at z: its time, and a little for steering fast.
template <class T>
T interval_cost(const LapProblem& p, std::size_t i, const T (&z)[lap_variables], const LapRates<T>& r) {
  const T rate = z[lap_rate] * (1.0 / p.car.ddelta_max);
  return p.ds[i] * r.time * (1.0 + p.smoothness * rate * rate);
}
/// (combined a)^2 + (Ff + Fr)^2 over (Df + Dr)^2, which TyreUse::combined holds below N^2.
template <class T>
T friction_used(const LapProblem& p, const T (&z)[lap_variables], const LapRates<T>& r) {
  const double most = p.tyres.front.D + p.tyres.rear.D;
  const T along = (p.use.combined / most) * z[lap_a], across = (r.front + r.rear) * (1.0 / most);
  return along * along + across * across;
}

struct LapSolution {
  std::vector<std::array<double, lap_variables>> z;  // nodes' states and the controls that begin there
  double time = 0;                                   // of the lap [s]
  int iterations = 0;
  bool solved = false;
  // Multipliers of the constraints and of the variables' bounds, for a warm start; empty if never solved.
  std::vector<double> lambda, lower, upper;
};

/// Solves from `guess`, warm when it brings multipliers along. Stops on iterations, never on time. Throws
/// std::invalid_argument for a problem that only a window is solved for (LapProblem).
LapSolution solve_lap(const LapProblem& problem, const LapSolution& guess, int max_iterations = 400);

}  // namespace gripline::time_optimal
