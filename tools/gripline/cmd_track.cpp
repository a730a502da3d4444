// gripline track FILE [FILE] [options]: a road from the formats that people have, repaired, checked and drawn.
#include <cmath>
#include <iostream>
#include <numbers>
#include <optional>
#include <string_view>

#include "car/vehicle.hpp"
#include "cli/options.hpp"
#include "config/errors.hpp"
#include "config/file_kind.hpp"
#include "config/json_file.hpp"
#include "config/shipped.hpp"
#include "geometry/corner_room.hpp"
#include "geometry/place_text.hpp"
#include "geometry/racing_line.hpp"
#include "geometry/road_reading.hpp"
#include "geometry/road_size.hpp"
#include "geometry/road_smoothing.hpp"
#include "geometry/road_table.hpp"
#include "geometry/track_checks.hpp"
#include "geometry/track_file.hpp"
#include "gripline/command.hpp"
#include "gripline/track_picture.hpp"
#include "gripline/validate_file.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"
#include "util/whole_file.hpp"
#include "world/world_spec.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace fs = std::filesystem;
namespace {

double length_option(const po::variables_map& given, const char* name) {
  const auto text = text_of(given, name);
  return text ? quantity_of("--" + std::string(name), *text, {"m", "a length above 0 m"}) : 0.0;
}

/// "1:43" or a factor.
double scale_option(const po::variables_map& given) {
  const auto text = text_of(given, "scale");
  if (!text) return 1.0;
  const std::size_t colon = text->find(':');
  const auto number = [](const std::string& one) {
    return quantity_of("--scale", one, {"", "a number above 0, or 1:43"});
  };
  return colon == std::string::npos ? number(*text) : number(text->substr(0, colon)) / number(text->substr(colon + 1));
}

/// The car of a car's or a world's file.
std::optional<Car> car_option(const po::variables_map& given) {
  const auto named = text_of(given, "car");
  if (!named) return std::nullopt;
  const fs::path file = find_shipped(*named);
  Node tree = load_json(file);
  if (kind_of(tree) == FileKind::world) {
    const Node world = load_world(file);
    const Node* own = world.find("car");
    if (own == nullptr) throw InputError(*named + ": is a world without a car");
    tree = *own;
  } else if (kind_of(tree) != FileKind::car) {
    throw InputError(*named + ": expected a car or a world");
  }
  Errors errors;
  const CarFile car = read_car(tree, errors);
  errors.throw_if_any();
  return car.car;
}

class Table {
 public:
  void row(const std::string& check, const std::string& found) {
    std::cout << check << std::string(check.size() < 18 ? 18 - check.size() : 1, ' ') << found << '\n';
  }
};

void tell_steps(Table& table, const RoadTable& road) {
  const std::vector<WidthStep> steps = width_steps(road);
  if (steps.empty()) return;
  const WidthStep& s = steps.front();
  table.row("steps of width",
            format("%zu; the first on the %s near %s, from %.4g to %.4g m (--smooth evens them out)", steps.size(),
                   s.right ? "right" : "left", place_text(s.at.x, s.at.y, 5).c_str(), s.from, s.to));
}

/// The sharpest bend, seen over half the least width and two steps: at the joins of straights and arcs, and at noise, a
/// spline's own curvature overshoots.
void tell_sharpest(Table& table, const Track& track, const RoadTable& road) {
  constexpr int count = 20000;
  const double length = track.length();
  const double over = std::max(0.5 * track.narrowest(), 2.0 * length / static_cast<double>(road.size()));
  double kappa = 0.0, kappa_s = 0.0;
  for (int i = 0; i < count; ++i) {
    const double s = length * i / count;
    const double bend = wrap_angle(track.at(s + 0.5 * over).yaw - track.at(s - 0.5 * over).yaw) / over;
    if (std::abs(bend) > std::abs(kappa)) kappa = bend, kappa_s = s;
  }
  table.row("sharpest bend", format("radius %.4g m to the %s at s = %.5g m", 1.0 / std::abs(kappa),
                                    kappa > 0 ? "left" : "right", kappa_s));
}

/// A peak of curvature that is too short to fold the edge far is no reason to refuse a road; mostly it is noise.
void warn_of_curvature_peaks(const Track& track) {
  constexpr int count = 20000;
  constexpr double tolerated = 0.9;  // as where Track looks for folds
  for (int i = 0; i < count; ++i) {
    const CurvePoint at = track.at(track.length() * i / count);
    const double half = at.kappa > 0.0 ? track.half_width_left(at.s) : track.half_width_right(at.s);
    if (tolerated * std::abs(at.kappa) * half <= 1.0) continue;
    std::cerr << format(
        "the line has curvature peaks sharper than its half width, the first at s = %.5g m (radius %.3g m); if they "
        "are noise: --smooth METRES\n",
        at.s, 1.0 / std::abs(at.kappa));
    return;
  }
}

void tell(const Track& track, const RoadTable& road) {
  Table table;
  table.row("road", track.name());
  table.row("length", format("%.6g m, %zu points", track.length(), road.size()));
  double narrow = INFINITY, wide = 0, narrow_s = 0, height = 0, low = 0, high = 0;
  constexpr int count = 20000;
  for (int i = 0; i < count; ++i) {
    const double s = track.length() * i / count;
    const double width = track.half_width_left(s) + track.half_width_right(s);
    if (width < narrow) narrow = width, narrow_s = s;
    wide = std::max(wide, width);
    height += track.length() / count * std::tan(track.grade(s));
    low = std::min(low, height), high = std::max(high, height);
  }
  table.row("width", format("%.4g to %.4g m, narrowest at s = %.5g m", narrow, wide, narrow_s));
  tell_sharpest(table, track, road);
  if (high > low) table.row("heights", format("%.4g m between the lowest and the highest place", high - low));
  for (const Crossing& c : track.crossings())
    table.row("bridge", format("at %s: s = %.5g m and s = %.5g m, at %.0f degrees", place_text(c.x, c.y, 5).c_str(),
                               c.first, c.second, c.angle * 180.0 / std::numbers::pi));
  tell_steps(table, road);
  warn_of_curvature_peaks(track);
}

/// Refuses a road that the car of this file cannot drive. Where its centre of gravity gets round and its corners do
/// not, that is told: it may race there, with a corner outside.
void check_car(const Track& track, const Car& car, const std::string& file) {
  const double radius = least_turning_radius(car);
  std::string problem = check_car_fits(track, car.width);
  if (problem.empty()) problem = check_car_turns(track, car.width, radius);
  if (!problem.empty()) throw InputError(file + ": " + problem);
  Table table;
  const FarthestCorner corner = farthest_corner(track, car);
  const std::string size = format("%.4g m wide, %.4g m long, least radius %.4g m: ", car.width, car.length, radius);
  if (corner.beyond <= 0.0)
    table.row("car", size + "drives it, its corners inside");
  else
    table.row("car", size + format("its centre of gravity gets round inside, its corners on no line that was tried; on "
                                   "the best one is %.2g m outside at s = %.5g m",
                                   corner.beyond, corner.s));
}

void add_track_options(po::options_description& visible) {
  auto add = visible.add_options();
  add("width", po::value<std::string>(), "whole width of a trace (GPX, CSV without widths) [m]");
  add("close", po::value<std::string>(), "close a gap between the ends of up to so many metres");
  add("smooth", po::value<std::string>(), "smooth; the points lie at most so many metres from the centre line");
  add("scale", po::value<std::string>(), "factor of all lengths, as 1:43 or 0.0233, after everything else");
  add("reverse", po::bool_switch(), "drive it the other way");
  add("bridges", po::bool_switch(), "where it crosses itself at an angle, one way passes over the other");
  add("car", po::value<std::string>(), "a car or a world: whether its car fits and can steer round, corners inside");
  add("out", po::value<std::string>(), "the road to write: .csv, or .json with a .csv beside it");
  add("picture", po::value<std::string>(), "a drawing to write, .svg");
  add("help,h", "this text");
}

/// The points of a road in JSON lie beside it, under a name that nobody gave: a file there is replaced only where the
/// road that was there named it.
void keep_foreign_points(const fs::path& road) {
  const fs::path points = points_beside(road);
  if (!fs::exists(points)) return;
  if (fs::exists(road)) {
    try {
      for (const fs::path& own : named_tables(load_json(road)))
        if (fs::exists(own) && fs::equivalent(own, points)) return;
    } catch (const InputError&) {  // no road that names its points
    }
  }
  throw InputError("--out " + road.string() + ": its points would replace " + points.string() +
                   ", which is another file; remove that or choose another name");
}

/// The files to be written, refused before any work.
std::optional<fs::path> output(const po::variables_map& given, const char* name,
                               std::initializer_list<const char*> endings, const Words& inputs) {
  const auto text = text_of(given, name);
  if (!text) return std::nullopt;
  const fs::path file = *text;
  std::string known;
  for (const char* ending : endings) {
    if (file.extension() == ending) {
      require_writable("--" + std::string(name), file, inputs);
      // write_road puts the road's points beside it.
      if (file.extension() == ".json") {
        require_writable("--" + std::string(name) + " " + *text + ", its points into", points_beside(file), inputs);
        keep_foreign_points(file);
      }
      return file;
    }
    known += (known.empty() ? "" : " or ") + std::string(ending);
  }
  throw InputError("--" + std::string(name) + " " + *text + ": expected a name that ends in " + known);
}

/// What is read of these roads: the files themselves, and of those in JSON the points that they name.
Words read_files(const Words& roads) {
  Words files = roads;
  for (const std::string& road : roads) {
    if (fs::path(road).extension() != ".json") continue;
    for (const fs::path& table : named_tables(load_json(road))) files.push_back(table.string());
  }
  return files;
}

/// A road ready to be described, and what it was before it was smoothed and scaled.
struct Prepared {
  RoadTable road, raw;
  double tolerance = 0.0;  ///< of its smoothing [m]; 0: none
};

/// Whether smoothing may help: units, widths and heights stay wrong.
bool says_line_is_wrong(std::string_view message) { return message.starts_with("the road "); }

/// The smoothing that would make a road of what is none; 0 where its line is not what is wrong, as where it is a road
/// until it is scaled, or where the line would have to move by half the road: that is no noise.
double helpful_smoothing(const Prepared& prepared, std::string_view message) {
  if (!says_line_is_wrong(message)) return 0.0;
  try {
    to_track(prepared.raw);
    return 0.0;
  } catch (const GeometryError& error) {
    const double tolerance = says_line_is_wrong(error.what()) ? helpful_tolerance(prepared.raw) : 0.0;
    std::vector<double> widths;
    for (std::size_t i = 0; i < prepared.raw.size(); ++i)
      widths.push_back(prepared.raw.right[i] + prepared.raw.left[i]);
    return tolerance < 0.5 * median(std::move(widths)) ? tolerance : 0.0;
  }
}

/// The message in terms of the command line.
std::string in_options(std::string message) {
  const std::string key = "\"bridges\": true";
  if (const std::size_t at = message.find(key); at != std::string::npos) message.replace(at, key.size(), "--bridges");
  return message;
}

Track make_track(const Prepared& prepared, const Words& files) {
  try {
    return to_track(prepared.road);
  } catch (const GeometryError& error) {
    const double tolerance = helpful_smoothing(prepared, error.what());
    std::string hint;
    if (tolerance > prepared.tolerance) hint = format("; if that is noise: --smooth %.2g makes it a road", tolerance);
    throw InputError(files.front() + ": " + in_options(error.what()) + hint);
  }
}

/// What a JSON road has and what is written has not.
void tell_left_out(const fs::path& out, const RoadTable& road, bool changed) {
  if (road.walls)
    std::cerr << "walls are left out of what is written: add them to the file "
              << (changed ? "with its own stations, sides and distances" : "as they were") << '\n';
  if (road.start && out.extension() != ".json")
    std::cerr << "the start is left out of what is written: a CSV has none, --out FILE.json writes it\n";
}

Prepared prepared_road(const po::variables_map& given, const Words& words) {
  const std::vector<fs::path> files(words.begin(), words.end());
  const RoadReading reading{.width = length_option(given, "width"), .largest_gap = length_option(given, "close")};
  const double tolerance = length_option(given, "smooth"), factor = scale_option(given);
  std::vector<std::string> remarks;
  RoadTable road = read_road(files, reading, remarks);
  road.bridges = road.bridges || given["bridges"].as<bool>();
  if (given["reverse"].as<bool>()) reverse(road);
  const RoadTable raw = road;
  if (tolerance > 0.0) {
    const Smoothed done = smooth(road, tolerance);
    remarks.push_back(format("smoothed: the points lie at most %.3g m from the centre line", done.moved));
    if (done.raised > 0.0) remarks.push_back(format("smoothed: heights moved by at most %.3g m", done.raised));
  }
  scale(road, factor);
  for (const std::string& remark : remarks) std::cerr << remark << '\n';
  return {std::move(road), raw, tolerance};
}

}  // namespace

