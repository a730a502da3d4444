#include "controllers/mpc_sqp/ocp_nlp.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace gripline::mpc_sqp {
namespace {

/// Whether all numbers are finite: so is then their sum, in eight parts that do not wait for one another.
bool finite(std::span<const double> values) {
  double part[8] = {};
  std::size_t i = 0;
  for (; i + 8 <= values.size(); i += 8)
    for (std::size_t j = 0; j < 8; ++j) part[j] += values[i + j];
  for (; i < values.size(); ++i) part[0] += values[i];
  return std::isfinite(std::accumulate(std::begin(part), std::end(part), 0.0));
}

}  // namespace

NlpIterate::NlpIterate(int N, int nx) {
  const auto n = static_cast<std::size_t>(nx), stages = static_cast<std::size_t>(N);
  x.resize((stages + 1) * n);
  u.resize(stages * 2);
  x_next.resize(stages * n);
  A.resize(stages * n * n);
  B.resize(stages * n * 2);
}

bool predict(const mpc::Ocp& ocp, Prediction& model, NlpIterate& at) {
  const auto n = static_cast<std::size_t>(ocp.states()), stages = static_cast<std::size_t>(ocp.horizon());
  model.step(stages, std::span(at.x).first(stages * n), at.u, ocp.places(), at.x_next, {}, {});
  at.cost = ocp.cost(at.x, at.u);
  return std::isfinite(at.cost) && finite(at.x_next);
}

bool linearise(const mpc::Ocp& ocp, Prediction& model, NlpIterate& at) {
  const auto n = static_cast<std::size_t>(ocp.states()), stages = static_cast<std::size_t>(ocp.horizon());
  model.step(stages, std::span(at.x).first(stages * n), at.u, ocp.places(), at.x_next, at.A, at.B);
  at.cost = ocp.cost(at.x, at.u);
  return std::isfinite(at.cost) && finite(at.x_next) && finite(at.A) && finite(at.B);
}

void set_cost_hessian(const mpc::Ocp& ocp, double damping, OcpQp& qp) {
  const mpc::OcpParams& p = ocp.params();
  const int ldx = qp.dims.ldx, ldux = qp.dims.ldux, d_before = ocp.states();
  qp.Z = 2 * p.slack;
  qp.z = p.slack_linear;
  for (int k = 0; k <= qp.dims.N; ++k) {
    double* Q = qp.Q(k);
    std::fill_n(Q, ldx * ldx, 0.0);
    if (k > 0) {
      const mpc::OcpStage& s = ocp.stage(k);
      Q[0] = 2 * s.q_xx;
      Q[1] = Q[ldx] = 2 * s.q_xy;
      Q[ldx + 1] = 2 * s.q_yy;
      Q[2 * ldx + 2] = 2 * s.q_yaw;
      Q[3 * ldx + 3] = 2 * s.q_v;
    }
    if (k == qp.dims.N) break;
    Q[d_before * ldx + d_before] = 2 * p.r_d;
    double* R = qp.R(k);
    std::fill_n(R, 2 * ldux, 0.0);  // S too
    R[0] = 2 * (p.r_d + p.regularization) + damping / square(d_range(ocp.car()));
    R[ldux + 1] = 2 * ocp.weight_ddelta() + damping / square(ddelta_range(ocp.car()));
    qp.S(k)[d_before] = -2 * p.r_d;
  }
}

void set_cost_gradient(const mpc::Ocp& ocp, const NlpIterate& at, OcpQp& qp) {
  const mpc::OcpParams& p = ocp.params();
  const auto n = static_cast<std::size_t>(ocp.states());
  double d_before = ocp.throttle_before();
  for (int k = 0; k <= qp.dims.N; ++k) {
    const auto i = static_cast<std::size_t>(k);
    double* q = qp.q(k);
    if (k > 0) {
      const auto gradient = ocp.stage(k).tracking_gradient(at.x.data() + i * n);
      std::copy(gradient.begin(), gradient.end(), q);
    }
    if (k == qp.dims.N) break;
    const double d = at.u[2 * i], ddelta = at.u[2 * i + 1];
    double* r = qp.r(k);
    r[0] = 2 * (p.r_d * (d - d_before) + p.regularization * d);
    r[1] = 2 * ocp.weight_ddelta() * ddelta;
    q[n] = -2 * p.r_d * (d - d_before);
    d_before = d;
  }
}

void set_constraints(const mpc::Ocp& ocp, const NlpIterate& at, OcpQp& qp) {
  const Car& car = ocp.car();
  const auto n = static_cast<std::size_t>(ocp.states());
  for (int k = 0; k <= qp.dims.N; ++k) {
    const auto i = static_cast<std::size_t>(k);
    if (k > 0) {
      const double* x = at.x.data() + i * n;
      const mpc::OcpStage& s = ocp.stage(k);
      const double edge = s.across(x);
      qp.C(k)[0] = s.normal_x;
      qp.C(k)[1] = s.normal_y;
      qp.lg(k) = s.edge_lower - edge;
      qp.ug(k) = s.edge_upper - edge;
      qp.lbx(k) = s.delta_min - x[delta_index];
      qp.ubx(k) = s.delta_max - x[delta_index];
    }
    if (k == qp.dims.N) break;
    const double d = at.u[2 * i], ddelta = at.u[2 * i + 1];
    double *lbu = qp.lbu(k), *ubu = qp.ubu(k);
    lbu[0] = car.d_min - d;
    ubu[0] = car.d_max - d;
    lbu[1] = -car.ddelta_max - ddelta;
    ubu[1] = car.ddelta_max - ddelta;
  }
}

double set_dynamics(const NlpIterate& at, int nx, OcpQp& qp) {
  const auto n = static_cast<std::size_t>(nx);
  double largest = 0;
  for (int k = 0; k < qp.dims.N; ++k) {
    const auto i = static_cast<std::size_t>(k);
    qp.set_AB(k, at.A.data() + i * n * n, at.B.data() + i * n * 2, nx);
    qp.B(k)[nx * qp.dims.ldux] = 1;  // the state that remembers the throttle
    double* b = qp.b(k);
    for (std::size_t j = 0; j < n; ++j) {
      b[j] = at.x_next[i * n + j] - at.x[(i + 1) * n + j];
      largest = std::max(largest, std::abs(b[j]));
    }
  }
  return largest;
}

}  // namespace gripline::mpc_sqp
