#include "geometry/road_trace.hpp"

#include <algorithm>
#include <array>
#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>
#include <cmath>
#include <numbers>
#include <sstream>
#include <utility>

#include "config/errors.hpp"
#include "config/files.hpp"
#include "geometry/road_columns.hpp"
#include "util/numbers.hpp"

namespace gripline {
namespace {

namespace fs = std::filesystem;
using boost::property_tree::ptree;

constexpr double degree = std::numbers::pi / 180.0;

[[noreturn]] void refuse(const fs::path& file, int line, std::string message) {
  throw InputError({Diagnostic{shown(file), line, line > 0 ? 1 : 0, {}, std::move(message), {}}});
}

void check_on_earth(const fs::path& file, int line, double latitude, double longitude) {
  if (std::abs(latitude) <= 89.0 && std::abs(longitude) <= 360.0) return;
  refuse(file, line,
         format("latitude %.6g and longitude %.6g: expected degrees, within 89 to the north or south", latitude,
                longitude));
}

/// What a GPX file says of its points: each point's place, height where all have one.
class GpxReader {
 public:
  explicit GpxReader(const fs::path& file) : file_(file) {}

  RoadTrace read() {
    const std::string bytes = read_bytes(file_);
    if (bytes.starts_with("\xff\xfe") || bytes.starts_with("\xfe\xff"))
      refuse(file_, 0, "is UTF-16; expected UTF-8 (iconv -f UTF-16 -t UTF-8)");
    scan(bytes);
    std::istringstream text(bytes);
    ptree tree;
    try {
      boost::property_tree::read_xml(text, tree);
    } catch (const boost::property_tree::xml_parser_error& error) {
      refuse(file_, static_cast<int>(error.line()), "is not XML: " + error.message());
    }
    const auto root = tree.get_child_optional("gpx");
    if (!root) refuse(file_, 0, "is not a GPX file: its first element is not <gpx>");
    trace_.on_earth = true;
    for (const auto& [outer, inner, point] : {std::array{"trk", "trkseg", "trkpt"}, std::array{"", "rte", "rtept"}}) {
      if (!trace_.points.empty()) break;
      routes_ = outer[0] == '\0';
      read_ = 0;
      read_points(*root, outer, inner, point);
    }
    if (trace_.points.empty()) refuse(file_, 0, "has no track points (<trkpt>) and no route points (<rtept>)");
    fill_heights();
    return std::move(trace_);
  }

