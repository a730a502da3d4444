#include "measured/session_file.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>

#include "config/errors.hpp"
#include "config/units.hpp"
#include "measured/delimited_table.hpp"
#include "measured/formula.hpp"
#include "measured/reading_pace.hpp"
#include "measured/unwrapped_angles.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

using std::numbers::pi;
using Values = std::vector<double>;
using Level = Finding::Level;

[[noreturn]] void refuse_file(const std::filesystem::path& file, const std::string& message, int line = 0) {
  Diagnostic d;
  d.file = file.string();
  d.line = line;
  d.message = message;
  throw InputError({d});
}

class SessionReader {
 public:
  SessionReader(DelimitedTable table, const LogMap& map) : map_(map), table_(std::move(table)) {}

  SessionFile read() {
    out_.session.name = table_.file.filename().string();
    for (const std::string& one : table_.found) note("file", one, "read so");
    read_time();
    for (std::size_t s = 0; s < source_count; ++s)
      if (map_.channel[s]) read_source(static_cast<Source>(s), *map_.channel[s]);
    check_needed();
    apply_valid();
    place_from_degrees();
    derive();
    drop_rows_before_commands();
    out_.session.written_yaw = of(Source::yaw).empty() ? Values(row_.size(), not_a_number) : of(Source::yaw);
    unwrap_angles(of(Source::yaw));
    fill();
    return std::move(out_);
  }

 private:
  void note(std::string check, std::string found, std::string done, Level level = Level::note) {
    out_.findings.push_back({level, std::move(check), std::move(found), std::move(done)});
  }
  std::string place_in_map(const MappedChannel& channel) const {
    return map_.file.empty() ? std::string() : " (" + channel.origin.pointer + " of " + map_.file.string() + ")";
  }

  /// What one of the channel's numbers is in SI: by the map's unit, else by the unit in the table's header.
  double factor_of(const MappedChannel& channel, const char* unit, const Formula& formula) {
    if (!channel.unit.empty()) return to_si("1 " + channel.unit, unit);
    if (formula.columns().size() != 1) return 1.0;
    const std::string& name = table_.name[formula.columns()[0]];
    const bool bare = channel.formula == name || channel.formula == '`' + name + '`';
    if (!bare && !channel.formula.starts_with('`')) return 1.0;
    const std::string& written = table_.unit[formula.columns()[0]];
    if (written.empty()) return 1.0;
    // Arithmetic may convert already what only a reader of headers understands.
    const std::string known = header_unit(written, unit, bare);
    if (!known.empty()) unit_of_header_ = true;
    if (!known.empty()) return to_si("1 " + known, unit);
    if (!bare) return 1.0;
    note("unit", name + ": the header's \"" + written + "\" is no unit of this kind",
         std::string("taken for ") + unit + "; `unit` in the map says another");
    return 1.0;
  }

  struct UnreadColumn {
    std::string message;
    int line;
  };

  /// Says once of a column that text stands where numbers are expected; a column of nothing else is refused.
  void check_cells(std::size_t column, bool of_time) {
    if (column >= table_.unread.size() || table_.unread[column].cells == 0) return;
    const DelimitedTable::Unread& unread = table_.unread[column];
    const bool none = std::ranges::all_of(table_.column[column], [](double v) { return std::isnan(v); });
    const std::string forms =
        of_time ? "; times are read as 12.5, 1:02.5, 12:34:56.7 and 2018-04-08 10:31:37.5" : std::string();
    const std::string first = "\"" + unread.first + "\"";
    if (none)
      throw UnreadColumn{"column " + table_.name[column] + ": none of its cells is a number; the first is " + first +
                             (of_time ? forms : "; expected numbers alone, as 12.5 or -2e-3"),
                         unread.line};
    if (!told_.insert(column).second) return;
    note("cells",
         table_.name[column] + ": " + std::to_string(unread.cells) + " are no numbers, the first " + first +
             " in line " + std::to_string(unread.line) + forms,
         "taken for missing");
  }

