// How the axes in which a car's sensors show its velocity are turned against its own.
#pragma once

#include <array>

#include "car/staged_car.hpp"

namespace gripline::measured {

/// The turn of these axes, to the left. A search for the state that reads as wished, which moves the state by what its
/// reading lacks, comes nearer at any turn where that difference is turned back first; else it does up to 60 degrees.
template <class T>
struct VelocityAxes {
  T cosine = T(1), sine = T(0);

  /// Of a car, by what it shows straight ahead at two speeds. Null params: as in CarBatch.
  static VelocityAxes of(const StagedCar& car, const T* params) {
    using gripline::hypot;
    const std::array<Place, 2> at{};
    std::array<Reading<T>, 2> shown{};
    shown[0].vx = T(1);
    shown[1].vx = T(2);
    car.read(shown.data(), shown.size(), at.data(), params);
    const T along = shown[1].vx - shown[0].vx, across = shown[1].vy - shown[0].vy, size = hypot(along, across);
    if (!(value(size) > 0.0)) return {};
    return {along / size, -across / size};
  }
  /// A difference of readings as one of states.
  void turn_back(T& vx, T& vy) const {
    const T along = vx * cosine - vy * sine;
    vy = vy * cosine + vx * sine;
    vx = along;
  }
};

}  // namespace gripline::measured
