#include "geometry/track_import.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "config/errors.hpp"
#include "config/files.hpp"
#include "geometry/height_drift.hpp"
#include "geometry/long_steps.hpp"
#include "geometry/middle_line.hpp"
#include "geometry/road_names.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline {
namespace {

[[noreturn]] void refuse(const CsvTable& table, int line, std::string message) {
  throw InputError({Diagnostic{shown(table.file), line, line > 0 ? 1 : 0, {}, std::move(message), {}}});
}

constexpr double farthest = 1e8;  // [m]: beyond it sums of squares and differences of neighbours lose precision

void require_enough(const CsvTable& table, std::size_t count) {
  if (count >= fewest_points) return;
  refuse(table, 0, "has " + std::to_string(count) + " points, a track needs at least " + std::to_string(fewest_points));
}

/// Numbers of the rows to keep: all, or all but a last one that repeats the first.
std::size_t distinct_rows(const CsvTable& table, std::span<const double> x, std::span<const double> y) {
  std::size_t count = x.size();
  if (count > 1 && x[0] == x[count - 1] && y[0] == y[count - 1]) --count;
  require_enough(table, count);
  for (std::size_t i = 1; i < count; ++i) {
    if (x[i] == x[i - 1] && y[i] == y[i - 1]) {
      refuse(table, table.line[i], "repeats the point of line " + std::to_string(table.line[i - 1]));
    }
  }
  return count;
}

std::vector<PlanePoint> points_of(const CsvTable& table, const char* x_name, const char* y_name,
                                  const ImportOptions& options) {
  const std::vector<double> x = table.column(x_name), y = table.column(y_name);
  const std::size_t count = distinct_rows(table, x, y);
  std::vector<PlanePoint> points(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (!(std::max(std::abs(x[i]), std::abs(y[i])) <= farthest))
      refuse(table, table.line[i], "a point farther away than " + std::to_string(std::lround(farthest)) + " m");
    points[i] = {x[i], options.left_handed ? -y[i] : y[i]};
  }
  try {
    drop_closing_point_and_check_closed(points);
  } catch (const GeometryError& error) {
    // It closes no three lines at once.
    const bool closable = std::string_view(x_name) == "x_m";
    refuse(table, 0, error.what() + std::string(closable ? "; gripline track --close METRES closes it" : ""));
  }
  require_enough(table, points.size());
  return points;
}

/// What to do about a column that a world's road has not: roads of others have it under this name, or it is misspelt.
std::string hint_of_column(const CsvTable& table, const std::string& name, std::span<const std::string> known) {
  const bool renamed = is_road_width(name) && nearest(name, known);
  if (!is_road_column(name) || renamed) return did_you_mean(name, known);
  const bool widths = std::ranges::any_of(table.header, is_road_width);
  return format("; gripline track FILE.csv %s--out ROAD.json makes a road of it", widths ? "" : "--width METRES ");
}

void check_columns(const CsvTable& table, std::span<const std::string> known) {
  for (const std::string& name : table.header) {
    if (name.find_first_not_of("+-.0123456789eE") == std::string::npos) {
      refuse(table, 1, "the first line must name the columns: x_m,y_m,w_tr_right_m,w_tr_left_m");
    }
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      refuse(table, 1, "unknown column \"" + name + "\"" + hint_of_column(table, name, known));
    }
    if (std::count(table.header.begin(), table.header.end(), name) > 1)
      refuse(table, 1, "column \"" + name + "\" is there twice");
  }
}

/// Half widths are more than 0, each by its line.
void check_width(const CsvTable& table, const char* name) {
  const std::vector<double> width = table.column(name);
  for (std::size_t i = 0; i < width.size(); ++i)
    if (!(width[i] > 0.0))
      refuse(table, table.line[i],
             format("the %s half width is %.4g m, expected more than 0",
                    std::string_view(name) == "w_tr_left_m" ? "left" : "right", width[i]));
}

/// Tells where points seem to be missing of a road with half widths at them.
void remark_long_steps(TrackShape& shape, const CsvTable& table) {
  std::vector<double> widths;
  for (const double s : shape.centre.spline()->knot_stations())
    widths.push_back(shape.half_width_right.at(s) + shape.half_width_left.at(s));
  const std::span<const PlanePoint> points = shape.points->points();
  std::string remark =
      remark_of_long_steps(points, std::span(table.line).first(points.size()), median(std::move(widths)));
  if (!remark.empty()) shape.remarks.push_back(std::move(remark));
}

