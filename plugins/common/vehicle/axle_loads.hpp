// What the axles of a car carry of its weight.
#pragma once

#include <gripline/types.hpp>

namespace gripline::vehicle {

/// The vertical loads of both axles, in the unit of the weight that they carry.
struct AxleLoads {
  double front = 0, rear = 0;

  double of(Axle axle) const { return axle == Axle::front ? front : rear; }
};

/// A weight at the centre of gravity of a car that stands on a level road, as its axles carry it.
inline AxleLoads axle_loads(double weight, const Car& car) {
  const double wheelbase = car.lf + car.lr;
  return {weight * car.lr / wheelbase, weight * car.lf / wheelbase};
}

/// Axle loads of the car at rest on a level road [N].
inline AxleLoads static_axle_loads(const Car& car) { return axle_loads(car.m * gravity, car); }

}  // namespace gripline::vehicle
