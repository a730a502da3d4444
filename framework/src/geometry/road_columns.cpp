#include "geometry/road_columns.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>
#include <span>

#include "config/errors.hpp"
#include "config/files.hpp"
#include "config/units.hpp"
#include "tables/column_names.hpp"
#include "tables/delimited_table.hpp"
#include "util/numbers.hpp"

namespace gripline {
namespace {

namespace fs = std::filesystem;

enum Role : std::size_t { x, y, longitude, latitude, height, right, left, width, grade, bank, roles };

/// What a column is to the road.
struct Meaning {
  const char* what;                ///< in messages
  std::vector<const char*> words;  ///< plain names (tables/column_names.hpp), best first
  const char* unit;                ///< where none is written
  bool states_unit;                ///< the unit must be written
  bool in_paths;                   ///< also by the last words of pose.position.x
  std::vector<std::string> own;    ///< names of gripline's own files, of which nothing is said
};

const Meaning& meaning(Role role) {
  const auto as_in_logs = [](const char* channel) {
    const std::span<const char* const> names = names_of(channel);
    return std::vector<const char*>(names.begin(), names.end());
  };
  static const std::array<Meaning, roles> all{
      {{"x", as_in_logs("x"), "m", false, true, {"x_m", "x"}},
       {"y", as_in_logs("y"), "m", false, true, {"y_m", "y"}},
       {"longitude", as_in_logs("longitude"), "deg", false, true, {"lon", "longitude", "lng", "lon_deg"}},
       {"latitude", as_in_logs("latitude"), "deg", false, true, {"lat", "latitude", "lat_deg"}},
       {"height",
        {"z", "posz", "positionz", "ele", "elevation", "alt", "altitude"},
        "m",
        false,
        true,
        {"z_m", "z", "ele", "elevation", "alt", "altitude"}},
       {"right",
        {"wtrright", "wright", "widthright", "halfwidthright", "rightwidth", "right"},
        "m",
        false,
        false,
        {"w_tr_right_m"}},
       {"left",
        {"wtrleft", "wleft", "widthleft", "halfwidthleft", "leftwidth", "left"},
        "m",
        false,
        false,
        {"w_tr_left_m"}},
       {"width", {"width", "trackwidth", "roadwidth"}, "m", false, false, {}},
       {"grade", {"grade"}, "rad", true, false, {"grade_rad"}},
       {"bank", {"bank"}, "rad", true, false, {"bank_rad"}}}};
  return all[role];
}

/// What a unit of a role is one of: "m" or "rad".
const char* kind_of(const Meaning& m) { return std::string_view(m.unit) == "m" ? "m" : "rad"; }

bool calls(std::string_view name, const char* word, const Meaning& m, bool in_path) {
  if (!in_path) return is_called(name, word, kind_of(m));
  return m.in_paths && is_called_in_path(name, word, kind_of(m)) && !is_path_of_command(name);
}

/// The unit at the end of a name. Of the words that a name may be the shortest is meant: x_mm is x in mm, not xm in m.
std::string unit_in_name(std::string_view name, const Meaning& m) {
  std::string_view shortest;
  for (const char* word : m.words)
    if ((calls(name, word, m, false) || calls(name, word, m, true)) &&
        (shortest.empty() || std::string_view(word).size() < shortest.size()))
      shortest = word;
  return shortest.empty() ? std::string() : unit_behind(name, shortest, kind_of(m));
}

/// Whether a column of this name, with what its header says is its unit, has this meaning.
bool means(std::string_view name, std::string_view written, const char* word, const Meaning& m, bool in_path) {
  return calls(name, word, m, in_path) && (!m.states_unit || !written.empty() || !unit_in_name(name, m).empty());
}

bool means(std::string_view name, std::string_view written, Role role) {
  const Meaning& m = meaning(role);
  return std::ranges::any_of(m.words, [&](const char* word) {
    return means(name, written, word, m, false) || means(name, written, word, m, true);
  });
}

bool is_known(std::string_view name, std::string_view written) {
  for (std::size_t role = 0; role < roles; ++role)
    if (means(name, written, static_cast<Role>(role))) return true;
  return false;
}

std::string listed(const std::vector<std::string>& names, std::string_view between) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? std::string() : std::string(between)) + name;
  return all;
}