TrackShape from_centre_columns(const CsvTable& table, const ImportOptions& options) {
  const std::array<std::string, 6> known{"x_m", "y_m", "w_tr_right_m", "w_tr_left_m", "grade_rad", "bank_rad"};
  check_columns(table, known);
  if (table.find("w_tr_right_m") < 0 && table.find("w_tr_left_m") < 0)
    refuse(table, 1,
           "has no widths (w_tr_right_m,w_tr_left_m); gripline track FILE.csv --width METRES --out ROAD.json makes a "
           "road of a trace");
  std::vector<PlanePoint> points = points_of(table, "x_m", "y_m", options);
  for (const char* name : {"w_tr_right_m", "w_tr_left_m"}) check_width(table, name);
  ClosedCurve centre = ClosedCurve::from_points(points);
  const std::vector<double> stations = centre.spline()->knot_stations();
  const auto by_station = [&](const char* name, double sign) {
    std::vector<double> values = table.column(name);
    values.resize(points.size());
    for (double& value : values) value *= sign;
    return StationTable(centre.length(), stations, std::move(values));
  };
  // Mirroring exchanges left and right and the sign of the bank; the grade stays.
  StationTable right = by_station(options.left_handed ? "w_tr_left_m" : "w_tr_right_m", 1.0);
  StationTable left = by_station(options.left_handed ? "w_tr_right_m" : "w_tr_left_m", 1.0);
  StationTable grade = table.find("grade_rad") >= 0 ? by_station("grade_rad", 1.0) : StationTable();
  StationTable bank =
      table.find("bank_rad") >= 0 ? by_station("bank_rad", options.left_handed ? -1.0 : 1.0) : StationTable();
  TrackShape shape{.centre = std::move(centre),
                   .half_width_right = std::move(right),
                   .half_width_left = std::move(left),
                   .grade = std::move(grade),
                   .bank = std::move(bank)};
  shape.points = ClosedPolyline(std::move(points));
  remark_long_steps(shape, table);
  return shape;
}

/// An edge keeps its side of the centre line, each by its line.
void check_side(const CsvTable& table, const char* edge, std::span<const double> lefts, bool left) {
  for (std::size_t i = 0; i < lefts.size(); ++i)
    if (!((left ? lefts[i] : -lefts[i]) > 0.0))
      refuse(table, table.line[i],
             format("the %s edge is %.4g m %s of the centre line, expected more than 0 m %s of it as elsewhere", edge,
                    std::abs(lefts[i]), left ? "right" : "left", left ? "left" : "right"));
}

/// The points of an edge lie across the road from those of the centre line, each by its line.
void check_correspondence(const CsvTable& table, const char* edge, std::span<const double> along,
                          std::span<const double> lefts) {
  for (std::size_t i = 0; i < along.size(); ++i)
    if (std::abs(along[i]) > std::abs(lefts[i]))
      refuse(
          table, table.line[i],
          format("the point of the %s edge lies %.4g m along the road from that of the centre line and %.4g m beside "
                 "it; expected points that correspond, or the two edges as files of their own",
                 edge, std::abs(along[i]), std::abs(lefts[i])));
}

TrackShape from_edge_columns(const CsvTable& table, const ImportOptions& options) {
  const std::array<std::string, 6> known{"x_center_m", "y_center_m", "x_inner_m",
                                         "y_inner_m",  "x_outer_m",  "y_outer_m"};
  check_columns(table, known);
  std::vector<PlanePoint> points = points_of(table, "x_center_m", "y_center_m", options);
  ClosedCurve centre = ClosedCurve::from_points(points);
  const std::vector<double> stations = centre.spline()->knot_stations();
  std::array<std::vector<double>, 2> widths, lefts, along;  // inner, outer; lefts: signed distances, left positive
  std::array<double, 2> side{};                             // sums of lefts
  for (int edge = 0; edge < 2; ++edge) {
    const std::vector<double> x = table.column(edge == 0 ? "x_inner_m" : "x_outer_m");
    const std::vector<double> y = table.column(edge == 0 ? "y_inner_m" : "y_outer_m");
    for (std::size_t i = 0; i < points.size(); ++i) {
      const CurvePoint at = centre.at(stations[i]);
      const double dx = x[i] - points[i].x, dy = (options.left_handed ? -y[i] : y[i]) - points[i].y;
      widths[edge].push_back(std::hypot(dx, dy));
      lefts[edge].push_back(std::cos(at.yaw) * dy - std::sin(at.yaw) * dx);
      along[edge].push_back(std::cos(at.yaw) * dx + std::sin(at.yaw) * dy);
      side[edge] += lefts[edge].back();
    }
  }
  for (int edge = 0; edge < 2; ++edge)
    check_correspondence(table, edge == 0 ? "inner" : "outer", along[edge], lefts[edge]);
  if (side[0] * side[1] >= 0.0) refuse(table, 0, "inner and outer edge lie on the same side of the centre line");
  for (int edge = 0; edge < 2; ++edge) check_side(table, edge == 0 ? "inner" : "outer", lefts[edge], side[edge] > 0.0);
  const bool inner_left = side[0] > 0.0;
  StationTable left(centre.length(), stations, std::move(widths[inner_left ? 0 : 1]));
  StationTable right(centre.length(), stations, std::move(widths[inner_left ? 1 : 0]));
  TrackShape shape{
      .centre = std::move(centre), .half_width_right = std::move(right), .half_width_left = std::move(left)};
  shape.points = ClosedPolyline(std::move(points));
  remark_long_steps(shape, table);
  return shape;
}

