#include "geometry/trace_repair.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "geometry/height_drift.hpp"
#include "geometry/long_steps.hpp"
#include "geometry/track_import.hpp"
#include "util/numbers.hpp"

namespace gripline {
namespace {

/// Every column of a trace, for what is done to all of them.
template <class Use>
void each_column(RoadTrace& trace, const Use& use) {
  for (std::vector<double>* column : {&trace.height, &trace.right, &trace.left, &trace.grade, &trace.bank})
    if (!column->empty()) use(*column);
}

void keep_first(RoadTrace& trace, std::size_t count) {
  trace.points.resize(count);
  if (!trace.line.empty()) trace.line.resize(count);
  each_column(trace, [&](std::vector<double>& column) { column.resize(count); });
}

/// Eight and more points in a row about one place, nearer than half a usual step and a quarter of the width: a logger
/// that stood. Their middle stays.
void drop_stands(RoadTrace& trace, double width, std::vector<std::string>& remarks) {
  constexpr std::size_t fewest = 8;
  std::vector<PlanePoint>& p = trace.points;
  const double reach = std::min(0.5 * step_quantile(p, 0.9), 0.25 * width);
  const std::size_t n = p.size();
  std::size_t kept = 0, next = 0;
  for (std::size_t i = 0; i < n; i = next) {
    PlanePoint sum{};
    for (next = i; next < n && distance(p[next], p[i]) <= reach; ++next) sum.x += p[next].x, sum.y += p[next].y;
    if (next - i < fewest) next = i + 1;
    const auto count = static_cast<double>(next - i);
    p[kept] = next == i + 1 ? p[i] : PlanePoint{sum.x / count, sum.y / count};
    each_column(trace, [&](std::vector<double>& column) { column[kept] = column[i]; });
    if (!trace.line.empty()) trace.line[kept] = trace.line[i];
    ++kept;
  }
  if (kept == n) return;
  remarks.push_back(format("%zu points where the trace stands are left out", n - kept));
  keep_first(trace, kept);
}

/// Where a trace comes back to its start and goes on.
class LapEnd {
 public:
  LapEnd(const std::vector<PlanePoint>& points, double near, bool surveyed)
      : p_(points), near_(near), surveyed_(surveyed) {}

  /// The point nearest to the first one when the trace is back there the first time; none if it never is.
  std::optional<std::size_t> find() {
    std::size_t i = 1;
    while (i < p_.size() && distance(p_[i], p_[0]) < 4.0 * near_) ++i;
    while (i < p_.size() && !back(i)) ++i;
    if (i >= p_.size()) return std::nullopt;
    std::size_t nearest = i;
    for (; i < p_.size() && back(i); ++i)
      if (distance(p_[i], p_[0]) < distance(p_[nearest], p_[0])) nearest = i;
    goes_on_ = i < p_.size();
    return nearest;
  }
  /// Whether find() saw the trace leave the start again.
  bool goes_on() const { return goes_on_; }
  /// How far a point lies ahead of the first [m].
  double ahead(const PlanePoint& point) const {
    const PlanePoint u = way(0, 1).value_or(PlanePoint{1.0, 0.0});
    return ((point.x - p_[0].x) * u.x + (point.y - p_[0].y) * u.y) / std::hypot(u.x, u.y);
  }

 private:
  /// From point k to the first one that is `near` away from it, forwards or backwards: noise turns a single step.
  std::optional<PlanePoint> way(std::size_t k, int direction) const {
    for (std::size_t i = k; i < p_.size(); i += static_cast<std::size_t>(direction))  // wraps below 0 and ends
      if (distance(p_[i], p_[k]) >= near_)
        return PlanePoint{direction * (p_[i].x - p_[k].x), direction * (p_[i].y - p_[k].y)};
    return std::nullopt;
  }
  /// A road that crosses its start on a bridge does so at 30 degrees or more. A drive may turn round where its lap
  /// ends: then the way before counts; so it does at the end of the file.
  bool back(std::size_t k) const {
    if (!(distance(p_[k], p_[0]) < near_)) return false;
    const auto u = way(0, 1), ahead = way(k, 1), behind = way(k, -1);
    const auto cosine = [&](const std::optional<PlanePoint>& v) {
      return u && v ? (u->x * v->x + u->y * v->y) / (std::hypot(u->x, u->y) * std::hypot(v->x, v->y)) : -1.0;
    };
    const double along = std::cos(std::numbers::pi / 6.0);
    if (!ahead) return cosine(behind) > 0.0;
    return cosine(ahead) > along || (!surveyed_ && cosine(behind) > along);
  }

