#include "geometry/road_smoothing.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>

#include "geometry/cyclic_box_qp.hpp"
#include "util/numbers.hpp"

namespace gripline {
namespace {

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Evens out values at the samples of a closed line: the least integral of the squared second derivative plus
/// (move / half^2)^2, both times the cube of the mean step, so that for equal steps it is made of second differences.
class Smoother {
 public:
  /// `steps[i]` leads from sample i to the next [m]; waves shorter than about six `half` [m] go.
  Smoother(const std::vector<double>& steps, double half)
      : before_(steps.size()), here_(steps.size()), after_(steps.size()), hessian_(steps.size()) {
    const std::size_t n = steps.size();
    const double usual = mean(steps);
    for (std::size_t i = 0; i < n; ++i) {
      const double last = steps[(i + n - 1) % n], next = steps[i], middle = 0.5 * (last + next);
      const double share = usual * std::sqrt(usual / middle);
      before_[i] = share / last;
      after_[i] = share / next;
      here_[i] = -before_[i] - after_[i];
      hessian_.diagonal[i] = middle / usual * std::pow(usual / half, 4.0);
    }
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t j = (i + 1) % n;
      hessian_.diagonal[i] += here_[i] * here_[i] + std::pow(after_[(i + n - 1) % n], 2) + std::pow(before_[j], 2);
      hessian_.next[i] = here_[i] * after_[i] + before_[j] * here_[j];
      hessian_.second[i] = before_[j] * after_[j];
    }
  }
  /// Wherever it takes them.
  std::vector<double> smooth(const std::vector<double>& values) const {
    std::vector<double> moves = gradient(values);
    for (double& move : moves) move = -move;
    CyclicPentadiagonalFactor(hessian_).solve(moves);
    return moved(values, std::move(moves));
  }
  /// Within +- bound of the values.
  std::vector<double> smooth(const std::vector<double>& values, double bound) const {
    const std::vector<double> lower(values.size(), -bound), upper(values.size(), bound);
    return moved(values, solve_cyclic_box_qp(hessian_, gradient(values), lower, upper));
  }

 private:
  static std::vector<double> moved(const std::vector<double>& values, std::vector<double> moves) {
    for (std::size_t i = 0; i < moves.size(); ++i) moves[i] += values[i];
    return moves;
  }
  std::vector<double> gradient(const std::vector<double>& values) const {
    const std::size_t n = values.size();
    std::vector<double> bends(n), result(n);
    for (std::size_t i = 0; i < n; ++i)
      bends[i] = before_[i] * (values[(i + n - 1) % n] - values[i]) + after_[i] * (values[(i + 1) % n] - values[i]);
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t last = (i + n - 1) % n, next = (i + 1) % n;
      result[i] = here_[i] * bends[i] + after_[last] * bends[last] + before_[next] * bends[next];
    }
    return result;
  }

  std::vector<double> before_, here_, after_;  ///< a sample's second difference: factors of it and its neighbours
  CyclicPentadiagonal hessian_;
};

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

/// No faster change than 1:2 along the road, by making it narrower.
void limit_width_steps(std::vector<double>& width, const std::vector<double>& steps) {
  const std::size_t n = width.size();
  const auto limit = [&](std::size_t to, std::size_t from, double step) {
    // A little less: chords of the line that is written are shorter.
    width[to] = std::min(width[to], width[from] + 0.9 * steepest_edge * step);
  };
  for (std::size_t k = 0; k < 2 * n; ++k) limit((k + 1) % n, k % n, steps[k % n]);
  for (std::size_t k = 2 * n; k-- > 0;) limit(k % n, (k + 1) % n, steps[k % n]);
}

std::vector<PlanePoint> joined(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<PlanePoint> points(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) points[i] = {x[i], y[i]};
  return points;
}

/// A road at more places of its centre line, its own points among them.
struct Refined {
  RoadTable road;
  std::vector<std::size_t> own;  ///< where the road's own points are
};

/// Between neighbouring points, equal shares at most `step` long.
Refined refined(const RoadTable& road, double step) {
  const ClosedCurve curve = ClosedCurve::from_points(road.points);
  const std::vector<double> knots = curve.spline()->knot_stations();
  std::vector<double> stations;
  Refined fine{road, {}};
  fine.road.points.clear();
  for (std::size_t i = 0; i < knots.size(); ++i) {
    const double way = (i + 1 == knots.size() ? curve.length() : knots[i + 1]) - knots[i];
    const auto shares = static_cast<int>(std::max(1.0, std::ceil(way / step - 1e-9)));
    fine.own.push_back(stations.size());
    for (int k = 0; k < shares; ++k) {
      stations.push_back(knots[i] + way * k / shares);
      const CurvePoint at = curve.at(stations.back());
      fine.road.points.push_back(k == 0 ? road.points[i] : PlanePoint{at.x, at.y});
    }
  }
  for (std::vector<double>* column : fine.road.columns()) {
    const StationTable table(curve.length(), knots, *column);
    column->clear();
    for (const double s : stations) column->push_back(table.at(s));
  }
  return fine;
}

/// A road without the points that are much nearer to the one before than it is wide: they say nothing of its shape.
struct Thinned {
  RoadTable road;
  std::vector<std::size_t> kept;  ///< by number of the old point: which of the new ones stands for it
};

