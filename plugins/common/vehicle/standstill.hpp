// What car models share about standing and rolling backwards: forces that oppose the motion, and steered wheels.
//
// Dry friction opposes the motion, and at rest whatever else pulls, up to its largest size. Both are smoothed for
// explicit integration:
//   resistance   Fres = (rolling + drag vx^2) clamp(vx / crawl, -1, 1)
//   brakes       B = -brake d for d < 0;   Fd = -clamp(m (k vx - max(0, 1 - |vx| / slow) g sin(grade)), -B, B)
//                with k = min(hold, B / (m slow)); crawl, slow and hold are crawl_speed, weak_brake_speed and
//                largest_hold_rate below
// Inside the bounds vx' = -k vx - g sin(grade) |vx| / slow - Fres / m, which is 0 at rest and stable where k exceeds
// g |sin(grade)| / slow: a car whose brakes are stronger than the slope, up to 19 degrees, comes to rest and stays
// there, where a force that only rises with speed would let it creep downhill. Forwards and faster than slow and B /
// (m hold), 0.2 m/s for 8 m/s2, Fd = brake d. k is what explicit methods and solvers can bear: along the car steps of
// at most 2 / (hold + g |sin(grade)| / slow + rolling / (m crawl)) are stable, on the flat 48 ms for the full-size car
// and 19 ms for the 1:43 car of worlds/cars (what effects add to rolling counts too); and a plan that ends at rest
// still converges where brakes are weak. Across, tyres at rest are as stiff as at `crawl`: steps of 20 ms need substeps
// there. Slopes and forces that effects of Stage::body add are not known here: a car held against an acceleration a
// creeps at a / k.
//
// The front wheels of a car that rolls backwards point, seen along its motion, to the other side: with the velocity vyf
// of the front axle to the left,
//   front slip = atan(clamp(vx / crawl, -1, 1) tan(delta)) - atan2(vyf, max(|vx|, crawl))
// vanishes where the wheels roll where they point, vyf = vx tan(delta), for either sign of vx: their force never adds
// to the kinetic energy. At rest no tyre pushes.
//
// Sources: dry friction with sticking: Karnopp, Computer Simulation of Stick-Slip Friction in Mechanical Dynamic
// Systems, J. Dyn. Sys. Meas. Control 107 (1985), with a rate in place of a zero-velocity band; slip as the angle
// between a wheel's plane and its velocity: ISO 8855, Pacejka, Tyre and Vehicle Dynamics, 2.2.
#pragma once

#include <gripline/plugin.hpp>
#include <gripline/slip.hpp>

namespace gripline::vehicle {

inline constexpr double crawl_speed = 0.02;        // full resistance and full slip from this speed on [m/s]
inline constexpr double weak_brake_speed = 0.08;   // up to this speed weak brakes fade in [m/s]
inline constexpr double largest_hold_rate = 40.0;  // largest rate at which brakes take the last speed away [1/s]

/// From -1 backwards to 1 forwards.
template <class T>
T direction(const T& vx) {
  return clamp_value(vx * (1.0 / crawl_speed), -1.0, 1.0);
}

/// Force of the motor that brakes at d = -1, (Cm1 - Cm2 |vx|), and never one that drives [N].
template <class T>
T motor_brake(const T& Cm1, const T& Cm2, const T& vx) {
  using gripline::max, std::max;
  using std::abs;
  return max(T(0), Cm1 - Cm2 * T(abs(vx)));
}

/// Fres, against the motion [N].
template <class T>
T resistance(const Quantities<T>& q) {
  return direction(q.vx) * (q.rolling + q.drag * square(q.vx));
}

/// Fd [N] of a car of mass m [kg] on a grade [rad]: the motor for d >= 0, brakes that hold below.
template <class T>
T drive_force(const Quantities<T>& q, const T& m, double grade) {
  if (!(q.d < T(0))) return gripline::drive_force(q);
  using gripline::max, gripline::min, std::max, std::min;
  using std::abs;
  const T braked = q.brake * q.d;
  if (!(q.vx < T(weak_brake_speed)) && !(m * q.vx * largest_hold_rate < -braked)) return braked;  // it drives
  const T rate = min(T(largest_hold_rate), -braked / (m * weak_brake_speed));
  const T at_rest = max(T(0), T(1) - T(abs(q.vx)) / weak_brake_speed);
  const T wanted = m * (at_rest * (gravity * std::sin(grade)) - rate * q.vx);
  if (wanted < braked) return braked;
  return wanted > -braked ? -braked : wanted;
}

/// Slip angles of both axles [rad], as slip.hpp's with |vx| from `crawl_speed` on forwards.
template <class T>
void fill_slips(Quantities<T>& q) {
  using std::abs, std::atan, std::tan;
  if (!(q.vx < T(crawl_speed))) {
    q.slip_front = front_slip(q.vx, q.vy, q.omega, q.delta, q.lf);
    q.slip_rear = rear_slip(q.vx, q.vy, q.omega, q.lr);
    return;
  }
  const T forward = q.vx < T(-crawl_speed) ? T(-q.vx) : T(crawl_speed);
  const T turned = atan(direction(q.vx) * tan(q.delta));
  q.slip_front = front_slip(forward, q.vy, q.omega, turned, q.lf);
  q.slip_rear = rear_slip(forward, q.vy, q.omega, q.lr);
}

}  // namespace gripline::vehicle
