#include "measured/session/session_file.hpp"

#include <algorithm>
#include <cmath>

#include "measured/readings/bridged_readings.hpp"
#include "measured/readings/held_readings.hpp"
#include "measured/readings/unwrapped_angles.hpp"
#include "measured/session/channel_reader.hpp"
#include "measured/session/log_clock.hpp"
#include "measured/session/session_commands.hpp"
#include "measured/table/earth_places.hpp"
#include "measured/table/placeholder_places.hpp"
#include "measured/table/row_times.hpp"
#include "tables/delimited_table.hpp"
#include "tables/refuse_file.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

using Values = std::vector<double>;
using Level = Finding::Level;

class SessionReader {
 public:
  SessionReader(DelimitedTable table, const LogMap& map) : map_(map), table_(std::move(table)) {}

  SessionFile read() {
    out_.session.name = table_.file.filename().string();
    out_.session.pose = map_.pose;
    out_.session.velocity = map_.velocity;
    for (const std::string& one : table_.found) note("file", one, "read so");
    read_time();
    for (std::size_t s = 0; s < source_count; ++s)
      if (map_.channel[s]) read_source(static_cast<Source>(s), *map_.channel[s]);
    drop_half_places();
    check_needed();
    apply_valid();
    find_places();
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
  void read_time() {
    if (map_.file.empty() && table_.find(map_.time.formula) < 0) refuse_missing(map_.time.formula);
    time_all_ = reader_.read(map_.time, "s", "time", time_all_).value;
    const int column = table_.find(map_.time.formula);
    const bool of_clock = column >= 0 && table_.is_clock(static_cast<std::size_t>(column));
    RowTimes rows = order_rows(table_, time_all_, of_clock, out_.findings);
    const double begin = rows.t.front(), end = rows.t.back();
    time_all_ = times_since(begin, std::move(time_all_), end);
    out_.session.begin = begin;
    out_.session.t = times_since(begin, std::move(rows.t), end);
    out_.row_step = rows.step;
    row_ = std::move(rows.row);
  }

  void read_source(Source source, const MappedChannel& channel) {
    const SourceInfo& info = source_info(source);
    const bool own_log = map_.file.empty();
    if (own_log && table_.find(info.column) < 0) return;  // absent; check_needed says what must be there
    const ChannelValues all = reader_.read(channel, info.unit, info.name, time_all_);
    of_header_[static_cast<std::size_t>(source)] = all.unit_of_header;
    Values& to = of(source);
    for (const std::size_t r : row_) to.push_back(all.value[r]);
    const bool command = source == Source::d || source == Source::delta;
    if (!command && std::ranges::all_of(to, [](double v) { return std::isnan(v); })) {
      to.clear();
      note(info.name, "no number in its column", "taken for absent");
      return;
    }
    if (channel.between.held() && !channel.command && !is_place(source)) drop_repeats(source);
  }
  void drop_repeats(Source source) {
    note(source_info(source).name,
         std::to_string(drop_held(out_.session.t, of(source))) + " rows hold the value before",
         "read when it is new, or stays for longer than usual");
  }
  /// A place has two coordinates: one without the other is none.
  void drop_half_places() {
    for (const auto& [one, other] : {std::pair(Source::x, Source::y), {Source::latitude, Source::longitude}})
      if (has(one) != has(other)) of(one).clear(), of(other).clear();
  }
  static bool is_place(Source source) {
    return source == Source::x || source == Source::y || source == Source::latitude || source == Source::longitude;
  }
  /// Placeholders repeat, and are told by that: before repeated readings are dropped.
  void find_places() {
    const bool on_earth = has(Source::latitude) && !has(Source::x);
    if (on_earth) place_from_degrees();
    if (!has(Source::x)) return;
    if (!on_earth) drop_placeholders();
    for (const auto& [to, from] : {std::pair(Source::x, on_earth ? Source::longitude : Source::x),
                                   {Source::y, on_earth ? Source::latitude : Source::y}})
      if (map_.channel[static_cast<std::size_t>(from)]->between.held()) drop_repeats(to);
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
    const Values all = reader_.read(channel, "1", "valid", time_all_).value;
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

  void drop_placeholders() {
    const PlaceholderPlaces dropped = drop_placeholder_places(out_.session.t, of(Source::x), of(Source::y));
    if (dropped.rows > 0)
      note("place",
           std::to_string(dropped.rows) + " rows at the beginning show " + significant(dropped.x, 6) + ", " +
               significant(dropped.y, 6) + ", far from the rest",
           "taken for missing: there was no fix yet");
  }

  void place_from_degrees() {
    std::vector<int> line;
    for (const std::size_t r : row_) line.push_back(table_.line[r]);
    PlanePlaces places = on_plane({.latitude = of(Source::latitude),
                                   .longitude = of(Source::longitude),
                                   .latitude_unit_is_known = has_unit(Source::latitude),
                                   .longitude_unit_is_known = has_unit(Source::longitude),
                                   .t = out_.session.t},
                                  table_.file, line, out_.findings);
    of(Source::x) = std::move(places.x);
    of(Source::y) = std::move(places.y);
  }

  /// Velocity of the point whose places the log has, in the axes of those.
  struct Moves {
    Values x, y;  // by row [m/s]
  };
  /// From the places of this row and the last one that had one: nothing later is looked at. NaN behind a gap, over
  /// which a car need not have moved evenly; places that are always so far apart have no gap between them.
  Moves moves() const {
    const auto& t = out_.session.t;
    const Values &x = of(Source::x), &y = of(Source::y);
    std::vector<std::size_t> placed;  // rows
    for (std::size_t i = 0; i < t.size(); ++i)
      if (!std::isnan(x[i] + y[i])) placed.push_back(i);
    Values steps;
    for (std::size_t k = 1; k < placed.size(); ++k) steps.push_back(t[placed[k]] - t[placed[k - 1]]);
    const double longest = std::max(even_motion, 1.5 * median(steps, 0.0));
    Moves out{Values(t.size(), not_a_number), Values(t.size(), not_a_number)};
    for (std::size_t k = 1; k < placed.size(); ++k) {
      const std::size_t i = placed[k], last = placed[k - 1];
      if (is_longer(steps[k - 1], longest)) continue;
      out.x[i] = (x[i] - x[last]) / steps[k - 1];
      out.y[i] = (y[i] - y[last]) / steps[k - 1];
    }
    return out;
  }

  /// Course and speed from places.
  void derive() {
    const bool place = has(Source::x) && has(Source::y), has_speed = has(Source::vx);
    if (!place || (has(Source::yaw) && has_speed)) return;
    const Moves along = moves();
    if (!has(Source::yaw))
      derive_course(along);
    else
      derive_velocity(along);
    if (has_speed) return;
    out_.derived_velocity = true;
    note("velocity", "absent", "from differences of the place, half a step late");
  }
  /// The course in place of a yaw, with the speed where that is absent, too.
  void derive_course(const Moves& along) {
    constexpr double slowest = 0.5;  // [m/s] below it a course is noise
    const bool has_speed = has(Source::vx);
    if (!has_speed) velocity_is_of_place();
    for (std::size_t i = 0; i < along.x.size(); ++i) {
      const double speed = std::hypot(along.x[i], along.y[i]);
      of(Source::yaw).push_back(speed > slowest ? std::atan2(along.y[i], along.x[i]) : not_a_number);
      if (!has_speed) of(Source::vx).push_back(along_unit(speed, 0.0));
    }
    out_.derived_yaw = true;
    out_.session.pose.yaw = 0.0;  // a course is of no unit whose axes could be turned
    out_.session.pose.yaw_given = false;
    note("yaw", "absent", "the course over ground is taken, half a step late; sideslip is not seen");
  }
  void derive_velocity(const Moves& along) {
    velocity_is_of_place();
    const bool sideways = !has(Source::vy);
    for (std::size_t i = 0; i < along.x.size(); ++i) {
      const double heading = of(Source::yaw)[i] - map_.pose.yaw, c = std::cos(heading), s = std::sin(heading);
      const double ahead = c * along.x[i] + s * along.y[i], left = c * along.y[i] - s * along.x[i];
      of(Source::vx).push_back(along_unit(ahead, left));
      if (sideways) of(Source::vy).push_back(left);
    }
  }
  /// A velocity that is derived is of the point that the places show, in the car's axes; beside a vy that is read, vx
  /// is that along the axes of vy's unit. Of two points the session has one that moves along these axes as the place's
  /// and across them as the unit's: where they are not turned it lies as far to the side as the place, which changes vx
  /// alone, and as far ahead as the unit, which changes vy alone.
  void velocity_is_of_place() {
    const Frame& pose = out_.session.pose;
    Frame& velocity = out_.session.velocity;
    if (!has(Source::vy)) velocity = {pose.x, 0.0, 0.0, pose.x_given, false, false};
    const double c = std::cos(velocity.yaw), s = std::sin(velocity.yaw);
    // What either shows for each rad/s.
    const double along = s * pose.x - c * pose.y, across = c * velocity.x + s * velocity.y;
    velocity.x = c * across + s * along;
    velocity.y = s * across - c * along;
    velocity.y_given = pose.y_given;
  }
  /// What a velocity in the car's axes shows along those of the velocity's unit.
  double along_unit(double ahead, double left) const {
    const double turned = out_.session.velocity.yaw;
    return turned == 0.0 ? ahead : std::cos(turned) * ahead + std::sin(turned) * left;
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
    fill_commands(s, of(Source::d), of(Source::delta), map_, out_.findings);
  }

  const LogMap& map_;
  DelimitedTable table_;
  SessionFile out_;
  ChannelReader reader_{table_, map_, out_.findings};
  Values time_all_;               // of the table's rows, from the first that counts on
  std::vector<std::size_t> row_;  // of the table, by row of the session
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