class ColumnReader {
 public:
  explicit ColumnReader(const fs::path& file)
      : table_(read_delimited(file, "x_m,y_m,w_tr_right_m,w_tr_left_m")), taken_(table_.name.size(), false) {}

  RoadColumns read() {
    check_rows();
    check_repeated();
    find_places();
    read_as(height, road_.height);
    find_widths();
    read_as(grade, road_.grade);
    read_as(bank, road_.bank);
    tell();
    road_.line = table_.line;
    return std::move(road_);
  }

 private:
  [[noreturn]] void refuse(int line, std::string message) const {
    throw InputError({Diagnostic{shown(table_.file), line, line > 0 ? 1 : 0, {}, std::move(message), {}}});
  }
  [[noreturn]] void refuse_header(std::string message) const { refuse(table_.header_line, std::move(message)); }

  /// A row that is left out would be a gap in the road.
  void check_rows() const {
    if (table_.other_length > 0)
      refuse(table_.other_length,
             format("expected %zu columns as in the header, found another number of them", table_.name.size()));
  }
  void check_repeated() const {
    for (const std::string& name : table_.repeated) {
      const auto c = static_cast<std::size_t>(table_.find(name));
      if (is_known(name, table_.unit[c])) refuse_header("column \"" + name + "\" is there twice");
    }
  }

  std::optional<std::size_t> find(Role role) const {
    const Meaning& m = meaning(role);
    for (const bool in_path : {false, true})
      for (const char* word : m.words)
        for (std::size_t c = 0; c < table_.name.size(); ++c)
          if (means(table_.name[c], table_.unit[c], word, m, in_path)) return c;
    return std::nullopt;
  }

  std::string unit_of(std::size_t c, const Meaning& m) {
    const std::string& written = table_.unit[c];
    if (written.empty()) {
      const std::string at_end = unit_in_name(table_.name[c], m);
      return at_end.empty() ? m.unit : at_end;
    }
    if (std::string known = header_unit(written, kind_of(m)); !known.empty()) return known;
    refuse_header("column \"" + table_.name[c] + "\" has the unit \"" + written + "\"; expected " +
                  (kind_of(m) == std::string_view("m") ? "a length: m, km, cm, mm or ft" : "an angle: deg or rad"));
  }

  /// The numbers of a column times `factor` over its unit in SI.
  std::vector<double> numbers(std::size_t c, const std::string& unit, double factor) const {
    std::vector<double> values = table_.column[c];
    const auto missing = std::ranges::find_if(values, [](double value) { return std::isnan(value); });
    if (missing != values.end()) {
      const int line = table_.line[static_cast<std::size_t>(missing - values.begin())];
      const DelimitedTable::Unread& unread = table_.unread[c];
      refuse(line, "column \"" + table_.name[c] + "\": expected a finite number, found \"" +
                       (unread.cells > 0 && unread.line == line ? unread.first : "") + "\"");
    }
    const double scale = factor * Unit::parse(unit).factor;
    for (double& value : values) value *= scale;
    return values;
  }

  void take(std::size_t c, const Meaning& m, const std::string& unit, const std::string& what) {
    taken_[c] = true;
    own_ = own_ && table_.unit[c].empty() && std::ranges::find(m.own, table_.name[c]) != m.own.end();
    read_.push_back(what + " from " + table_.name[c] + " (" + unit + ")");
  }
  bool read_as(Role role, std::vector<double>& values) {
    const std::optional<std::size_t> c = find(role);
    if (!c) return false;
    const Meaning& m = meaning(role);
    const std::string unit = unit_of(*c, m);
    // Degrees stay as they are written.
    const bool place = role == longitude || role == latitude;
    values = numbers(*c, unit == "deg" && place ? "1" : unit, place && unit != "deg" ? 180.0 / std::numbers::pi : 1.0);
    take(*c, m, unit, m.what);
    return true;
  }

