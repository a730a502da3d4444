// Quality checks of a log: what they found, and what is expected of it.
#pragma once

#include <string>

#include "measured/road.hpp"

namespace gripline::measured {

/// A row of the data-health table: what was checked, what was found, what was done about it.
struct Health {
  std::string check, found, done;
  enum class Level { good, note, bad } level = Level::good;
};

/// What a log is checked against.
struct LogExpectations {
  double v_ref = 1;            // [m/s]
  const Road* road = nullptr;  // null: any place will do
  double delta_max = 0;        // largest steering angle of the car [rad]; 0: not known
};

}  // namespace gripline::measured
