#include "controllers/mpc_sqp/riccati.hpp"

#include <algorithm>
#include <cmath>

namespace gripline::mpc_sqp {
namespace {

/// The cost to go of stage k is 1/2 x' P_k x + p_k' x, its optimal inputs are u = K_k x + k_k:
///   P_k = Q + A' P_k+1 A + S' K,   K = -R^-1 S   with R, S short for R_k + B' P_k+1 B + Gamma_u and S_k + B' P_k+1 A
///   p_k = q + A' h + K' (r + B' h),   k_k = -R^-1 (r + B' h + gamma_u)   with h = P_k+1 b + p_k+1
/// P_k and p_k also take up Gamma and gamma of the state constraints.
/// kLdx is the padded number of states, or 0 where it is known at run time only.
template <int kLdx>
class Recursion final : public Riccati {
 public:
  Recursion(int N, int nx)
      : n_(padded(nx)),
        P_((N + 1) * size_n() * size_n()),
        p_((N + 1) * size_n()),
        Pb_((N + 1) * size_n()),
        S_((N + 1) * 2 * size_n()),
        K_((N + 1) * 2 * size_n()),
        R_inverse_((N + 1) * 4),
        k_((N + 1) * 4),
        h_(size_n()),
        PBA_(size_n() * (size_n() + 4)) {}

  bool factorize(const OcpQp& qp, const ConstraintTerms& terms) override;
  void solve(const OcpQp& qp, const ConstraintTerms& terms, double* ux, double* v) override;
  void curvatures(const OcpQp& qp, double* curvature) const override;

 private:
  int n() const { return kLdx > 0 ? kLdx : n_; }
  std::size_t size_n() const { return static_cast<std::size_t>(n()); }
  double* at(Buffer& buffer, int k, int size) { return buffer.data() + static_cast<std::size_t>(k) * size; }
  const double* at(const Buffer& buffer, int k, int size) const {
    return buffer.data() + static_cast<std::size_t>(k) * size;
  }
  void multiply_PBA(const double* P, const double* BA);
  bool eliminate_inputs(const OcpQp& qp, const ConstraintTerms& terms, int k);
  void update_P(const OcpQp& qp, int k);
  void add_state_terms(const OcpQp& qp, const ConstraintTerms& terms, int k);
  void backward(const OcpQp& qp, const ConstraintTerms& terms);
  void forward_states(const OcpQp& qp, int k, const double* ux, double* x_next) const;