/// The heights of an edge by its stations.
StationTable height_table(const ClosedPolyline& edge, const std::vector<double>& heights) {
  std::vector<double> stations(edge.points().size());
  for (std::size_t i = 0; i < stations.size(); ++i) stations[i] = edge.station(i);
  return StationTable(edge.length(), std::move(stations), heights);
}

/// Grade and bank of a road between two edges with heights.
void add_slopes(TrackShape& shape, const MiddleLine& middle, const StationTable& inner_height,
                const StationTable& outer_height, bool inner_left) {
  const double length = shape.centre.length();
  const std::vector<double> stations = shape.centre.spline()->knot_stations();
  std::vector<double> height, bank;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    const double za = inner_height.at(middle.on_inner[i]), zb = outer_height.at(middle.on_outer[i]);
    const double width = shape.half_width_left.at(stations[i]) + shape.half_width_right.at(stations[i]);
    height.push_back(0.5 * (za + zb));
    bank.push_back(std::atan2(inner_left ? zb - za : za - zb, width));
  }
  shape.grade = grade_from_heights(length, stations, height);
  shape.bank = StationTable(length, stations, std::move(bank));
}

}  // namespace

void drop_closing_point_and_check_closed(std::vector<PlanePoint>& points) {
  const std::size_t n = points.size();
  // A closing point that was rounded, or surveyed again, is much nearer to the first than its neighbours are.
  if (n > 3 && repeats_first(points, n - 1)) points.pop_back();
  double longest = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) longest = std::max(longest, distance(points[i], points[i - 1]));
  const double gap = distance(points.front(), points.back());
  if (gap > std::max(5.0 * step_quantile(points, 0.9), 3.0 * longest))
    throw GeometryError(
        format("the line is open: its last point is %.4g m from its first, its longest step is %.4g m", gap, longest));
}

TrackShape shape_from_table(const CsvTable& table, const ImportOptions& options) {
  try {
    return table.find("x_center_m") >= 0 ? from_edge_columns(table, options) : from_centre_columns(table, options);
  } catch (const GeometryError& error) {
    refuse(table, 0, error.what());
  }
}

EdgePoints EdgePoints::from_table(const CsvTable& table) {
  const std::array<std::string, 3> known{"x_m", "y_m", "z_m"};
  check_columns(table, known);
  EdgePoints edge;
  edge.points = points_of(table, "x_m", "y_m", {});
  edge.lines.assign(table.line.begin(), table.line.begin() + static_cast<std::ptrdiff_t>(edge.points.size()));
  if (table.find("z_m") >= 0) {
    edge.heights = table.column("z_m");
    if (const std::size_t lap = edge.points.size(); edge.heights.size() > lap) {  // that row repeats the first
      std::vector<PlanePoint> points = edge.points;
      points.push_back({table.column("x_m")[lap], table.column("y_m")[lap]});
      try {
        edge.remark = even_out_lap(points, edge.heights, lap);
      } catch (const GeometryError& error) {
        refuse(table, 0, error.what());
      }
    }
    edge.heights.resize(edge.points.size());
  }
  return edge;
}