int run_track(Arguments args) {
  po::options_description visible("options");
  add_track_options(visible);
  const auto given =
      parse_options(args, visible, "track FILE [options], or track LEFT.csv RIGHT.csv [options]", "road");
  if (!given) return good;
  Words words = words_of(*given, "road");
  for (std::string& word : words) word = find_shipped(word, "worlds/tracks").string();
  if (words.empty() || words.size() > 2)
    throw InputError(
        "track needs one road or its two edges: gripline track ROAD.csv, gripline track LEFT.csv RIGHT.csv");
  const Words inputs = read_files(words);
  const auto out = output(*given, "out", {".csv", ".json"}, inputs);
  const auto picture = output(*given, "picture", {".svg"}, inputs);
  const std::optional<Car> car = car_option(*given);
  try {
    const Prepared prepared = prepared_road(*given, words);
    const RoadTable& road = prepared.road;
    if (std::string warning = warning_of_size(road); !warning.empty()) {
      Diagnostic diagnostic;
      diagnostic.message = std::move(warning);
      print_warnings(words.front(), {diagnostic});
    }
    const Track track = make_track(prepared, words);
    tell(track, road);
    if (picture) write_file(*picture, picture_of(track));
    if (car) check_car(track, *car, *text_of(*given, "car"));
    if (out) {
      write_road(*out, track, road);
      tell_left_out(*out, road, given->contains("scale") || (*given)["reverse"].as<bool>());
    }
  } catch (const GeometryError& error) {
    throw InputError(words.front() + ": " + error.what());
  }
  const bool points = out && out->extension() == ".json";
  for (const auto& file : {out, points ? std::optional(points_beside(*out)) : std::nullopt, picture})
    if (file) std::cout << "written           " << file->string() << '\n';
  return good;
}

}  // namespace gripline::tools