  int n_;
  Buffer P_, p_;      // [n][n], [n]
  Buffer Pb_;         // P_k+1 b_k [n]
  Buffer S_, K_;      // [2][n]
  Buffer R_inverse_;  // (00, 01, 11), 3 of 4
  Buffer k_;          // [2], 2 of 4
  Buffer h_;          // [n]
  Buffer PBA_;        // P_k+1 [B_k 0 A_k] [n][ldux]
};

/// PBA_ = P [B 0 A], four rows at a time.
template <int kLdx>
void Recursion<kLdx>::multiply_PBA(const double* P, const double* BA) {
  const int n = this->n(), ldux = n + 4;
  double* out = PBA_.data();
  for (int i = 0; i < n; i += 4) {
    for (int j = 0; j < ldux; j += 4) {
      Vec4 s0{}, s1{}, s2{}, s3{};
      for (int l = 0; l < n; ++l) {
        const Vec4 b = vec4(BA + l * ldux + j);
        const double* column = P + l * n + i;  // P is symmetric: its row l read as column l
        s0 += column[0] * b;
        s1 += column[1] * b;
        s2 += column[2] * b;
        s3 += column[3] * b;
      }
      vec4(out + (i + 0) * ldux + j) = s0;
      vec4(out + (i + 1) * ldux + j) = s1;
      vec4(out + (i + 2) * ldux + j) = s2;
      vec4(out + (i + 3) * ldux + j) = s3;
    }
  }
}

/// R, its inverse, S and K; false if R is not positive definite.
template <int kLdx>
bool Recursion<kLdx>::eliminate_inputs(const OcpQp& qp, const ConstraintTerms& terms, int k) {
  const int n = this->n(), ldux = n + 4;
  const double* BA = qp.B(k);
  const double* RS = qp.R(k);
  Vec4 h0 = vec4(RS), h1 = vec4(RS + ldux);
  for (int l = 0; l < n; ++l) {
    const Vec4 w = vec4(PBA_.data() + l * ldux);
    h0 += BA[l * ldux] * w;
    h1 += BA[l * ldux + 1] * w;
  }
  const double* Gamma = terms.Gamma.data() + con_count * k;
  const double a = h0[0] + Gamma[con_u0], b = h0[1], c = h1[1] + Gamma[con_u1];
  const double ratio = b / a, schur = c - b * ratio;
  if (!(a > 0) || !(schur > 1e-14 * c) || !std::isfinite(a + c)) return false;
  double* inverse = at(R_inverse_, k, 4);
  inverse[2] = 1.0 / schur;
  inverse[1] = -ratio * inverse[2];
  inverse[0] = 1.0 / a - ratio * inverse[1];
  double* S = at(S_, k, 2 * n);
  double* K = at(K_, k, 2 * n);
  for (int j = 0; j < n; j += 4) {
    Vec4 x0 = vec4(RS + 4 + j), x1 = vec4(RS + ldux + 4 + j);
    for (int l = 0; l < n; ++l) {
      const Vec4 w = vec4(PBA_.data() + l * ldux + 4 + j);
      x0 += BA[l * ldux] * w;
      x1 += BA[l * ldux + 1] * w;
    }
    vec4(S + j) = x0;
    vec4(S + n + j) = x1;
    vec4(K + j) = -(inverse[0] * x0 + inverse[1] * x1);
    vec4(K + n + j) = -(inverse[1] * x0 + inverse[2] * x1);
  }
  return true;
}

/// P_k without the state constraints: the blocks on and right of the diagonal, the others mirrored.
template <int kLdx>
void Recursion<kLdx>::update_P(const OcpQp& qp, int k) {
  const int n = this->n(), ldux = n + 4;
  const double* A = qp.A(k);
  const double* Q = qp.Q(k);
  const double* S = at(S_, k, 2 * n);
  const double* K = at(K_, k, 2 * n);
  double* P = at(P_, k, n * n);
  for (int i = 0; i < n; i += 4) {
    for (int j = i; j < n; j += 4) {
      Vec4 s[4];
      const Vec4 k0 = vec4(K + j), k1 = vec4(K + n + j);
      for (int r = 0; r < 4; ++r) {
        s[r] = vec4(Q + (i + r) * n + j) + S[i + r] * k0 + S[n + i + r] * k1;
      }
      for (int l = 0; l < n; ++l) {
        const Vec4 w = vec4(PBA_.data() + l * ldux + 4 + j);
        const double* column = A + l * ldux + i;
        s[0] += column[0] * w;
        s[1] += column[1] * w;
        s[2] += column[2] * w;
        s[3] += column[3] * w;
      }
      for (int r = 0; r < 4; ++r) vec4(P + (i + r) * n + j) = s[r];
      if (j == i) {
        for (int r = 1; r < 4; ++r) {
          for (int q = 0; q < r; ++q) P[(i + r) * n + i + q] = P[(i + q) * n + i + r];
        }
      } else {
        for (int r = 0; r < 4; ++r) {
          for (int q = 0; q < 4; ++q) P[(j + q) * n + i + r] = s[r][q];
        }
      }
    }
  }
}

template <int kLdx>
void Recursion<kLdx>::add_state_terms(const OcpQp& qp, const ConstraintTerms& terms, int k) {
  const int n = this->n();
  double* P = at(P_, k, n * n);
  const double* Gamma = terms.Gamma.data() + con_count * k;
  const int bounded = qp.idxbx;
  const double* C = qp.C(k);
  P[bounded * n + bounded] += Gamma[con_x];
  if (Gamma[con_g] == 0) return;
  for (int i = 0; i < n; ++i) {
    const double scale = Gamma[con_g] * C[i];
    if (scale == 0) continue;
    for (int j = 0; j < n; j += 4) vec4(P + i * n + j) += scale * vec4(C + j);
  }
}

template <int kLdx>
bool Recursion<kLdx>::factorize(const OcpQp& qp, const ConstraintTerms& terms) {
  const int n = this->n();
  const int last = qp.dims.N;
  std::copy_n(qp.Q(last), n * n, at(P_, last, n * n));
  add_state_terms(qp, terms, last);
  for (int k = last - 1; k >= 0; --k) {
    const double* P = at(P_, k + 1, n * n);
    const double* b = qp.b(k);
    double* Pb = at(Pb_, k, n);
    for (int j = 0; j < n; j += 4) {
      Vec4 s{};
      for (int l = 0; l < n; ++l) s += b[l] * vec4(P + l * n + j);
      vec4(Pb + j) = s;
    }
    multiply_PBA(P, qp.B(k));
    if (!eliminate_inputs(qp, terms, k)) return false;
    if (k == 0) break;  // x_0 is given
    update_P(qp, k);
    add_state_terms(qp, terms, k);
  }
  return true;
}

/// p_k and k_k.
template <int kLdx>
void Recursion<kLdx>::backward(const OcpQp& qp, const ConstraintTerms& terms) {
  const int n = this->n(), ldux = n + 4;
  double* h = h_.data();
  std::copy_n(qp.q(qp.dims.N), n, at(p_, qp.dims.N, n));
  for (int k = qp.dims.N;; --k) {
    double* p = at(p_, k, n);
    const double* gamma = terms.gamma.data() + con_count * k;
    const double* C = qp.C(k);
    p[qp.idxbx] += gamma[con_x];
    for (int j = 0; j < n; j += 4) vec4(p + j) += gamma[con_g] * vec4(C + j);
    if (k == 0) break;

    const double* BA = qp.B(k - 1);
    const double* rq = qp.r(k - 1);
    const double* Pb = at(Pb_, k - 1, n);
    const double* input_gamma = terms.gamma.data() + con_count * (k - 1);
    for (int j = 0; j < n; j += 4) vec4(h + j) = vec4(p + j) + vec4(Pb + j);
    Vec4 r = vec4(rq);
    for (int l = 0; l < n; ++l) r += h[l] * vec4(BA + l * ldux);
    const double r0 = r[0] + input_gamma[con_u0], r1 = r[1] + input_gamma[con_u1];
    const double* inverse = at(R_inverse_, k - 1, 4);
    double* feedforward = at(k_, k - 1, 4);
    feedforward[0] = -(inverse[0] * r0 + inverse[1] * r1);
    feedforward[1] = -(inverse[1] * r0 + inverse[2] * r1);
    const double* K = at(K_, k - 1, 2 * n);
    double* before = at(p_, k - 1, n);
    for (int j = 0; j < n; j += 4) {
      Vec4 s = vec4(rq + 4 + j) + r0 * vec4(K + j) + r1 * vec4(K + n + j);
      for (int l = 0; l < n; ++l) s += h[l] * vec4(BA + l * ldux + 4 + j);
      vec4(before + j) = s;
    }
  }
}

/// x_next = A x + B u + b, four rows at a time.
template <int kLdx>
void Recursion<kLdx>::forward_states(const OcpQp& qp, int k, const double* ux, double* x_next) const {
  const int n = this->n(), ldux = n + 4;
  const double* BA = qp.B(k);
  const double* b = qp.b(k);
  for (int i = 0; i < n; i += 4, BA += 4 * ldux) {
    Vec4 s[4] = {};
    for (int j = 0; j < ldux; j += 4) {
      const Vec4 column = vec4(ux + j);
      for (int r = 0; r < 4; ++r) s[r] += vec4(BA + r * ldux + j) * column;
    }
    vec4(x_next + i) = vec4(b + i) + sums(s[0], s[1], s[2], s[3]);
  }
}

template <int kLdx>
void Recursion<kLdx>::solve(const OcpQp& qp, const ConstraintTerms& terms, double* ux, double* v) {
  backward(qp, terms);
  const int n = this->n(), ldux = n + 4;
  for (int k = 0;; ++k, ux += ldux, v += con_count) {
    const double* x = ux + 4;
    const double* C = qp.C(k);
    Vec4 Cx{};
    for (int j = 0; j < n; j += 4) Cx += vec4(C + j) * vec4(x + j);
    Vec4 u{};
    if (k < qp.dims.N) {
      const double* K = at(K_, k, 2 * n);
      const double* feedforward = at(k_, k, 4);
      Vec4 u0{}, u1{};
      for (int j = 0; j < n; j += 4) {
        u0 += vec4(K + j) * vec4(x + j);
        u1 += vec4(K + n + j) * vec4(x + j);
      }
      u = Vec4{feedforward[0] + sum(u0), feedforward[1] + sum(u1), 0, 0};
    }
    vec4(ux) = u;
    vec4(v) = Vec4{u[0], u[1], x[qp.idxbx], sum(Cx)};
    if (k == qp.dims.N) return;
    forward_states(qp, k, ux, ux + ldux + 4);
  }
}

template <int kLdx>
void Recursion<kLdx>::curvatures(const OcpQp& qp, double* curvature) const {
  const int n = this->n();
  for (int k = 0; k <= qp.dims.N; ++k, curvature += con_count) {
    std::fill_n(curvature, con_count, 0.0);
    if (k < qp.dims.N) {
      const double* inverse = at(R_inverse_, k, 4);
      const double determinant = inverse[0] * inverse[2] - inverse[1] * inverse[1];
      curvature[con_u0] = inverse[2] / determinant;
      curvature[con_u1] = inverse[0] / determinant;
    }
    if (k == 0) continue;
    const double* P = at(P_, k, n * n);
    const double* C = qp.C(k);
    curvature[con_x] = P[qp.idxbx * n + qp.idxbx];
    for (int i = 0; i < n; ++i) {
      for (int j = 0; C[i] != 0 && j < n; ++j) curvature[con_g] += C[i] * P[i * n + j] * C[j];
    }
  }
}

}  // namespace

std::unique_ptr<Riccati> make_riccati(int N, int nx) {
  switch (padded(nx)) {
    case 4:
      return std::make_unique<Recursion<4>>(N, nx);
    case 8:
      return std::make_unique<Recursion<8>>(N, nx);
    case 12:
      return std::make_unique<Recursion<12>>(N, nx);
    case 16:
      return std::make_unique<Recursion<16>>(N, nx);
    default:
      return std::make_unique<Recursion<0>>(N, nx);
  }
}

}  // namespace gripline::mpc_sqp
