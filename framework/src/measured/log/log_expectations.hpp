// What a log is checked against.
#pragma once

#include "measured/log/road.hpp"

namespace gripline::measured {

struct LogExpectations {
  double v_ref = 1;            // typical speed of the car [m/s]
  const Road* road = nullptr;  // null: any place will do
  double delta_max = 0;        // largest steering angle of the car [rad]; 0: not known
};

}  // namespace gripline::measured
