#include "geometry/middle_line.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/place_text.hpp"
#include "util/statistics.hpp"

namespace gripline {
namespace {

/// Points every `spacing` metres along a closed line.
std::vector<PlanePoint> resample(const ClosedCurve& curve, double spacing) {
  const auto count = static_cast<std::size_t>(std::max(16.0, std::round(curve.length() / spacing)));
  std::vector<PlanePoint> points(count);
  for (std::size_t i = 0; i < count; ++i) {
    const CurvePoint at = curve.at(curve.length() * static_cast<double>(i) / static_cast<double>(count));
    points[i] = {at.x, at.y};
  }
  return points;
}

/// Where a road comes by itself, the nearest place of the other edge may belong to another stretch. It is across the
/// road where it is on the usual side, in the same direction and at the usual distance.
std::size_t surest(const std::vector<EdgeSides>& each, const EdgeSides& mean) {
  std::vector<double> distances;
  for (const EdgeSides& one : each) distances.push_back(one.distance);
  const double usual = median(std::move(distances));
  std::size_t best = 0;
  double least = INFINITY;
  for (std::size_t i = 0; i < each.size(); ++i) {
    const double unusual = std::abs(each[i].distance - usual);
    if (each[i].along < 0.9 || each[i].left * mean.left <= 0.0 || unusual >= least) continue;
    least = unusual;
    best = i;
  }
  return best;
}

/// Stations on an edge of the places beside the points of a line along it, which follow each other: each is sought
/// around the one before, from point `first`, which is beside the station `around`. Where that does not lead once round
/// the edge, each is its nearest place.
std::vector<double> beside(const ClosedPolyline& edge, std::span<const PlanePoint> line, double reach,
                           std::size_t first, double around) {
  const std::size_t n = line.size();
  std::vector<double> stations(n);
  double way = 0.0;
  for (std::size_t k = 0; k <= n; ++k) {
    const PlanePoint& p = line[(first + k) % n];
    const double s = edge.nearest_station(p.x, p.y, around, reach);
    if (k > 0) way += wrap_difference(s - around, edge.length());
    stations[(first + k) % n] = around = s;
  }
  if (std::abs(way - edge.length()) < 0.01 * edge.length()) return stations;
  for (std::size_t i = 0; i < n; ++i) stations[i] = edge.nearest_station(line[i].x, line[i].y);
  return stations;
}

}  // namespace

EdgeSides compare_edges(const ClosedPolyline& edge, const ClosedPolyline& other) {
  EdgeSides sides;
  std::vector<EdgeSides> each;
  const double step = 1e-6 * other.length();
  const std::size_t n = edge.points().size();
  for (std::size_t i = 0; i < n; ++i) {
    const PlanePoint p = edge.points()[i], next = edge.points()[i + 1 == n ? 0 : i + 1];
    const double s = other.nearest_station(p.x, p.y);
    const PlanePoint q = other.at(s), beyond = other.at(s + step);
    const double yaw = std::atan2(next.y - p.y, next.x - p.x), other_yaw = std::atan2(beyond.y - q.y, beyond.x - q.x);
    const double left = std::cos(yaw) * (q.y - p.y) - std::sin(yaw) * (q.x - p.x);
    each.push_back({distance(p, q), left, std::cos(other_yaw - yaw), i, s});
    sides.distance += each.back().distance / static_cast<double>(n);
    sides.left += left / static_cast<double>(n);
    sides.along += each.back().along / static_cast<double>(n);
  }
  sides.anchor = surest(each, sides);
  sides.beside = each[sides.anchor].beside;
  return sides;
}

MiddleLine middle_line(const ClosedPolyline& inner, const ClosedPolyline& outer, const EdgeSides& sides,
                       double spacing) {
  constexpr int rounds = 8;
  // In a hairpin about a corner of the inner edge a step along it is half a circle along the outer one.
  const double reach = 6.0 * sides.distance + 2.0 * spacing;
  const ClosedCurve along_inner = ClosedCurve::from_points(inner.points());
  MiddleLine middle{resample(along_inner, spacing), {}, {}};
  const std::size_t n = middle.points.size();
  const double share = along_inner.spline()->knot_stations()[sides.anchor] / along_inner.length();
  const auto anchor = static_cast<std::size_t>(std::lround(share * static_cast<double>(n))) % n;
  middle.on_outer = beside(outer, middle.points, reach, anchor, sides.beside);
  for (std::size_t i = 0; i < n; ++i) {
    PlanePoint& p = middle.points[i];
    const PlanePoint q = outer.at(middle.on_outer[i]);
    p = {0.5 * (p.x + q.x), 0.5 * (p.y + q.y)};
  }
  middle.on_inner = {0.0};  // both lines begin at the inner edge's first point
  for (int round = 0; round <= rounds; ++round) {
    if (round < rounds) middle.points = resample(ClosedCurve::from_points(middle.points), spacing);
    middle.on_inner = beside(inner, middle.points, reach, 0, middle.on_inner[0]);
    middle.on_outer = beside(outer, middle.points, reach, 0, middle.on_outer[0]);
    for (std::size_t i = 0; round < rounds && i < middle.points.size(); ++i) {
      PlanePoint& p = middle.points[i];
      const PlanePoint a = inner.at(middle.on_inner[i]), b = outer.at(middle.on_outer[i]);
      const double move = 0.5 * (distance(b, p) - distance(a, p)) / distance(a, b);
      p.x += move * (b.x - a.x);
      p.y += move * (b.y - a.y);
    }
  }
  return middle;
}

void check_crossing(const ClosedCurve& centre, const MiddleLine& middle, const ClosedPolyline& inner,
                    const ClosedPolyline& outer, bool inner_left) {
  const std::vector<double> stations = centre.spline()->knot_stations();
  for (std::size_t i = 0; i < stations.size(); ++i) {
    const CurvePoint at = centre.at(stations[i]);
    const PlanePoint a = inner.at(middle.on_inner[i]), b = outer.at(middle.on_outer[i]);
    const double dx = inner_left ? a.x - b.x : b.x - a.x, dy = inner_left ? a.y - b.y : b.y - a.y;
    if (std::cos(at.yaw) * dy - std::sin(at.yaw) * dx < -0.5 * std::hypot(dx, dy))
      throw GeometryError("the two edges cross each other: near " + place_text(at.x, at.y, 5) +
                          " the left one is to the right of the other");
  }
}

}  // namespace gripline