  void find_places() {
    road_.on_earth = !find(x) || !find(y);
    const Role east = road_.on_earth ? longitude : x, north = road_.on_earth ? latitude : y;
    if (find(east) && find(north)) {
      read_as(east, road_.x);
      read_as(north, road_.y);
      return;
    }
    const std::string wanted[] = {"x_m", "y_m", "lat", "lon", "easting", "northing", "latitude", "longitude"};
    refuse_header("expected columns x_m,y_m or lat,lon (and w_tr_right_m,w_tr_left_m where it has widths); found " +
                  escape_control(listed(table_.name, ",")) + meant(wanted));
  }

  void find_widths() {
    const std::optional<std::size_t> whole = find(width);
    const bool has_right = find(right).has_value(), has_left = find(left).has_value();
    if (has_right != has_left) {
      const std::string side = has_right ? "left" : "right";
      const std::string wanted[] = {"w_tr_" + side + "_m", "w_" + side + "_m", "width_" + side, side};
      refuse_header("w_tr_right_m and w_tr_left_m go together; no column for the " + side + " half width" +
                    meant(wanted));
    }
    if (has_right) {
      read_as(right, road_.right);
      read_as(left, road_.left);
    } else if (whole) {
      const Meaning& m = meaning(width);
      const std::string unit = unit_of(*whole, m);
      road_.right = road_.left = numbers(*whole, unit, 0.5);
      take(*whole, m, unit, "right and left, half each,");
    }
  }

  /// "; did you mean "x_m" by "xm_"?" for each column that nothing is read of and that is like one of those wanted.
  std::string meant(std::span<const std::string> wanted) const {
    std::string all;
    for (std::size_t c = 0; c < table_.name.size(); ++c) {
      if (is_known(table_.name[c], table_.unit[c])) continue;
      if (const auto near = nearest(table_.name[c], wanted))
        all += (all.empty() ? "; did you mean \"" : " and \"") + *near + "\" by \"" + table_.name[c] + '"';
    }
    return all.empty() ? all : all + '?';
  }

  /// The name that a column beside widths was meant to have.
  static std::string hint(const std::string& name) {
    static const std::vector<std::string> road{"x_m",      "y_m", "w_tr_right_m", "w_tr_left_m", "grade_rad",
                                               "bank_rad", "z_m", "lat",          "lon",         "ele"};
    const auto longer = std::ranges::find_if(road, [&](const std::string& one) { return one.starts_with(name + "_"); });
    return longer != road.end() ? "; did you mean \"" + *longer + "\"?" : did_you_mean(name, road);
  }

  /// Says how the table was read where that was not by gripline's own names, and what is left out.
  void tell() {
    const bool widths = !road_.right.empty();
    std::vector<std::string> others;
    for (std::size_t c = 0; c < table_.name.size(); ++c) {
      if (taken_[c]) continue;
      const std::string& name = table_.name[c];
      if (widths && !is_known(name, table_.unit[c])) refuse_header("unknown column \"" + name + "\"" + hint(name));
      others.push_back(name);  // places and heights may be there under two names
    }
    if (!table_.found.empty()) road_.remarks.push_back(escape_control(listed(table_.found, ", ")));
    if (!own_) road_.remarks.push_back("read: " + escape_control(listed(read_, ", ")));
    if (others.empty()) return;
    road_.remarks.push_back("columns that are left out: " + escape_control(listed(others, ",")));
    if (widths) return;
    const std::string wanted[] = {"w_tr_right_m", "w_tr_left_m", "w_right", "w_left",  "width_right",
                                  "width_left",   "right",       "left",    "width_m", "width"};
    road_.instead_of_widths = "; " + road_.remarks.back() + meant(wanted);
  }

  DelimitedTable table_;
  RoadColumns road_;
  std::vector<bool> taken_;        ///< by column
  std::vector<std::string> read_;  ///< what is read as what
  bool own_ = true;                ///< all of them by gripline's own names
};

}  // namespace

RoadColumns read_road_columns(const fs::path& file) { return ColumnReader(file).read(); }

bool is_road_column(std::string_view name) { return is_known(name, {}); }

bool is_road_width(std::string_view name) {
  return means(name, {}, right) || means(name, {}, left) || means(name, {}, width);
}

}  // namespace gripline
