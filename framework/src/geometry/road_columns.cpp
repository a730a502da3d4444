#include "geometry/road_columns.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

#include "config/errors.hpp"
#include "config/files.hpp"
#include "config/units.hpp"
#include "geometry/road_names.hpp"
#include "tables/delimited_table.hpp"
#include "util/numbers.hpp"

namespace gripline {
namespace {

namespace fs = std::filesystem;

std::string listed(const std::vector<std::string>& names, std::string_view between) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? std::string() : std::string(between)) + name;
  return all;
}

/// A column that may be what is looked for.
struct Candidate {
  std::size_t at = 0;
  RoadName name;
};
struct CandidatePair {
  Candidate first, second;
};

double factor_of(const RoadName& name) { return Unit::parse(name.unit).factor; }

/// Whether both of a pair have a unit of their kind, and the same one.
bool is_sound(const CandidatePair& pair) {
  const RoadName &a = pair.first.name, &b = pair.second.name;
  return a.foreign.empty() && b.foreign.empty() && factor_of(a) == factor_of(b);
}

/// Pairs of names, for each of those of the one role the best of the other; sound pairs first, the best before others.
std::vector<CandidatePair> pairs_of(const std::vector<Candidate>& ones, const std::vector<Candidate>& others) {
  std::vector<CandidatePair> all;
  for (const Candidate& one : ones) {
    const auto match = [&](const Candidate& other) {
      if (other.name.frame != one.name.frame) return 0;
      if (!is_sound({one, other})) return 1;
      return other.name.stated == one.name.stated ? 3 : 2;
    };
    const auto best = std::ranges::max_element(others, {}, match);
    if (best != others.end() && match(*best) > 0) all.push_back({one, *best});
  }
  std::ranges::stable_partition(all, is_sound);
  return all;
}

/// Whether a slope is written as rise over way: in %.
bool is_rise(const RoadName& name) { return !header_unit(name.unit, "1").empty(); }

/// Heights and slopes of loggers that only sound like a road's: in another unit, slopes of gradients and lean angles in
/// % and deg, which lead to no height that comes back after a lap.
bool is_left_out_of_traces(RoadRole role, const RoadName& name) {
  const bool slope = role == RoadRole::grade || role == RoadRole::bank;
  return !name.foreign.empty() || (slope && name.unit != "rad");
}

class ColumnReader {
 public:
  explicit ColumnReader(const fs::path& file)
      : table_(read_delimited(file, "x_m,y_m,w_tr_right_m,w_tr_left_m")), taken_(table_.name.size(), false) {}

  RoadColumns read() {
    check_rows();
    check_repeated();
    find_places();
    trace_ = candidates(RoadRole::right).empty() && candidates(RoadRole::left).empty() &&
             candidates(RoadRole::width).empty();
    read_optional(RoadRole::height, road_.height);
    find_widths();
    read_optional(RoadRole::grade, road_.grade);
    read_optional(RoadRole::bank, road_.bank);
    check_lengths();
    if (!trace_) check_slopes();
    tell();
    road_.line = table_.line;
    return std::move(road_);
  }

 private:
  [[noreturn]] void refuse(int line, std::string message) const {
    throw InputError({Diagnostic{shown(table_.file), line, line > 0 ? 1 : 0, {}, std::move(message), {}}});
  }
  [[noreturn]] void refuse_header(std::string message) const { refuse(table_.header_line, std::move(message)); }
  [[noreturn]] void refuse_unit(RoadRole role, const Candidate& c) const {
    refuse_header("column \"" + table_.name[c.at] + "\" has the unit \"" + c.name.foreign + "\"; expected " +
                  units_of(role));
  }

