#include "geometry/crossings.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "util/numbers.hpp"

namespace gripline {
namespace {

/// Height of a station above the road's first one [m].
double height_at(const TrackShape& shape, double s) {
  if (shape.grade.constant()) return s * std::tan(shape.grade.minimum());
  const int count = static_cast<int>(std::clamp(s / 0.1, 1000.0, 100000.0));
  double height = 0.0;
  for (int i = 0; i < count; ++i) height += s / count * std::tan(shape.grade.at((i + 0.5) * s / count));
  return height;
}

/// Where two straight pieces of the centre line cross, with the shares of both pieces. Ends count: rounding must not
/// lose a crossing between two pieces.
std::optional<std::pair<double, double>> intersection(const CurvePoint& a, const CurvePoint& b, const CurvePoint& c,
                                                      const CurvePoint& d) {
  const double ux = b.x - a.x, uy = b.y - a.y, vx = d.x - c.x, vy = d.y - c.y;
  const double cross = ux * vy - uy * vx, wx = c.x - a.x, wy = c.y - a.y;
  if (cross == 0.0) return std::nullopt;
  const double u = (wx * vy - wy * vx) / cross, v = (wx * uy - wy * ux) / cross;
  constexpr double rounding = 1e-9;
  const auto within = [](double share) { return share >= -rounding && share <= 1.0 + rounding; };
  if (!within(u) || !within(v)) return std::nullopt;
  return std::pair(u, v);
}

/// The crossing of two passes whose straight pieces meet at these stations.
Crossing crossing_at(const TrackShape& shape, double a, double b, double step) {
  const double length = shape.centre.length();
  const auto station = [&](double s) {
    return std::abs(wrap_difference(s, length)) < 1e-6 * step ? 0.0 : wrap_periodic(s, length);
  };
  const double first = std::min(station(a), station(b)), second = std::max(station(a), station(b));
  const CurvePoint here = shape.centre.at(first), there = shape.centre.at(second);
  const auto rounded = [&](double metres) { return std::abs(metres) < 1e-3 * step ? 0.0 : metres; };
  const double turned = std::abs(wrap_angle(here.yaw - there.yaw));
  return {first,
          second,
          rounded(0.5 * (here.x + there.x)),
          rounded(0.5 * (here.y + there.y)),
          std::min(turned, std::numbers::pi - turned),
          height_at(shape, second) - height_at(shape, first)};
}

/// Where the centre line crosses itself, by the first piece that does.
std::vector<Crossing> find_crossings(const TrackShape& shape, std::span<const RoadStation> road) {
  const std::size_t n = road.size();
  const double length = shape.centre.length(), step = length / static_cast<double>(n);
  std::vector<Crossing> found;
  const auto known = [&](const Crossing& c) {
    const auto near = [&](double s, double other) { return std::abs(wrap_difference(s - other, length)) < 0.5 * step; };
    return std::any_of(found.begin(), found.end(), [&](const Crossing& other) {
      return (near(c.first, other.first) && near(c.second, other.second)) ||
             (near(c.first, other.second) && near(c.second, other.first));
    });
  };
  const StationSquares squares(road, 3.0 * step);
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < n; ++i) {
    const CurvePoint &a = road[i].centre, &b = road[i + 1 == n ? 0 : i + 1].centre;
    near.clear();
    squares.visit_near(a.x, a.y, 3.0 * step, [&](std::size_t j) { near.push_back(j); });
    std::sort(near.begin(), near.end());
    for (const std::size_t j : near) {
      if (j < i + 2) continue;
      const CurvePoint &c = road[j].centre, &d = road[j + 1 == n ? 0 : j + 1].centre;
      if (std::abs(a.x - c.x) > 2.0 * step || std::abs(a.y - c.y) > 2.0 * step || (i == 0 && j + 1 == n)) continue;
      const auto shares = intersection(a, b, c, d);
      if (!shares) continue;
      const Crossing one = crossing_at(shape, a.s + shares->first * step, c.s + shares->second * step, step);
      if (!known(one)) found.push_back(one);
    }
  }
  return found;
}

}  // namespace

Crossings::Crossings(const TrackShape& shape, std::span<const RoadStation> road)
    : length_(shape.centre.length()),
      widest_half_(shape.widest_half()),
      clearance_(0.25 * (shape.half_width_right.minimum() + shape.half_width_left.minimum())) {
  constexpr double least_angle = std::numbers::pi / 6.0;  // of a bridge
  for (const Crossing& c : find_crossings(shape, road)) {
    if (c.angle < least_angle)
      shallow_.push_back(c);
    else if (shape.bridges || std::abs(c.height) >= clearance_)
      bridges_.push_back(c);
    else
      at_grade_.push_back(c);
  }
}

const Crossing* Crossings::no_bridge() const {
  if (!at_grade_.empty()) return &at_grade_.front();
  return shallow_.empty() ? nullptr : &shallow_.front();
}

bool Crossings::bridge_explains(double a, double b) const {
  const auto near = [&](double s, double at, const Crossing& c) {
    return std::abs(wrap_difference(s - at, length_)) <= reach(c);
  };
  return std::any_of(bridges_.begin(), bridges_.end(), [&](const Crossing& c) {
    return (near(a, c.first, c) && near(b, c.second, c)) || (near(a, c.second, c) && near(b, c.first, c));
  });
}

double Crossings::reach(const Crossing& c) const { return 2.6 * widest_half_ / std::sin(c.angle); }

}  // namespace gripline
