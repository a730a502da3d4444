#include "measured/session_file.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

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
    if (!known.empty()) return to_si("1 " + known, unit);
    if (!bare) return 1.0;
    note("unit", name + ": the header's \"" + written + "\" is no unit of this kind",
         std::string("taken for ") + unit + "; `unit` in the map says another");
    return 1.0;
  }

  Values evaluate(const MappedChannel& channel, const char* unit, const char* name) {
    try {
      const Formula formula(channel.formula, table_, std::string(name));
      Values values = formula.evaluate(table_, time_all_);
      const double factor = channel.sign * factor_of(channel, unit, formula);
      for (double& v : values) v = std::isfinite(v) ? factor * v : not_a_number;
      return values;
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

  void read_time() {
    if (map_.file.empty() && table_.find(map_.time.formula) < 0) refuse_missing(map_.time.formula);
    time_all_ = evaluate(map_.time, "s", "time");
    Values kept;
    std::size_t without = 0, again = 0;
    for (std::size_t r = 0; r < table_.rows(); ++r) {
      const double t = time_all_[r];
      if (std::isnan(t)) {
        ++without;
      } else if (!kept.empty() && t == kept.back()) {
        ++again;
      } else if (!kept.empty() && t < kept.back()) {
        refuse_file(table_.file,
                    "time runs backward from " + significant(kept.back(), 10) + " s to " + significant(t, 10) +
                        " s; expected rows in the order of time",
                    table_.line[r]);
      } else {
        kept.push_back(t);
        row_.push_back(r);
      }
    }
    if (without > 0) note("rows", std::to_string(without) + " without time", "left out");
    if (again > 0) note("rows", std::to_string(again) + " repeat a time stamp", "left out");
    if (kept.size() < 20)
      refuse_file(table_.file,
                  "only " + std::to_string(kept.size()) + " rows with a time; expected a log of at least 5 s");
    Values steps;
    for (std::size_t i = 1; i < kept.size(); ++i) steps.push_back(kept[i] - kept[i - 1]);
    out_.row_step = median(std::move(steps));
    const int column = table_.find(map_.time.formula);
    const bool of_clock = column >= 0 && table_.is_clock(static_cast<std::size_t>(column));
    for (const auto& [unit, factor] : {std::pair("milliseconds", 1e-3), {"microseconds", 1e-6}, {"nanoseconds", 1e-9}})
      if (!of_clock && out_.row_step > 0.9 && out_.row_step * factor >= 0.9e-3 && out_.row_step * factor < 0.3)
        refuse_file(table_.file, "time rises by " + significant(out_.row_step) + " s from row to row: it looks like " +
                                     unit + "; the map should say so (\"unit\")");
    for (const auto& [unit, factor] : {std::pair("milliseconds", 1e3), {"microseconds", 1e6}, {"nanoseconds", 1e9}})
      if (out_.row_step < 1e-4 && out_.row_step * factor > 0.9e-3 && out_.row_step * factor < 0.3)
        refuse_file(table_.file, "rows are " + significant(out_.row_step) +
                                     " s apart, which no logger writes: time was taken for " + unit +
                                     " and is seconds");
    if (out_.row_step > 0.5)
      refuse_file(table_.file, "rows are " + significant(out_.row_step) + " s apart; expected 0.5 s or less");
    out_.session.t = std::move(kept);
  }

  void read_source(Source source, const MappedChannel& channel) {
    const SourceInfo& info = source_info(source);
    const bool own_log = map_.file.empty();
    if (own_log && table_.find(info.column) < 0) return;  // absent; check_needed says what must be there
    const Values all = evaluate(channel, info.unit, info.name);
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

  /// Angles on the earth that no radians can be are degrees: maps and tables often leave their unit out.
  void take_for_degrees(Values& lat, Values& lon) {
    const auto beyond = [](const Values& all, double most) {
      return std::ranges::any_of(all, [&](double angle) { return std::abs(angle) > most; });
    };
    if (!beyond(lat, 0.5 * pi) && !beyond(lon, pi)) return;
    for (Values* const all : {&lat, &lon})
      for (double& angle : *all) angle *= pi / 180.0;
    note("unit", "latitude and longitude are beyond what radians can be",
         "taken for degrees; `unit` in the map says so");
  }

  /// Local tangent plane at the first position on the WGS 84 ellipsoid: x east, y north.
  void place_from_degrees() {
    if (!has(Source::latitude) || has(Source::x)) return;
    Values &lat = of(Source::latitude), &lon = of(Source::longitude);
    take_for_degrees(lat, lon);
    std::size_t first = 0;
    while (first < lat.size() && std::isnan(lat[first] + lon[first])) ++first;
    if (first == lat.size()) refuse_file(table_.file, "latitude and longitude are never given");
    constexpr double a = 6378137.0, e2 = 6.69437999014e-3;
    const double w = 1.0 - e2 * std::sin(lat[first]) * std::sin(lat[first]);
    const double north = a * (1.0 - e2) / (w * std::sqrt(w)), east = a / std::sqrt(w) * std::cos(lat[first]);
    for (std::size_t i = 0; i < lat.size(); ++i) {
      of(Source::x).push_back(east * (lon[i] - lon[first]));
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
