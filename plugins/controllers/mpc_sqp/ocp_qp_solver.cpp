#include "controllers/mpc_sqp/ocp_qp_solver.hpp"

#include "controllers/mpc_sqp/interior_point.hpp"
#include "controllers/mpc_sqp/riccati.hpp"

namespace gripline::mpc_sqp {

struct OcpQpSolver::Work {
  Work(int N, int nx) : point(N, nx), riccati(make_riccati(N, nx)), active_set(N), interior_point(N, nx) {}
  QpPoint point;
  std::unique_ptr<Riccati> riccati;
  ActiveSet active_set;
  InteriorPoint interior_point;
};

OcpQpSolver::OcpQpSolver(int N, int nx) : work_(std::make_unique<Work>(N, nx)) {}
OcpQpSolver::~OcpQpSolver() = default;
OcpQpSolver::OcpQpSolver(OcpQpSolver&&) noexcept = default;
OcpQpSolver& OcpQpSolver::operator=(OcpQpSolver&&) noexcept = default;

OcpQpSolverStatistics OcpQpSolver::solve(const OcpQp& qp, const double* x0, const OcpQpSolverOptions& options) {
  Work& w = *work_;
  OcpQpSolverStatistics statistics;
  w.point.set_x0(x0, qp.dims.nx);
  const auto settle = [&](int iterations) {
    const ActiveSetResult result = w.active_set.settle(qp, *w.riccati, w.point, iterations, options.tol);
    statistics.active_set_iter += result.iterations;
    return result.settled;
  };
  if (!w.active_set.update_curvature(qp, *w.riccati, w.point)) return statistics;
  statistics.exact = settle(options.active_set_iter_max);
  if (!statistics.exact && options.ip_iter_max == 0) return statistics;
  if (!statistics.exact) {
    w.interior_point.start(qp, *w.riccati, w.point);
    while (!statistics.exact) {
      const int left = options.ip_iter_max - w.interior_point.iterations();
      const InteriorPoint::Status status = w.interior_point.iterate(qp, *w.riccati, w.point, options.ip_tol, left);
      statistics.ip_iter = w.interior_point.iterations();
      if (status == InteriorPoint::Status::failed) return statistics;
      w.interior_point.get_active_set(w.point);
      if (!w.active_set.update_curvature(qp, *w.riccati, w.point)) return statistics;
      statistics.exact = settle(5);
      if (status == InteriorPoint::Status::converged) break;
    }
    if (!statistics.exact) w.interior_point.get_solution(w.point);
  }
  statistics.solved = true;
  return statistics;
}

const double* OcpQpSolver::u(int k) const { return work_->point.stage(k); }
const double* OcpQpSolver::x(int k) const { return work_->point.stage(k) + 4; }
double* OcpQpSolver::lam(int k) { return work_->point.lam.data() + con_count * k; }
const double* OcpQpSolver::lam(int k) const { return work_->point.lam.data() + con_count * k; }
BoundStatus* OcpQpSolver::status(int k) { return work_->point.status.data() + con_count * k; }
const BoundStatus* OcpQpSolver::status(int k) const { return work_->point.status.data() + con_count * k; }
void OcpQpSolver::reset() { work_->point.reset(); }

/// Stationarity in x_k: pi_k = Q x_k + S' u_k + q + C' lam_g + lam_x + A' pi_k+1.
void OcpQpSolver::get_pi(const OcpQp& qp, double* pi) const {
  const int n = qp.dims.ldx, ldux = qp.dims.ldux;
  for (int k = qp.dims.N; k > 0; --k) {
    const double *xk = x(k), *uk = u(k), *lam_k = lam(k);
    const double* Q = qp.Q(k);
    for (int j = 0; j < n; j += 4) {
      Vec4 s = vec4(qp.q(k) + j) + lam_k[con_g] * vec4(qp.C(k) + j);
      for (int l = 0; l < n; ++l) s += xk[l] * vec4(Q + l * n + j);
      if (k < qp.dims.N) {
        const double *A = qp.A(k) + j, *S = qp.S(k) + j;
        s += uk[0] * vec4(S) + uk[1] * vec4(S + ldux);
        for (int l = 0; l < n; ++l) s += pi[(k + 1) * n + l] * vec4(A + l * ldux);
      }
      vec4(pi + k * n + j) = s;
    }
    pi[k * n + qp.idxbx] += lam_k[con_x];
  }
}

}  // namespace gripline::mpc_sqp
