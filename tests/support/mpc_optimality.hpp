// Whether a plan is optimal, judged from outside: the nonlinear problem's own conditions, not a solver's word.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "common/mpc/ocp.hpp"

namespace gripline::testing_support {

/// What the tests of both controllers drive with.
inline mpc::OcpParams ocp_params(int horizon) {
  mpc::OcpParams p;
  p.horizon = horizon;
  p.q_yaw = p.q_v = 0.01;
  p.tighten = 0.008;
  return p;
}

/// How far a plan is from the conditions of optimality of the nonlinear problem, each relative to what matters.
struct Optimality {
  double defect = 0;        // of the dynamics, in the states' own units
  double stationarity = 0;  // of the Lagrangian by an input over its range, relative to the sum of the terms' sizes
  double bounds = 0;        // beyond a hard bound
};

/// The multipliers of the dynamics run backwards; that of a steering angle at its limit is the one that makes the rate
/// before it stationary, if its sign is right. Values within `room` of a limit count as at it, because interior point
/// methods stay inside.
inline Optimality optimality(const mpc::Ocp& ocp, std::span<const double> x, std::span<const double> u,
                             Prediction& model, double room = 1e-6) {
  const auto n = static_cast<std::size_t>(ocp.states()), steps = static_cast<std::size_t>(ocp.horizon());
  const Car& car = ocp.car();
  const mpc::OcpParams& p = ocp.params();
  std::vector<double> next(steps * n), a(steps * n * n), b(steps * n * 2), lambda(n), before(n);
  model.step(steps, x.first(steps * n), u, ocp.places(), next, a, b);
  Optimality worst;
  for (std::size_t i = 0; i < steps * n; ++i) worst.defect = std::max(worst.defect, std::abs(next[i] - x[n + i]));
  for (std::size_t k = steps; k > 0; --k) {
    const mpc::OcpStage& s = ocp.stage(static_cast<int>(k));
    const double* at = x.data() + k * n;
    if (k < steps) {
      std::fill(before.begin(), before.end(), 0.0);
      for (std::size_t l = 0; l < n; ++l) {
        for (std::size_t i = 0; i < n; ++i) before[i] += lambda[l] * a[(k * n + l) * n + i];
      }
      lambda = before;
    }
    const double ex = at[0] - s.x, ey = at[1] - s.y, edge = s.normal_x * at[0] + s.normal_y * at[1];
    const double push = 2 * p.slack * (std::max(0.0, edge - s.edge_upper) - std::max(0.0, s.edge_lower - edge));
    lambda[0] += 2 * (s.q_xx * ex + s.q_xy * ey) + push * s.normal_x;
    lambda[1] += 2 * (s.q_xy * ex + s.q_yy * ey) + push * s.normal_y;
    lambda[2] += 2 * s.q_yaw * (at[2] - s.yaw);
    lambda[3] += 2 * s.q_v * (at[3] - s.v);

    const double d = u[2 * k - 2], ddelta = u[2 * k - 1];
    const double d_before = k > 1 ? u[2 * k - 4] : ocp.throttle_before();
    double slope[2] = {2 * p.r_d * (d - d_before) + 2 * p.regularization * d, 2 * ocp.weight_ddelta() * ddelta};
    if (k < steps) slope[0] -= 2 * p.r_d * (u[2 * k] - d);
    double size[2] = {1e-4 + std::abs(slope[0]), 1e-4 / car.ddelta_max + std::abs(slope[1])};
    const auto add = [&](std::size_t l, double multiplier) {
      for (std::size_t i = 0; i < 2; ++i) {
        const double term = multiplier * b[((k - 1) * n + l) * 2 + i];
        slope[i] += term;
        size[i] += std::abs(term);
      }
    };
    for (std::size_t l = 0; l < n; ++l) add(l, lambda[l]);
    const bool rate_free = std::abs(ddelta) < car.ddelta_max - room;
    if (rate_free && std::abs(at[6]) > s.delta_max - room) {
      const double force = -slope[1] / b[((k - 1) * n + 6) * 2 + 1];
      if (force * at[6] > 0) {
        lambda[6] += force;
        add(6, force);
      }
    }
    const double low[2] = {car.d_min, -car.ddelta_max}, high[2] = {car.d_max, car.ddelta_max};
    for (std::size_t i = 0; i < 2; ++i) {
      const double v = u[2 * k - 2 + i];
      worst.bounds = std::max({worst.bounds, v - high[i], low[i] - v});
      double off = std::abs(slope[i]);
      if (v > high[i] - room) off = std::max(0.0, slope[i]);  // may push outward
      if (v < low[i] + room) off = std::max(0.0, -slope[i]);
      worst.stationarity = std::max(worst.stationarity, off / size[i]);
    }
    worst.bounds = std::max(worst.bounds, std::abs(at[6]) - s.delta_max);
  }
  return worst;
}

}  // namespace gripline::testing_support
