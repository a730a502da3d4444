// Optimal control programs to test on, and what it means to have solved one.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "controllers/mpc_sqp/ocp_qp.hpp"

namespace gripline::testing_support {

struct ProgramShape {
  int horizon = 30, states = 8;
  double soft_quadratic = 100, soft_linear = 0;
  double pull = 1;  // how far the references lie outside what the bounds allow
};

/// A program as a car gives it: stable-ish dynamics, a steering angle that integrates its rate, a throttle remembered, a
/// tracking cost that leaves most states free, every kind of bound.
inline ocp::OcpQp random_program(const ProgramShape& shape, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  ocp::OcpQp qp(shape.horizon, shape.states);
  ocp::Links& links = qp.links;
  const int nx = shape.states, n = links.n, steering = nx - 2, throttle = nx - 1;
  qp.soft_quadratic = shape.soft_quadratic;
  qp.soft_linear = shape.soft_linear;
  links.bounded_state = steering;
  std::vector<double> a(static_cast<std::size_t>(nx * nx)), b(static_cast<std::size_t>(nx * 2));
  for (int k = 0; k <= shape.horizon; ++k) {
    double* h = links.hessian_x(k);
    for (int term = 0; term < 3; ++term) {
      std::vector<double> c(static_cast<std::size_t>(nx));
      for (double& v : c) v = normal(random);
      c[static_cast<std::size_t>(throttle)] = 0;
      const double reference = shape.pull * normal(random);
      for (int i = 0; i < nx; ++i) {
        for (int j = 0; j < nx; ++j)
          h[i * n + j] += 0.3 * c[static_cast<std::size_t>(i)] * c[static_cast<std::size_t>(j)];
        links.gradient(k)[4 + i] -= 0.3 * c[static_cast<std::size_t>(i)] * reference;
      }
    }
    for (int i = 0; i < 2; ++i) links.row(k)[i] = normal(random);
    const double lower[] = {-0.5, -1, -0.35, -0.3 * uniform(random) - 0.05};
    const double upper[] = {1, 1, 0.35, 0.3 * uniform(random) + 0.05};
    std::copy_n(lower, 4, qp.lower(k));
    std::copy_n(upper, 4, qp.upper(k));
    if (k == shape.horizon) break;
    h[throttle * n + throttle] += 0.01;
    double* hu = links.hessian_u(k);
    hu[0] = 0.011;
    hu[4 + throttle] = -0.01;
    hu[links.width + 1] = 0.02;
    for (double& v : a) v = 0.04 * normal(random);
    for (double& v : b) v = 0.3 * normal(random);
    for (int i = 0; i < nx; ++i) a[static_cast<std::size_t>(i * nx + i)] += 0.95;
    for (int j = 0; j < nx; ++j)
      a[static_cast<std::size_t>(steering * nx + j)] = a[static_cast<std::size_t>(throttle * nx + j)] = 0;
    a[static_cast<std::size_t>(steering * nx + steering)] = 1;
    b[static_cast<std::size_t>(2 * steering)] = b[static_cast<std::size_t>(2 * throttle + 1)] = 0;
    b[static_cast<std::size_t>(2 * steering + 1)] = 0.1;
    b[static_cast<std::size_t>(2 * throttle)] = 1;
    links.set_dynamics(k, a.data(), b.data(), nx);
    for (int i = 0; i < steering; ++i) links.offset(k)[i] = 0.02 * normal(random);
  }
  return qp;
}

/// Largest violations of the conditions of optimality.
struct Residuals {
  double dynamics = 0;         // of the equality constraints
  double stationarity = 0;     // of the Lagrangian, by the inputs (by the states it defines the multipliers)
  double bounds = 0;           // beyond a hard bound
  double complementarity = 0;  // of hard bounds: the distance or the multiplier, whichever is smaller; or its sign
  double softness = 0;         // of soft multipliers, off the penalty's slope
  double worst() const { return std::max({dynamics, stationarity, bounds, complementarity, softness}); }
};

inline double row_value(const ocp::OcpQp& qp, const ocp::OcpQpSolver& solver, int k, int row) {
  if (row < ocp::row_state) return solver.input(k)[row];
  if (row == ocp::row_state) return solver.state(k)[qp.links.bounded_state];
  double value = 0;
  for (int i = 0; i < qp.links.states; ++i) value += qp.links.row(k)[i] * solver.state(k)[i];
  return value;
}

/// By how much y misses the slopes of the penalty at v; at a kink any slope between its sides.
inline double off_slope(const ocp::OcpQp& qp, double v, double lower, double upper, double y) {
  const double near = 1e-6;
  const auto slope = [&](double at) {
    if (at > upper) return qp.soft_linear + 2 * qp.soft_quadratic * (at - upper);
    if (at < lower) return -qp.soft_linear - 2 * qp.soft_quadratic * (lower - at);
    return 0.0;
  };
  return std::max({0.0, slope(v - near) - y, y - slope(v + near)});
}

inline Residuals residuals(const ocp::OcpQp& qp, const ocp::OcpQpSolver& solver) {
  const ocp::Links& links = qp.links;
  const int n = links.n;
  Residuals worst;
  ocp::Buffer pi(static_cast<std::size_t>((links.horizon + 1) * n));
  solver.dynamics_multipliers(qp, pi.data());
  const auto raise = [](double& to, double by) { to = std::isfinite(by) ? std::max(to, by) : 1e300; };
  for (int k = 0; k <= links.horizon; ++k) {
    const double *x = solver.state(k), *u = solver.input(k), *y = solver.row_multiplier(k);
    for (int row = 0; row < ocp::row_count; ++row) {
      if (row < ocp::row_state ? k == links.horizon : k == 0) continue;
      const double lower = qp.lower(k)[row], upper = qp.upper(k)[row], v = row_value(qp, solver, k, row);
      if (row == ocp::row_soft) {
        raise(worst.softness, off_slope(qp, v, lower, upper, y[row]));
        continue;
      }
      raise(worst.bounds, std::max(v - upper, lower - v));
      raise(worst.complementarity, std::min(std::abs(y[row]), y[row] > 0 ? std::abs(upper - v) : std::abs(v - lower)));
    }
    if (k == links.horizon) break;
    for (int i = 0; i < links.states; ++i) {
      const double* m = links.link(k) + i * links.width;
      double next = links.offset(k)[i] + m[0] * u[0] + m[1] * u[1];
      for (int j = 0; j < links.states; ++j) next += m[4 + j] * x[j];
      raise(worst.dynamics, std::abs(next - solver.state(k + 1)[i]));
    }
    for (int i = 0; i < 2; ++i) {
      const double* h = links.hessian_u(k) + i * links.width;
      double slope = links.gradient(k)[i] + h[0] * u[0] + h[1] * u[1] + y[i];
      for (int j = 0; j < links.states; ++j) slope += h[4 + j] * x[j];
      for (int l = 0; l < n; ++l) slope += links.link(k)[l * links.width + i] * pi.data()[(k + 1) * n + l];
      raise(worst.stationarity, std::abs(slope));
    }
  }
  return worst;
}

/// Cost of inputs [N][2], states and slacks following from them; infinite where a hard bound is broken.
inline double rolled_out_cost(const ocp::OcpQp& qp, const std::vector<double>& x0, const std::vector<double>& inputs) {
  const ocp::Links& links = qp.links;
  std::vector<double> x = x0, next(x0.size());
  double total = 0;
  for (int k = 0; k <= links.horizon; ++k) {
    const auto at = [&](int i) { return x[static_cast<std::size_t>(i)]; };
    double edge = 0;
    for (int i = 0; i < links.states; ++i) {
      edge += links.row(k)[i] * at(i);
      total += links.gradient(k)[4 + i] * at(i);
      for (int j = 0; j < links.states; ++j) total += 0.5 * at(i) * links.hessian_x(k)[i * links.n + j] * at(j);
    }
    if (k > 0) {
      const double eps = std::max({0.0, edge - qp.upper(k)[ocp::row_soft], qp.lower(k)[ocp::row_soft] - edge});
      total += (qp.soft_quadratic * eps + qp.soft_linear) * eps;
      const double v = at(links.bounded_state);
      if (v > qp.upper(k)[ocp::row_state] + 1e-6 || v < qp.lower(k)[ocp::row_state] - 1e-6) return INFINITY;
    }
    if (k == links.horizon) break;
    const double* u = inputs.data() + 2 * k;
    for (int i = 0; i < 2; ++i) {
      if (u[i] > qp.upper(k)[i] + 1e-6 || u[i] < qp.lower(k)[i] - 1e-6) return INFINITY;
      const double* h = links.hessian_u(k) + i * links.width;
      total += links.gradient(k)[i] * u[i];
      for (int j = 0; j < 2; ++j) total += 0.5 * u[i] * h[j] * u[j];
      for (int j = 0; j < links.states; ++j) total += u[i] * h[4 + j] * at(j);
    }
    for (int i = 0; i < links.states; ++i) {
      const double* m = links.link(k) + i * links.width;
      double v = links.offset(k)[i] + m[0] * u[0] + m[1] * u[1];
      for (int j = 0; j < links.states; ++j) v += m[4 + j] * at(j);
      next[static_cast<std::size_t>(i)] = v;
    }
    x.swap(next);
  }
  return total;
}

}  // namespace gripline::testing_support
