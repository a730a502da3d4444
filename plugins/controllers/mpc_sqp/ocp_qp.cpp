#include "controllers/mpc_sqp/ocp_qp.hpp"

#include <algorithm>
#include <limits>

namespace gripline::mpc_sqp {

OcpQp::OcpQp(int N, int nx)
    : dims(N, nx),
      BA_(N, dims.ldx * dims.ldux),
      b_(N, dims.ldx),
      RS_(N, OcpQpDims::nu * dims.ldux),
      Q_(N + 1, dims.ldx * dims.ldx),
      rq_(N + 1, dims.ldux),
      C_(N + 1, dims.ldx),
      bounds_(N + 1, 2 * con_count) {
  const double infinity = std::numeric_limits<double>::infinity();
  for (int k = 0; k <= N; ++k) {
    std::fill_n(lb(k), con_count, -infinity);
    std::fill_n(ub(k), con_count, infinity);
  }
}

void OcpQp::set_AB(int k, const double* A, const double* B, int n) {
  double* row = this->B(k);
  for (int i = 0; i < n; ++i, row += dims.ldux) {
    row[0] = B[2 * i];
    row[1] = B[2 * i + 1];
    std::copy_n(A + i * n, n, row + 4);
  }
}

}  // namespace gripline::mpc_sqp
