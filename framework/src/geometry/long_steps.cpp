#include "geometry/long_steps.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/place_text.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline {
namespace {

/// Between which points of a file step i is.
std::string step_place(std::span<const PlanePoint> points, std::span<const int> lines, std::size_t i) {
  if (i + 1 == points.size()) return "the last point and the first";
  if (lines.size() == points.size() && lines[i] > 0 && lines[i + 1] > 0)
    return format("lines %d and %d", lines[i], lines[i + 1]);
  return place_text(points[i].x, points[i].y, 6) + " and " + place_text(points[i + 1].x, points[i + 1].y, 6);
}

/// Step i of a closed line beside those before and after it.
class LongStep {
 public:
  LongStep(std::span<const PlanePoint> points, std::size_t i)
      : before_(way(points, i + points.size() - 1)), step_(way(points, i)), after_(way(points, i + 1)) {}

  double length() const { return std::hypot(step_.x, step_.y); }
  /// An edge where a pit lane or a run-off begins leads aside and goes on as it came.
  bool aside() const { return cosine(before_, after_) > 0.9 && std::abs(cosine(step_, after_)) < 0.5; }
  /// Within 0.8 degrees.
  bool straight() const { return std::min(cosine(before_, step_), cosine(step_, after_)) > 0.9999; }

 private:
  static PlanePoint way(std::span<const PlanePoint> points, std::size_t i) {
    const PlanePoint &from = points[i % points.size()], &to = points[(i + 1) % points.size()];
    return {to.x - from.x, to.y - from.y};
  }
  static double cosine(const PlanePoint& a, const PlanePoint& b) {
    return (a.x * b.x + a.y * b.y) / (std::hypot(a.x, a.y) * std::hypot(b.x, b.y));
  }

  PlanePoint before_, step_, after_;
};

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
  constexpr double widest_aside = 4.0;  // widths
  for (std::size_t i = 0; i < points.size(); ++i) {
    const LongStep step(points, i);
    const double length = step.length();
    if (!(length > std::max(3.0 * usual, width))) continue;
    if (length <= 10.0 * usual && step.straight()) continue;
    if (length <= widest_aside * width && step.aside()) continue;
    ++count;
    if (length > most) most = length, longest = i;
  }
  if (count == 0) return {};
  const std::string others = count == 1 ? "" : format("; %zu steps are so long, this one most", count);
  return format("nothing between %s for %.4g m, where most steps are at most %.3g m: drawn in as a smooth curve%s",
                step_place(points, lines, longest).c_str(), most, usual, others.c_str());
}

}  // namespace gripline
