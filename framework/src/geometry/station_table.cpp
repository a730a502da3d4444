#include "geometry/station_table.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "geometry/plane.hpp"
#include "util/numbers.hpp"

namespace gripline {

StationTable::StationTable(double period, std::vector<double> stations, std::vector<double> values)
    : period_(period), stations_(std::move(stations)), values_(std::move(values)) {
  if (values_.empty() || values_.size() != stations_.size())
    throw GeometryError("a table by station needs at least one row");
  for (std::size_t i = 0; i < values_.size(); ++i) {
    const std::string row = "row " + std::to_string(i + 1) + " of a table by station ";
    if (std::isnan(values_[i])) throw GeometryError(row + "is not a number");
    if (!(stations_[i] >= 0.0) || !(stations_[i] < period_)) {
      throw GeometryError(
          row + format("has station %f m, expected 0 to below the road's length %f m", stations_[i], period_));
    }
    if (i > 0 && !(stations_[i] > stations_[i - 1])) {
      throw GeometryError(row + format("has station %f m, not beyond the one before", stations_[i]));
    }
  }
  bucket_.resize(values_.size());
  std::size_t row = 0;
  for (std::size_t i = 0; i < bucket_.size(); ++i) {
    const double s = period_ * static_cast<double>(i) / static_cast<double>(bucket_.size());
    while (row + 1 < stations_.size() && stations_[row + 1] <= s) ++row;
    bucket_[i] = row;
  }
}

double StationTable::at(double s) const {
  const std::size_t n = values_.size();
  if (n == 1) return values_.front();
  s = wrap_periodic(s, period_);
  if (s < stations_.front()) s += period_;
  const auto share = static_cast<std::size_t>(std::min(s, period_) / period_ * static_cast<double>(n));
  std::size_t i = bucket_[std::min(share, n - 1)];
  while (i + 1 < n && stations_[i + 1] <= s) ++i;
  const bool last = i + 1 == n;
  const double next = last ? stations_.front() + period_ : stations_[i + 1];
  const double share_of_gap = (s - stations_[i]) / (next - stations_[i]);
  const double to = values_[last ? 0 : i + 1];
  if (std::isinf(values_[i]) || std::isinf(to)) return values_[i];  // between walls
  return values_[i] + share_of_gap * (to - values_[i]);
}

double StationTable::minimum() const { return *std::min_element(values_.begin(), values_.end()); }
double StationTable::maximum() const { return *std::max_element(values_.begin(), values_.end()); }

}  // namespace gripline
