#include "geometry/road_reading.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "config/ascii.hpp"
#include "config/errors.hpp"
#include "config/files.hpp"
#include "geometry/middle_line.hpp"
#include "geometry/road_trace.hpp"
#include "geometry/trace_repair.hpp"
#include "geometry/track_file.hpp"
#include "geometry/track_import.hpp"
#include "util/csv.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& file, std::string message) {
  throw InputError({Diagnostic{shown(file), 0, 0, {}, std::move(message), {}}});
}

/// What is wrong with a line is wrong in its file.
template <class Step>
void in_file(const fs::path& file, const Step& step) {
  try {
    step();
  } catch (const GeometryError& error) {
    refuse(file, error.what());
  }
}

/// The ending of a name in small letters: .gpx of .GPX.
std::string lower_ending(const fs::path& file) { return lower_case(file.extension().string()); }

/// Within so few degrees of 0, 0 is only sea: numbers of that size are radians.
void tell_radians(RoadTrace& trace) {
  constexpr double half_turn = std::numbers::pi, degree = half_turn / 180.0;
  const auto small = [](const PlanePoint& p) {
    return std::abs(p.y) <= 0.5 * half_turn * degree && std::abs(p.x) <= half_turn * degree;
  };
  if (trace.on_earth && std::ranges::all_of(trace.points, small))
    trace.remarks.emplace_back("the places lie in the sea, near latitude 0 and longitude 0: radians? Expected degrees");
}

RoadTrace read_trace(const fs::path& file) {
  if (const std::string why = why_unreadable(file); !why.empty()) refuse(file, why);
  const std::string ending = lower_ending(file);
  if (ending == ".xodr") refuse(file, not_opendrive);
  RoadTrace trace = ending == ".gpx" ? read_gpx_trace(file) : read_csv_trace(file);
  in_file(file, [&] { require_points(trace); });
  tell_radians(trace);
  return trace;
}

void to_plane(RoadTrace& trace, const PlanePoint& origin) {
  if (!trace.on_earth) return;
  for (PlanePoint& p : trace.points) p = on_tangent_plane(p, origin);
  trace.on_earth = false;
}

/// The usual distance between two edges. One place would do for a road of one width; a pit exit beside the start, or an
/// edge of few points, would not.
double usual_width(const std::vector<PlanePoint>& edge, const std::vector<PlanePoint>& other) {
  constexpr std::size_t most = 200;
  const ClosedPolyline line(other);
  std::vector<double> widths;
  for (std::size_t i = 0; i < edge.size(); i += 1 + edge.size() / most)
    widths.push_back(distance(edge[i], line.at(line.nearest_station(edge[i].x, edge[i].y))));
  return median(std::move(widths));
}

/// The usual width of a road of half widths, 0 without.
double usual_width(const RoadTrace& trace) {
  std::vector<double> widths;
  for (std::size_t i = 0; i < trace.right.size(); ++i) widths.push_back(trace.right[i] + trace.left[i]);
  return median(std::move(widths), 0.0);
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
           "edges" +
               trace.instead_of_widths);
  if (!trace.grade.empty() && !trace.height.empty()) {
    remarks.push_back("heights are left out: grade_rad says how it slopes");
    trace.height.clear();
  }
  const bool widths = !trace.right.empty();
  const TraceRepair how{
      .width = widths ? usual_width(trace) : reading.width, .surveyed = widths, .largest_gap = reading.largest_gap};
  in_file(file, [&] { repair(trace, how, remarks); });
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
  road.points.assign(shape.points->points().begin(), shape.points->points().end());
  for (const double s : shape.centre.spline()->knot_stations()) {
    road.right.push_back(shape.half_width_right.at(s));
    road.left.push_back(shape.half_width_left.at(s));
    road.grade.push_back(shape.grade.at(s));
    road.bank.push_back(shape.bank.at(s));
  }
  return road;
}

/// Whether a CSV has the centre line and both edges, by its first lines.
bool has_three_lines(const fs::path& file) {
  constexpr std::size_t first = 2000;  // bytes
  return lower_ending(file) == ".csv" && why_unreadable(file).empty() &&
         read_bytes(file).substr(0, first).find("x_center_m") != std::string::npos;
}

