#include "geometry/road_names.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <span>
#include <vector>

#include "config/units.hpp"
#include "tables/column_names.hpp"

namespace gripline {
namespace {

struct Meaning {
  const char* what;                ///< in messages
  std::vector<const char*> words;  ///< plain names without units (tables/column_names.hpp), best first
  std::vector<const char*> kinds;  ///< of units
  const char* unit;                ///< where none is written; null: it must be
  bool in_paths;                   ///< also by the last words of pose.position.x
  std::vector<const char*> sides;  ///< parts of the words that are others in the words of its pair
  std::vector<std::string> own;    ///< names of gripline's own files, best first
};

/// What loggers call a channel, without the names that are another one with its unit: x stands for x_m and x_mm.
std::vector<const char*> as_in_logs(const char* channel, const char* kind) {
  const std::span<const char* const> names = names_of(channel);
  std::vector<const char*> words;
  std::ranges::copy_if(names, std::back_inserter(words), [&](std::string_view name) {
    return std::ranges::none_of(names, [&](std::string_view one) { return one != name && is_called(name, one, kind); });
  });
  return words;
}

const Meaning& meaning(RoadRole role) {
  static const std::array<Meaning, road_roles> all{
      {{"x", as_in_logs("x", "m"), {"m"}, "m", true, {"east", "x"}, {"x_m", "x"}},
       {"y", as_in_logs("y", "m"), {"m"}, "m", true, {"north", "y"}, {"y_m", "y"}},
       {"longitude",
        as_in_logs("longitude", "rad"),
        {"rad"},
        "deg",
        true,
        {"longitude", "long", "lon", "lng"},
        {"lon", "longitude", "lng", "lon_deg"}},
       {"latitude",
        as_in_logs("latitude", "rad"),
        {"rad"},
        "deg",
        true,
        {"latitude", "lat"},
        {"lat", "latitude", "lat_deg"}},
       {"height",
        {"z", "posz", "positionz", "ele", "elevation", "alt", "altitude"},
        {"m"},
        "m",
        true,
        {},
        {"z_m", "z", "ele", "elevation", "alt", "altitude"}},
       {"right",
        {"wtrright", "wright", "widthright", "halfwidthright", "rightwidth", "right"},
        {"m"},
        "m",
        false,
        {"right"},
        {"w_tr_right_m"}},
       {"left",
        {"wtrleft", "wleft", "widthleft", "halfwidthleft", "leftwidth", "left"},
        {"m"},
        "m",
        false,
        {"left"},
        {"w_tr_left_m"}},
       {"width", {"width", "trackwidth", "roadwidth"}, {"m"}, "m", false, {}, {}},
       {"grade", {"grade"}, {"rad", "1"}, nullptr, false, {}, {"grade_rad"}},
       {"bank", {"bank"}, {"rad", "1"}, nullptr, false, {}, {"bank_rad"}}}};
  return all[static_cast<std::size_t>(role)];
}

bool calls(std::string_view name, const char* word, const char* kind, const Meaning& m, bool in_path) {
  if (!in_path) return is_called(name, word, kind);
  if (!m.in_paths || is_path_of_command(name)) return false;
  // A letter alone is of many meanings, pose.orientation.x; with a unit of length it is a place, odom.x_mm.
  const bool letter = std::string_view(word).size() == 1;
  return is_called_in_path(name, word + (letter ? unit_behind(name, word, kind) : std::string()), kind);
}

/// What names of a pair have in common: "odom" and what is not the side of "positionx" in "odom.position.x".
std::string frame_of(std::string_view name, const std::string& word, const Meaning& m, bool in_path) {
  std::string rest = word;
  for (const std::string_view side : m.sides)
    if (const std::size_t at = rest.find(side); at != std::string::npos) {
      // Where it stood and how long it was: xpos is not posx, east not x; lat goes with longitude.
      const bool on_earth = m.unit == std::string_view("deg");
      rest.replace(at, side.size(), on_earth ? "" : side.size() == 1 ? "#" : "@");
    }
  const std::string plain = plain_name(name);
  return (in_path ? plain.substr(0, plain.rfind(word)) : std::string()) + rest;
}

/// The unit, in a name by whose word and kind of unit the column is called; false: it must be stated, and is not.
bool read_unit(RoadName& out, std::string_view at_end, std::string_view written, const Meaning& m) {
  out.stated = !written.empty() || !at_end.empty();
  if (!out.stated) {
    if (m.unit != nullptr) out.unit = m.unit;
    return m.unit != nullptr;
  }
  if (written.empty()) {
    out.unit = at_end;
    return true;
  }
  for (const char* kind : m.kinds)
    if (out.unit.empty()) out.unit = header_unit(written, kind);
  if (out.unit.empty()) out.foreign = written;
  return true;
}

}  // namespace

std::optional<RoadName> road_name(RoadRole role, std::string_view name, std::string_view unit) {
  const Meaning& m = meaning(role);
  std::size_t rank = 0;
  for (const bool in_path : {false, true}) {
    for (const char* word : m.words) {
      ++rank;
      for (const char* kind : m.kinds) {
        if (!calls(name, word, kind, m, in_path)) continue;
        RoadName out;
        if (!read_unit(out, unit_behind(name, word, kind), unit, m)) continue;
        const auto own = std::ranges::find(m.own, name);
        out.own = own != m.own.end() && unit.empty();
        out.rank = rank * (m.own.size() + 1) + static_cast<std::size_t>(own - m.own.begin());
        out.frame = frame_of(name, word, m, in_path);
        return out;
      }
    }
  }
  return std::nullopt;
}

const char* what_of(RoadRole role) { return meaning(role).what; }

const char* units_of(RoadRole role) {
  const Meaning& m = meaning(role);
  if (m.kinds.size() > 1) return "an angle, deg or rad, or %";
  return m.kinds[0] == std::string_view("m") ? "a length: m, km, cm, mm or ft" : "an angle: deg or rad";
}

bool is_road_column(std::string_view name, std::string_view unit) {
  for (std::size_t role = 0; role < road_roles; ++role)
    if (road_name(static_cast<RoadRole>(role), name, unit)) return true;
  return false;
}

bool is_road_width(std::string_view name) {
  return road_name(RoadRole::right, name, {}) || road_name(RoadRole::left, name, {}) ||
         road_name(RoadRole::width, name, {});
}

}  // namespace gripline
