#include "geometry/track_file.hpp"

#include <algorithm>
#include <charconv>
#include <numeric>
#include <ostream>

#include "config/files.hpp"
#include "config/json_file.hpp"
#include "config/reader.hpp"
#include "geometry/track_checks.hpp"
#include "geometry/track_import.hpp"
#include "util/numbers.hpp"

namespace gripline {
namespace {

constexpr double half_turn = std::numbers::pi;

Pose read_pose(ObjectReader pose) {
  Pose result;
  const NumberRange near = NumberRange::closed(-1e8, 1e8);
  result.x = pose.number("x", "m", near);
  result.y = pose.number("y", "m", near);
  result.yaw = pose.number("yaw", "rad", NumberRange::closed(-2.0 * half_turn, 2.0 * half_turn));
  return result;
}

Segment read_segment(const Node& node, Errors& errors) {
  constexpr Segment any{1.0, 0.0};
  const std::size_t before = errors.added();
  ObjectReader segment(node, errors);
  const bool line = segment.find("line") != nullptr, arc = segment.find("arc") != nullptr;
  if (line != arc) {
    if (line) return Segment::line(segment.number("line", "m", NumberRange::positive()));
    ObjectReader bend = segment.object("arc");
    const double radius = bend.number("radius", "m", NumberRange::positive());
    const double turn = bend.number("turn", "rad", NumberRange::closed(-2.0 * half_turn, 2.0 * half_turn));
    if (errors.added() == before && turn == 0.0) bend.error_at("turn", "an arc that does not turn; expected a line");
    return Segment::arc(radius, turn);
  }
  segment.finish();
  if (errors.added() == before) segment.error("expected one of \"line\" and \"arc\"");
  return any;
}

struct Rows {
  std::vector<double> stations;
  std::vector<std::vector<double>> values;  ///< per column
};

struct Column {
  const char* key;
  const char* unit;
  NumberRange range;
};

/// [{"s": .., key: ..}, ...]
Rows read_rows(std::span<const Node> nodes, std::initializer_list<Column> columns, Errors& errors) {
  Rows rows;
  rows.values.resize(columns.size());
  for (const Node& node : nodes) {
    ObjectReader row(node, errors);
    rows.stations.push_back(row.number("s", "m", NumberRange::non_negative()));
    std::size_t i = 0;
    for (const Column& column : columns) rows.values[i++].push_back(row.number(column.key, column.unit, column.range));
  }
  return rows;
}

/// What an object says about a road whose centre line is known. GeometryErrors are reported at the key they come from.
class Details {
 public:
  Details(ObjectReader& object, TrackShape& shape) : object_(object), shape_(shape), length_(shape.centre.length()) {}

  void half_width() {
    const NumberRange wide = NumberRange::positive();
    const Node* node = object_.require("half_width", "a length, an object or a table");
    if (node == nullptr) return;
    if (node->is_array()) {
      with_rows("half_width", {{"left", "m", wide}, {"right", "m", wide}}, [this](const Rows& rows) {
        shape_.half_width_left = StationTable(length_, rows.stations, rows.values[0]);
        shape_.half_width_right = StationTable(length_, rows.stations, rows.values[1]);
      });
    } else if (node->is_object()) {
      ObjectReader sides = object_.object("half_width");
      shape_.half_width_left = sides.number("left", "m", wide);
      shape_.half_width_right = sides.number("right", "m", wide);
    } else {
      shape_.half_width_left = shape_.half_width_right = object_.number("half_width", "m", wide);
    }
  }

  void slope() {
    const NumberRange steep = NumberRange::closed(-0.7, 0.7);
    for (const auto& [key, table] :
         {std::pair{"grade", &shape_.grade}, {"height", &shape_.grade}, {"bank", &shape_.bank}}) {
      const bool in_file = !table->constant() || table->minimum() != 0.0;
      if (in_file && object_.has(key)) object_.error_at(key, "the points' file already has this by station");
    }
    if (object_.has("grade") && object_.has("height"))
      object_.error_at("height", "\"grade\" and \"height\" say the same; expected one");
    with_rows("grade", {{"grade", "rad", steep}},
              [this](const Rows& rows) { shape_.grade = StationTable(length_, rows.stations, rows.values[0]); });
    with_rows("height", {{"z", "m", NumberRange::any()}}, [this](const Rows& rows) {
      const StationTable checked(length_, rows.stations, rows.values[0]);
      shape_.grade = grade_from_heights(length_, rows.stations, rows.values[0]);
    });
    with_rows("bank", {{"bank", "rad", steep}},
              [this](const Rows& rows) { shape_.bank = StationTable(length_, rows.stations, rows.values[0]); });
  }

  void walls() {
    const Node* node = object_.find("walls");
    if (node == nullptr) return;
    if (node->is_array()) {
      wall_sections(node->array());
      return;
    }
    ObjectReader sides = object_.object("walls");
    shape_.wall_left = sides.number("left", "m", NumberRange::non_negative(), INFINITY);
    shape_.wall_right = sides.number("right", "m", NumberRange::non_negative(), INFINITY);
  }

