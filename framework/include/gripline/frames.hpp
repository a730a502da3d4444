/// \file
/// What a measuring unit shows that sits at another point of the car, or turned against it: rigid-body kinematics. Each
/// function changes the reading that it is given.
#pragma once

#include <gripline/types.hpp>

namespace gripline {

/// Moves the place of a reading from the centre of gravity to the point px ahead of it and py to its left [m].
template <class T>
void move_place_to_point(Reading<T>& r, const T& px, const T& py) {
  const auto [s, c] = sine_cosine(r.yaw);
  r.x += px * c - py * s;
  r.y += px * s + py * c;
}

/// Changes the velocity of a reading from that of the centre of gravity to that of such a point, in the car's axes.
template <class T>
void move_velocity_to_point(Reading<T>& r, const T& px, const T& py) {
  r.vx -= py * r.omega;
  r.vy += px * r.omega;
}

/// Changes the velocity of a reading to what axes show that are turned to the left by `angle` [rad].
template <class T>
void turn_velocity_axes(Reading<T>& r, const T& angle) {
  const auto [s, c] = sine_cosine(angle);
  const T vx = r.vx * c + r.vy * s;
  r.vy = r.vy * c - r.vx * s;
  r.vx = vx;
}

}  // namespace gripline
