// A quadratic program with the structure of an optimal control problem, named as in HPIPM and acados.
//
//   minimise    sum_k=0..N  1/2 [u_k; x_k]' [R_k S_k; S_k' Q_k] [u_k; x_k] + r_k' u_k + q_k' x_k
//             + sum_k=1..N  1/2 Z (sl_k^2 + su_k^2) + z (sl_k + su_k)
//   subject to  x_0 given,   x_k+1 = A_k x_k + B_k u_k + b_k                  k = 0 .. N-1
//               lbu_k <= u_k <= ubu_k                                         k = 0 .. N-1
//               lbx_k <= x_k[idxbx] <= ubx_k                                  k = 1 .. N
//               lg_k - sl_k <= C_k x_k <= ug_k + su_k,   sl_k, su_k >= 0      k = 1 .. N
//
// There are no inputs at k = N. Two inputs, any number of states, one bounded state, one general constraint, which is
// soft. What couples an input to its predecessor is expressed by a state that remembers it. The slacks never become
// variables.
// Source of the names: Frison, Diehl (2020), "HPIPM: a high-performance quadratic programming framework for model
// predictive control"; Verschueren et al. (2022), "acados".
#pragma once

#include <cstddef>

#include "controllers/mpc_sqp/vec4.hpp"

namespace gripline::mpc_sqp {

struct OcpQpDims {
  OcpQpDims(int N, int nx) : N(N), nx(nx), ldx(padded(nx)), ldux(4 + ldx) {}

  static constexpr int nu = 2;
  int N, nx;
  int ldx;   // states padded with zeros to whole vectors: doubles of a state, of a row of Q
  int ldux;  // doubles of (u, x): columns 0, 1 the inputs, 2, 3 zero, 4 .. the states
};

/// The two-sided constraints of a stage, in the order of lb and ub: both inputs, the bounded state, the general one.
enum Constraint : int { con_u0 = 0, con_u1 = 1, con_x = 2, con_g = 3 };
inline constexpr int con_count = 4;

/// Whether stage k has a constraint.
inline bool has_constraint(int k, int N, int constraint) { return constraint < con_x ? k < N : k > 0; }

/// Data of the program. Matrices are row-major; a row of A, B, R, S takes dims.ldux doubles, a row of Q dims.ldx.
/// Padding stays zero. Bounds that a stage lacks are ignored; infinite ones are allowed, a lower above its upper one is
/// not. All memory is taken by the constructor, which sets bounds infinite and the rest zero.
class OcpQp {
 public:
  OcpQp(int N, int nx);

  OcpQpDims dims;
  int idxbx = 0;   // which state is bounded
  double Z = 2.0;  // weight of a squared slack, of either side; > 0
  double z = 0.0;  // weight of a slack; >= 0

  double* A(int k) { return BA_[k] + 4; }   // [nx][nx], k < N
  double* B(int k) { return BA_[k]; }       // [nx][nu], k < N
  double* b(int k) { return b_[k]; }        // [nx], k < N
  double* Q(int k) { return Q_[k]; }        // [nx][nx], k <= N
  double* R(int k) { return RS_[k]; }       // [nu][nu], k < N
  double* S(int k) { return RS_[k] + 4; }   // [nu][nx], k < N
  double* r(int k) { return rq_[k]; }       // [nu], k < N
  double* q(int k) { return rq_[k] + 4; }   // [nx], k <= N
  double* C(int k) { return C_[k]; }        // [nx], k <= N
  double* lb(int k) { return bounds_[k]; }  // [con_count]: lbu, lbx, lg
  double* ub(int k) { return bounds_[k] + con_count; }
  double* lbu(int k) { return lb(k); }  // [nu]
  double* ubu(int k) { return ub(k); }
  double& lbx(int k) { return lb(k)[con_x]; }
  double& ubx(int k) { return ub(k)[con_x]; }
  double& lg(int k) { return lb(k)[con_g]; }
  double& ug(int k) { return ub(k)[con_g]; }

  const double* A(int k) const { return BA_[k] + 4; }
  const double* B(int k) const { return BA_[k]; }
  const double* b(int k) const { return b_[k]; }
  const double* Q(int k) const { return Q_[k]; }
  const double* R(int k) const { return RS_[k]; }
  const double* S(int k) const { return RS_[k] + 4; }
  const double* r(int k) const { return rq_[k]; }
  const double* q(int k) const { return rq_[k] + 4; }
  const double* C(int k) const { return C_[k]; }
  const double* lb(int k) const { return bounds_[k]; }
  const double* ub(int k) const { return bounds_[k] + con_count; }

  /// The first n rows of A_k and B_k, in the first n states: A [n][n] and B [n][nu] without padding.
  void set_AB(int k, const double* A, const double* B, int n);

 private:
  /// The doubles of every stage, one stage after the other.
  class PerStage {
   public:
    PerStage(int stages, int size)
        : size_(static_cast<std::size_t>(size)), buffer_(static_cast<std::size_t>(stages) * size_) {}
    double* operator[](int k) { return buffer_.data() + static_cast<std::size_t>(k) * size_; }
    const double* operator[](int k) const { return buffer_.data() + static_cast<std::size_t>(k) * size_; }

   private:
    std::size_t size_;
    Buffer buffer_;
  };
  PerStage BA_, b_, RS_, Q_, rq_, C_, bounds_;
};

}  // namespace gripline::mpc_sqp
