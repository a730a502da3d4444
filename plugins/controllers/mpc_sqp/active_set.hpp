// Newton's method on the optimality conditions of the program, which are linear between changes of the active set.
#pragma once

#include <vector>

#include "controllers/mpc_sqp/ocp_qp.hpp"
#include "controllers/mpc_sqp/riccati.hpp"
#include "controllers/mpc_sqp/vec4.hpp"

namespace gripline::ocp {

/// A point of the program: z and the rows' values v as in riccati.hpp, the rows' multipliers and sides.
struct Point {
  Point(int horizon, int states);
  double* stage(int k) { return z.data() + static_cast<std::size_t>(k) * width; }
  const double* stage(int k) const { return z.data() + static_cast<std::size_t>(k) * width; }
  void start(const double* x0, int states);
  void forget_guess();
  /// Whether the last state is finite: whatever is not finite on the way ends there.
  bool finite() const;

  int width;
  Buffer z;                // [N+1][width]
  Buffer v, multiplier;    // [N+1][row_count]
  Buffer stiffness;        // of the problem along each row while none is held, about; not 0 [N+1][row_count]
  std::vector<Side> side;  // [N+1][row_count]
  int measured_past = -1;  // soft rows past when the stiffness was measured; -1: never
};

/// Whether stage k of a horizon has a row.
inline bool has_row(int k, int horizon, int row) { return row < row_state ? k < horizon : k > 0; }

/// The unit in which a row's violation is measured.
double row_width(double lower, double upper);

struct ActiveSetResult {
  bool settled = false;
  int iterations = 0;
};

class ActiveSet {
 public:
  explicit ActiveSet(int horizon) : terms_(horizon) {}

  /// Measures the point's stiffness, with the soft rows past that its sides say, unless that was done for as many.
  /// False if the program has no unique solution.
  bool measure_stiffness(const OcpQp& qp, Riccati& riccati, Point& point);
  /// From the sides of `point` (its guess) to its solution and sides, in at most `iterations` Riccati sweeps.
  ActiveSetResult settle(const OcpQp& qp, Riccati& riccati, Point& point, int iterations, double tolerance);

 private:
  void set_weights(const OcpQp& qp, const Point& point, double spring);
  void set_shifts(const OcpQp& qp, const Point& point);
  /// The largest distance of a held row from its bound, relative to the row's width.
  double update_multipliers(const OcpQp& qp, Point& point) const;
  bool update_sides(const OcpQp& qp, Point& point, double tolerance) const;

  RowTerms terms_;
};

}  // namespace gripline::ocp
