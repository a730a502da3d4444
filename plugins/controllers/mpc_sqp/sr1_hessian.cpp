#include "controllers/mpc_sqp/sr1_hessian.hpp"

#include <algorithm>
#include <cmath>

namespace gripline::mpc_sqp {
namespace {

// An update is skipped where its denominator is small against what it may be: it would be noise, magnified.
constexpr double least_cosine = 1e-2;

std::size_t place(int k, int size) { return static_cast<std::size_t>(k) * static_cast<std::size_t>(size); }

}  // namespace

Sr1Hessian::Sr1Hessian(int N, int nx)
    : N_(N),
      nx_(nx),
      size_(nx + 2),
      c_(place(N, size_ * size_)),
      step_(static_cast<std::size_t>(size_)),
      change_(static_cast<std::size_t>(size_)),
      residual_(static_cast<std::size_t>(size_)) {}

/// s_k. The first state is given: what moved it is not a step.
void Sr1Hessian::set_step(const NlpIterate& from, const NlpIterate& to, int k) {
  const double *x0 = from.x.data() + place(k, nx_), *x1 = to.x.data() + place(k, nx_);
  const double *u0 = from.u.data() + place(k, 2), *u1 = to.u.data() + place(k, 2);
  for (int i = 0; i < nx_; ++i) step_[static_cast<std::size_t>(i)] = k == 0 ? 0.0 : x1[i] - x0[i];
  for (int i = 0; i < 2; ++i) step_[static_cast<std::size_t>(nx_) + static_cast<std::size_t>(i)] = u1[i] - u0[i];
}

void Sr1Hessian::set_change(const NlpIterate& from, const NlpIterate& to, const double* pi, int k) {
  const std::size_t n = static_cast<std::size_t>(nx_);
  const double *a0 = from.A.data() + place(k, nx_ * nx_), *a1 = to.A.data() + place(k, nx_ * nx_);
  const double *b0 = from.B.data() + place(k, nx_ * 2), *b1 = to.B.data() + place(k, nx_ * 2);
  std::fill(change_.begin(), change_.end(), 0.0);
  for (std::size_t l = 0; l < n; ++l) {
    for (std::size_t i = 0; i < n; ++i) change_[i] += pi[l] * (a1[l * n + i] - a0[l * n + i]);
    for (std::size_t i = 0; i < 2; ++i) change_[n + i] += pi[l] * (b1[l * 2 + i] - b0[l * 2 + i]);
  }
  if (k == 0) std::fill_n(change_.begin(), n, 0.0);
}

/// C += r r' / (r' s) with the residual r = change - C s.
void Sr1Hessian::update_stage(double* c) {
  const std::size_t size = static_cast<std::size_t>(size_);
  std::vector<double>& r = residual_;
  double rs = 0, rr = 0, ss = 0;
  for (std::size_t i = 0; i < size; ++i) {
    r[i] = change_[i];
    for (std::size_t j = 0; j < size; ++j) r[i] -= c[i * size + j] * step_[j];
    rs += r[i] * step_[i];
    rr += r[i] * r[i];
    ss += step_[i] * step_[i];
  }
  if (!(rr > 0) || !(std::abs(rs) >= least_cosine * std::sqrt(rr * ss))) return;
  for (std::size_t i = 0; i < size; ++i) {
    const double scale = r[i] / rs;
    for (std::size_t j = 0; j < size; ++j) c[i * size + j] += scale * r[j];
  }
}

void Sr1Hessian::update(const NlpIterate& from, const NlpIterate& to, const double* pi, int ldpi) {
  empty_ = false;
  for (int k = 0; k < N_; ++k) {
    set_step(from, to, k);
    set_change(from, to, pi + place(k + 1, ldpi), k);
    update_stage(c_.data() + place(k, size_ * size_));
  }
}

void Sr1Hessian::add_to(OcpQp& qp, double share) const {
  if (empty_) return;
  const int n = nx_, ldx = qp.dims.ldx, ldux = qp.dims.ldux;
  for (int k = 0; k < N_; ++k) {
    const double* c = c_.data() + place(k, size_ * size_);
    double *Q = qp.Q(k), *S = qp.S(k), *R = qp.R(k);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) Q[i * ldx + j] += share * c[i * size_ + j];
    }
    for (int i = 0; i < 2; ++i) {
      const double* row = c + (n + i) * size_;
      for (int j = 0; j < n; ++j) S[i * ldux + j] += share * row[j];
      for (int j = 0; j < 2; ++j) R[i * ldux + j] += share * row[n + j];
    }
  }
}

void Sr1Hessian::shift() {
  if (!empty_) std::copy(c_.begin() + static_cast<std::ptrdiff_t>(size_) * size_, c_.end(), c_.begin());
}

void Sr1Hessian::reset() {
  std::fill(c_.begin(), c_.end(), 0.0);
  empty_ = true;
}

}  // namespace gripline::mpc_sqp
