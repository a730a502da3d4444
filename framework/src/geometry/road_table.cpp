#include "geometry/road_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <sstream>

#include "config/errors.hpp"
#include "config/files.hpp"
#include "geometry/cyclic_box_qp.hpp"
#include "geometry/road_trace.hpp"
#include "geometry/track_file.hpp"
#include "geometry/track_import.hpp"
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

/// Whether a point lies ahead of the first, seen along the first step.
bool ahead(const PlanePoint& point, const PlanePoint& first, const PlanePoint& second) {
  return (point.x - first.x) * (second.x - first.x) + (point.y - first.y) * (second.y - first.y) > 0.0;
}

/// Cuts a trace that continues after a lap where it comes nearest to its start again.
void cut_after_a_lap(RoadTrace& trace, double near, std::vector<std::string>& remarks) {
  const std::vector<PlanePoint>& p = trace.points;
  std::size_t i = 1, n = p.size();
  while (i < n && distance(p[i], p[0]) < 4.0 * near) ++i;
  const auto back = [&](std::size_t k) {
    const double ux = p[1].x - p[0].x, uy = p[1].y - p[0].y, vx = p[k].x - p[k - 1].x, vy = p[k].y - p[k - 1].y;
    return distance(p[k], p[0]) < near && ux * vx + uy * vy > 0.0;
  };
  while (i < n && !back(i)) ++i;
  if (i >= n) return;
  std::size_t nearest = i;
  for (; i < n && back(i); ++i)
    if (distance(p[i], p[0]) < distance(p[nearest], p[0])) nearest = i;
  // The last point of a road with widths may be as near to the first as any other step: it stays.
  if (!trace.right.empty() && (n - nearest < 2 || !ahead(p[n - 1], p[0], p[1]))) return;
  if (n - nearest > 2 || !trace.right.empty())
    remarks.push_back(format("the trace goes on for %zu points after a lap: left out", n - nearest));
  keep_first(trace, nearest);  // the nearest point would repeat the first
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

RoadTrace read_trace(const fs::path& file) {
  if (const std::string why = why_unreadable(file); !why.empty()) refuse(file, why);
  RoadTrace trace = file.extension() == ".gpx" ? read_gpx_trace(file) : read_csv_trace(file);
  require_points(file, trace);
  return trace;
}

void close(const fs::path& file, RoadTrace& trace, double near, const RoadReading& reading,
           std::vector<std::string>& remarks) {
  if (!trace.right.empty()) near = trace.right.front() + trace.left.front();
  if (near > 0.0) cut_after_a_lap(trace, near, remarks);
  close_gap(trace, reading.largest_gap, remarks);
  try {
    const std::size_t before = trace.points.size();
    drop_closing_point_and_check_closed(trace.points);
    if (trace.points.size() != before) keep_first(trace, trace.points.size());
  } catch (const GeometryError& error) {
    refuse(file, std::string(error.what()) + "; --close METRES closes it");
  }
  require_points(file, trace);
}

RoadTable from_trace(const fs::path& file, const RoadReading& reading, std::vector<std::string>& remarks) {
  RoadTrace trace = read_trace(file);
  to_plane(trace, middle_of(trace.points));
  if (trace.right.empty() && !(reading.width > 0.0))
    refuse(file,
           "has no widths (w_tr_right_m,w_tr_left_m); expected --width METRES beside a trace, or the files of both "
           "edges");
  close(file, trace, reading.width, reading, remarks);
  RoadTable road;
  road.points = std::move(trace.points);
  road.right = std::move(trace.right);
  road.left = std::move(trace.left);
  if (road.right.empty()) road.right = road.left = std::vector<double>(road.size(), 0.5 * reading.width);
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

RoadTable from_edges(std::span<const fs::path> files, const RoadReading& reading, std::vector<std::string>& remarks) {
  std::vector<RoadTrace> traces;
  for (const fs::path& file : files) traces.push_back(read_trace(file));
  if (traces[0].on_earth != traces[1].on_earth) throw InputError("one edge is in metres, the other in degrees");
  const PlanePoint origin = middle_of(traces[0].points);
  std::vector<EdgePoints> edges;
  for (std::size_t i = 0; i < 2; ++i) {
    to_plane(traces[i], origin);
    close(files[i], traces[i], 0.0, reading, remarks);
    edges.push_back({std::move(traces[i].points), std::move(traces[i].height)});
  }
  TrackShape shape = shape_from_edges(edges[0], edges[1]);
  RoadTable road;
  const double length = shape.centre.length();
  for (std::size_t i = 0; i < shape.points->points().size(); ++i) {
    const double s = shape.centre.spline()->knot_station(i);
    road.points.push_back(shape.points->points()[i]);
    road.right.push_back(shape.half_width_right.at(s));
    road.left.push_back(shape.half_width_left.at(s));
    road.grade.push_back(shape.grade.at(s));
    road.bank.push_back(shape.bank.at(s));
  }
  remarks.push_back(
      format("the centre line is where both edges are equally far: %zu points on %.5g m", road.points.size(), length));
  return road;
}

/// The least sum of squared second differences plus weight times squared moves, within +- bound of the values.
std::vector<double> smoothed(const std::vector<double>& values, double weight, double bound) {
  const std::size_t n = values.size();
  CyclicPentadiagonal hessian(n);
  for (std::size_t i = 0; i < n; ++i) {
    hessian.diagonal[i] = 6.0 + weight;
    hessian.next[i] = -4.0;
    hessian.second[i] = 1.0;
  }
  std::vector<double> gradient(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto at = [&](std::size_t k) { return values[(i + n + k - 2) % n]; };
    gradient[i] = at(0) - 4.0 * at(1) + 6.0 * at(2) - 4.0 * at(3) + at(4);
  }
  const std::vector<double> lower(n, -bound), upper(n, bound);
  std::vector<double> moved = solve_cyclic_box_qp(hessian, gradient, lower, upper);
  for (std::size_t i = 0; i < n; ++i) moved[i] += values[i];
  return moved;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

/// No faster change than 1:2 along the road, by making it narrower.
void limit_width_steps(std::vector<double>& width, double step) {
  const std::size_t n = width.size();
  const double most = 0.9 * steepest_edge * step;  // chords of the inner line are shorter
  for (std::size_t k = 0; k < 2 * n; ++k) {
    const std::size_t i = k % n, j = (k + 1) % n;
    width[j] = std::min(width[j], width[i] + most);
  }
  for (std::size_t k = 2 * n; k-- > 0;) {
    const std::size_t i = (k + 1) % n, j = k % n;
    width[j] = std::min(width[j], width[i] + most);
  }
}

/// The road's columns at equal steps of its centre line, which goes through its points.
RoadTable resampled(const RoadTable& road, std::size_t count) {
  const ClosedCurve curve = ClosedCurve::from_points(road.points);
  std::vector<double> stations(road.size());
  for (std::size_t i = 0; i < stations.size(); ++i) stations[i] = curve.spline()->knot_station(i);
  RoadTable even = road;
  even.points.clear();
  for (std::size_t i = 0; i < count; ++i) {
    const CurvePoint at = curve.at(curve.length() * static_cast<double>(i) / static_cast<double>(count));
    even.points.push_back({at.x, at.y});
  }
  const auto take = [&](const std::vector<double>& column, std::vector<double>& to) {
    if (column.empty()) return;
    const StationTable table(curve.length(), stations, column);
    to.clear();
    for (std::size_t i = 0; i < count; ++i)
      to.push_back(table.at(curve.length() * static_cast<double>(i) / static_cast<double>(count)));
  };
  take(road.right, even.right), take(road.left, even.left);
  take(road.height, even.height), take(road.grade, even.grade), take(road.bank, even.bank);
  return even;
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
  RoadTable road;
  if (files.size() == 2) {
    road = from_edges(files, reading, remarks);
  } else if (files[0].extension() == ".json") {
    const Track track = load_track(files[0]);
    road = sampled(track, std::max(0.05 * track.narrowest(), track.length() / 20000.0));
    road.name = track.name();
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
  constexpr std::size_t most = 40000;
  double half = 0.0;
  for (std::size_t i = 0; i < road.size(); ++i)
    half += 0.5 * (road.right[i] + road.left[i]) / static_cast<double>(road.size());
  const double length = road.length(), wanted = std::min(length / static_cast<double>(road.size()), half);
  const auto count = static_cast<std::size_t>(std::clamp(length / wanted, 16.0, static_cast<double>(most)));
  const RoadTable before = resampled(road, count);
  road = before;
  const double step = length / static_cast<double>(count), weight = std::pow(step / half, 4.0);
  std::vector<double> x, y;
  for (const PlanePoint& p : before.points) x.push_back(p.x), y.push_back(p.y);
  x = smoothed(x, weight, tolerance / std::numbers::sqrt2);
  y = smoothed(y, weight, tolerance / std::numbers::sqrt2);
  Smoothed result;
  const ClosedCurve old = ClosedCurve::from_points(before.points);
  double hint = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    road.points[i] = {x[i], y[i]};
    result.moved = std::max(result.moved, distance(road.points[i], before.points[i]));
    // The edges stay: what the centre line moves to the left is taken from the left.
    const CurveLocation place = old.locate(x[i], y[i], hint);
    hint = place.s;
    road.left[i] -= place.n;
    road.right[i] += place.n;
  }
  limit_width_steps(road.left, step), limit_width_steps(road.right, step);
  if (!road.height.empty()) {
    road.height = smoothed(before.height, std::pow(step / (10.0 * half), 4.0), 1e3 * half);
    result.raised = largest_difference(road.height, before.height);
  }
  return result;
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
