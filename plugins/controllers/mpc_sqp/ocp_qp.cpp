#include "controllers/mpc_sqp/ocp_qp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "controllers/mpc_sqp/active_set.hpp"
#include "controllers/mpc_sqp/interior_point.hpp"

namespace gripline::ocp {

OcpQp::OcpQp(int horizon, int states)
    : links(horizon, states), bounds_(2u * row_count * static_cast<std::size_t>(horizon + 1)) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (int k = 0; k <= horizon; ++k) {
    std::fill_n(lower(k), row_count, -infinity);
    std::fill_n(upper(k), row_count, infinity);
  }
}

struct OcpQpSolver::Work {
  Work(int horizon, int states)
      : point(horizon, states),
        riccati(make_riccati(horizon, states)),
        active_set(horizon),
        interior(horizon, states) {}
  Point point;
  std::unique_ptr<Riccati> riccati;
  ActiveSet active_set;
  InteriorPoint interior;
};

OcpQpSolver::OcpQpSolver(int horizon, int states) : work_(std::make_unique<Work>(horizon, states)) {}
OcpQpSolver::~OcpQpSolver() = default;
OcpQpSolver::OcpQpSolver(OcpQpSolver&&) noexcept = default;
OcpQpSolver& OcpQpSolver::operator=(OcpQpSolver&&) noexcept = default;

QpReport OcpQpSolver::solve(const OcpQp& qp, const double* x0, const QpOptions& options) {
  Work& w = *work_;
  QpReport report;
  w.point.start(x0, qp.states());
  const auto settle = [&](int iterations) {
    const ActiveSetResult result = w.active_set.settle(qp, *w.riccati, w.point, iterations, options.tolerance);
    report.active_set_iterations += result.iterations;
    return result.settled;
  };
  if (!w.active_set.measure_stiffness(qp, *w.riccati, w.point)) return report;
  report.exact = settle(options.active_set_iterations);
  if (!report.exact) {
    w.interior.start(qp, *w.riccati, w.point);
    while (!report.exact) {
      const int left = options.interior_iterations - w.interior.iterations();
      const InteriorPoint::State state = w.interior.iterate(qp, *w.riccati, w.point, options.interior_tolerance, left);
      report.interior_iterations = w.interior.iterations();
      if (state == InteriorPoint::State::failed) return report;
      w.interior.suggestion(w.point);
      if (!w.active_set.measure_stiffness(qp, *w.riccati, w.point)) return report;
      report.exact = settle(5);
      if (state == InteriorPoint::State::converged) break;
    }
    if (!report.exact) w.interior.solution(w.point);
  }
  report.solved = true;
  return report;
}

const double* OcpQpSolver::input(int k) const { return work_->point.stage(k); }
const double* OcpQpSolver::state(int k) const { return work_->point.stage(k) + 4; }
double* OcpQpSolver::row_multiplier(int k) { return work_->point.multiplier.data() + row_count * k; }
const double* OcpQpSolver::row_multiplier(int k) const { return work_->point.multiplier.data() + row_count * k; }
Side* OcpQpSolver::side(int k) { return work_->point.side.data() + row_count * k; }
const Side* OcpQpSolver::side(int k) const { return work_->point.side.data() + row_count * k; }
void OcpQpSolver::forget_guess() { work_->point.forget_guess(); }

void OcpQpSolver::dynamics_multipliers(const OcpQp& qp, double* pi) const {
  // Stationarity in x_k: pi_k = Hxx x_k + Hux' u_k + g_x + rows + A' pi_k+1.
  const Links& links = qp.links;
  const int n = links.n, width = links.width;
  for (int k = links.horizon; k > 0; --k) {
    const double *x = state(k), *u = input(k), *y = row_multiplier(k);
    const double* hessian = links.hessian_x(k);
    for (int j = 0; j < n; j += 4) {
      Vec4 s = vec4(links.gradient(k) + 4 + j) + y[row_soft] * vec4(links.row(k) + j);
      for (int l = 0; l < n; ++l) s += x[l] * vec4(hessian + l * n + j);
      if (k < links.horizon) {
        const double *m = links.link(k) + 4 + j, *hux = links.hessian_u(k) + 4 + j;
        s += u[0] * vec4(hux) + u[1] * vec4(hux + width);
        for (int l = 0; l < n; ++l) s += pi[(k + 1) * n + l] * vec4(m + l * width);
      }
      vec4(pi + k * n + j) = s;
    }
    pi[k * n + links.bounded_state] += y[row_state];
  }
}

}  // namespace gripline::ocp
