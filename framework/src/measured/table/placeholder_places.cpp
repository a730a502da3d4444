#include "measured/table/placeholder_places.hpp"

#include <cmath>

#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

/// Quantiles of the ways from one place to the next other one, behind row `from`, and of their speeds.
struct MoveQuantiles {
  double way = 0, speed = 0;
};

MoveQuantiles move_quantiles(std::span<const double> t, const std::vector<double>& x, const std::vector<double>& y,
                             std::size_t from) {
  constexpr double most = 0.9;  // spikes are beyond it
  std::vector<double> ways, speeds;
  std::size_t last = from;
  for (std::size_t i = from + 1; i < x.size(); ++i) {
    if (!std::isfinite(x[i] + y[i])) continue;
    const double way = std::hypot(x[i] - x[last], y[i] - y[last]);
    if (way > 0.0) {
      ways.push_back(way);
      speeds.push_back(way / (t[i] - t[last]));
    }
    last = i;
  }
  return {lower_quantile(std::move(ways), most, 0.0), lower_quantile(std::move(speeds), most, 0.0)};
}

}  // namespace

PlaceholderPlaces drop_placeholder_places(std::span<const double> t, std::vector<double>& x, std::vector<double>& y) {
  constexpr double far = 10.0;  // times that quantile
  std::size_t first = x.size(), last = x.size(), rows = 0, next = 0;
  for (; next < x.size(); ++next) {
    if (!std::isfinite(x[next] + y[next])) continue;
    if (rows == 0) first = next;
    if (x[next] != x[first] || y[next] != y[first]) break;
    last = next;
    ++rows;
  }
  if (rows < 2 || next >= x.size()) return {};
  // By the way, as places that are held jump in one row; by the speed, as a car may have driven during a gap.
  const MoveQuantiles typical = move_quantiles(t, x, y, next);
  const double way = std::hypot(x[next] - x[first], y[next] - y[first]), speed = way / (t[next] - t[last]);
  if (!(typical.way > 0.0) || way < far * typical.way || speed < far * typical.speed) return {};
  const PlaceholderPlaces dropped{rows, x[first], y[first]};
  for (std::size_t i = first; i < next; ++i) x[i] = y[i] = not_a_number;
  return dropped;
}

}  // namespace gripline::measured
