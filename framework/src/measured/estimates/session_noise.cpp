#include "measured/estimates/session_noise.hpp"

#include <array>
#include <cmath>
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

/// Fourth difference of five readings, for uneven ones the divided difference that white noise gives the same size.
double fourth_difference(const Session& s, std::size_t channel, std::span<const std::size_t, 5> row, bool even) {
  std::array<double, 5> t{}, y{};
  for (std::size_t i = 0; i < row.size(); ++i) t[i] = s.t[row[i]], y[i] = s.at(row[i], channel);
  if (even) return y[4] - 4.0 * y[3] + 6.0 * y[2] - 4.0 * y[1] + y[0];
  return scaled_difference(t, y) * std::sqrt(fourth_difference_covariance(0.0, 0));
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
  const std::vector<std::size_t> rows = rows_with(session, channel);
  std::vector<double> steps;
  for (std::size_t k = 1; k < rows.size(); ++k) steps.push_back(session.t[rows[k]] - session.t[rows[k - 1]]);
  const bool in_rows = !(median(steps, 0.0) > sparse * row_step);
  const double step = in_rows ? row_step : lower_quantile(steps, 0.9);
  const std::size_t n = in_rows ? session.rows() : rows.size();
  std::vector<double> difference(n, not_a_number), sizes;
  for (std::size_t k = 4; k < n; ++k) {
    std::array<std::size_t, 5> row{};
    for (std::size_t i = 0; i < row.size(); ++i) row[i] = in_rows ? k - 4 + i : rows[k - 4 + i];
    if (session.t[row.back()] - session.t[row.front()] > 4.6 * step) continue;
    difference[k] = fourth_difference(session, channel, row, in_rows);
    if (!std::isnan(difference[k])) sizes.push_back(std::abs(difference[k]));
  }
  if (sizes.size() < 100) return std::nullopt;
  Noise noise;
  noise.samples = sizes.size();
  const double scale = median(sizes) / 0.6745;  // of a normal distribution
  if (!(scale > 0.0)) return noise;
  const auto white = [&] {
    noise.sigma = scale / std::sqrt(fourth_difference_covariance(0.0, 0));
    return noise;
  };
  constexpr double even = 0.8;          // of the typical longest step
  constexpr double still_linear = 0.3;  // [s] from one reading to the next
  if (!in_rows && lower_quantile(std::move(steps), 0.1) < even * step) {
    // Differences of uneven readings are correlated by their spacing: of noise that is taken for white, where the car
    // cannot have moved much otherwise.
    if (step > still_linear) return std::nullopt;
    return white();
  }
  const std::optional<double> colour = colour_of(difference, 4.0 * scale);
  if (!colour) return white();
  noise.colour = *colour;
  if (!in_rows && noise.colour > most_telling) return std::nullopt;
  noise.sigma = scale / std::sqrt(fourth_difference_covariance(noise.colour, 0));
  return noise;
}

}  // namespace gripline::measured
