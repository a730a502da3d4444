#include "util/resampling.hpp"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <random>

#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline {

MedianInterval bootstrap_median_interval(std::vector<double> values) {
  constexpr int resamples = 4000;
  constexpr double share = 0.95;
  if (values.size() < 2) return {not_a_number, not_a_number};
  std::sort(values.begin(), values.end());
  std::mt19937_64 random(1);
  const std::size_t n = values.size();
  std::vector<double> medians, sample(n);
  medians.reserve(resamples);
  for (int i = 0; i < resamples; ++i) {
    for (double& one : sample) one = values[random() % n];
    medians.push_back(median(sample));
  }
  return {nearest_rank_quantile(medians, 0.5 * (1.0 - share)), nearest_rank_quantile(medians, 0.5 * (1.0 + share))};
}

double least_sign_test(std::size_t differences) {
  return std::min(1.0, std::ldexp(2.0, -static_cast<int>(std::min<std::size_t>(differences, 1000))));
}

double sign_test(std::span<const double> differences) {
  const auto plus = std::count_if(differences.begin(), differences.end(), [](double d) { return d > 0.0; });
  const auto minus = std::count_if(differences.begin(), differences.end(), [](double d) { return d < 0.0; });
  if (plus + minus == 0) return 1.0;
  const boost::math::binomial_distribution<double> fair(static_cast<double>(plus + minus), 0.5);
  return std::min(1.0, 2.0 * boost::math::cdf(fair, static_cast<double>(std::min(plus, minus))));
}

}  // namespace gripline
