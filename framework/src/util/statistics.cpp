#include "util/statistics.hpp"

#include <algorithm>
#include <boost/math/statistics/univariate_statistics.hpp>
#include <cmath>

namespace gripline {

double order_statistic(std::vector<double> values, std::size_t rank, double if_empty) {
  if (values.empty()) return if_empty;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::min(rank, values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double median(std::vector<double> values, double if_empty) {
  return values.empty() ? if_empty : boost::math::statistics::median(values);
}

double upper_median(std::vector<double> values, double if_empty) {
  const std::size_t middle = values.size() / 2;
  return order_statistic(std::move(values), middle, if_empty);
}

double nearest_rank_quantile(std::vector<double> values, double share, double if_empty) {
  const auto count = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  return order_statistic(std::move(values), count > 0 ? count - 1 : 0, if_empty);
}

double linear_quantile(std::vector<double> values, double share, double if_empty) {
  if (values.empty()) return if_empty;
  std::sort(values.begin(), values.end());
  const double at = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const double next = values[std::min(below + 1, values.size() - 1)];
  return values[below] + (at - static_cast<double>(below)) * (next - values[below]);
}

double lower_quantile(std::vector<double> values, double share, double if_empty) {
  if (values.empty()) return if_empty;
  const auto rank = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1));
  return order_statistic(std::move(values), rank, if_empty);
}

}  // namespace gripline