Thinned without_dense_points(const RoadTable& road, double least) {
  Thinned thin{road, {}};
  const std::vector<std::vector<double>*> columns = thin.road.columns();
  std::size_t count = 0;
  for (std::size_t i = 0; i < road.size(); ++i) {
    if (i == 0 || distance(road.points[i], thin.road.points[count - 1]) >= least) {
      thin.road.points[count] = road.points[i];
      for (std::vector<double>* column : columns) (*column)[count] = (*column)[i];
      ++count;
    }
    thin.kept.push_back(count - 1);
  }
  if (count < 8) throw GeometryError("all points lie within a hundredth of the width of fewer than 8 of them");
  thin.road.points.resize(count);
  for (std::vector<double>* column : columns) column->resize(count);
  return thin;
}

/// The line's chords, none shorter than a tenth of their mean: Smoother divides by them.
std::vector<double> sound_steps(const std::vector<PlanePoint>& points) {
  std::vector<double> steps = chord_lengths(points);
  const double least = 0.1 * mean(steps);
  for (double& step : steps) step = std::max(step, least);
  return steps;
}

/// Steps of the line without its noise, which makes the way along a noisy one longer: those of the smoothest line,
/// which is sought three times, as it depends on them. `move` becomes its largest distance in x or y from the line.
std::vector<double> true_steps(const std::vector<double>& x, const std::vector<double>& y, double half, double& move) {
  std::vector<double> steps = sound_steps(joined(x, y));
  for (int round = 0; round < 3; ++round) {
    const Smoother smoother(steps, half);
    const std::vector<double> even_x = smoother.smooth(x), even_y = smoother.smooth(y);
    move = std::max(largest_difference(x, even_x), largest_difference(y, even_y));
    steps = sound_steps(joined(even_x, even_y));
  }
  return steps;
}

/// The largest distance of a point from the closed line, whose nearest place is searched around a sample of its own:
/// what was a fold of the line before may lie beside another stretch of it.
double farthest_from(const std::vector<PlanePoint>& samples, const std::vector<PlanePoint>& points,
                     const std::function<std::size_t(std::size_t)>& sample_of) {
  const ClosedPolyline line(samples);
  double farthest = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const PlanePoint& p = points[i];
    farthest = std::max(farthest, distance(p, line.at(line.nearest_station(p.x, p.y, sample_of(i)))));
  }
  return farthest;
}

/// The edges stay: what the centre line moves to the left is taken from the left. Seen across the new line: the old one
/// may be folded.
void keep_edges(RoadTable& road, const std::vector<PlanePoint>& before) {
  const std::size_t n = road.size();
  for (std::size_t i = 0; i < n; ++i) {
    const PlanePoint &last = road.points[(i + n - 1) % n], &next = road.points[(i + 1) % n];
    const double along_x = next.x - last.x, along_y = next.y - last.y, way = std::hypot(along_x, along_y);
    const double dx = road.points[i].x - before[i].x, dy = road.points[i].y - before[i].y;
    const double left = way > 0.0 ? (along_x * dy - along_y * dx) / way : 0.0;
    road.left[i] -= left;
    road.right[i] += left;
  }
}

/// Throws GeometryError unless it is more than 0.
double mean_half_width(const RoadTable& road) {
  double half = 0.0;
  for (std::size_t i = 0; i < road.size(); ++i)
    half += 0.5 * (road.right[i] + road.left[i]) / static_cast<double>(road.size());
  if (!(half > 0.0)) throw GeometryError(format("the mean half width is %.4g m, expected more than 0", half));
  return half;
}

}  // namespace

Smoothed smooth(RoadTable& road, double tolerance) {
  constexpr double most = 40000;
  const std::vector<PlanePoint> given = road.points;
  const double half = mean_half_width(road);
  const Thinned thin = without_dense_points(road, 0.02 * half);
  const Refined fine = refined(thin.road, std::max(half, road.length() / most));
  const std::vector<PlanePoint>& before = fine.road.points;
  road = fine.road;
  std::vector<double> x, y;
  for (const PlanePoint& p : before) x.push_back(p.x), y.push_back(p.y);
  Smoothed result;
  const std::vector<double> steps = true_steps(x, y, half, result.wanted);
  result.wanted *= std::numbers::sqrt2;
  const Smoother smoother(steps, half);
  const double bound = tolerance / std::numbers::sqrt2;
  road.points = joined(smoother.smooth(x, bound), smoother.smooth(y, bound));
  result.moved = farthest_from(road.points, given, [&](std::size_t i) { return fine.own[thin.kept[i]]; });
  if (road.edges_known) keep_edges(road, before);
  const std::vector<double> chords = chord_lengths(road.points);
  limit_width_steps(road.left, chords), limit_width_steps(road.right, chords);
  if (!road.height.empty()) {
    road.height = Smoother(steps, 10.0 * half).smooth(fine.road.height);
    result.raised = largest_difference(road.height, fine.road.height);
  }
  return result;
}

double helpful_tolerance(const RoadTable& road) {
  try {
    RoadTable even = road;
    const double wanted = smooth(even, 1.0).wanted;
    const double digit = std::pow(10.0, std::floor(std::log10(wanted)) - 1.0);
    const double tolerance = digit * std::ceil(wanted / digit);  // two digits, upwards
    even = road;
    smooth(even, tolerance);
    to_track(even);
    return tolerance;
  } catch (const GeometryError&) {
    return 0.0;
  }
}

}  // namespace gripline
