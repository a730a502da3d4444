#include "geometry/road_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <optional>
#include <sstream>

#include "config/errors.hpp"
#include "config/files.hpp"
#include "geometry/cyclic_box_qp.hpp"
#include "geometry/road_trace.hpp"
#include "geometry/track_file.hpp"
#include "geometry/track_import.hpp"
#include "util/csv.hpp"
#include "util/csv_writer.hpp"
#include "util/numbers.hpp"

namespace gripline {
namespace {

namespace fs = std::filesystem;

constexpr double steepest_edge = 0.5;  // change of a half width per metre of road

double distance(const PlanePoint& a, const PlanePoint& b) { return std::hypot(a.x - b.x, a.y - b.y); }

/// Every column of a trace, for what is done to all of them.
template <class Use>
void each_column(RoadTrace& trace, const Use& use) {
  for (std::vector<double>* column : {&trace.height, &trace.right, &trace.left, &trace.grade, &trace.bank})
    if (!column->empty()) use(*column);
}

void keep_first(RoadTrace& trace, std::size_t count) {
  trace.points.resize(count);
  each_column(trace, [&](std::vector<double>& column) { column.resize(count); });
}

/// The step that a share of all steps is shorter than [m].
double step_quantile(const std::vector<PlanePoint>& points, double share) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < points.size(); ++i) steps.push_back(distance(points[i], points[i - 1]));
  if (steps.empty()) return 0.0;
  const auto rank = steps.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(steps.size() - 1));
  std::nth_element(steps.begin(), rank, steps.end());
  return *rank;
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
  /// Whether a point lies ahead of the first.
  bool ahead(const PlanePoint& point) const {
    const PlanePoint u = way(0, 1).value_or(PlanePoint{});
    return (point.x - p_[0].x) * u.x + (point.y - p_[0].y) * u.y > 0.0;
  }

 private:
  /// From point k to the first one that is `near` away from it, forwards or backwards: noise turns a single step.
  std::optional<PlanePoint> way(std::size_t k, int direction) const {
    for (std::size_t i = k; i < p_.size(); i += static_cast<std::size_t>(direction))  // wraps below 0 and ends
      if (distance(p_[i], p_[k]) >= near_)
        return PlanePoint{direction * (p_[i].x - p_[k].x), direction * (p_[i].y - p_[k].y)};
    return std::nullopt;
  }
  /// A road that crosses its start on a bridge does so at 30 degrees or more. A drive may turn round where its lap ends:
  /// then the way before counts; so it does at the end of the file.
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

/// Cuts a trace that continues after a lap where it comes nearest to its start again. The last point of a surveyed road
/// may be as near to the first as any other step: it stays.
void cut_after_a_lap(RoadTrace& trace, double near, bool surveyed, std::vector<std::string>& remarks) {
  const std::size_t n = trace.points.size();
  LapEnd lap(trace.points, std::max(near, 0.6 * step_quantile(trace.points, 0.5)), surveyed);
  const std::optional<std::size_t> nearest = lap.find();
  if (!nearest) return;
  if (surveyed && !lap.goes_on() && (n - *nearest < 2 || !lap.ahead(trace.points.back()))) return;
  if (n - *nearest > 2 || surveyed)
    remarks.push_back(format("the trace goes on for %zu points after a lap: left out", n - *nearest));
  keep_first(trace, *nearest);  // the nearest point would repeat the first
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
  remarks.push_back(format("a gap of %.4g m between the last point and the first is closed", gap));
}

void to_plane(RoadTrace& trace, const PlanePoint& origin) {
  if (!trace.on_earth) return;
  for (PlanePoint& p : trace.points) p = on_tangent_plane(p, origin);
  trace.on_earth = false;
}

[[noreturn]] void refuse(const fs::path& file, std::string message) {
  throw InputError({Diagnostic{shown(file), 0, 0, {}, std::move(message), {}}});
}

void require_points(const fs::path& file, const RoadTrace& trace) {
  if (trace.points.size() >= 8) return;
  refuse(file, format("has %zu points, a track needs at least 8", trace.points.size()));
}

/// The ending of a name in small letters: .gpx of .GPX.
std::string lower_ending(const fs::path& file) {
  std::string ending = file.extension().string();
  for (char& c : ending)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return ending;
}