 private:
  /// The parser calls itself for every element within an element; and it keeps no lines.
  void scan(const std::string& text) {
    constexpr int deepest = 50;
    int depth = 0, line = 1;
    std::size_t counted = 0;
    for (std::size_t i = text.find('<'), end = 0; i < text.size(); i = text.find('<', end)) {
      line += static_cast<int>(std::count(text.begin() + counted, text.begin() + i, '\n'));
      counted = i;
      const std::string_view rest = std::string_view(text).substr(i);
      end = end_of_markup(text, i);
      if (end == std::string::npos) return;  // the parser says what is wrong
      if (rest.starts_with("<?") || rest.starts_with("<!")) continue;
      if (rest.starts_with("<trkpt")) track_lines_.push_back(line);
      if (rest.starts_with("<rtept")) route_lines_.push_back(line);
      if (text[i + 1] == '/')
        --depth;
      else if (text[end - 1] != '/')
        ++depth;
      if (depth > deepest) refuse(file_, line, "has elements within each other more than 50 deep");
    }
  }
  /// Where what begins with '<' ends: a tag at the '>' that is in no quotes. Whatever stands in a comment or in CDATA
  /// is no element.
  static std::size_t end_of_markup(std::string_view text, std::size_t i) {
    const std::string_view rest = text.substr(i);
    if (rest.starts_with("<!--")) return text.find("-->", i);
    if (rest.starts_with("<![CDATA[")) return text.find("]]>", i);
    if (rest.starts_with("<!") || rest.starts_with("<?")) return text.find('>', i);
    char quote = 0;
    for (; i < text.size(); ++i) {
      if (quote == 0 && text[i] == '>') return i;
      if (quote != 0 && text[i] == quote)
        quote = 0;
      else if (quote == 0 && (text[i] == '"' || text[i] == '\''))
        quote = text[i];
    }
    return std::string::npos;
  }
  /// Line of the n-th point of the kind that is read, from 0; 0: unknown.
  int line_of(std::size_t n) const {
    const std::vector<int>& lines = routes_ ? route_lines_ : track_lines_;
    return n < lines.size() ? lines[n] : 0;
  }
  void read_points(const ptree& root, const std::string& outer, const std::string& inner, const std::string& point) {
    if (outer.empty()) {
      read_groups(root, inner, point);
      return;
    }
    for (const auto& [name, child] : root)
      if (name == outer) read_groups(child, inner, point);
  }
  void read_groups(const ptree& parent, const std::string& group, const std::string& point) {
    for (const auto& [name, child] : parent) {
      if (name != group) continue;
      for (const auto& [key, place] : child)
        if (key == point) add(place);
    }
  }
  void add(const ptree& place) {
    const int line = line_of(read_++);
    const auto latitude = place.get_optional<double>("<xmlattr>.lat");
    const auto longitude = place.get_optional<double>("<xmlattr>.lon");
    if (!latitude || !longitude) {
      const auto text = [&](const char* name) { return escape_control(place.get<std::string>(name, "")); };
      refuse(file_, line,
             "point " + std::to_string(read_) + " has lat=\"" + text("<xmlattr>.lat") + "\" lon=\"" +
                 text("<xmlattr>.lon") + "\"; expected numbers, with '.' as the decimal sign");
    }
    check_on_earth(file_, line, *latitude, *longitude);
    const PlanePoint at{*longitude * degree, *latitude * degree};
    if (!trace_.points.empty() && at.x == trace_.points.back().x && at.y == trace_.points.back().y) return;
    trace_.points.push_back(at);
    trace_.line.push_back(line);
    trace_.height.push_back(height_of(place, line));
  }
  /// The height of a point, not a number if it has none. What cannot be read is no missing height.
  double height_of(const ptree& place, int line) const {
    const auto height = place.get_optional<double>("ele");
    if (height) return *height;
    std::istringstream words(place.get<std::string>("ele", ""));
    std::string text;
    words >> text;
    if (text.empty() || text == "nan" || text == "NaN") return not_a_number;
    refuse(file_, line,
           "point " + std::to_string(read_) + " has the height \"" + escape_control(place.get<std::string>("ele")) +
               "\"; expected a number of metres without its unit, with '.' as the decimal sign");
  }
  /// Points without a height: between their neighbours if they are few.
  void fill_heights() {
    std::vector<double>& z = trace_.height;
    const std::size_t n = z.size();
    const auto missing =
        static_cast<std::size_t>(std::count_if(z.begin(), z.end(), [](double h) { return !(h == h); }));
    if (missing == 0) return;
    if (10 * missing > n) {
      if (missing < n)
        trace_.remarks.push_back(format("%zu of %zu points have no height: heights are left out", missing, n));
      z.clear();
      return;
    }
    std::vector<std::size_t> known;
    for (std::size_t i = 0; i < n; ++i)
      if (z[i] == z[i]) known.push_back(i);
    for (std::size_t i = 0; i < n; ++i) {
      if (z[i] == z[i]) continue;
      const auto after = std::upper_bound(known.begin(), known.end(), i);
      const std::size_t b = after == known.end() ? known.back() : *after, a = after == known.begin() ? b : *(after - 1);
      const double share = a == b ? 0.0 : static_cast<double>(i - a) / static_cast<double>(b - a);
      z[i] = std::lerp(z[a], z[b], share);
    }
    trace_.remarks.push_back(format("%zu of %zu points have no height: interpolated", missing, n));
  }

