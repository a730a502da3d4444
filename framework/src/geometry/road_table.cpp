#include "geometry/road_table.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <sstream>

#include "config/node.hpp"
#include "geometry/track_checks.hpp"
#include "geometry/track_file.hpp"
#include "geometry/track_import.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"
#include "util/whole_file.hpp"

namespace gripline {

namespace fs = std::filesystem;

double RoadTable::length() const {
  const std::vector<double> chords = chord_lengths(points);
  return std::accumulate(chords.begin(), chords.end(), 0.0);
}

std::vector<std::vector<double>*> RoadTable::columns() {
  std::vector<std::vector<double>*> filled;
  for (std::vector<double>* column : {&right, &left, &height, &grade, &bank})
    if (!column->empty()) filled.push_back(column);
  return filled;
}

void scale(RoadTable& road, double factor) {
  for (PlanePoint& p : road.points) p = {factor * p.x, factor * p.y};
  for (std::vector<double>* column : {&road.right, &road.left, &road.height})
    for (double& value : *column) value *= factor;
  if (road.start) road.start = Pose{factor * road.start->x, factor * road.start->y, road.start->yaw};
}

void reverse(RoadTable& road) {
  const auto turn = [](auto& column) { std::reverse(column.begin() + 1, column.end()); };
  if (road.points.empty()) return;
  turn(road.points);
  for (std::vector<double>* column : road.columns()) turn(*column);
  std::swap(road.right, road.left);
  for (std::vector<double>* column : {&road.grade, &road.bank})
    for (double& value : *column) value = -value;
  if (road.start) road.start->yaw = wrap_angle(road.start->yaw + std::numbers::pi);
}

std::vector<WidthStep> width_steps(const RoadTable& road) {
  const std::vector<double> chords = chord_lengths(road.points);
  std::vector<WidthStep> steps;
  for (std::size_t i = 0; i < road.size(); ++i) {
    const std::size_t j = (i + 1) % road.size();
    for (const bool right : {false, true}) {
      const std::vector<double>& width = right ? road.right : road.left;
      if (std::abs(width[j] - width[i]) > steepest_edge * chords[i])
        steps.push_back({road.points[j], width[i], width[j], right});
    }
  }
  return steps;
}

Track to_track(const RoadTable& road) {
  ClosedCurve centre = ClosedCurve::from_points(road.points);
  const double length = centre.length();
  const std::vector<double> stations = centre.spline()->knot_stations();
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
  shape.start = road.start;
  return Track(std::move(shape));
}

namespace {

/// Rows are written at equal steps, as dense as the road's points are in its corners: a mean step would cut those of a
/// road whose straights have few points. No more than eight rows a point.
double written_spacing(const RoadTable& road) {
  const std::vector<double> chords = chord_lengths(road.points);
  const double mean = road.length() / static_cast<double>(road.size());
  return std::clamp(lower_quantile(chords, 0.1), mean / 8.0, mean);
}

}  // namespace

fs::path points_beside(const fs::path& out) { return fs::path(out).replace_extension(".csv"); }

void write_road(const fs::path& out, const Track& track, const RoadTable& road) {
  const bool json = out.extension() == ".json";
  if (!json && road.bridges && !track.crossings().empty())
    throw GeometryError("a CSV cannot say that crossings are bridges; expected --out FILE.json");
  const fs::path csv = json ? points_beside(out) : out;
  std::ostringstream rows;
  write_track_csv(rows, track, written_spacing(road));
  write_file(csv, rows.str());
  if (!json) return;
  const auto quoted = [](const std::string& text) {
    std::string word = to_json_text(Node(text));
    if (word.back() == '\n') word.pop_back();
    return word;
  };
  std::string start;
  if (road.start && check_start(track, *road.start).empty())
    start = format(",\n  \"start\": {\"x\": %.17g, \"y\": %.17g, \"yaw\": %.17g}", road.start->x, road.start->y,
                   road.start->yaw);
  write_file(out, "{\n  \"name\": " + quoted(track.name()) + ",\n  \"centre\": " + quoted(csv.filename().string()) +
                      (road.bridges ? ",\n  \"bridges\": true" : "") + start + "\n}\n");
}

}  // namespace gripline
