// Newton's method on the optimality conditions of the program, which are linear between changes of the active set.
//
// Active constraints are kept by a quadratic penalty and multipliers (an augmented Lagrangian), so that every Newton
// step is one Riccati recursion.
// Source: Hintermueller, Ito, Kunisch (2002), "The primal-dual active set strategy as a semismooth Newton method".
#pragma once

#include <cstdint>
#include <vector>

#include "controllers/mpc_sqp/ocp_qp.hpp"
#include "controllers/mpc_sqp/riccati.hpp"

namespace gripline::mpc_sqp {

/// Which part of a constraint's piecewise penalty holds: none between the bounds, active at a bound, or violated, which
/// only a soft one may be.
enum class BoundStatus : std::int8_t {
  lower_violated = -2,
  lower_active = -1,
  inactive = 0,
  upper_active = 1,
  upper_violated = 2
};

/// A point of the program: ux and the constraints' values v as in riccati.hpp, their multipliers and status.
struct QpPoint {
  QpPoint(int N, int nx);
  double* stage(int k) { return ux.data() + static_cast<std::size_t>(k) * ldux; }
  const double* stage(int k) const { return ux.data() + static_cast<std::size_t>(k) * ldux; }
  /// x_0 [nx]; null for zero.
  void set_x0(const double* x0, int nx);
  /// Every constraint inactive, multipliers zero.
  void reset();
  /// Whether the last state is finite: whatever is not finite on the way ends there.
  bool finite() const;

  int ldux;
  Buffer ux;         // [N+1][ldux]
  Buffer v, lam;     // [N+1][con_count]; multipliers are positive at the upper bound, negative at the lower
  Buffer curvature;  // of the cost along each constraint while none is active, roughly; never 0 [N+1][con_count]
  std::vector<BoundStatus> status;  // [N+1][con_count]
  int curvature_at = -1;            // violated soft constraints when the curvature was computed; -1: never
};

/// The unit in which a constraint's violation is measured: the distance of its bounds, 1 where that is not finite.
double bound_range(double lower, double upper);

struct ActiveSetResult {
  bool settled = false;
  int iterations = 0;
};

class ActiveSet {
 public:
  explicit ActiveSet(int N) : terms_(N) {}

  /// Computes the point's curvature with the soft constraints violated that its status says, unless that was done for
  /// as many. False if the program has no unique solution.
  bool update_curvature(const OcpQp& qp, Riccati& riccati, QpPoint& point);
  /// From the status of `point` (its guess) to its solution and status, in at most `iterations` factorisations.
  ActiveSetResult settle(const OcpQp& qp, Riccati& riccati, QpPoint& point, int iterations, double tolerance);

 private:
  void set_Gamma(const OcpQp& qp, const QpPoint& point, double penalty);
  void set_gamma(const OcpQp& qp, const QpPoint& point);
  /// The largest distance of an active constraint from its bound, relative to the range of its bounds.
  double update_lam(const OcpQp& qp, QpPoint& point) const;
  bool update_status(const OcpQp& qp, QpPoint& point, double tolerance) const;

  ConstraintTerms terms_;
};

}  // namespace gripline::mpc_sqp
