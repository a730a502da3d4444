// Order statistics, and the normal interval. Several definitions of a quantile are in use, and files depend on which:
// each is named here. Hyndman and Fan, "Sample quantiles in statistical packages", The American Statistician 50 (1996),
// number them.
#pragma once

#include <vector>

#include "util/numbers.hpp"

namespace gripline {

inline constexpr double normal_95 = 1.959964;  // half a 95 % interval of a normal, in standard deviations

/// The value that sorting would put at `rank`, counted from 0 and limited to the last one. No value may be NaN; this
/// and the following give `if_empty` for no values.
double order_statistic(std::vector<double> values, std::size_t rank, double if_empty = not_a_number);

/// The mean of the two middle values when their number is even.
double median(std::vector<double> values, double if_empty = not_a_number);

/// The larger of the two middle values when their number is even: always a value that occurs.
double upper_median(std::vector<double> values, double if_empty = not_a_number);

/// Definition 1, nearest rank: the smallest value with at least `share` of all at or below it. `share` in [0, 1].
double nearest_rank_quantile(std::vector<double> values, double share, double if_empty = not_a_number);

/// Definition 7, linear between the values at ranks k / (n - 1), k = 0 .. n - 1. `share` in [0, 1].
double linear_quantile(std::vector<double> values, double share, double if_empty = not_a_number);

/// As linear_quantile, but the lower of its two neighbours: always a value that occurs.
double lower_quantile(std::vector<double> values, double share, double if_empty = not_a_number);

}  // namespace gripline