RoadTrace read_trace(const fs::path& file) {
  if (const std::string why = why_unreadable(file); !why.empty()) refuse(file, why);
  const std::string ending = lower_ending(file);
  if (ending == ".xodr")
    refuse(file,
           "is OpenDRIVE, which is not read; export its reference line as a CSV x_m,y_m,w_tr_right_m,w_tr_left_m");
  RoadTrace trace = ending == ".gpx" ? read_gpx_trace(file) : read_csv_trace(file);
  require_points(file, trace);
  return trace;
}

/// Heights that drifted within the lap, as those of barometers do, would be a cliff between the last point and the first:
/// the road is tilted along its way until they meet, where that is little.
void close_heights(const fs::path& file, RoadTrace& trace, std::vector<std::string>& remarks) {
  constexpr double most = 0.005;  // of the length
  std::vector<double>& z = trace.height;
  if (z.empty()) return;
  const std::size_t n = z.size();
  std::vector<double> way(n, 0.0);
  double largest = 0.0;
  for (std::size_t i = 1; i < n; ++i) {
    way[i] = way[i - 1] + distance(trace.points[i], trace.points[i - 1]);
    largest = std::max(largest, std::abs(z[i] - z[i - 1]));
  }
  const double gap = distance(trace.points.front(), trace.points.back()), length = way.back() + gap;
  const double step = way.back() / static_cast<double>(n - 1), usual = largest * std::max(1.0, gap / step);
  const double grade = 0.5 * ((z[1] - z[0]) / way[1] + (z[n - 1] - z[n - 2]) / (way[n - 1] - way[n - 2]));
  const double drift = z.back() + std::clamp(gap * grade, -usual, usual) - z.front();
  if (std::abs(drift) <= std::max(3.0 * usual, 1e-3 * step)) return;
  const char* const where = drift > 0.0 ? "higher" : "lower";
  if (std::abs(drift) > most * length)
    refuse(file,
           format("the heights do not close: after a lap it is %.3g m %s than where it began (up to 0.5 %% of its "
                  "length, %.3g m, is evened out)",
                  std::abs(drift), where, most * length));
  for (std::size_t i = 1; i < n; ++i) z[i] -= drift * way[i] / length;
  remarks.push_back(
      format("after a lap it is %.3g m %s than where it began: evened out along the way", std::abs(drift), where));
}

/// `width` [m] of the road at the first point; `surveyed`: a table of the road or of an edge, not a drive.
void close(const fs::path& file, RoadTrace& trace, double width, bool surveyed, const RoadReading& reading,
           std::vector<std::string>& remarks) {
  if (!surveyed) drop_stands(trace, width, remarks);
  if (width > 0.0) cut_after_a_lap(trace, width, surveyed, remarks);
  close_gap(trace, reading.largest_gap, remarks);
  try {
    const std::size_t before = trace.points.size();
    const double gap = distance(trace.points.front(), trace.points.back());
    drop_closing_point_and_check_closed(trace.points);
    if (trace.points.size() != before) keep_first(trace, trace.points.size());
    if (trace.points.size() != before && gap > 1e-9)
      remarks.push_back(format("the last point nearly repeats the first, %.3g m from it: left out", gap));
  } catch (const GeometryError& error) {
    refuse(file, std::string(error.what()) + "; --close METRES closes it");
  }
  require_points(file, trace);
  close_heights(file, trace, remarks);
}

RoadTable from_trace(const fs::path& file, const RoadReading& reading, std::vector<std::string>& remarks) {
  RoadTrace trace = read_trace(file);
  remarks.insert(remarks.end(), trace.remarks.begin(), trace.remarks.end());
  to_plane(trace, middle_of(trace.points));
  if (!trace.right.empty() && reading.width > 0.0)
    refuse(file, "has widths of its own; --width is for a trace without");
  if (trace.right.empty() && !(reading.width > 0.0))
    refuse(file,
           "has no widths (w_tr_right_m,w_tr_left_m); expected --width METRES beside a trace, or the files of both "
           "edges");
  if (!trace.grade.empty() && !trace.height.empty()) {
    remarks.push_back("heights are left out: grade_rad says how it slopes");
    trace.height.clear();
  }
  const bool widths = !trace.right.empty();
  close(file, trace, widths ? trace.right.front() + trace.left.front() : reading.width, widths, reading, remarks);
  RoadTable road;
  road.points = std::move(trace.points);
  road.right = std::move(trace.right);
  road.left = std::move(trace.left);
  road.edges_known = !road.right.empty();
  if (!road.edges_known) road.right = road.left = std::vector<double>(road.size(), 0.5 * reading.width);
  road.height = std::move(trace.height);
  road.grade = std::move(trace.grade);
  road.bank = std::move(trace.bank);
  return road;
}

