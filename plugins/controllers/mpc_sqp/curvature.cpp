#include "controllers/mpc_sqp/curvature.hpp"

#include <algorithm>
#include <cmath>

namespace gripline::mpc {
namespace {

// An update is skipped where its denominator is small against what it may be: it would be noise, magnified.
constexpr double least_cosine = 1e-2;

std::size_t place(int k, int size) { return static_cast<std::size_t>(k) * static_cast<std::size_t>(size); }

}  // namespace

Curvature::Curvature(int horizon, int states)
    : horizon_(horizon),
      states_(states),
      size_(states + 2),
      c_(place(horizon, size_ * size_)),
      step_(static_cast<std::size_t>(size_)),
      change_(static_cast<std::size_t>(size_)),
      residual_(static_cast<std::size_t>(size_)) {}

/// s_k. The first state is given: what moved it is not a step.
void Curvature::stage_step(const LinearisedRows& from, const LinearisedRows& to, int k) {
  const double *x0 = from.x.data() + place(k, states_), *x1 = to.x.data() + place(k, states_);
  const double *u0 = from.u.data() + place(k, 2), *u1 = to.u.data() + place(k, 2);
  for (int i = 0; i < states_; ++i) step_[static_cast<std::size_t>(i)] = k == 0 ? 0.0 : x1[i] - x0[i];
  for (int i = 0; i < 2; ++i) step_[static_cast<std::size_t>(states_) + static_cast<std::size_t>(i)] = u1[i] - u0[i];
}

void Curvature::stage_change(const LinearisedRows& from, const LinearisedRows& to, const double* pi, int k) {
  const std::size_t n = static_cast<std::size_t>(states_);
  const double *a0 = from.a.data() + place(k, states_ * states_), *a1 = to.a.data() + place(k, states_ * states_);
  const double *b0 = from.b.data() + place(k, states_ * 2), *b1 = to.b.data() + place(k, states_ * 2);
  std::fill(change_.begin(), change_.end(), 0.0);
  for (std::size_t l = 0; l < n; ++l) {
    for (std::size_t i = 0; i < n; ++i) change_[i] += pi[l] * (a1[l * n + i] - a0[l * n + i]);
    for (std::size_t i = 0; i < 2; ++i) change_[n + i] += pi[l] * (b1[l * 2 + i] - b0[l * 2 + i]);
  }
  if (k == 0) std::fill_n(change_.begin(), n, 0.0);
}

/// C += r r' / (r' s) with the residual r = change - C s.
void Curvature::update(double* c) {
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

void Curvature::learn(const LinearisedRows& from, const LinearisedRows& to, const double* multipliers, int stride) {
  empty_ = false;
  for (int k = 0; k < horizon_; ++k) {
    stage_step(from, to, k);
    stage_change(from, to, multipliers + place(k + 1, stride), k);
    update(c_.data() + place(k, size_ * size_));
  }
}

void Curvature::add_to(ocp::Links& links) const {
  if (empty_) return;
  const int n = states_;
  for (int k = 0; k < horizon_; ++k) {
    const double* c = c_.data() + place(k, size_ * size_);
    double *h = links.hessian_x(k), *hu = links.hessian_u(k);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) h[i * links.n + j] += c[i * size_ + j];
    }
    for (int i = 0; i < 2; ++i) {
      const double* row = c + (n + i) * size_;
      for (int j = 0; j < n; ++j) hu[i * links.width + 4 + j] += row[j];
      for (int j = 0; j < 2; ++j) hu[i * links.width + j] += row[n + j];
    }
  }
}

void Curvature::shift() {
  if (!empty_) std::copy(c_.begin() + static_cast<std::ptrdiff_t>(size_) * size_, c_.end(), c_.begin());
}

void Curvature::forget() {
  std::fill(c_.begin(), c_.end(), 0.0);
  empty_ = true;
}

}  // namespace gripline::mpc
