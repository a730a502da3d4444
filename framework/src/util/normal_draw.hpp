// A draw that is nearly normal and the same on every machine: std::normal_distribution differs between libraries.
#pragma once

#include <random>

namespace gripline {

/// The sum of twelve uniform draws less its mean: mean 0, standard deviation 1, at most 6 in size.
inline double nearly_normal(std::mt19937& random) {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += static_cast<double>(random()) / 4294967296.0;
  return sum;
}

}  // namespace gripline
