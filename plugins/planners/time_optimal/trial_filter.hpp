// The filter of a line search: a point is taken if it violates the constraints less, or has a lower objective, than
// every point from which the filter let a step begin. A merit function refuses good steps along curved constraints,
// since both change at second order; a filter does not weigh one against the other.
// Source: Waechter, Biegler (2006), "On the implementation of an interior-point filter line-search algorithm for
// large-scale nonlinear programming", section 2.3.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace gripline::time_optimal {

class TrialFilter {
 public:
  struct Point {
    double violation = 0, objective = 0;
  };

  /// For another problem, where no point may violate it more than this.
  void clear(double most_violation) {
    most_ = most_violation;
    count_ = 0;
  }

  /// Whether a step from one point to another may be taken; the first is remembered if so. No step is taken to what is
  /// not finite.
  bool take(const Point& from, const Point& to) {
    if (!(to.violation <= most_) || !std::isfinite(to.objective) || !better(from, to)) return false;
    const std::size_t known = std::min(count_, points_.size());
    for (std::size_t i = 0; i < known; ++i)
      if (!better(points_[i], to)) return false;
    points_[count_++ % points_.size()] = from;  // beyond its size the oldest is forgotten
    return true;
  }

 private:
  static bool better(const Point& than, const Point& p) {
    constexpr double margin = 1e-3, least = 1e-7;
    return p.violation <= (1.0 - margin) * than.violation ||
           p.objective <= than.objective - margin * than.violation - least;
  }

  std::array<Point, 32> points_{};
  std::size_t count_ = 0;
  double most_ = 0;
};

}  // namespace gripline::time_optimal