  /// A row that is left out would be a gap in the road.
  void check_rows() const {
    if (table_.other_length > 0)
      refuse(table_.other_length,
             format("expected %zu columns as in the header, found another number of them", table_.name.size()));
  }
  void check_repeated() const {
    for (const std::string& name : table_.repeated)
      if (is_known(static_cast<std::size_t>(table_.find(name))))
        refuse_header("column \"" + name + "\" is there twice");
  }
  bool is_known(std::size_t c) const { return is_road_column(table_.name[c], table_.unit[c]); }

  /// The columns that may have a role, the best first, those with a unit of another kind last.
  std::vector<Candidate> all_candidates(RoadRole role) const {
    std::vector<Candidate> all;
    for (std::size_t c = 0; c < table_.name.size(); ++c)
      if (auto name = road_name(role, table_.name[c], table_.unit[c])) all.push_back({c, *std::move(name)});
    std::ranges::stable_sort(all, {},
                             [](const Candidate& c) { return std::pair(!c.name.foreign.empty(), c.name.rank); });
    return all;
  }
  /// Those with a unit of their kind.
  std::vector<Candidate> candidates(RoadRole role) const {
    std::vector<Candidate> all = all_candidates(role);
    std::erase_if(all, [](const Candidate& c) { return !c.name.foreign.empty(); });
    return all;
  }

