/// \file
/// Slip angles of a single-track car [rad], positive where the tyre pushes to the left.
///
///     front = delta - atan2(omega lf + vy, forward),   rear = atan2(omega lr - vy, forward)
///
/// `forward` stands for the forward speed [m/s]: |vx| in a plant, max(|vx|, v_min) in a model whose derivatives must
/// stay finite at standstill. T, that of vy (of the angle in steered_along_motion), is double or Dual<N>; whatever else
/// is given may be a plain double, such as the car's geometry.
/// Source: Kalaria, Lin, Dolan, arXiv 2303.08235, the dynamic model's slip angles, with |vx| as in the published plant.
#pragma once

#include <cmath>
#include <type_traits>

#include <gripline/dual.hpp>

namespace gripline {

/// The steering angle seen along the motion: wheels of a car that rolls backwards point to the other side [rad]. It
/// jumps at rest: a model that is evaluated there lets the forces that come of it fade towards standstill.
template <class T>
T steered_along_motion(const std::type_identity_t<T>& vx, const T& delta) {
  return vx < T(0) ? T(-delta) : delta;
}

/// Slip angle of the front axle, which lies lf [m] before the centre of gravity, with its road wheels at delta [rad].
/// That is the angle that acts (Quantities::delta); of a commanded one (State::delta) comes the slip of wheels that
/// stand as commanded.
template <class T>
T front_slip(const std::type_identity_t<T>& forward, const T& vy, const std::type_identity_t<T>& omega,
             const std::type_identity_t<T>& delta, const std::type_identity_t<T>& lf) {
  using std::atan2;
  return delta - atan2(omega * lf + vy, forward);
}

/// Slip angle of the rear axle, lr [m] behind the centre of gravity.
template <class T>
T rear_slip(const std::type_identity_t<T>& forward, const T& vy, const std::type_identity_t<T>& omega,
            const std::type_identity_t<T>& lr) {
  using std::atan2;
  return atan2(omega * lr - vy, forward);
}

}  // namespace gripline
