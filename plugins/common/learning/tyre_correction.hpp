// e_pred of the paper: what axle forces and resistance change in the accelerations of the nominal model.
//
//   vx'    += (gain Fd - (sign(vx) (Cr0 + Cd vx^2) + Ff sin(delta))) / m + vy omega
//   vy'     = (Fr + Ff cos(delta)) / m - vx omega   (+ g sin(bank) where the nominal model leaves it out)
//   omega'  = (Ff lf cos(delta) - Fr lr + arm (1 + gain) Fd (Fr + Ff cos(delta)) / (m g)) / Iz
//
// with Ff, Fr the learned curves times the axle loads of the nominal model's load stage (1 unless an effect there says
// more) and the grip of the place, less what drive and brakes leave of the friction ellipse, `gain` what the drive
// force Fd of the nominal model lacks of itself and `arm` that at which it turns the car, 0 under brakes (the paper:
// both 0). The paper adds f_dyn - f_ekin to f_ekin; the last two rows are that sum. Its slope terms stand here with g
// for m and with the road's signs (grade and bank are added by the framework). If the nominal model has tyres itself,
// its own part of vx' is removed first. Below v_min the correction fades, the bank's pull with it: at rest the model is
// the nominal one. The grade is the nominal model's at any speed. All was learned driving forward; backwards resistance
// and side forces oppose the motion as they do forwards.
#pragma once

#include <cmath>

#include <gripline/types.hpp>

#include "common/learning/friction_ellipse.hpp"
#include "common/learning/single_track.hpp"
#include "common/learning/straight_drive.hpp"

namespace gripline::learning {

/// From `from` to `to` as the speed rises to v_min, and `to` itself from there on. Below it slip angles mean less and
/// less, and at standstill a turned wheel pushes nothing.
template <class T>
T faded(const T& from, const T& to, const T& vx, double v_min) {
  using std::abs;
  const T u = T(abs(vx)) / v_min;
  if (u >= T(1)) return to;
  return from + u * u * (3.0 - 2.0 * u) * (to - from);
}

/// What a correction consists of beside the tyres' curves. By default nothing is learned of resistance and drive, and
/// side forces share no friction with drive and brakes.
struct CorrectionTerms {
  bool model_has_tyres = false;  // StraightDrive::model_has_tyres() of the nominal model
  double v_min = 0;              // below it the correction fades [m/s]
  ResistanceForce resistance = {};
  FrictionEllipse ellipse = {};
  PeakForces peaks = {};
  DriveGains gains = {};
};

/// Corrects q at Stage::body. `force(Axle, slip)` is the learned side force at static load [N]. Loads are the nominal
/// model's, for all learners: at most those of a slope, as a Place has grade and bank, not how they change along the way. Crests and dips, with
/// which `elm_rls` learns (road_load() of step_path.hpp), are not in the prediction; plans of time-optimal laps have
/// them (lap_dynamics.hpp).
template <class T, class Force>
void correct_body(Quantities<T>& q, const Place& at, const CorrectionTerms& terms, const Force& force) {
  using std::cos, std::sin;
  const auto& [model_has_tyres, v_min, resistance, ellipse, peaks, gains] = terms;
  const T missing = gains.missing(q.drive_force);
  const T drive_force = q.drive_force + missing;
  const T forward = slip_speed(q.vx, v_min);
  const T front = at.grip * q.load_front, rear = at.grip * q.load_rear;
  const T ff = front * ellipse.side_share(Axle::front, drive_force, front, peaks.front) *
               force(Axle::front, front_slip(forward, q.vy, q.omega, steered_along_motion(q.vx, q.delta), q.lf));
  const T fr = rear * ellipse.side_share(Axle::rear, drive_force, rear, peaks.rear) *
               force(Axle::rear, rear_slip(forward, q.vy, q.omega, q.lr));
  const T sine = sin(q.delta), cosine = cos(q.delta);
  const T moment = gains.turning_moment(drive_force, T(fr + ff * cosine), q.m);
  T straight = q.ax;
  if (model_has_tyres)
    straight += q.force_front * sine / q.m - q.vy * q.omega;
  else
    q.bank = faded<T>(q.bank, q.bank + at.bank, q.vx, v_min);
  T resisting = resistance.Cr0 + resistance.Cd * square(q.vx);
  if (q.vx < T(0)) resisting = -resisting;
  const T loss = resisting + ff * sine - missing;
  q.ax = faded<T>(q.ax, straight - loss / q.m + q.vy * q.omega, q.vx, v_min);
  q.ay = faded<T>(q.ay, (fr + ff * cosine) / q.m - q.vx * q.omega, q.vx, v_min);
  q.aw = faded<T>(q.aw, (ff * q.lf * cosine - fr * q.lr + moment) / q.Iz, q.vx, v_min);
}

}  // namespace gripline::learning
