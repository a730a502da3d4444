#include "measured/estimates/session_noise.hpp"

#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <vector>

#include "measured/estimates/uneven_noise.hpp"
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

constexpr double normal_quartile = 0.6745;  // of standard deviation 1: the median size of its values
constexpr std::size_t fewest_differences = 100;

using FiveRows = std::span<const std::size_t, 5>;
using Five = std::array<double, 5>;

Five times_of(const Session& s, FiveRows row) {
  Five t{};
  for (std::size_t i = 0; i < row.size(); ++i) t[i] = s.t[row[i]];
  return t;
}
Five readings_of(const Session& s, std::size_t channel, FiveRows row) {
  Five y{};
  for (std::size_t i = 0; i < row.size(); ++i) y[i] = s.at(row[i], channel);
  return y;
}

double plain_difference(const Five&, const Five& y) { return y[4] - 4.0 * y[3] + 6.0 * y[2] - 4.0 * y[1] + y[0]; }
/// For uneven readings, of the same size for white noise.
double divided_difference(const Five& t, const Five& y) {
  return scaled_difference(t, y) * std::sqrt(fourth_difference_covariance(0.0, 0));
}
/// The plain difference without what it would be of a motion as fast as from the first to the last of the readings.
double difference_off_slope(const Five& t, const Five& y) {
  const double slope = (y[4] - y[0]) / (t[4] - t[0]);
  return plain_difference(t, y) - slope * plain_difference(t, t);
}

/// Fourth differences of a channel, at the last of every five of some rows.
struct Differences {
  std::vector<double> at;     // NaN over gaps and where a reading is missing
  std::vector<double> sizes;  // of those there are
  double scale = 0;           // the standard deviation of a normal distribution with their median size
};
/// `step`: from one of the rows to the next [s]; `difference`: of the times and the values of five readings.
template <class Difference>
Differences differences_of(const Session& s, std::size_t channel, std::span<const std::size_t> rows, double step,
                           Difference difference) {
  Differences out;
  out.at.assign(rows.size(), not_a_number);
  for (std::size_t k = 4; k < rows.size(); ++k) {
    const auto row = rows.subspan(k - 4).first<5>();
    if (s.t[row.back()] - s.t[row.front()] > 4.6 * step) continue;
    out.at[k] = difference(times_of(s, row), readings_of(s, channel, row));
    if (!std::isnan(out.at[k])) out.sizes.push_back(std::abs(out.at[k]));
  }
  out.scale = median(out.sizes, 0.0) / normal_quartile;
  return out;
}

/// Whether a channel that is read in all rows was read at the times that they are stamped with. Where these are uneven,
/// either it was, or it was read evenly and the clock that stamped it was not (as that of the 1:10 car's motion
/// capture): whichever is wrong passes the car's motion for noise. If it was, plain differences have in them what the
/// channel moves between uneven times, and are smaller without it; noise of any colour has next to nothing of this.
bool is_read_when_stamped(const Session& s, std::size_t channel, std::span<const std::size_t> rows, const Steps& steps,
                          const Differences& plain) {
  constexpr double even = 0.99, smaller = 0.95;  // what is nearer to 1 is rounding of stamps, and chance
  if (!steps.vary_beyond(even)) return false;
  return differences_of(s, channel, rows, steps.typical, difference_off_slope).scale < smaller * plain.scale;
}

