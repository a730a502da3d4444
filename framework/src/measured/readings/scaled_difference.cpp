#include "measured/readings/scaled_difference.hpp"

#include <cmath>

namespace gripline::measured {

double divided_weight(std::span<const double> at, std::size_t i) {
  double weight = 1.0;
  for (std::size_t j = 0; j < at.size(); ++j)
    if (j != i) weight /= at[i] - at[j];
  return weight;
}

double scaled_difference(std::span<const double> at, std::span<const double> reading) {
  double difference = 0.0, gain = 0.0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const double weight = divided_weight(at, i);
    difference += weight * reading[i];
    gain += weight * weight;
  }
  return difference / std::sqrt(gain);
}

}  // namespace gripline::measured
