// Places that a logger writes as long as it knows none.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace gripline::measured {

/// Rows before the first fix, which show one and the same place again and again: 0, 0, or -9999, or that of yesterday.
struct PlaceholderPlaces {
  std::size_t rows = 0;
  double x = 0, y = 0;  // what they show
};

/// Leaves out places at the beginning that repeat and from which the next other one is further away than the car can
/// have come: they become NaN. `t`: times of the rows [s]; the unit of x and y is any.
PlaceholderPlaces drop_placeholder_places(std::span<const double> t, std::vector<double>& x, std::vector<double>& y);

}  // namespace gripline::measured
