#include "measured/estimates/session_noise.hpp"

#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <vector>

#include "measured/readings/scaled_difference.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

/// Covariance at a lag of the fourth differences of a first-order process of variance 1.
double fourth_difference_covariance(double colour, int lag) {
  constexpr std::array<double, 5> c = {1, -4, 6, -4, 1};
  double sum = 0.0;
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j)
      sum += c[static_cast<std::size_t>(i)] * c[static_cast<std::size_t>(j)] * std::pow(colour, std::abs(i - j + lag));
  return sum;
}

/// Rows in which a channel was read.
std::vector<std::size_t> rows_with(const Session& session, std::size_t channel) {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < session.rows(); ++i)
    if (!std::isnan(session.at(i, channel))) rows.push_back(i);
  return rows;
}

/// From one of some rows to the next [s], without the tenth at each end.
struct Steps {
  double typical = 0, shortest = 0, longest = 0;
  Steps(const Session& s, std::span<const std::size_t> rows) {
    std::vector<double> all;
    for (std::size_t k = 1; k < rows.size(); ++k) all.push_back(s.t[rows[k]] - s.t[rows[k - 1]]);
    typical = median(all, 0.0);
    shortest = lower_quantile(all, 0.1);
    longest = lower_quantile(std::move(all), 0.9);
  }
  bool vary_beyond(double share) const { return shortest < share * longest; }
};

/// Fourth difference of five readings, for uneven ones the divided difference that white noise gives the same size.
double fourth_difference(const Session& s, std::size_t channel, std::span<const std::size_t, 5> row, bool even) {
  std::array<double, 5> t{}, y{};
  for (std::size_t i = 0; i < row.size(); ++i) t[i] = s.t[row[i]], y[i] = s.at(row[i], channel);
  if (even) return y[4] - 4.0 * y[3] + 6.0 * y[2] - 4.0 * y[1] + y[0];
  return scaled_difference(t, y) * std::sqrt(fourth_difference_covariance(0.0, 0));
}

/// Fourth differences of a channel, at the last of every five of some rows.
struct Differences {
  std::vector<double> at;     // NaN over gaps and where a reading is missing
  std::vector<double> sizes;  // of those there are
  double scale = 0;           // the standard deviation of a normal distribution with their median size
  bool divided = false;       // by the times between the readings
};
/// `step`: from one of the rows to the next [s].
Differences differences_of(const Session& s, std::size_t channel, std::span<const std::size_t> rows, double step,
                           bool even) {
  Differences out;
  out.at.assign(rows.size(), not_a_number);
  for (std::size_t k = 4; k < rows.size(); ++k) {
    const auto row = rows.subspan(k - 4).first<5>();
    if (s.t[row.back()] - s.t[row.front()] > 4.6 * step) continue;
    out.at[k] = fourth_difference(s, channel, row, even);
    if (!std::isnan(out.at[k])) out.sizes.push_back(std::abs(out.at[k]));
  }
  out.scale = median(out.sizes, 0.0) / 0.6745;
  out.divided = !even;
  return out;
}

/// Of consecutive rows. Where their steps vary, either the readings were taken at these times, or they were even and the
/// clock that stamped them was not (as that of the 1:10 car's motion capture): whichever is wrong passes the car's
/// motion for noise, so that of the two differences the smaller one counts.
Differences differences_in_rows(const Session& s, std::size_t channel, std::span<const std::size_t> rows,
                                const Steps& steps) {
  constexpr double even = 0.99, smaller = 0.95;  // what is nearer to 1 is rounding of stamps, and chance
  Differences plain = differences_of(s, channel, rows, steps.typical, true);
  if (!steps.vary_beyond(even)) return plain;
  Differences divided = differences_of(s, channel, rows, steps.typical, false);
  return divided.scale < smaller * plain.scale ? divided : plain;
}

/// Lag-one correlation of the noise that leaves fourth differences correlated as these are, those above `most` aside.
/// Nothing where few of them follow each other, as of five readings and a gap, again and again.
std::optional<double> colour_of(const std::vector<double>& difference, double most) {
  constexpr std::size_t fewest_pairs = 20;
  double cross = 0.0, square = 0.0;
  std::size_t pairs = 0;
  for (std::size_t i = 1; i < difference.size(); ++i) {
    const double a = difference[i - 1], b = difference[i];
    if (!(std::abs(a) < most) || !(std::abs(b) < most)) continue;
    cross += a * b;
    square += 0.5 * (a * a + b * b);
    ++pairs;
  }
  if (pairs < fewest_pairs) return std::nullopt;
  const double seen = cross / square;
  double low = -0.95, high = 0.99;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    const double expected = fourth_difference_covariance(middle, 1) / fourth_difference_covariance(middle, 0);
    (expected < seen ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

std::optional<Noise> noise_of(const Session& session, std::size_t channel, double row_step) {
  constexpr double sparse = 1.5;        // rows from one reading to the next
  constexpr double most_telling = 0.9;  // correlation from where on noise and motion between readings look alike
  std::vector<std::size_t> rows = rows_with(session, channel);
  Steps steps(session, rows);
  const bool in_rows = !(steps.typical > sparse * row_step);
  if (in_rows) {
    rows.resize(session.rows());
    std::iota(rows.begin(), rows.end(), std::size_t{0});
    steps = Steps(session, rows);
  }
  steps.typical = in_rows ? row_step : steps.longest;
  const Differences difference = in_rows ? differences_in_rows(session, channel, rows, steps)
                                         : differences_of(session, channel, rows, steps.typical, false);
  if (difference.sizes.size() < 100) return std::nullopt;
  Noise noise;
  noise.samples = difference.sizes.size();
  if (!(difference.scale > 0.0)) return noise;
  const auto white = [&] {
    noise.sigma = difference.scale / std::sqrt(fourth_difference_covariance(0.0, 0));
    return noise;
  };
  const double even = in_rows ? 0.5 : 0.8;  // of the typical longest step; of readings in all rows there are more
  constexpr double still_linear = 0.3;      // [s] from one reading to the next
  if (difference.divided && steps.vary_beyond(even)) {
    // Differences of uneven readings are correlated by their spacing: of noise that is taken for white, where the car
    // cannot have moved much otherwise.
    if (steps.typical > still_linear) return std::nullopt;
    return white();
  }
  const std::optional<double> colour = colour_of(difference.at, 4.0 * difference.scale);
  if (!colour) return white();
  noise.colour = *colour;
  if (!in_rows && noise.colour > most_telling) return std::nullopt;
  noise.sigma = difference.scale / std::sqrt(fourth_difference_covariance(noise.colour, 0));
  return noise;
}

}  // namespace gripline::measured
