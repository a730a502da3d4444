#include "geometry/long_steps.hpp"

#include <algorithm>
#include <vector>

#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline {
namespace {

/// Between which points of a file step i is.
std::string step_place(std::span<const PlanePoint> points, std::span<const int> lines, std::size_t i) {
  if (i + 1 == points.size()) return "the last point and the first";
  if (lines.size() == points.size() && lines[i] > 0 && lines[i + 1] > 0)
    return format("lines %d and %d", lines[i], lines[i + 1]);
  return format("(%.6g, %.6g) and (%.6g, %.6g)", points[i].x, points[i].y, points[i + 1].x, points[i + 1].y);
}

}  // namespace

double step_quantile(std::span<const PlanePoint> points, double share) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < points.size(); ++i) steps.push_back(distance(points[i], points[i - 1]));
  return lower_quantile(std::move(steps), share, 0.0);
}

std::string remark_of_long_steps(std::span<const PlanePoint> points, std::span<const int> lines, double width) {
  const double usual = step_quantile(points, 0.9);
  std::size_t longest = 0, count = 0;
  double most = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double step = distance(points[i], points[(i + 1) % points.size()]);
    if (!(step > std::max(3.0 * usual, width))) continue;
    ++count;
    if (step > most) most = step, longest = i;
  }
  if (count == 0) return {};
  const std::string others = count == 1 ? "" : format("; %zu steps are so long, this one most", count);
  return format("nothing between %s for %.4g m, where most steps are at most %.3g m: drawn in as a smooth curve%s",
                step_place(points, lines, longest).c_str(), most, usual, others.c_str());
}

}  // namespace gripline
