// Readings that a logger repeats in its rows until there is a new one.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace gripline::measured {

/// Leaves out values that are held: NaN from then on. One that stays for twice the median time between new ones was
/// read again, and again after each such time: of a car that stands. `t`: times of the values [s]. Returns how many are left
/// out.
std::size_t drop_held(std::span<const double> t, std::vector<double>& values);

/// In how many rows a logger repeats each value, where it does so; 1 where it does not: where less than a third of the
/// rows repeat, or as irregularly as those of a reading that is rounded coarsely. What stays for more than two seconds
/// is not a repetition, the car stands.
double rows_between_new(std::span<const double> t, std::span<const double> values);

}  // namespace gripline::measured