bool has_walls(const Track& track) {
  for (int i = 0; i < 1000; ++i)
    for (const double n : {1e-3, -1e-3})
      if (std::isfinite(track.wall_clearance({track.length() * i / 1000, n, 0.0, 0.0}))) return true;
  return false;
}

/// The start of a road, if it is elsewhere than at the first point.
std::optional<Pose> own_start(const Track& track) {
  const CurvePoint first = track.at(0.0);
  const Pose start = track.start();
  if (start.x == first.x && start.y == first.y && start.yaw == first.yaw) return std::nullopt;
  return start;
}

/// Says so where the edge that is named first, the left one, lies to the right.
void tell_exchanged(std::span<const fs::path> files, const std::vector<EdgePoints>& edges,
                    std::vector<std::string>& remarks) {
  const EdgeSides sides = compare_edges(ClosedPolyline(edges[0].points), ClosedPolyline(edges[1].points));
  if (sides.left <= 0.0) return;
  remarks.push_back(shown(files[0]) +
                    ", named as the left edge, lies to the right of the direction of travel: are the files exchanged, "
                    "their rows in reverse, or does y point to the right?");
}

RoadTable from_edges(std::span<const fs::path> files, const RoadReading& reading, std::vector<std::string>& remarks) {
  std::vector<RoadTrace> traces;
  for (const fs::path& file : files) {
    traces.push_back(read_trace(file));
    for (const std::string& remark : traces.back().remarks) remarks.push_back(shown(file) + ": " + remark);
  }
  if (traces[0].on_earth != traces[1].on_earth)
    refuse(files[1], format("is in %s, the other edge in %s; expected both in the same",
                            traces[1].on_earth ? "degrees" : "metres", traces[0].on_earth ? "degrees" : "metres"));
  if (traces[0].height.empty() != traces[1].height.empty())
    remarks.push_back("heights are left out: only " + shown(files[traces[0].height.empty() ? 1 : 0]) + " has them");
  if (traces[0].height.empty() || traces[1].height.empty())
    for (RoadTrace& trace : traces) trace.height.clear();
  const PlanePoint origin = middle_of(traces[0].points);
  for (RoadTrace& trace : traces) to_plane(trace, origin);
  const TraceRepair how{
      .width = usual_width(traces[0].points, traces[1].points), .surveyed = true, .largest_gap = reading.largest_gap};
  std::vector<EdgePoints> edges;
  for (std::size_t i = 0; i < 2; ++i) {
    const std::size_t before = remarks.size();
    in_file(files[i], [&] { repair(traces[i], how, remarks); });
    for (std::size_t k = before; k < remarks.size(); ++k) remarks[k] = shown(files[i]) + ": " + remarks[k];
    edges.push_back({std::move(traces[i].points), std::move(traces[i].height)});
  }
  RoadTable road;
  try {
    road = from_shape(shape_from_edges(edges[0], edges[1]));
  } catch (const GeometryError& error) {
    throw InputError(shown(files[0]) + " and " + shown(files[1]) + ": " + error.what());
  }
  tell_exchanged(files, edges, remarks);
  const double length = ClosedCurve::from_points(road.points).length();
  remarks.push_back(
      format("the centre line is where both edges are equally far: %zu points on %.5g m", road.points.size(), length));
  return road;
}

}  // namespace

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
    const TrackShape shape = shape_from_table(read_csv(files[0]));
    road = from_shape(shape);
    remarks.insert(remarks.end(), shape.remarks.begin(), shape.remarks.end());
  } else if (files.size() == 2) {
    road = from_edges(files, reading, remarks);
  } else if (json) {
    const Track track = load_track(files[0]);
    road = sampled(track, std::max(0.05 * track.narrowest(), track.length() / 20000.0));
    road.name = track.name();
    remarks.insert(remarks.end(), track.remarks().begin(), track.remarks().end());
    road.start = own_start(track);
    road.walls = has_walls(track);
  } else {
    road = from_trace(files[0], reading, remarks);
  }
  if (road.name.empty()) road.name = files[0].stem().string();
  return road;
}

}  // namespace gripline
