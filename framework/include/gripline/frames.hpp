// What a measuring unit shows that sits at another point of the car, or turned against it. Rigid-body kinematics.
#pragma once

#include <gripline/types.hpp>

namespace gripline {

/// The place of the point px ahead of the centre of gravity and py to its left [m].
template <class T>
void show_place_of_point(Reading<T>& r, const T& px, const T& py) {
  const auto [s, c] = sine_cosine(r.yaw);
  r.x += px * c - py * s;
  r.y += px * s + py * c;
}

/// The velocity of such a point, in the car's axes.
template <class T>
void show_velocity_of_point(Reading<T>& r, const T& px, const T& py) {
  r.vx -= py * r.omega;
  r.vy += px * r.omega;
}

/// The velocity in axes turned to the left by `angle` [rad].
template <class T>
void show_velocity_in_turned_axes(Reading<T>& r, const T& angle) {
  const auto [s, c] = sine_cosine(angle);
  const T vx = r.vx * c + r.vy * s;
  r.vy = r.vy * c - r.vx * s;
  r.vx = vx;
}

}  // namespace gripline