 private:
  struct Section {
    double from = 0.0, to = 0.0, distance = 0.0;
  };

  template <class Use>
  void with_rows(const char* key, std::initializer_list<Column> columns, Use use) {
    if (object_.find(key) == nullptr) return;
    const std::size_t before = object_.errors().size();
    const Rows rows = read_rows(object_.array(key), columns, object_.errors());
    if (object_.errors().size() != before) return;
    guarded(key, [&] { use(rows); });
  }

  template <class Use>
  void guarded(const char* key, Use use) {
    try {
      use();
    } catch (const GeometryError& error) {
      object_.error_at(key, error.what());
    }
  }

  void wall_sections(std::span<const Node> nodes) {
    std::vector<Section> left, right;
    const std::size_t before = object_.errors().size();
    for (const Node& node : nodes) {
      ObjectReader section(node, object_.errors());
      const bool is_left = section.choice<bool>("side", {{"left", true}, {"right", false}});
      Section one;
      one.from = section.number("from_s", "m", NumberRange::closed(0.0, length_));
      one.to = section.number("to_s", "m", NumberRange::closed(0.0, length_));
      one.distance = section.number("distance", "m", NumberRange::non_negative());
      if (!(one.from < one.to))
        section.error_at("to_s", "expected a station beyond from_s; a wall over the start is two sections");
      (is_left ? left : right).push_back(one);
    }
    if (object_.errors().size() != before) return;
    guarded("walls", [&] {
      if (!left.empty()) shape_.wall_left = steps(left);
      if (!right.empty()) shape_.wall_right = steps(right);
    });
  }

  /// Sections become a table in which a wall stands between two rows and nothing elsewhere.
  StationTable steps(std::vector<Section> sections) const {
    std::sort(sections.begin(), sections.end(), [](const Section& a, const Section& b) { return a.from < b.from; });
    std::vector<double> stations, values;
    double end = 0.0;
    for (const Section& section : sections) {
      if (section.from < end) throw GeometryError("two walls of one side overlap");
      if (section.from > end) {
        stations.push_back(end);
        values.push_back(INFINITY);
      }
      stations.push_back(section.from);
      values.push_back(section.distance);
      end = section.to;
      // Up to its end the wall keeps its distance, whatever follows.
      stations.push_back(std::nextafter(end, 0.0));
      values.push_back(section.distance);
    }
    if (end < length_) {
      stations.push_back(end);
      values.push_back(INFINITY);
    }
    return StationTable(length_, std::move(stations), std::move(values));
  }

