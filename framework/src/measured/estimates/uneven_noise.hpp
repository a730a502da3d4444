// What noise that a sensor filters leaves of the divided fourth differences of readings at uneven times. These lean on
// the readings that are nearest to each other, whose noise is most alike: what they show depends on the spacing of each
// five as well as on the noise, and is small of noise that is strongly correlated.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace gripline::measured {

/// Of noise of variance 1 whose correlation fades with time, or from each reading to the next. Differences are those of
/// readings/scaled_difference, named by the last of their five readings: by numbers from 4 on.
class UnevenNoise {
 public:
  /// `times`: of the readings [s], no two of them alike; `step`: what lies between two readings whose correlation is
  /// the noise's colour [s], nothing where it is that of any two which follow each other.
  UnevenNoise(std::span<const double> times, std::optional<double> step);

  /// The correlation of these differences with those before them.
  double correlation(double colour, const std::vector<std::size_t>& differences) const;
  /// The standard deviation of each difference, NaN below the fourth.
  std::vector<double> sizes(double colour) const;

 private:
  using Five = std::array<double, 5>;
  std::vector<double> fades(double colour) const;
  double covariance(std::size_t first, std::size_t second, const std::vector<double>& fade) const;
  std::vector<Five> weight_;  // of readings, by difference
  std::vector<double> step_;  // to a reading from the one before, in those of the colour
};

}  // namespace gripline::measured