/// Rows every `spacing` metres along a road's shape.
RoadTable sampled(const Track& track, double spacing) {
  RoadTable road;
  const auto count = static_cast<std::size_t>(std::max(16.0, std::ceil(track.length() / spacing)));
  for (std::size_t i = 0; i < count; ++i) {
    const CurvePoint at = track.at(track.length() * static_cast<double>(i) / static_cast<double>(count));
    road.points.push_back({at.x, at.y});
    road.right.push_back(track.half_width_right(at.s));
    road.left.push_back(track.half_width_left(at.s));
    road.grade.push_back(track.grade(at.s));
    road.bank.push_back(track.bank(at.s));
  }
  road.bridges = !track.crossings().empty();
  return road;
}

/// The columns of a shape at the points that it was made of.
RoadTable from_shape(const TrackShape& shape) {
  RoadTable road;
  for (std::size_t i = 0; i < shape.points->points().size(); ++i) {
    const double s = shape.centre.spline()->knot_station(i);
    road.points.push_back(shape.points->points()[i]);
    road.right.push_back(shape.half_width_right.at(s));
    road.left.push_back(shape.half_width_left.at(s));
    road.grade.push_back(shape.grade.at(s));
    road.bank.push_back(shape.bank.at(s));
  }
  return road;
}

/// Whether a CSV has the centre line and both edges, by its first line.
bool has_three_lines(const fs::path& file) {
  return lower_ending(file) == ".csv" && why_unreadable(file).empty() && read_csv(file).find("x_center_m") >= 0;
}

double least_distance(const PlanePoint& from, const std::vector<PlanePoint>& points) {
  double least = INFINITY;
  for (const PlanePoint& p : points) least = std::min(least, distance(from, p));
  return least;
}

/// What a JSON road has and a table of points has not.
void tell_left_out(const Track& track, std::vector<std::string>& remarks) {
  bool walls = false;
  for (int i = 0; i < 1000; ++i)
    for (const double n : {1e-3, -1e-3})
      walls = walls || std::isfinite(track.wall_clearance({track.length() * i / 1000, n, 0.0, 0.0}));
  if (walls) remarks.push_back("walls are left out of what is written: add them to the file as they were");
  const CurvePoint first = track.at(0.0);
  const Pose start = track.start();
  if (start.x != first.x || start.y != first.y || start.yaw != first.yaw)
    remarks.push_back("the start is left out of what is written: add it to the file as it was");
}

RoadTable from_edges(std::span<const fs::path> files, const RoadReading& reading, std::vector<std::string>& remarks) {
  std::vector<RoadTrace> traces;
  for (const fs::path& file : files) {
    traces.push_back(read_trace(file));
    for (const std::string& remark : traces.back().remarks) remarks.push_back(shown(file) + ": " + remark);
  }
  if (traces[0].on_earth != traces[1].on_earth) throw InputError("one edge is in metres, the other in degrees");
  if (traces[0].height.empty() != traces[1].height.empty())
    remarks.push_back("heights are left out: only " + shown(files[traces[0].height.empty() ? 1 : 0]) + " has them");
  if (traces[0].height.empty() || traces[1].height.empty())
    for (RoadTrace& trace : traces) trace.height.clear();
  const PlanePoint origin = middle_of(traces[0].points);
  for (RoadTrace& trace : traces) to_plane(trace, origin);
  const double width = least_distance(traces[0].points.front(), traces[1].points);
  std::vector<EdgePoints> edges;
  for (std::size_t i = 0; i < 2; ++i) {
    close(files[i], traces[i], width, true, reading, remarks);
    edges.push_back({std::move(traces[i].points), std::move(traces[i].height)});
  }
  const RoadTable road = from_shape(shape_from_edges(edges[0], edges[1]));
  const double length = ClosedCurve::from_points(road.points).length();
  remarks.push_back(
      format("the centre line is where both edges are equally far: %zu points on %.5g m", road.points.size(), length));
  return road;
}

