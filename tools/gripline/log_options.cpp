#include "gripline/log_options.hpp"

#include <iostream>

#include "calibrate/effects/place_effects.hpp"
#include "config/errors.hpp"
#include "config/files.hpp"
#include "config/json_file.hpp"
#include "measured/estimates/session_delays.hpp"
#include "measured/health/session_health.hpp"
#include "measured/session/session_warnings.hpp"
#include "util/csv.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace fs = std::filesystem;
namespace {

bool is_edge(const fs::path& file) {
  if (file.extension() != ".csv" || !fs::exists(file)) return false;
  const CsvTable table = read_csv(file);
  return table.find("x_m") >= 0 && table.find("y_m") >= 0 && table.find("w_tr_right_m") < 0 && table.columns <= 3;
}

/// The other edge's file: inner for outer, left for right.
std::optional<fs::path> partner_of(const fs::path& edge) {
  for (const auto& [one, other] :
       {std::pair("inner", "outer"), {"outer", "inner"}, {"left", "right"}, {"right", "left"}}) {
    std::string name = edge.filename().string();
    const std::size_t at = name.rfind(one);
    if (at == std::string::npos) continue;
    name.replace(at, std::string(one).size(), other);
    if (const fs::path file = edge.parent_path() / name; fs::exists(file)) return file;
  }
  return std::nullopt;
}

std::string absolute_text(const fs::path& file) {
  if (const std::string why = why_unreadable(file); !why.empty())
    throw InputError("--track " + file.string() + ": " + why);
  return fs::absolute(file).string();
}

Node edges_node(const fs::path& inner, const fs::path& outer) {
  Node edges = Node::empty_object();
  edges.set("inner", Node(absolute_text(inner)));
  edges.set("outer", Node(absolute_text(outer)));
  Node track = Node::empty_object();
  track.set("edges", std::move(edges));
  return track;
}

/// Whether a finding says only in which form the log is written: nothing is lost or replaced.
bool is_form(const measured::Finding& f) {
  if (f.level == measured::Finding::Level::good) return true;
  if (f.check == "file") return !f.found.ends_with("left out");
  return f.check == "place" && f.found == "latitude and longitude";
}

/// Whether a world holds a command between steps that a map has without a word on what it does between rows.
bool is_silent(const std::optional<measured::MappedChannel>& command, bool held_in_world) {
  return held_in_world && command && command->command && !command->between.stated;
}

/// A map's commands are linear between rows unless it says otherwise, whatever the world does.
void tell_linear_commands(const measured::LogMap& map, const WorldSpec& world) {
  const bool d = is_silent(map[measured::Source::d], world.hold != Hold::foh),
             delta = is_silent(map[measured::Source::delta], world.hold == Hold::zoh);
  if (!d && !delta) return;
  std::cerr << map.file.string() << ": "
            << (d && delta ? "d and delta are"
                : d        ? "d is"
                           : "delta is")
            << " read as linear between rows, though the world's input_hold is not \"foh\": the map does not say "
               "\"hold\": \"held\" (\"sampled\" if they are linear)\n";
}

}  // namespace

void add_log_options(po::options_description& visible) {
  auto add = visible.add_options();
  add("map", po::value<std::string>(), "what the log's columns mean, JSON; without it gripline's own columns");
  add("track", po::value<Words>()->composing(), "a road: JSON, CSV, or the CSVs of both edges (LEFT,RIGHT)");
}

std::optional<Node> track_option(const po::variables_map& given) {
  const Words words = words_of(given, "track");
  if (words.empty()) return std::nullopt;
  std::vector<fs::path> files;
  for (const std::string& one : words) {
    const std::size_t comma = fs::exists(one) ? std::string::npos : one.find(',');
    files.emplace_back(one.substr(0, comma));
    if (comma != std::string::npos) files.emplace_back(one.substr(comma + 1));
  }
  if (files.size() > 2)
    throw InputError("--track names " + std::to_string(files.size()) + " files; expected one road or its two edges");
  if (files.size() == 2) return edges_node(files[0], files[1]);
  if (is_edge(files[0])) {
    const auto other = partner_of(files[0]);
    if (!other)
      throw InputError("--track " + files[0].string() +
                       " is one edge of a road; expected both: --track LEFT.csv,RIGHT.csv");
    return edges_node(files[0], *other);
  }
  return Node(absolute_text(files[0]));
}

LogWorld read_log_world(const fs::path& file, const po::variables_map& given, const Registry& registry) {
  LogWorld out;
  out.tree = load_world(file);
  Node read = out.tree;
  if (const auto track = track_option(given)) {
    read.set("track", *track);
    inline_world_files(read);
  }
  // Predictions need no race: neither a start on this road nor an end.
  read.erase("start");
  if (read.find("duration") == nullptr && read.find("laps") == nullptr) read.set("duration", Node(1.0));
  Errors errors;
  out.spec = read_world(read, registry, errors, RoadRule::optional);
  errors.throw_if_any();
  require_vehicle_model(out.spec, "a prediction");
  if (!out.spec.track) {
    out.left_out = calibrate::leave_out_place_effects(out.spec.vehicle, out.spec.car.car);
    for (const std::string& id : out.left_out)
      std::cerr << file.string() << ": no road is given, so that the effect of place \"" << id << "\" is left out\n";
  }
  return out;
}

measured::LogMap map_option(const po::variables_map& given, const WorldSpec& world) {
  if (const auto file = text_of(given, "map")) {
    measured::LogMap map = measured::load_log_map(*file);
    tell_linear_commands(map, world);
    return map;
  }
  measured::LogMap own = measured::gripline_map();
  const auto hold = [&](measured::Source command, bool held) {
    using Kind = measured::BetweenRows::Kind;
    own.channel[static_cast<std::size_t>(command)]->between.used = held ? Kind::held : Kind::linear;
  };
  hold(measured::Source::d, world.hold != Hold::foh);
  hold(measured::Source::delta, world.hold == Hold::zoh);
  return own;
}

void warn_of_findings(const std::string& log, const measured::SessionFile& file) {
  for (const measured::Finding& f : file.findings) {
    if (is_form(f)) continue;
    std::cerr << "warning: " << log << ": ";
    if (f.check == "file")
      std::cerr << f.found << '\n';
    else
      std::cerr << f.check << ' ' << f.found << ": " << f.done << '\n';
  }
}

void warn_of_inconsistencies(const std::string& log, const measured::SessionFile& file) {
  for (const auto& findings :
       {measured::constant_commands(file.session), measured::consistency_warnings(file, measured::place_lateness)})
    for (const measured::Finding& f : findings)
      std::cerr << "warning: " << log << ": " << f.check << ' ' << f.found << ": " << f.done << '\n';
}

}  // namespace gripline::tools