TrackShape shape_from_edges(const EdgePoints& inner_points, const EdgePoints& outer_points, double spacing) {
  const ClosedPolyline inner(inner_points.points), outer(outer_points.points);
  const EdgeSides sides = compare_edges(inner, outer);
  if (sides.distance < 1e-6 * inner.length()) throw GeometryError("the two edges are the same line");
  if (sides.along <= 0.0) {
    throw GeometryError(
        "the two edges run opposite ways round; both must follow the direction of travel: reverse the rows of the one "
        "that does not");
  }
  if (std::abs(sides.left) < 0.5 * sides.distance) throw GeometryError("the two edges cross each other");
  MiddleLine middle = middle_line(inner, outer, sides, spacing > 0.0 ? spacing : 0.5 * sides.distance);
  ClosedCurve centre = ClosedCurve::from_points(middle.points);
  const double length = centre.length();
  const std::vector<double> stations = centre.spline()->knot_stations();
  const bool inner_left = sides.left < 0.0;
  check_crossing(centre, middle, inner, outer, inner_left);
  std::vector<double> to_inner, to_outer;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    to_inner.push_back(distance(inner.at(middle.on_inner[i]), middle.points[i]));
    to_outer.push_back(distance(outer.at(middle.on_outer[i]), middle.points[i]));
  }
  TrackShape shape{.centre = std::move(centre),
                   .half_width_right = StationTable(length, stations, inner_left ? to_outer : to_inner),
                   .half_width_left = StationTable(length, stations, inner_left ? to_inner : to_outer)};
  if (!inner_points.heights.empty() && !outer_points.heights.empty())
    add_slopes(shape, middle, height_table(inner, inner_points.heights), height_table(outer, outer_points.heights),
               inner_left);
  for (const auto& [edge, name] : {std::pair(&inner_points, "inner"), std::pair(&outer_points, "outer")})
    for (const std::string& remark : {edge->remark, remark_of_long_steps(edge->points, edge->lines, sides.distance)})
      if (!remark.empty()) shape.remarks.push_back(std::string(name) + " edge: " + remark);
  shape.points = ClosedPolyline(std::move(middle.points));
  return shape;
}

StationTable grade_from_heights(double length, std::span<const double> stations, std::span<const double> heights) {
  const std::size_t n = stations.size();
  std::vector<double> widths(n);
  for (std::size_t i = 0; i < n; ++i)
    widths[i] = i + 1 == n ? stations[0] + length - stations[i] : stations[i + 1] - stations[i];
  const std::vector<double> slopes = periodic_spline_slopes(heights, widths);
  // Within each interval the slope is a parabola: knots, and points between them for the table's straight pieces.
  constexpr int per_interval = 8;
  std::vector<std::pair<double, double>> rows;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = i + 1 == n ? 0 : i + 1;
    const double rise = (heights[j] - heights[i]) / widths[i];
    for (int k = 0; k < per_interval; ++k) {
      const double u = static_cast<double>(k) / per_interval;
      const double slope =
          slopes[i] * (1.0 - u) * (1.0 - 3.0 * u) + slopes[j] * u * (3.0 * u - 2.0) + 6.0 * rise * u * (1.0 - u);
      rows.emplace_back(wrap_periodic(stations[i] + u * widths[i], length), std::atan(slope));
    }
  }
  std::sort(rows.begin(), rows.end());
  std::vector<double> s, grade;
  for (const auto& [station, value] : rows) {
    s.push_back(station);
    grade.push_back(value);
  }
  return StationTable(length, std::move(s), std::move(grade));
}

StationTable grade_from_heights(const ClosedCurve& centre, const ClosedCurve& measured_along,
                                std::span<const double> stations, std::span<const double> heights) {
  std::vector<std::pair<double, double>> rows;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    const CurvePoint at = measured_along.at(stations[i]);
    rows.emplace_back(centre.locate(at.x, at.y).s, heights[i]);
  }
  std::sort(rows.begin(), rows.end());
  // At the inside of a sharp bend several places have one foot: nearer together than this they would make a cliff.
  const double least = 0.1 * centre.length() / static_cast<double>(std::max<std::size_t>(1, rows.size()));
  std::vector<double> s, z;
  std::size_t together = 1;
  for (const auto& [station, height] : rows) {
    if (!s.empty() && station - s.back() < least) {
      z.back() += (height - z.back()) / static_cast<double>(++together);
      continue;
    }
    together = 1;
    s.push_back(station);
    z.push_back(height);
  }
  if (s.size() > 1 && s.front() + centre.length() - s.back() < least) {  // over the seam
    z.front() = 0.5 * (z.front() + z.back());
    s.pop_back(), z.pop_back();
  }
  return grade_from_heights(centre.length(), s, z);
}

}  // namespace gripline