  Values evaluate(const MappedChannel& channel, const char* unit, const char* name) {
    try {
      const Formula formula(channel.formula, table_, std::string(name));
      for (const std::size_t column : formula.columns()) check_cells(column, name == std::string_view("time"));
      Values values = formula.evaluate(table_, time_all_);
      const double factor = channel.sign * factor_of(channel, unit, formula);
      for (double& v : values) v = std::isfinite(v) ? factor * v : not_a_number;
      return values;
    } catch (const UnreadColumn& problem) {
      refuse_file(table_.file, problem.message, problem.line);
    } catch (const InputError& problem) {
      if (map_.file.empty()) refuse_file(table_.file, problem.what(), 1);
      Diagnostic d;
      d.file = map_.file.string();
      d.line = channel.origin.line;
      d.column = channel.origin.column;
      d.pointer = channel.origin.pointer;
      d.message = std::string(problem.what()) + " in " + table_.file.string();
      throw InputError({d});
    }
  }

  static constexpr double longest_step = 3600.0;  // [s] of a clock that was not set

  void read_time() {
    if (map_.file.empty() && table_.find(map_.time.formula) < 0) refuse_missing(map_.time.formula);
    time_all_ = evaluate(map_.time, "s", "time");
    merge_repeated_rows();
    find_timed_rows();
    if (row_.size() < 20)
      refuse_file(table_.file,
                  "only " + std::to_string(row_.size()) + " rows with a time; expected a log of at least 5 s");
    check_steps(times());
    drop_rows_before_clock_was_set();
    out_.session.t = times();
  }

  Values times() const {
    Values t;
    for (const std::size_t r : row_) t.push_back(time_all_[r]);
    return t;
  }

  /// Rows of one time stamp are one row: loggers of several buses write a row for each message. Of every column the
  /// first cell that holds a number counts.
  void merge_repeated_rows() {
    std::vector<std::size_t> kept;
    std::size_t again = 0, last = table_.rows();  // the last row that has a time
    for (std::size_t r = 0; r < table_.rows(); ++r) {
      if (last < r && time_all_[r] == time_all_[last]) {
        ++again;
        for (Values& column : table_.column)
          if (std::isnan(column[last])) column[last] = column[r];
        continue;
      }
      if (!std::isnan(time_all_[r])) last = r;
      kept.push_back(r);
    }
    if (again == 0) return;
    const auto compact = [&](auto& all) {
      for (std::size_t i = 0; i < kept.size(); ++i) all[i] = all[kept[i]];
      all.resize(kept.size());
    };
    for (Values& column : table_.column) compact(column);
    compact(table_.line);
    compact(time_all_);
    note("rows", std::to_string(again) + " repeat a time stamp", "they fill the empty cells of the first row of it");
  }

  void find_timed_rows() {
    for (std::size_t r = 0; r < table_.rows(); ++r) {
      const double t = time_all_[r], last = row_.empty() ? t : time_all_[row_.back()];
      if (std::isnan(t)) continue;
      if (t < last)
        refuse_file(table_.file,
                    "time runs backward by " + significant(last - t) + " s, from " + significant(last, 16) + " s to " +
                        significant(t, 16) +
                        " s; expected rows in the order of time (sort them, or cut the log where its clock was set)",
                    table_.line[r]);
      row_.push_back(r);
    }
    const std::size_t without = table_.rows() - row_.size();
    if (without > 0) note("rows", std::to_string(without) + " without time", "left out");
  }

  /// A step beyond an hour is a clock that was set, as by the first fix of a receiver. A few rows before it are left
  /// out; elsewhere it is refused, for everything that lies on a grid of time would fill memory with the step.
  void drop_rows_before_clock_was_set() {
    std::size_t leading = 0;
    for (std::size_t i = 1; i < row_.size(); ++i) {
      const double step = time_all_[row_[i]] - time_all_[row_[i - 1]];
      if (!(step > longest_step)) continue;
      if (100 * i >= row_.size())
        refuse_file(table_.file,
                    "time steps by " + significant(step) +
                        " s, more than an hour: the clock was set here, or the car stood; cut the log in two before "
                        "this row",
                    table_.line[row_[i]]);
      leading = i;
    }
    if (leading == 0) return;
    row_.erase(row_.begin(), row_.begin() + static_cast<std::ptrdiff_t>(leading));
    note("rows", std::to_string(leading) + " before the clock was set", "left out");
  }