  ObjectReader& object_;
  TrackShape& shape_;
  double length_;
};

std::optional<ClosedCurve> read_segments(ObjectReader& object) {
  const std::size_t before = object.errors().size();
  const Pose origin = object.has("origin") ? read_pose(object.object("origin")) : Pose{};
  std::vector<Segment> segments;
  for (const Node& node : object.array("segments")) segments.push_back(read_segment(node, object.errors()));
  if (object.errors().size() != before) return std::nullopt;
  double length = 0.0;
  for (const Segment& segment : segments) length += segment.length;
  try {
    return ClosedCurve::from_segments(origin, segments, 1e-5 * std::max(1.0, length / 20.0));
  } catch (const GeometryError& error) {
    object.error_at("segments", error.what());
    return std::nullopt;
  }
}

std::optional<TrackShape> read_edges(ObjectReader& object) {
  const std::size_t before = object.errors().size();
  ObjectReader edges = object.object("edges");
  const std::filesystem::path inner = edges.input_file("inner", csv_ending),
                              outer = edges.input_file("outer", csv_ending);
  const double spacing = edges.number("spacing", "m", NumberRange::positive(), 0.0);
  if (object.errors().size() != before) return std::nullopt;
  try {
    const EdgePoints one = EdgePoints::from_table(read_csv(inner)), other = EdgePoints::from_table(read_csv(outer));
    constexpr double most = 1e5;  // points: the line between the edges takes memory and time for each
    const std::vector<double> chords = chord_lengths(one.points);
    const double length = std::accumulate(chords.begin(), chords.end(), 0.0);
    if (length > most * spacing && spacing > 0.0) {
      edges.error_at("spacing", format("%.4g m are %.3g points on an edge of %.5g m, expected at most %.0f points",
                                       spacing, length / spacing, length, most));
      return std::nullopt;
    }
    return shape_from_edges(one, other, spacing);
  } catch (const GeometryError& error) {
    object.error_at("edges", error.what());
    return std::nullopt;
  }
}

std::optional<TrackShape> read_shape(ObjectReader& object) {
  const bool segments = object.has("segments"), centre = object.has("centre"), edges = object.has("edges");
  if (segments + centre + edges != 1) {
    object.error("a track has exactly one of \"segments\", \"centre\" and \"edges\"");
    return std::nullopt;
  }
  if (centre) {
    const std::size_t before = object.errors().size();
    const std::filesystem::path file = object.input_file("centre", csv_ending);
    const bool left_handed = object.boolean("left_handed", false);
    if (object.errors().size() != before) return std::nullopt;
    return shape_from_table(read_csv(file), {.left_handed = left_handed});
  }
  if (edges) return read_edges(object);
  std::optional<ClosedCurve> curve = read_segments(object);
  if (!curve) return std::nullopt;
  TrackShape shape{.centre = std::move(*curve)};
  Details(object, shape).half_width();
  return shape;
}

std::optional<Track> read_object(const Node& node, Errors& errors, const std::string& fallback_name) {
  const std::size_t before = errors.added();
  ObjectReader object(node, errors);
  const std::string name = object.text("name", fallback_name);
  std::optional<Pose> start;
  if (object.has("start")) start = read_pose(object.object("start"));
  std::optional<TrackShape> shape = read_shape(object);
  if (!shape) {
    for (const char* key : {"half_width", "grade", "height", "bank", "walls", "origin", "left_handed", "bridges"})
      object.find(key);
    return std::nullopt;
  }
  shape->name = name;
  shape->start = start;
  shape->bridges = object.boolean("bridges", false);
  Details details(object, *shape);
  details.slope();
  details.walls();
  object.finish();
  if (errors.added() != before) return std::nullopt;
  try {
    Track track(std::move(*shape));
    if (const std::string problem = start ? check_start(track, *start) : ""; !problem.empty()) {
      object.error_at("start", problem);
      return std::nullopt;
    }
    return track;
  } catch (const GeometryError& error) {
    errors.add(node.origin, error.what());
    return std::nullopt;
  }
}

Track from_csv(const std::filesystem::path& file) {
  TrackShape shape = shape_from_table(read_csv(file));
  shape.name = file.stem().string();
  try {
    return Track(std::move(shape));
  } catch (const GeometryError& error) {
    throw InputError({Diagnostic{shown(file), 0, 0, {}, error.what(), {}}});
  }
}

/// What to do with a road in the format of another tool; "" where there is no such file.
std::string hint_of_format(const std::filesystem::path& file) {
  if (!why_unreadable(file).empty()) return {};
  if (file.extension() == ".gpx") return "; gripline track FILE --width METRES --out ROAD.json makes a road of it";
  if (file.extension() == ".xodr") return std::string("; it ") + not_opendrive;
  return {};
}

}  // namespace

std::optional<Track> read_track(const Node& node, Errors& errors) {
  try {
    if (node.is_text()) {
      const std::string why = why_no_input(node, input_endings);
      if (why.empty()) return load_track(resolve_path(node));
      errors.add(node.origin, '"' + node.text() + "\": " + why + hint_of_format(resolve_path(node)));
      return std::nullopt;
    }
    if (node.is_object()) return read_object(node, errors, "track");
  } catch (const InputError& error) {
    errors.add(error);
    return std::nullopt;
  }
  errors.add(node.origin, "expected a track: the name of a .json or .csv file, or an object; found " + node.describe());
  return std::nullopt;
}

std::vector<std::filesystem::path> named_tables(const Node& road) {
  std::vector<std::filesystem::path> files;
  const auto add = [&](const Node* holder, const char* key) {
    if (const Node* name = holder != nullptr ? holder->find(key) : nullptr; name != nullptr && name->is_text())
      files.push_back(resolve_path(*name));
  };
  add(&road, "centre");
  for (const char* edge : {"inner", "outer"}) add(road.find("edges"), edge);
  return files;
}

Track load_track(const std::filesystem::path& file) {
  if (const std::string why = why_unreadable(file); !why.empty()) {
    throw InputError({Diagnostic{shown(file), 0, 0, {}, why, {}}});
  }
  if (file.extension() == ".csv") return from_csv(file);
  Errors errors;
  const Node node = load_json(file);
  std::optional<Track> track;
  if (node.is_object()) {
    track = read_object(node, errors, file.stem().string());
  } else {
    errors.add(node.origin, "expected a track, an object; found " + node.describe());
  }
  errors.throw_if_any();
  return std::move(track.value());
}

void write_track_csv(std::ostream& out, const Track& track, double spacing) {
  out << "# x_m,y_m,w_tr_right_m,w_tr_left_m,grade_rad,bank_rad\n";
  const auto count = static_cast<std::size_t>(std::max(8.0, std::round(track.length() / spacing)));
  for (std::size_t i = 0; i < count; ++i) {
    const CurvePoint at = track.at(track.length() * static_cast<double>(i) / static_cast<double>(count));
    const double row[] = {
        at.x, at.y, track.half_width_right(at.s), track.half_width_left(at.s), track.grade(at.s), track.bank(at.s)};
    for (const double& value : row) {
      char text[32];
      const auto end = std::to_chars(text, text + sizeof text, value).ptr;
      out.write(text, end - text);
      out << (&value == &row[5] ? '\n' : ',');
    }
  }
}

}  // namespace gripline
