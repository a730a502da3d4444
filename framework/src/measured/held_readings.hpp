// Readings that a logger repeats in its rows until there is a new one.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace gripline::measured {

/// Leaves out values that are held: NaN from then on. One that stays for twice the usual time between new ones was read
/// again, and again after each such time: of a car that stands. `t`: times of the values [s]. Returns how many are left
/// out.
std::size_t drop_held(std::span<const double> t, std::vector<double>& values);

}  // namespace gripline::measured