  void check_steps(const Values& t) {
    Values steps;
    for (std::size_t i = 1; i < t.size(); ++i) steps.push_back(t[i] - t[i - 1]);
    out_.row_step = median(steps);
    // Rows of a bus come in bursts: how often they come is seen in their number, where no clock was set.
    constexpr double shortest_step = 1e-4;  // [s] that a logger writes
    std::erase_if(steps, [](double step) { return step > longest_step; });
    if (out_.row_step < shortest_step)
      out_.row_step = std::accumulate(steps.begin(), steps.end(), 0.0) / static_cast<double>(steps.size());
    const int column = table_.find(map_.time.formula);
    const bool of_clock = column >= 0 && table_.is_clock(static_cast<std::size_t>(column));
    for (const auto& [unit, factor] : {std::pair("milliseconds", 1e-3), {"microseconds", 1e-6}, {"nanoseconds", 1e-9}})
      if (!of_clock && out_.row_step > 0.9 && out_.row_step * factor >= 0.9e-3 && out_.row_step * factor < 0.3)
        refuse_file(table_.file, "time rises by " + significant(out_.row_step) + " s from row to row: it looks like " +
                                     unit + "; the map should say so (\"unit\")");
    for (const auto& [unit, factor] : {std::pair("milliseconds", 1e3), {"microseconds", 1e6}, {"nanoseconds", 1e9}})
      if (out_.row_step < shortest_step && out_.row_step * factor > 0.9e-3 && out_.row_step * factor < 0.3)
        refuse_file(table_.file, "rows are " + significant(out_.row_step) +
                                     " s apart, which no logger writes: time was taken for " + unit +
                                     " and is seconds");
    if (out_.row_step > 0.5)
      refuse_file(table_.file, "rows are " + significant(out_.row_step) + " s apart; expected 0.5 s or less");
  }

  void read_source(Source source, const MappedChannel& channel) {
    const SourceInfo& info = source_info(source);
    const bool own_log = map_.file.empty();
    if (own_log && table_.find(info.column) < 0) return;  // absent; check_needed says what must be there
    unit_of_header_ = false;
    const Values all = evaluate(channel, info.unit, info.name);
    of_header_[static_cast<std::size_t>(source)] = unit_of_header_;
    Values& to = of(source);
    for (const std::size_t r : row_) to.push_back(all[r]);
    if (!channel.held || channel.command) return;
    note(info.name, std::to_string(drop_held(to)) + " rows hold the value before",
         "read when it is new, or stays for longer than usual");
  }