/// Lag-one correlation of the noise that leaves fourth differences correlated as these are, those above `most` aside.
/// Nothing where few of them follow each other, as of five readings and a gap, again and again. `expected`: the
/// correlation by colour, of differences and those before them, by number; `halvings`: of the range of colours.
template <class Expected>
std::optional<double> colour_of(const std::vector<double>& difference, double most, Expected expected, int halvings) {
  constexpr std::size_t fewest_pairs = 20;
  double cross = 0.0, square = 0.0;
  std::vector<std::size_t> pairs;
  for (std::size_t i = 1; i < difference.size(); ++i) {
    const double a = difference[i - 1], b = difference[i];
    if (!(std::abs(a) < most) || !(std::abs(b) < most)) continue;
    cross += a * b;
    square += 0.5 * (a * a + b * b);
    pairs.push_back(i);
  }
  if (pairs.size() < fewest_pairs) return std::nullopt;
  const double seen = cross / square;
  double low = -0.95, high = 0.99;
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (low + high);
    (expected(middle, pairs) < seen ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double correlation_of_even(double colour, const std::vector<std::size_t>&) {
  return fourth_difference_covariance(colour, 1) / fourth_difference_covariance(colour, 0);
}

/// Noise that explains divided differences.
struct Explained {
  Noise noise;
  double unlikely = 0;  // minus the log likelihood of a difference's size, on mean, but for a constant
};
std::optional<Explained> explained_by(const UnevenNoise& uneven, const Differences& difference) {
  const auto colour = colour_of(
      difference.at, 4.0 * difference.scale, [&](double c, const auto& pairs) { return uneven.correlation(c, pairs); },
      20);
  if (!colour) return std::nullopt;
  const std::vector<double> size = uneven.sizes(*colour);
  std::vector<double> sizes;
  double sum = 0.0, logarithms = 0.0;
  for (std::size_t k = 0; k < size.size(); ++k)
    if (!std::isnan(difference.at[k])) {
      sizes.push_back(std::abs(difference.at[k]) / size[k]);
      sum += sizes.back();
      logarithms += std::log(size[k]);
    }
  const auto n = static_cast<double>(sizes.size());
  const double sigma = median(std::move(sizes)) / normal_quartile;
  return Explained{{sigma, *colour, difference.sizes.size()}, logarithms / n + std::log(sum / n)};
}

/// Of a channel whose readings were taken at uneven times, one in each row. The noise of a sensor that filters fades
/// with time, that of a filter which takes in each reading fades from one to the next: of the two, what explains better
/// how differences vary with the times between readings.
std::optional<Noise> noise_of_uneven_rows(const Session& session, std::size_t channel,
                                          std::span<const std::size_t> rows, double row_step) {
  const Differences difference = differences_of(session, channel, rows, row_step,
                                                [](const Five& t, const Five& y) { return scaled_difference(t, y); });
  if (difference.sizes.size() < fewest_differences) return std::nullopt;
  const Noise white{difference.scale, 0.0, difference.sizes.size()};
  if (!(difference.scale > 0.0)) return white;
  const auto by_time = explained_by(UnevenNoise(session.t, row_step), difference),
             by_reading = explained_by(UnevenNoise(session.t, std::nullopt), difference);
  if (!by_time || !by_reading) return white;
  return by_time->unlikely < by_reading->unlikely ? by_time->noise : by_reading->noise;
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
  const Differences difference =
      differences_of(session, channel, rows, steps.typical, in_rows ? plain_difference : divided_difference);
  if (in_rows && is_read_when_stamped(session, channel, rows, steps, difference))
    return noise_of_uneven_rows(session, channel, rows, row_step);
  if (difference.sizes.size() < fewest_differences) return std::nullopt;
  Noise noise;
  noise.samples = difference.sizes.size();
  if (!(difference.scale > 0.0)) return noise;
  const auto white = [&] {
    noise.sigma = difference.scale / std::sqrt(fourth_difference_covariance(0.0, 0));
    return noise;
  };
  constexpr double even = 0.8;          // of the typical longest step
  constexpr double still_linear = 0.3;  // [s] from one reading to the next
  if (!in_rows && steps.vary_beyond(even)) {
    // Differences of uneven readings are correlated by their spacing: of noise that is taken for white, where the car
    // cannot have moved much otherwise.
    if (steps.typical > still_linear) return std::nullopt;
    return white();
  }
  const std::optional<double> colour = colour_of(difference.at, 4.0 * difference.scale, correlation_of_even, 50);
  if (!colour) return white();
  noise.colour = *colour;
  if (!in_rows && noise.colour > most_telling) return std::nullopt;
  noise.sigma = difference.scale / std::sqrt(fourth_difference_covariance(noise.colour, 0));
  return noise;
}

}  // namespace gripline::measured
