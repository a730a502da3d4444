// How effects see that the wheels of a car do not slip.
#pragma once

#include <gripline/types.hpp>

namespace gripline::vehicle {

/// The stiffness that a model without tyres leaves in q.stiff_front and q.stiff_rear [1/rad]: far beyond any tyre's.
inline constexpr double stiffness_without_slip = 1e12;

/// Whether a side force moves the car sideways. Wheels that do not slip hold it.
template <class T>
bool slips(const Quantities<T>& q) {
  return q.stiff_front < T(stiffness_without_slip);
}

}  // namespace gripline::vehicle