  /// Leaves out values that are held. One that stays for twice the usual time between new ones was read again, and
  /// again after each such time: of a car that stands. Returns how many are left out.
  std::size_t drop_held(Values& values) const {
    constexpr std::size_t few = 3, many = 101;  // times between new values that the usual one is the median of
    const std::vector<double>& t = out_.session.t;
    Values between;
    double last = not_a_number, usual = 0.0, changed = 0.0, next = 0.0;
    std::size_t dropped = 0, changes = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (std::isnan(values[i])) continue;  // an empty cell is no reading
      const bool same = values[i] == last;
      last = values[i];
      if (!same) {
        if (changes > 0 && between.size() < many)
          between.push_back(t[i] - changed);
        else if (changes > 0)
          between[changes % many] = t[i] - changed;
        ++changes;
        usual = between.size() < few ? 0.0 : median(between);
        changed = t[i];
        next = t[i] + 2.0 * usual;
      } else if (usual > 0.0 && t[i] >= next - 1e-9) {
        next = t[i] + usual;
      } else {
        values[i] = not_a_number;
        ++dropped;
      }
    }
    return dropped;
  }

  Values& of(Source source) { return values_[static_cast<std::size_t>(source)]; }
  const Values& of(Source source) const { return values_[static_cast<std::size_t>(source)]; }
  bool has(Source source) const { return !of(source).empty(); }

  void check_needed() const {
    std::string missing;
    const auto need = [&](bool there, const char* what) {
      if (!there) missing += (missing.empty() ? "" : ", ") + std::string(what);
    };
    const bool place = has(Source::x) && has(Source::y);
    const bool degrees = has(Source::latitude) && has(Source::longitude);
    need(place || degrees || has(Source::vx), "x_m and y_m, or vx_mps");
    need(place || degrees || has(Source::yaw) || has(Source::yaw_rate), "yaw_rad or yaw_rate_radps");
    need(has(Source::delta), "delta_rad");
    if (missing.empty()) return;
    refuse_missing(missing);
  }

  [[noreturn]] void refuse_missing(const std::string& missing) const {
    std::string found;
    for (const std::string& name : table_.name) found += (found.empty() ? "" : ", ") + name;
    refuse_file(table_.file,
                "columns missing: " + missing + "; found: " + found +
                    "; a log with columns of its own needs a map (gripline import --guess LOG.csv writes one)");
  }

  void apply_valid() {
    if (map_.valid.empty()) return;
    MappedChannel channel = map_.time;
    channel.formula = map_.valid;
    channel.sign = 1;
    channel.unit.clear();
    const Values all = evaluate(channel, "1", "valid");
    std::size_t dropped = 0;
    for (std::size_t i = 0; i < row_.size(); ++i) {
      if (all[row_[i]] != 0.0 && !std::isnan(all[row_[i]])) continue;
      ++dropped;
      for (const Source s : {Source::x, Source::y, Source::yaw, Source::vx, Source::vy, Source::yaw_rate,
                             Source::latitude, Source::longitude})
        if (has(s)) of(s)[i] = not_a_number;
    }
    if (dropped > 0) note("valid", std::to_string(dropped) + " rows are not", "their readings are left out");
  }

  /// Whether map, header or formula say in which unit the numbers of a channel are that is read.
  bool has_unit(Source source) const {
    const MappedChannel& channel = *map_[source];
    // Arithmetic may convert; a column alone does not.
    const bool bare = table_.find(channel.formula) >= 0;
    for (const char* conversion : {"rad(", "pi"})
      if (!bare && channel.formula.find(conversion) != std::string::npos) return true;
    return !channel.unit.empty() || of_header_[static_cast<std::size_t>(source)];
  }

  /// Angles on the earth that no radians can be are degrees: maps and tables often leave their unit out.
  void take_for_degrees() {
    const auto beyond = [&](Source source, double most) {
      return !has_unit(source) && std::ranges::any_of(of(source), [&](double a) { return std::abs(a) > most; });
    };
    if (!beyond(Source::latitude, 0.5 * pi) && !beyond(Source::longitude, pi)) return;
    for (const Source source : {Source::latitude, Source::longitude})
      if (!has_unit(source))
        for (double& angle : of(source)) angle *= pi / 180.0;
    note("unit", "latitude and longitude are beyond what radians can be",
         "taken for degrees; `unit` in the map says so");
  }

  /// Receivers write 0, 0 as long as they do not know where they are.
  void drop_places_without_fix() {
    Values &lat = of(Source::latitude), &lon = of(Source::longitude);
    std::size_t dropped = 0;
    for (std::size_t i = 0; i < lat.size(); ++i) {
      if (lat[i] != 0.0 || lon[i] != 0.0) continue;
      lat[i] = lon[i] = not_a_number;
      ++dropped;
    }
    if (dropped > 0)
      note("place", std::to_string(dropped) + " rows have the latitude and longitude 0, 0",
           "taken for missing: the receiver had no fix");
  }

  void check_latitudes() const {
    const Values& lat = of(Source::latitude);
    const auto wrong = std::ranges::find_if(lat, [](double a) { return std::abs(a) > 0.5 * pi + 1e-9; });
    if (wrong == lat.end()) return;
    refuse_file(table_.file,
                "the latitude is " + significant(*wrong * 180.0 / pi, 6) +
                    " deg, beyond 90: NMEA's ddmm.mmmm are degrees and minutes ((v - mod(v, 100)) / 100 + mod(v, 100) "
                    "/ 60 in deg)",
                table_.line[row_[static_cast<std::size_t>(wrong - lat.begin())]]);
  }

  /// Local tangent plane at the first position on the WGS 84 ellipsoid: x east, y north.
  void place_from_degrees() {
    if (!has(Source::latitude) || has(Source::x)) return;
    Values &lat = of(Source::latitude), &lon = of(Source::longitude);
    drop_places_without_fix();
    take_for_degrees();
    check_latitudes();
    std::size_t first = 0;
    while (first < lat.size() && std::isnan(lat[first] + lon[first])) ++first;
    if (first == lat.size()) refuse_file(table_.file, "latitude and longitude are never given");
    constexpr double a = 6378137.0, e2 = 6.69437999014e-3;
    const double w = 1.0 - e2 * std::sin(lat[first]) * std::sin(lat[first]);
    const double north = a * (1.0 - e2) / (w * std::sqrt(w)), east = a / std::sqrt(w) * std::cos(lat[first]);
    for (std::size_t i = 0; i < lat.size(); ++i) {
      of(Source::x).push_back(east * std::remainder(lon[i] - lon[first], 2.0 * pi));
      of(Source::y).push_back(north * (lat[i] - lat[first]));
    }
    note("place", "latitude and longitude", "x to the east and y to the north of the first position");
  }

  /// Course and speed from the places of this row and the last one that had one: nothing later is looked at.
  void derive() {
    const bool place = has(Source::x) && has(Source::y), has_speed = has(Source::vx);
    if (!place || (has(Source::yaw) && has_speed)) return;
    const auto& t = out_.session.t;
    Values course(t.size(), not_a_number), speed(t.size(), not_a_number), along_x(t.size(), not_a_number),
        along_y(t.size(), not_a_number);
    std::size_t last = t.size();
    for (std::size_t i = 0; i < t.size(); ++i) {
      if (std::isnan(of(Source::x)[i] + of(Source::y)[i])) continue;
      if (last < i) {
        const double dt = t[i] - t[last];
        along_x[i] = (of(Source::x)[i] - of(Source::x)[last]) / dt;
        along_y[i] = (of(Source::y)[i] - of(Source::y)[last]) / dt;
        speed[i] = std::hypot(along_x[i], along_y[i]);
        if (speed[i] > 0.5) course[i] = std::atan2(along_y[i], along_x[i]);
      }
      last = i;
    }
    if (!has(Source::yaw)) {
      of(Source::yaw) = std::move(course);
      out_.derived_yaw = true;
      note("yaw", "absent", "the course over ground is taken; sideslip is not seen");
      if (!has_speed) of(Source::vx) = std::move(speed);
    } else {
      const bool sideways = !has(Source::vy);
      for (std::size_t i = 0; i < t.size(); ++i) {
        const double c = std::cos(of(Source::yaw)[i]), s = std::sin(of(Source::yaw)[i]);
        of(Source::vx).push_back(c * along_x[i] + s * along_y[i]);
        if (sideways) of(Source::vy).push_back(c * along_y[i] - s * along_x[i]);
      }
    }
    if (has_speed) return;
    out_.derived_velocity = true;
    note("velocity", "absent", "from differences of the place, half a step late");
  }

  /// Before the first value of a command nobody knows it, and the car need not drive straight.
  void drop_rows_before_commands() {
    std::size_t first = 0;
    for (const Source command : {Source::d, Source::delta}) {
      if (!has(command)) continue;
      const Values& values = of(command);
      const auto begin = std::ranges::find_if(values, [](double v) { return !std::isnan(v); });
      if (begin != values.end()) {
        first = std::max(first, static_cast<std::size_t>(begin - values.begin()));
      } else if (command == Source::d) {
        of(command).clear();  // as if the map did not name it
      } else {
        refuse_file(table_.file, "the steering is never given");
      }
    }
    if (first == 0) return;
    const auto drop = [&](auto& all) {
      if (!all.empty()) all.erase(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(first));
    };
    for (Values& values : values_) drop(values);
    drop(out_.session.t);
    drop(row_);
    note("commands", std::to_string(first) + " rows before the first value of throttle and steering", "left out");
    if (row_.size() < 20)
      refuse_file(table_.file, "only " + std::to_string(row_.size()) +
                                   " rows from the first value of throttle and steering on; expected a log of at least "
                                   "5 s");
  }

  void fill() {
    Session& s = out_.session;
    const std::size_t n = s.t.size();
    for (std::size_t c = 0; c < channels; ++c)
      s.has[c] = std::any_of(values_[c].begin(), values_[c].end(), [](double v) { return !std::isnan(v); });
    if (!s.has[Channel::vy]) note("vy", "absent", "done without");
    if (!s.has[Channel::yaw_rate]) note("yaw rate", "absent", "seen through the heading only");
    if (!s.has[Channel::x]) note("place", "absent", "speeds and yaw rate are judged alone");
    s.reading.resize(n * channels, not_a_number);
    for (std::size_t c = 0; c < channels; ++c)
      if (s.has[c])
        for (std::size_t i = 0; i < n; ++i) s.reading[i * channels + c] = values_[c][i];
    out_.has_throttle = has(Source::d);
    if (!out_.has_throttle) note("throttle", "absent", "vx is taken from the log: the lateral motion is judged");
    CommandSample<double> now{0.0, 0.0};
    std::size_t missing = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double d = out_.has_throttle ? of(Source::d)[i] : 0.0;
      const double delta = of(Source::delta)[i];
      missing += std::isnan(d) || std::isnan(delta);
      if (!std::isnan(d)) now.d = d;
      if (!std::isnan(delta)) now.delta = delta;
      s.command.push_back(now);
    }
    if (missing > 0) note("commands", std::to_string(missing) + " rows without", "the last one is held");
    s.held_throttle = map_[Source::d] && map_[Source::d]->held;
    s.held_steering = map_[Source::delta] && map_[Source::delta]->held;
    s.throttle_every = map_[Source::d] ? map_[Source::d]->every : 0.0;
    s.steering_every = map_[Source::delta] ? map_[Source::delta]->every : 0.0;
    s.prescribed_speed = !out_.has_throttle;
    check_pace("throttle", &CommandSample<double>::d, s.throttle_every);
    check_pace("steering", &CommandSample<double>::delta, s.steering_every);
  }

  void check_pace(const char* name, double CommandSample<double>::*command, double every) {
    if (!(every > 0.0)) return;
    const Session& s = out_.session;
    ReadingPace pace(every, s.t.front());
    Values intervals;
    std::size_t stood = 0, until = 0;  // changes that are taken as they stand, and all of them up to the last of these
    for (std::size_t i = 1; i < s.rows(); ++i) {
      if (s.command[i].*command == s.command[i - 1].*command) continue;
      intervals.push_back(s.t[i] - pace.last());
      pace.change(s.t[i]);
      if (!pace.kept()) ++stood, until = intervals.size();
    }
    if (stood == 0) return;
    const std::string of = std::to_string(stood) + " of " + std::to_string(intervals.size());
    intervals.resize(until);
    note(name,
         "changes every " + significant(median(std::move(intervals)), 2) + " s, the map says read every " +
             significant(every) + " s",
         of + " changes are taken as they stand in the rows");
  }

  const LogMap& map_;
  DelimitedTable table_;
  SessionFile out_;
  Values time_all_;
  std::vector<std::size_t> row_;  // of the table, by row of the session
  std::set<std::size_t> told_;    // columns of which it is said that cells are no numbers
  bool unit_of_header_ = false;   // the channel that was evaluated last has the unit of the table's header
  std::array<bool, source_count> of_header_{};
  std::array<Values, source_count> values_;
};

}  // namespace

SessionFile read_session(const std::filesystem::path& log, const LogMap& map) {
  return read_session(read_delimited(log), map);
}

SessionFile read_session(DelimitedTable table, const LogMap& map) {
  return SessionReader(std::move(table), map).read();
}

}  // namespace gripline::measured
