// The linear-quadratic problem of one Newton step, solved by dynamic programming over the horizon.
//
//   minimise   sum_k  1/2 z_k' H_k z_k + g_k' z_k  +  1/2 w_k' v_k^2 + s_k' v_k,    v_k = (u_k0, u_k1, x_k[bounded], a_k' x_k)
//   subject to x_0 given,  x_k+1 = M_k z_k + c_k,  M_k = [B_k A_k]
//
// The row terms (w, s) are what an active set or a barrier adds; they change between Newton steps while H, M stay.
// factor() is the part that depends on w, solve() the part that depends on s: a predictor and a corrector share a factor.
#pragma once

#include <cstddef>
#include <memory>

#include "controllers/mpc_sqp/vec4.hpp"

namespace gripline::ocp {

/// The two-sided rows of a stage, in this order.
enum Row : int { row_input0 = 0, row_input1 = 1, row_state = 2, row_soft = 3 };
inline constexpr int row_count = 4;

/// Data of the stages in the layout of the recursion. States are padded with zeros to whole vectors (`n`), a row of M_k or
/// of the inputs' Hessian is `width` = 4 + n doubles: columns 0, 1 the inputs, 2, 3 zero, 4 .. the states.
struct Links {
  Links(int horizon, int states);

  int horizon, states, n, width;
  int bounded_state = 0;

  double* link(int k) { return link_.data() + offset_of(k, n * width); }            // [n][width], k < N
  double* offset(int k) { return offset_.data() + offset_of(k, n); }                // c_k [n], k < N
  double* hessian_u(int k) { return hessian_u_.data() + offset_of(k, 2 * width); }  // (Huu, Hux) [2][width], k < N
  double* hessian_x(int k) { return hessian_x_.data() + offset_of(k, n * n); }      // Hxx [n][n], k <= N
  double* gradient(int k) { return gradient_.data() + offset_of(k, width); }        // g_k [width], k <= N
  double* row(int k) { return row_.data() + offset_of(k, n); }                      // a_k [n], k <= N
  const double* link(int k) const { return const_cast<Links*>(this)->link(k); }
  const double* offset(int k) const { return const_cast<Links*>(this)->offset(k); }
  const double* hessian_u(int k) const { return const_cast<Links*>(this)->hessian_u(k); }
  const double* hessian_x(int k) const { return const_cast<Links*>(this)->hessian_x(k); }
  const double* gradient(int k) const { return const_cast<Links*>(this)->gradient(k); }
  const double* row(int k) const { return const_cast<Links*>(this)->row(k); }

  /// The first `rows` rows of M_k, in the first `rows` states: A [rows][rows] and B [rows][2], row-major.
  void set_dynamics(int k, const double* a, const double* b, int rows);

 private:
  static std::size_t offset_of(int k, int size) { return static_cast<std::size_t>(k) * static_cast<std::size_t>(size); }
  Buffer link_, offset_, hessian_u_, hessian_x_, gradient_, row_;
};

/// Row terms of all stages, 4 per stage.
struct RowTerms {
  explicit RowTerms(int horizon) : weight(row_count * static_cast<std::size_t>(horizon + 1)), shift(weight.size()) {}
  Buffer weight, shift;
};

class Riccati {
 public:
  virtual ~Riccati() = default;
  /// Cost to go of every stage; false if the problem is not strictly convex in the inputs or not finite.
  virtual bool factor(const Links& links, const RowTerms& rows) = 0;
  /// z [N+1][width] and v [N+1][4] of the minimum, from x_0 in z. After factor().
  virtual void solve(const Links& links, const RowTerms& rows, double* z, double* v) = 0;
  /// Second derivative of the optimal cost along each row [N+1][4], its own weight included. After factor().
  virtual void curvatures(const Links& links, double* rows) const = 0;
};

/// The recursion compiled for up to 8, 12 or 16 states, or with loops of any length.
std::unique_ptr<Riccati> make_riccati(int horizon, int states);

}  // namespace gripline::ocp