  const std::vector<PlanePoint>& p_;
  double near_;  // [m]
  bool surveyed_;
  bool goes_on_ = false;
};

/// The first point's height when the trace is back there, at point k, tells how far heights drifted in the lap, also
/// where that is too little for close_heights() to see.
void close_heights_at(RoadTrace& trace, std::size_t k, std::vector<std::string>& remarks) {
  std::string remark = even_out_lap(trace.points, trace.height, k);
  if (!remark.empty()) remarks.push_back(std::move(remark));
}

/// Cuts a trace that continues after a lap where it comes nearest to its start again. The last point of a surveyed road
/// may be as near to the first as any other step: it stays, as does the nearest point of a trace that is half a usual
/// step and more before the first.
void cut_after_a_lap(RoadTrace& trace, double near, bool surveyed, std::vector<std::string>& remarks) {
  const std::size_t n = trace.points.size();
  const double step = step_quantile(trace.points, 0.5);
  LapEnd lap(trace.points, std::max(near, 0.6 * step), surveyed);
  const std::optional<std::size_t> nearest = lap.find();
  if (!nearest) return;
  if (surveyed && !lap.goes_on() && (n - *nearest < 2 || !(lap.ahead(trace.points.back()) > 0.0))) return;
  // Otherwise the nearest point would repeat the first.
  const bool distinct = !surveyed && lap.ahead(trace.points[*nearest]) <= -0.5 * step;
  const std::size_t kept = distinct ? *nearest + 1 : *nearest;
  if (n - kept > 2 || surveyed)
    remarks.push_back(format("the trace goes on for %zu points after a lap: left out", n - kept));
  close_heights_at(trace, *nearest, remarks);
  keep_first(trace, kept);
}

/// An open line is closed by a cubic that leaves its end and meets its start along them.
void close_gap(RoadTrace& trace, double largest, std::vector<std::string>& remarks) {
  std::vector<PlanePoint>& p = trace.points;
  const std::size_t n = p.size();
  if (n < 4) return;
  double way = 0.0;
  for (std::size_t i = 1; i < n; ++i) way += distance(p[i], p[i - 1]);
  const double step = way / static_cast<double>(n - 1), gap = distance(p.back(), p.front());
  if (gap <= 2.0 * step || !(gap <= largest)) return;
  const auto tangent = [&](const PlanePoint& a, const PlanePoint& b) {
    const double share = gap / distance(a, b);
    return PlanePoint{share * (b.x - a.x), share * (b.y - a.y)};
  };
  const PlanePoint from = p.back(), to = p.front(), u = tangent(p[n - 2], p[n - 1]), v = tangent(p[0], p[1]);
  const auto pieces = static_cast<std::size_t>(std::ceil(gap / step));
  for (std::size_t i = 1; i < pieces; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(pieces), r = 1.0 - t;
    const double a = (1 + 2 * t) * r * r, b = t * r * r, c = t * t * (3 - 2 * t), d = -t * t * r;
    p.push_back({a * from.x + b * u.x + c * to.x + d * v.x, a * from.y + b * u.y + c * to.y + d * v.y});
    each_column(trace, [&](std::vector<double>& column) { column.push_back(std::lerp(column[n - 1], column[0], t)); });
  }
  if (!trace.line.empty()) trace.line.resize(p.size(), 0);
  remarks.push_back(format("a gap of %.4g m between the last point and the first is closed", gap));
}

/// Heights that drifted within the lap would be a cliff between the last point and the first. Where there is one of
/// little size the road is tilted along its way until they meet.
void close_heights(RoadTrace& trace, std::vector<std::string>& remarks) {
  std::vector<double>& z = trace.height;
  if (z.empty()) return;
  const std::size_t n = z.size();
  std::vector<double> way(n, 0.0);
  double largest = 0.0;
  for (std::size_t i = 1; i < n; ++i) {
    way[i] = way[i - 1] + distance(trace.points[i], trace.points[i - 1]);
    largest = std::max(largest, std::abs(z[i] - z[i - 1]));
  }
  const double gap = distance(trace.points.front(), trace.points.back());
  const double step = way.back() / static_cast<double>(n - 1), usual = largest * std::max(1.0, gap / step);
  const double grade = 0.5 * ((z[1] - z[0]) / way[1] + (z[n - 1] - z[n - 2]) / (way[n - 1] - way[n - 2]));
  const double drift = z.back() + std::clamp(gap * grade, -usual, usual) - z.front();
  if (std::abs(drift) <= std::max(3.0 * usual, 1e-3 * step)) return;
  remarks.push_back(take_drift_off(trace.points, z, drift));
}

/// Drops a last point that repeats the first; the line must be closed then, by a gap that `largest` allows.
void drop_closing_point(RoadTrace& trace, double largest, std::vector<std::string>& remarks) {
  const std::size_t before = trace.points.size();
  const double gap = distance(trace.points.front(), trace.points.back());
  close_heights_at(trace, before - 1, remarks);
  try {
    drop_closing_point_and_check_closed(trace.points);
  } catch (const GeometryError& error) {
    const std::string hint = largest > 0.0 && gap > largest
                                 ? format("--close %.4g is less than that gap of %.4g m", largest, gap)
                                 : std::string("--close METRES closes it");
    throw GeometryError(error.what() + ("; " + hint));
  }
  if (trace.points.size() == before) return;
  keep_first(trace, trace.points.size());
  if (gap > 1e-9) remarks.push_back(format("the last point nearly repeats the first, %.3g m from it: left out", gap));
}

}  // namespace

void require_points(const RoadTrace& trace) {
  if (trace.points.size() >= fewest_points) return;
  throw GeometryError(format("has %zu points, a track needs at least %zu", trace.points.size(), fewest_points));
}

void repair(RoadTrace& trace, const TraceRepair& how, std::vector<std::string>& remarks) {
  if (!how.surveyed) drop_stands(trace, how.width, remarks);
  if (how.width > 0.0) cut_after_a_lap(trace, how.width, how.surveyed, remarks);
  close_gap(trace, how.largest_gap, remarks);
  drop_closing_point(trace, how.largest_gap, remarks);
  require_points(trace);
  if (std::string remark = remark_of_long_steps(trace.points, trace.line, how.width); !remark.empty())
    remarks.push_back(std::move(remark));
  close_heights(trace, remarks);
}

}  // namespace gripline
