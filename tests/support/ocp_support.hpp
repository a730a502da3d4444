// Optimal control programs to test on, and what it means to have solved one.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "controllers/mpc_sqp/ocp_qp_solver.hpp"

namespace gripline::testing_support {

struct ProgramShape {
  int N = 30, nx = 8;
  double Z = 200, z = 0;
  double pull = 1;  // how far the references lie outside what the bounds allow
};

/// A program as a car gives it: stable-ish dynamics, a steering angle that integrates its rate, a throttle remembered,
/// a tracking cost that leaves most states free, every kind of bound.
inline mpc_sqp::OcpQp random_program(const ProgramShape& shape, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  mpc_sqp::OcpQp qp(shape.N, shape.nx);
  const int nx = shape.nx, n = qp.dims.ldx, steering = nx - 2, throttle = nx - 1;
  qp.Z = shape.Z;
  qp.z = shape.z;
  qp.idxbx = steering;
  std::vector<double> a(static_cast<std::size_t>(nx * nx)), b(static_cast<std::size_t>(nx * 2));
  for (int k = 0; k <= shape.N; ++k) {
    double* Q = qp.Q(k);
    for (int term = 0; term < 3; ++term) {
      std::vector<double> c(static_cast<std::size_t>(nx));
      for (double& v : c) v = normal(random);
      c[static_cast<std::size_t>(throttle)] = 0;
      const double reference = shape.pull * normal(random);
      for (int i = 0; i < nx; ++i) {
        for (int j = 0; j < nx; ++j)
          Q[i * n + j] += 0.3 * c[static_cast<std::size_t>(i)] * c[static_cast<std::size_t>(j)];
        qp.q(k)[i] -= 0.3 * c[static_cast<std::size_t>(i)] * reference;
      }
    }
    for (int i = 0; i < 2; ++i) qp.C(k)[i] = normal(random);
    const double lower[] = {-0.5, -1, -0.35, -0.3 * uniform(random) - 0.05};
    const double upper[] = {1, 1, 0.35, 0.3 * uniform(random) + 0.05};
    std::copy_n(lower, 4, qp.lb(k));
    std::copy_n(upper, 4, qp.ub(k));
    if (k == shape.N) break;
    Q[throttle * n + throttle] += 0.01;
    qp.R(k)[0] = 0.011;
    qp.R(k)[qp.dims.ldux + 1] = 0.02;
    qp.S(k)[throttle] = -0.01;
    for (double& v : a) v = 0.04 * normal(random);
    for (double& v : b) v = 0.3 * normal(random);
    for (int i = 0; i < nx; ++i) a[static_cast<std::size_t>(i * nx + i)] += 0.95;
    for (int j = 0; j < nx; ++j)
      a[static_cast<std::size_t>(steering * nx + j)] = a[static_cast<std::size_t>(throttle * nx + j)] = 0;
    a[static_cast<std::size_t>(steering * nx + steering)] = 1;
    b[static_cast<std::size_t>(2 * steering)] = b[static_cast<std::size_t>(2 * throttle + 1)] = 0;
    b[static_cast<std::size_t>(2 * steering + 1)] = 0.1;
    b[static_cast<std::size_t>(2 * throttle)] = 1;
    qp.set_AB(k, a.data(), b.data(), nx);
    for (int i = 0; i < steering; ++i) qp.b(k)[i] = 0.02 * normal(random);
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

inline double constraint_value(const mpc_sqp::OcpQp& qp, const mpc_sqp::OcpQpSolver& solver, int k, int row) {
  if (row < mpc_sqp::con_x) return solver.u(k)[row];
  if (row == mpc_sqp::con_x) return solver.x(k)[qp.idxbx];
  double value = 0;
  for (int i = 0; i < qp.dims.nx; ++i) value += qp.C(k)[i] * solver.x(k)[i];
  return value;
}

/// By how much y misses the slopes of the penalty at v; at a kink any slope between its sides.
inline double off_slope(const mpc_sqp::OcpQp& qp, double v, double lower, double upper, double y) {
  const double near = 1e-6;
  const auto slope = [&](double at) {
    if (at > upper) return qp.z + qp.Z * (at - upper);
    if (at < lower) return -qp.z - qp.Z * (lower - at);
    return 0.0;
  };
  return std::max({0.0, slope(v - near) - y, y - slope(v + near)});
}

inline Residuals residuals(const mpc_sqp::OcpQp& qp, const mpc_sqp::OcpQpSolver& solver) {
  const mpc_sqp::OcpQpDims& dims = qp.dims;
  const int n = dims.ldx;
  Residuals worst;
  mpc_sqp::Buffer pi(static_cast<std::size_t>((dims.N + 1) * n));
  solver.get_pi(qp, pi.data());
  const auto raise = [](double& to, double by) { to = std::isfinite(by) ? std::max(to, by) : 1e300; };
  for (int k = 0; k <= dims.N; ++k) {
    const double *x = solver.x(k), *u = solver.u(k), *y = solver.lam(k);
    for (int row = 0; row < mpc_sqp::con_count; ++row) {
      if (row < mpc_sqp::con_x ? k == dims.N : k == 0) continue;
      const double lower = qp.lb(k)[row], upper = qp.ub(k)[row], v = constraint_value(qp, solver, k, row);
      if (row == mpc_sqp::con_g) {
        raise(worst.softness, off_slope(qp, v, lower, upper, y[row]));
        continue;
      }
      raise(worst.bounds, std::max(v - upper, lower - v));
      raise(worst.complementarity, std::min(std::abs(y[row]), y[row] > 0 ? std::abs(upper - v) : std::abs(v - lower)));
    }
    if (k == dims.N) break;
    for (int i = 0; i < dims.nx; ++i) {
      const double *A = qp.A(k) + i * dims.ldux, *B = qp.B(k) + i * dims.ldux;
      double next = qp.b(k)[i] + B[0] * u[0] + B[1] * u[1];
      for (int j = 0; j < dims.nx; ++j) next += A[j] * x[j];
      raise(worst.dynamics, std::abs(next - solver.x(k + 1)[i]));
    }
    for (int i = 0; i < 2; ++i) {
      const double *R = qp.R(k) + i * dims.ldux, *S = qp.S(k) + i * dims.ldux;
      double slope = qp.r(k)[i] + R[0] * u[0] + R[1] * u[1] + y[i];
      for (int j = 0; j < dims.nx; ++j) slope += S[j] * x[j];
      for (int l = 0; l < n; ++l) slope += qp.B(k)[l * dims.ldux + i] * pi.data()[(k + 1) * n + l];
      raise(worst.stationarity, std::abs(slope));
    }
  }
  return worst;
}

/// Cost of inputs [N][2], states and slacks following from them; infinite where a hard bound is broken.
inline double rolled_out_cost(const mpc_sqp::OcpQp& qp, const std::vector<double>& x0,
                              const std::vector<double>& inputs) {
  const mpc_sqp::OcpQpDims& dims = qp.dims;
  std::vector<double> x = x0, next(x0.size());
  double total = 0;
  for (int k = 0; k <= dims.N; ++k) {
    const auto at = [&](int i) { return x[static_cast<std::size_t>(i)]; };
    double edge = 0;
    for (int i = 0; i < dims.nx; ++i) {
      edge += qp.C(k)[i] * at(i);
      total += qp.q(k)[i] * at(i);
      for (int j = 0; j < dims.nx; ++j) total += 0.5 * at(i) * qp.Q(k)[i * dims.ldx + j] * at(j);
    }
    if (k > 0) {
      const double eps = std::max({0.0, edge - qp.ub(k)[mpc_sqp::con_g], qp.lb(k)[mpc_sqp::con_g] - edge});
      total += (0.5 * qp.Z * eps + qp.z) * eps;
      const double v = at(qp.idxbx);
      if (v > qp.ub(k)[mpc_sqp::con_x] + 1e-6 || v < qp.lb(k)[mpc_sqp::con_x] - 1e-6) return INFINITY;
    }
    if (k == dims.N) break;
    const double* u = inputs.data() + 2 * k;
    for (int i = 0; i < 2; ++i) {
      if (u[i] > qp.ub(k)[i] + 1e-6 || u[i] < qp.lb(k)[i] - 1e-6) return INFINITY;
      const double *R = qp.R(k) + i * dims.ldux, *S = qp.S(k) + i * dims.ldux;
      total += qp.r(k)[i] * u[i];
      for (int j = 0; j < 2; ++j) total += 0.5 * u[i] * R[j] * u[j];
      for (int j = 0; j < dims.nx; ++j) total += u[i] * S[j] * at(j);
    }
    for (int i = 0; i < dims.nx; ++i) {
      const double *A = qp.A(k) + i * dims.ldux, *B = qp.B(k) + i * dims.ldux;
      double v = qp.b(k)[i] + B[0] * u[0] + B[1] * u[1];
      for (int j = 0; j < dims.nx; ++j) v += A[j] * at(j);
      next[static_cast<std::size_t>(i)] = v;
    }
    x.swap(next);
  }
  return total;
}

}  // namespace gripline::testing_support
