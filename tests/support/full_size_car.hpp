// The lengths and the limit of steering of worlds/cars/full_size.json that planners ask for, without the file.
#pragma once

#include <gripline/interfaces.hpp>

namespace gripline::testing_support {

inline Car full_size_car() {
  Car car;
  car.lf = 1.34;
  car.lr = 1.30;
  car.width = 1.84;
  car.delta_max = 0.35;
  car.v_min = 2;
  return car;
}

}  // namespace gripline::testing_support