  fs::path file_;
  RoadTrace trace_;
  std::vector<int> track_lines_, route_lines_;  ///< of the points' elements
  bool routes_ = false;
  std::size_t read_ = 0;  ///< points so far, repeated ones too
};

/// Earth-centred place of a point on the WGS 84 ellipsoid [m].
std::array<double, 3> earth_centred(const PlanePoint& place) {
  constexpr double a = 6378137.0, e2 = 6.69437999014e-3;
  const double n = a / std::sqrt(1.0 - e2 * std::sin(place.y) * std::sin(place.y));
  return {n * std::cos(place.y) * std::cos(place.x), n * std::cos(place.y) * std::sin(place.x),
          n * (1.0 - e2) * std::sin(place.y)};
}

}  // namespace

RoadTrace read_csv_trace(const fs::path& file) {
  RoadColumns table = read_road_columns(file);
  RoadTrace trace;
  trace.on_earth = table.on_earth;
  trace.remarks = std::move(table.remarks);
  trace.instead_of_widths = std::move(table.instead_of_widths);
  const bool widths = !table.right.empty();
  for (std::size_t i = 0; i < table.x.size(); ++i) {
    const double x = table.x[i], y = table.y[i];
    if (trace.on_earth) check_on_earth(file, table.line[i], y, x);
    if (!(std::max(std::abs(x), std::abs(y)) <= 1e8))
      refuse(file, table.line[i], "a point farther away than 100000000 m");
    const double unit = trace.on_earth ? degree : 1.0;
    const PlanePoint at{unit * x, unit * y};
    if (!trace.points.empty() && at.x == trace.points.back().x && at.y == trace.points.back().y) {
      // A logger at rest repeats points; in a table with widths a repeated point is a mistake.
      if (widths) refuse(file, table.line[i], "repeats the point of line " + std::to_string(table.line[i - 1]));
      continue;
    }
    trace.points.push_back(at);
    trace.line.push_back(table.line[i]);
    if (widths && !(table.right[i] > 0.0 && table.left[i] > 0.0))
      refuse(file, table.line[i],
             format("half widths of %.4g m (right) and %.4g m (left): expected more than 0", table.right[i],
                    table.left[i]));
    for (const auto& [from, to] : {std::pair(&table.height, &trace.height),
                                   {&table.right, &trace.right},
                                   {&table.left, &trace.left},
                                   {&table.grade, &trace.grade},
                                   {&table.bank, &trace.bank}})
      if (!from->empty()) to->push_back((*from)[i]);
  }
  return trace;
}

RoadTrace read_gpx_trace(const fs::path& file) { return GpxReader(file).read(); }

PlanePoint middle_of(const std::vector<PlanePoint>& places) {
  if (places.empty()) return {};
  // Longitudes beside that of the first place: a road over 180 degrees is no road round the earth.
  double west = 0.0, east = 0.0, south = places[0].y, north = places[0].y;
  for (const PlanePoint& place : places) {
    const double beside = wrap_angle(place.x - places[0].x);
    west = std::min(west, beside), east = std::max(east, beside);
    south = std::min(south, place.y), north = std::max(north, place.y);
  }
  return {places[0].x + 0.5 * (west + east), 0.5 * (south + north)};
}

PlanePoint on_tangent_plane(const PlanePoint& place, const PlanePoint& origin) {
  const std::array<double, 3> p = earth_centred(place), o = earth_centred(origin);
  const double dx = p[0] - o[0], dy = p[1] - o[1], dz = p[2] - o[2];
  const double sl = std::sin(origin.x), cl = std::cos(origin.x), sp = std::sin(origin.y), cp = std::cos(origin.y);
  return {-sl * dx + cl * dy, -sp * cl * dx - sp * sl * dy + cp * dz};
}

}  // namespace gripline