  /// "East" in ft, or "y" without a unit.
  std::string with_unit(const Candidate& c) const {
    return "\"" + table_.name[c.at] + "\" " + (c.name.stated ? "in " + c.name.unit : "without a unit");
  }
  [[noreturn]] void refuse_pair(RoadRole one, RoadRole other, const CandidatePair& pair) const {
    if (!pair.first.name.foreign.empty()) refuse_unit(one, pair.first);
    if (!pair.second.name.foreign.empty()) refuse_unit(other, pair.second);
    refuse_header(with_unit(pair.first) + " and " + with_unit(pair.second) + ": expected one unit for both");
  }
  [[noreturn]] void refuse_strangers(const Candidate& one, const Candidate& other) const {
    refuse_header('"' + table_.name[one.at] + "\" and \"" + table_.name[other.at] +
                  "\" are no pair of names; expected one as x_m,y_m, easting,northing or w_right,w_left");
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

  void take(const Candidate& c, const std::string& what) {
    taken_[c.at] = true;
    own_ = own_ && c.name.own;
    read_.push_back(what + " from " + table_.name[c.at] + " (" + c.name.unit + ")");
  }
  void read_length(RoadRole role, const Candidate& c, std::vector<double>& values) {
    values = numbers(c.at, c.name.unit, 1.0);
    lengths_.push_back(c);
    take(c, what_of(role));
  }
  /// Degrees stay as they are written.
  void read_degrees(RoadRole role, const Candidate& c, std::vector<double>& values) {
    const bool degrees = c.name.unit == "deg";
    values = numbers(c.at, degrees ? "1" : c.name.unit, degrees ? 1.0 : 180.0 / std::numbers::pi);
    take(c, what_of(role));
  }
  void read_slope(RoadRole role, const Candidate& c, std::vector<double>& values) {
    values = numbers(c.at, c.name.unit, 1.0);
    if (is_rise(c.name))
      for (double& value : values) value = std::atan(value);
    take(c, what_of(role));
  }
  /// Heights and slopes.
  void read_optional(RoadRole role, std::vector<double>& values) {
    const std::vector<Candidate> all = all_candidates(role);
    if (all.empty() || (trace_ && is_left_out_of_traces(role, all.front().name))) return;
    const Candidate& best = all.front();
    if (!best.name.foreign.empty()) refuse_unit(role, best);
    if (role == RoadRole::height)
      read_length(role, best, values);
    else
      read_slope(role, best, values);
  }

  void find_places() {
    for (const bool on_earth : {false, true}) {
      const RoadRole east = on_earth ? RoadRole::longitude : RoadRole::x;
      const RoadRole north = on_earth ? RoadRole::latitude : RoadRole::y;
      const std::vector<CandidatePair> all = pairs_of(all_candidates(east), all_candidates(north));
      if (all.empty() || !is_sound(all.front())) continue;
      road_.on_earth = on_earth;
      const auto read_as = [&](RoadRole role, const Candidate& c, std::vector<double>& values) {
        on_earth ? read_degrees(role, c, values) : read_length(role, c, values);
      };
      read_as(east, all.front().first, road_.x);
      read_as(north, all.front().second, road_.y);
      note_other_places(all);
      return;
    }
    refuse_places();
  }
  [[noreturn]] void refuse_places() const {
    for (const auto& [east, north] : {std::pair(RoadRole::x, RoadRole::y), {RoadRole::longitude, RoadRole::latitude}}) {
      const std::vector<Candidate> ones = all_candidates(east), others = all_candidates(north);
      const std::vector<CandidatePair> all = pairs_of(ones, others);
      if (!all.empty()) refuse_pair(east, north, all.front());
      if (!ones.empty() && !others.empty()) refuse_strangers(ones.front(), others.front());
    }
    const std::string wanted[] = {"x_m", "y_m", "lat", "lon", "easting", "northing", "latitude", "longitude"};
    refuse_header("expected columns x_m,y_m or lat,lon (and w_tr_right_m,w_tr_left_m where it has widths); found " +
                  escape_control(listed(table_.name, ",")) + meant(wanted));
  }
  void note_other_places(const std::vector<CandidatePair>& all) {
    const CandidatePair& read = all.front();
    const auto named = [&](const CandidatePair& p) { return table_.name[p.first.at] + "," + table_.name[p.second.at]; };
    std::vector<std::string> others;
    for (const CandidatePair& pair : all)
      if (is_sound(pair) && pair.first.at != read.first.at && pair.second.at != read.second.at)
        others.push_back(named(pair));
    if (!others.empty())
      other_places_ = "several pairs of places: " + named(read) + " are read, not " + listed(others, " or ");
  }

  void find_widths() {
    const std::vector<Candidate> rights = candidates(RoadRole::right), lefts = candidates(RoadRole::left);
    if (rights.empty() != lefts.empty()) {
      const std::string side = rights.empty() ? "right" : "left";
      const std::string wanted[] = {"w_tr_" + side + "_m", "w_" + side + "_m", "width_" + side, side};
      refuse_header("w_tr_right_m and w_tr_left_m go together; no column for the " + side + " half width" +
                    meant(wanted));
    }
    if (!rights.empty()) {
      const std::vector<CandidatePair> all = pairs_of(rights, lefts);
      if (all.empty()) refuse_strangers(rights.front(), lefts.front());
      if (!is_sound(all.front())) refuse_pair(RoadRole::right, RoadRole::left, all.front());
      read_length(RoadRole::right, all.front().first, road_.right);
      read_length(RoadRole::left, all.front().second, road_.left);
    } else if (const std::vector<Candidate> whole = candidates(RoadRole::width); !whole.empty()) {
      const Candidate& best = whole.front();
      road_.right = road_.left = numbers(best.at, best.name.unit, 0.5);
      lengths_.push_back(best);
      take(best, "right and left, half each,");
    }
  }

  /// A length without a unit is not guessed where the places state another one than m, or a row of units some other.
  void check_lengths() const {
    const auto other = std::ranges::find_if(lengths_, [](const Candidate& c) { return factor_of(c.name) != 1.0; });
    const bool places = other == lengths_.begin() && !road_.on_earth;
    if (other == lengths_.end() || !(places || table_.unit_row)) return;
    std::vector<std::string> without;
    for (const Candidate& c : lengths_)
      if (!c.name.stated) without.push_back(table_.name[c.at]);
    if (without.empty()) return;
    const std::string& one = without.front();
    refuse_header("columns without a unit beside " + with_unit(*other) + ": " + escape_control(listed(without, ",")) +
                  "; expected theirs in the header, as \"" + one + " (" + other->name.unit + ")\" or \"" + one +
                  " (m)\"");
  }

  /// "; did you mean "x_m" by "xm_"?" for each column that nothing is read of and that is like one of those wanted.
  std::string meant(std::span<const std::string> wanted) const {
    std::string all;
    for (std::size_t c = 0; c < table_.name.size(); ++c) {
      if (is_known(c)) continue;
      if (const auto near = nearest(table_.name[c], wanted))
        all += (all.empty() ? "; did you mean \"" : " and \"") + *near + "\" by \"" + table_.name[c] + '"';
    }
    return all.empty() ? all : all + '?';
  }

  /// Refuses a slip in the name of a slope, as grade or bnak_rad: the road would be level.
  void check_slopes() const {
    std::vector<std::string> wanted;
    if (road_.grade.empty()) wanted.emplace_back("grade_rad");
    if (road_.bank.empty()) wanted.emplace_back("bank_rad");
    for (std::size_t c = 0; c < table_.name.size(); ++c) {
      const std::string& name = table_.name[c];
      if (is_known(c)) continue;
      const auto longer = std::ranges::find_if(wanted, [&](const std::string& w) { return w.starts_with(name + "_"); });
      const auto meant = longer != wanted.end() ? std::optional(*longer) : nearest(name, wanted);
      if (meant) refuse_header("unknown column \"" + name + "\"; did you mean \"" + *meant + "\"?");
    }
  }

  /// Whether a column would be read if it had another unit.
  bool has_foreign_unit(std::size_t c) const {
    for (std::size_t i = 0; i < road_roles; ++i) {
      const auto role = static_cast<RoadRole>(i);
      const auto name = road_name(role, table_.name[c], table_.unit[c]);
      if (name && (!name->foreign.empty() || (trace_ && is_left_out_of_traces(role, *name)))) return true;
    }
    return false;
  }
  std::vector<std::string> left_out() const {
    std::vector<std::string> others, foreign, all;
    for (std::size_t c = 0; c < table_.name.size(); ++c) {
      if (taken_[c]) continue;  // places and heights may be there under two names
      const std::string &name = table_.name[c], &unit = table_.unit[c];
      if (has_foreign_unit(c))
        foreign.push_back(unit.empty() ? name : name + " (" + unit + ")");
      else
        others.push_back(name);
    }
    if (!foreign.empty())
      all.push_back("columns that are left out for their units: " + escape_control(listed(foreign, ", ")));
    if (!others.empty()) all.push_back("columns that are left out: " + escape_control(listed(others, ",")));
    return all;
  }

  /// Says how the table was read where that was not by gripline's own names, and what is left out.
  void tell() {
    if (!table_.found.empty()) road_.remarks.push_back(escape_control(listed(table_.found, ", ")));
    if (!own_) road_.remarks.push_back("read: " + escape_control(listed(read_, ", ")));
    if (!other_places_.empty()) road_.remarks.push_back(escape_control(other_places_));
    const std::vector<std::string> without = left_out();
    road_.remarks.insert(road_.remarks.end(), without.begin(), without.end());
    if (!trace_ || without.empty()) return;
    const std::string wanted[] = {"w_tr_right_m", "w_tr_left_m", "w_right", "w_left",  "width_right",
                                  "width_left",   "right",       "left",    "width_m", "width"};
    road_.instead_of_widths = "; " + listed(without, "; ") + meant(wanted);
  }

  DelimitedTable table_;
  RoadColumns road_;
  bool trace_ = false;              ///< without widths
  std::vector<bool> taken_;         ///< by column
  std::vector<Candidate> lengths_;  ///< that are read, places first
  std::vector<std::string> read_;   ///< what is read as what
  std::string other_places_;        ///< that are not read, for a remark; may be empty
  bool own_ = true;                 ///< all that is read by gripline's own names
};

}  // namespace

RoadColumns read_road_columns(const fs::path& file) { return ColumnReader(file).read(); }

}  // namespace gripline
