// The fastest flying lap as a nonlinear program: direct collocation along the centre line, solved by Ipopt.
//
//   minimise  sum_k ds_k time(z_k) (1 + w (rate_k / rate_max)^2),      z_k = ((x_k + x_k+1) / 2, u_k)
//   subject to  x_k+1 - x_k = ds_k dx/ds(z_k)   (implicit midpoint, x_N = x_0),
//               n inside the edges at the nodes and half-way between, or the car's four corners half-way between,
//               |delta| <= delta_max, |rate| <= rate_max, d_min <= d <= d_max,
//               used(z_k) <= 1 for a car that states what its tyres hold (LapCar::bounded)
//   with  time = (1 - n kappa) / (vx cos(xi) - vy sin(xi)) per metre of the centre line,
//         n' = (vx sin(xi) + vy cos(xi)) time,  xi' = omega time - kappa,  delta' = rate time,
//         (vx, vy, omega)' = the plant's rates times time
//
// The change of the independent variable is that of Lot, Biral, "A curvilinear abscissa approach for the lap time
// optimization of racing vehicles" (2014). Slips have no bound: this car may drift.
//
// Drive and brake are different formulas, whose slopes differ at d = 0, where a Newton method needs smooth ones. Hence
// the rates are r(d+) + r(d-) - r(0) with d+ = (d + sqrt(d^2 + e^2)) / 2, d- = d - d+; e = 0.002.
#pragma once

#include "limit/lap_car.hpp"
#include "limit/lap_mesh.hpp"

namespace gripline {

struct LapProblem {
  const LapCar& plant;
  const LapMesh& mesh;
  bool body = false;         ///< the car's corners inside, not only its centre of gravity
  double smoothness = 1e-4;  ///< the weight w
};

/// How far the guess is from a solution: of a warm start it is near one.
enum class LapStart { cold, warm };

/// Stops on iterations, never on time.
Lap solve_lap(const LapProblem& problem, const Lap& guess, LapStart start, int max_iterations = 600);

/// Offset from the centre line, of curvature kappa, of the point that lies (forward, left) in the axes of a car at
/// offset n and heading xi relative to the line: exact on arcs and straights. [m]
template <class T>
T offset_of_corner(const T& n, const T& xi, double kappa, double forward, double left) {
  using std::cos, std::sin, std::sqrt;
  const T along = forward * cos(xi) - left * sin(xi), across = n + forward * sin(xi) + left * cos(xi);
  const T inward = 1.0 - kappa * across;
  return (2.0 * across - kappa * (across * across + along * along)) /
         (1.0 + sqrt(inward * inward + (kappa * kappa) * (along * along)));
}

}  // namespace gripline