/// Evens out values at the samples of a closed line: the least integral of the squared second derivative plus
/// (move / half^2)^2, both times the cube of the mean step, so that for equal steps it is made of second differences.
class Smoother {
 public:
  /// `steps[i]` leads from sample i to the next [m]; waves shorter than about six `half` [m] go.
  Smoother(const std::vector<double>& steps, double half)
      : before_(steps.size()), here_(steps.size()), after_(steps.size()), hessian_(steps.size()) {
    const std::size_t n = steps.size();
    const double mean = std::accumulate(steps.begin(), steps.end(), 0.0) / static_cast<double>(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double last = steps[(i + n - 1) % n], next = steps[i], middle = 0.5 * (last + next);
      const double share = mean * std::sqrt(mean / middle);
      before_[i] = share / last;
      after_[i] = share / next;
      here_[i] = -before_[i] - after_[i];
      hessian_.diagonal[i] = middle / mean * std::pow(mean / half, 4.0);
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

std::vector<double> steps_between(const std::vector<PlanePoint>& points) {
  std::vector<double> steps(points.size());
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = distance(points[i], points[(i + 1) % points.size()]);
  return steps;
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
  std::vector<double> knots(road.size()), stations;
  for (std::size_t i = 0; i < knots.size(); ++i) knots[i] = curve.spline()->knot_station(i);
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
  for (std::vector<double>* column :
       {&fine.road.right, &fine.road.left, &fine.road.height, &fine.road.grade, &fine.road.bank}) {
    if (column->empty()) continue;
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
  const std::array columns{&thin.road.right, &thin.road.left, &thin.road.height, &thin.road.grade, &thin.road.bank};
  std::size_t count = 0;
  for (std::size_t i = 0; i < road.size(); ++i) {
    if (i == 0 || distance(road.points[i], thin.road.points[count - 1]) >= least) {
      thin.road.points[count] = road.points[i];
      for (std::vector<double>* column : columns)
        if (!column->empty()) (*column)[count] = (*column)[i];
      ++count;
    }
    thin.kept.push_back(count - 1);
  }
  if (count < 8) throw GeometryError("all points lie within a hundredth of the width of fewer than 8 of them");
  thin.road.points.resize(count);
  for (std::vector<double>* column : columns)
    if (!column->empty()) column->resize(count);
  return thin;
}

/// Steps of the line without its noise, which makes the way along a noisy one longer: from the smoothest line, twice.
/// The largest move in x or y that this takes is told, too.
std::vector<double> true_steps(const std::vector<double>& x, const std::vector<double>& y, double half, double& move) {
  std::vector<double> steps = steps_between(joined(x, y));
  for (int round = 0; round < 3; ++round) {
    const double mean = std::accumulate(steps.begin(), steps.end(), 0.0) / static_cast<double>(steps.size());
    for (double& step : steps) step = std::max(step, 0.1 * mean);
    const Smoother smoother(steps, half);
    const std::vector<double> even_x = smoother.smooth(x), even_y = smoother.smooth(y);
    move = std::max(largest_difference(x, even_x), largest_difference(y, even_y));
    steps = steps_between(joined(even_x, even_y));
  }
  const double mean = std::accumulate(steps.begin(), steps.end(), 0.0) / static_cast<double>(steps.size());
  for (double& step : steps) step = std::max(step, 0.1 * mean);
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

}  // namespace

double RoadTable::length() const {
  double way = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) way += distance(points[i], points[(i + 1) % points.size()]);
  return way;
}

RoadTable read_road(std::span<const fs::path> files, const RoadReading& reading, std::vector<std::string>& remarks) {
  if (files.empty() || files.size() > 2)
    throw InputError("expected one file of a road, or the files of its two edges; found " +
                     std::to_string(files.size()));
  const bool json = lower_ending(files[0]) == ".json", lines = files.size() == 1 && has_three_lines(files[0]);
  if (reading.width > 0.0 && files.size() == 2)
    throw InputError("--width is for a trace; two edges have their width between them");
  if (reading.width > 0.0 && (json || lines)) refuse(files[0], "has widths of its own; --width is for a trace without");
  RoadTable road;
  if (lines) {
    road = from_shape(shape_from_table(read_csv(files[0])));
  } else if (files.size() == 2) {
    road = from_edges(files, reading, remarks);
  } else if (json) {
    const Track track = load_track(files[0]);
    road = sampled(track, std::max(0.05 * track.narrowest(), track.length() / 20000.0));
    road.name = track.name();
    tell_left_out(track, remarks);
  } else {
    road = from_trace(files[0], reading, remarks);
  }
  if (road.name.empty()) road.name = files[0].stem().string();
  return road;
}

void scale(RoadTable& road, double factor) {
  for (PlanePoint& p : road.points) p = {factor * p.x, factor * p.y};
  for (std::vector<double>* column : {&road.right, &road.left, &road.height})
    for (double& value : *column) value *= factor;
}

void reverse(RoadTable& road) {
  const auto turn = [](auto& column) {
    if (column.size() > 1) std::reverse(column.begin() + 1, column.end());
  };
  turn(road.points);
  for (std::vector<double>* column : {&road.right, &road.left, &road.height, &road.grade, &road.bank}) turn(*column);
  std::swap(road.right, road.left);
  for (std::vector<double>* column : {&road.grade, &road.bank})
    for (double& value : *column) value = -value;
}

std::vector<WidthStep> width_steps(const RoadTable& road) {
  std::vector<WidthStep> steps;
  for (std::size_t i = 0; i < road.size(); ++i) {
    const std::size_t j = (i + 1) % road.size();
    const double most = steepest_edge * distance(road.points[i], road.points[j]);
    for (const bool right : {false, true}) {
      const std::vector<double>& width = right ? road.right : road.left;
      if (std::abs(width[j] - width[i]) > most) steps.push_back({road.points[j], width[i], width[j], right});
    }
  }
  return steps;
}

Smoothed smooth(RoadTable& road, double tolerance) {
  constexpr double most = 40000;
  const std::vector<PlanePoint> given = road.points;
  double half = 0.0;
  for (std::size_t i = 0; i < road.size(); ++i)
    half += 0.5 * (road.right[i] + road.left[i]) / static_cast<double>(road.size());
  if (!(half > 0.0)) throw GeometryError(format("the mean half width is %.4g m, expected more than 0", half));
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
  const std::vector<double> chords = steps_between(road.points);
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

Track to_track(const RoadTable& road) {
  ClosedCurve centre = ClosedCurve::from_points(road.points);
  const double length = centre.length();
  std::vector<double> stations(road.size());
  for (std::size_t i = 0; i < stations.size(); ++i) stations[i] = centre.spline()->knot_station(i);
  const auto table = [&](const std::vector<double>& column) {
    return column.empty() ? StationTable() : StationTable(length, stations, column);
  };
  TrackShape shape{.name = road.name,
                   .centre = std::move(centre),
                   .half_width_right = table(road.right),
                   .half_width_left = table(road.left),
                   .grade = table(road.grade),
                   .bank = table(road.bank)};
  if (road.grade.empty() && !road.height.empty()) shape.grade = grade_from_heights(length, stations, road.height);
  shape.points = ClosedPolyline(road.points);
  shape.bridges = road.bridges;
  return Track(std::move(shape));
}

fs::path points_beside(const fs::path& out) { return fs::path(out).replace_extension(".csv"); }

void write_road(const fs::path& out, const Track& track, const RoadTable& road) {
  const bool json = out.extension() == ".json";
  const double spacing = road.length() / static_cast<double>(road.size());
  std::ostringstream rows;
  write_track_csv(rows, track, spacing);
  if (!json) {
    if (road.bridges && !track.crossings().empty())
      throw GeometryError("a CSV cannot say that crossings are bridges; expected --out FILE.json");
    write_file(out, rows.str());
    return;
  }
  const fs::path csv = points_beside(out);
  write_file(csv, rows.str());
  std::string text = "{\n  \"name\": ";
  text.append(to_json_text(Node(track.name())));
  if (text.back() == '\n') text.pop_back();
  text.append(",\n  \"centre\": ");
  text.append(to_json_text(Node(csv.filename().string())));
  if (text.back() == '\n') text.pop_back();
  if (road.bridges) text.append(",\n  \"bridges\": true");
  text.append("\n}\n");
  write_file(out, text);
}

}  // namespace gripline
