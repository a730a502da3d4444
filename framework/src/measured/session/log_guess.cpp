#include "measured/session/log_guess.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "config/errors.hpp"
#include "config/units.hpp"
#include "measured/readings/held_readings.hpp"
#include "measured/readings/unit_checks.hpp"
#include "measured/session/log_map.hpp"
#include "measured/table/column_names.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

using std::numbers::pi;
using Values = std::vector<double>;

double quantile_of_size(const Values& values, double q) {
  Values sizes;
  for (const double v : values)
    if (!std::isnan(v)) sizes.push_back(std::abs(v));
  return lower_quantile(std::move(sizes), q, 0.0);
}

/// Channel by channel: a column by its name, its unit by header, name and size, its sign by the channels before it.
class Guesser {
 public:
  explicit Guesser(const DelimitedTable& table) : table_(table) {}

  Guess run() {
    guess_time();
    for (const char* name : {"x", "y"}) guess_column(name, "m");
    if (!found("x") || !found("y")) guess_earth_places();
    guess_yaw();
    for (const char* name : {"vx", "vy"}) guess_column(name, "m/s");
    check_speed_unit();
    guess_yaw_rate();
    guess_throttle();
    guess_steering();
    name_what_is_missing();
    Node map = Node::empty_object();
    map.set("note", Node("A first guess from names, units and numbers. Read every line; units and signs are checked "
                         "when the log is read."));
    map.set("time", time_);
    map.set("channels", channels_);
    if (const int valid = column("valid"); valid >= 0) map.set("valid", Node(quoted(valid) + " > 0.5"));
    name_what_is_unused(map);
    return {std::move(map), std::move(remarks_), std::move(open_)};
  }

 private:
  /// What log_map.hpp asks of every map.
  void name_what_is_missing() {
    const bool place = (found("x") && found("y")) || found("latitude");
    if (!found("delta")) {
      Node node = unnamed("delta",
                          "the front wheels' angle, positive to the left (the steering wheel's as \"formula\": "
                          "\"COLUMN / RATIO\")",
                          "rad");
      node.set("kind", Node("command"));
      channels_.set("delta", std::move(node));
    }
    if (!place && !found("vx")) channels_.set("vx", unnamed("vx", "the speed along the car", "m/s"));
    if (!place && !found("yaw") && !found("yaw_rate"))
      channels_.set("yaw_rate", unnamed("yaw_rate", "the yaw rate, positive to the left", "rad/s"));
    if (time_.is_null()) time_ = unnamed("time", "the time", "s", true);
  }

  int column(const char* channel) const {
    const char* const kind = unit_kind(channel);
    for (const char* word : names_of(channel))
      for (std::size_t c = 0; c < table_.name.size(); ++c)
        if (is_called(known_as(c), word, kind) && quantile_of_size(table_.column[c], 1.0) > 0.0)
          return static_cast<int>(c);
    return -1;
  }
  /// Columns that vary and no channel has taken, each with its range; `rising`: those that never fall.
  std::string candidates(bool rising) const {
    constexpr std::size_t most = 12;
    std::string all;
    std::size_t shown = 0;
    for (std::size_t c = 0; c < table_.name.size(); ++c) {
      if (!varies(c) || taken(static_cast<int>(c)) || (rising && falls(c))) continue;
      if (++shown > most) continue;
      const auto [low, high] = range(c);
      all += (all.empty() ? "" : ", ") + table_.name[c] + " (" + significant(low) + " to " + significant(high) + ")";
    }
    if (shown > most) all += " and " + std::to_string(shown - most) + " more";
    return all.empty() ? "no column is left that varies" : all;
  }
  bool taken(int c) const {
    const auto names = [&](const Node& node) {
      const Node* const as_column = node.find("column");
      const Node* const formula = node.find("formula");
      return (as_column != nullptr && as_column->text() == name(c)) ||
             (formula != nullptr && formula->text().find(quoted(c)) != std::string::npos);
    };
    return (time_.is_object() && names(time_)) ||
           std::ranges::any_of(channels_.object(), [&](const Member& m) { return names(m.value); });
  }
  /// A channel that the map must have, and nothing here looks like.
  Node unnamed(const char* channel_name, const char* what, const char* unit, bool rising = false) {
    open_.emplace_back(channel_name);
    Node node = channel("column", unnamed_column, unit, false);
    node.set("note", Node(std::string("Fill in the column of ") + what + "; it may be one of: " + candidates(rising)));
    return node;
  }

  const std::string& known_as(std::size_t c) const {
    return table_.meaning.empty() ? table_.name[c] : table_.meaning[c];
  }
  bool found(const char* channel) const { return channels_.find(channel) != nullptr; }
  const Values& values(int c) const { return table_.column[static_cast<std::size_t>(c)]; }
  std::string name(int c) const { return table_.name[static_cast<std::size_t>(c)]; }
  std::string quoted(int c) const {
    const std::string n = name(c);
    const bool word =
        std::all_of(n.begin(), n.end(), [](unsigned char ch) { return std::isalnum(ch) != 0 || ch == '_'; });
    return word && std::isdigit(static_cast<unsigned char>(n.front())) == 0 ? n : "`" + n + "`";
  }

  /// The unit that the name ends with, if it is one of the kind wanted; else "".
  std::string unit_of_name(int c, const char* wanted) const {
    return unit_at_end(known_as(static_cast<std::size_t>(c)), wanted);
  }
  /// The unit in the header, or in the name's ending, if it is one of the kind wanted.
  std::string unit_of(int c, const char* wanted) {
    const std::string& written = table_.unit[static_cast<std::size_t>(c)];
    if (std::string known = header_unit(written, wanted); !known.empty()) return known;
    if (std::string known = unit_of_name(c, wanted); !known.empty()) return known;
    if (!written.empty())
      remarks_.push_back(name(c) + ": the header's \"" + written + "\" is no unit of this kind; taken for " + wanted);
    return wanted;
  }

  Node channel(const std::string& key, const std::string& what, const std::string& unit, bool delay = true) const {
    Node node = Node::empty_object();
    node.set(key, Node(what));
    node.set("unit", Node(unit));
    if (delay) node.set("delay", Node("find"));
    return node;
  }

  void guess_time() {
    const int c = column("time");
    if (c < 0) return;
    std::string unit = unit_of(c, "s");
    Values steps;
    const Values& t = values(c);
    for (std::size_t i = 1; i < t.size(); ++i)
      if (t[i] > t[i - 1]) steps.push_back(t[i] - t[i - 1]);
    const double step = quantile_of_size(steps, 0.5);
    constexpr double least_count = 5.0;  // steps below it may be those of a slow logger, in seconds
    constexpr double a_day = 86400.0;
    if (unit == "s" && !table_.is_clock(static_cast<std::size_t>(c)) && step > 0.9 && step < least_count) {
      if (unit_of_name(c, "s").empty() && step * static_cast<double>(steps.size()) > a_day) unit = "ms";
      remarks_.push_back("time: steps of " + significant(step) + " are " + significant(1.0 / step) + " Hz in s and " +
                         significant(1e3 / step, 4) + " Hz in ms; taken for " + unit);
    }
    for (const auto& [name_of, factor] : {std::pair("ms", 1e3), {"us", 1e6}, {"ns", 1e9}})
      if (!table_.is_clock(static_cast<std::size_t>(c)) && unit == "s" && step > 0.9e-3 * factor &&
          step < 0.3 * factor && step >= least_count) {
        unit = name_of;
        remarks_.push_back("time: steps of " + significant(step) + ", taken for " + name_of);
      }
    time_ = channel("column", name(c), unit, false);
  }

  /// A channel whose column needs no look at its numbers.
  void guess_column(const char* which, const char* unit) {
    if (const int c = column(which); c >= 0) channels_.set(which, channel("column", name(c), unit_of(c, unit)));
  }

  void guess_earth_places() {
    const int lat = column("latitude"), lon = column("longitude");
    if (lat < 0 || lon < 0) return;
    channels_.set("latitude", channel("column", name(lat), "deg"));
    channels_.set("longitude", channel("column", name(lon), "deg"));
    lat_ = lat, lon_ = lon;
  }

  /// Where the place is read: x and y, or neither where it is latitude and longitude.
  struct PlaceColumns {
    const Values *x = nullptr, *y = nullptr;
    double metres = 1.0;  // that 1 of them is
  };
  /// Looked up once for all rows: a look reads whole columns.
  PlaceColumns place_columns() const {
    if (!found("x") || !found("y")) return {};
    return {&values(column("x")), &values(column("y")), to_si("1 " + channels_.find("x")->find("unit")->text(), "m")};
  }
  /// Whether a row's place is another than that of the row before.
  bool is_new(const PlaceColumns& place, std::size_t i) const {
    if (place.x == nullptr && lat_ < 0) return false;
    const Values &x = place.x != nullptr ? *place.x : values(lon_), &y = place.y != nullptr ? *place.y : values(lat_);
    return std::isfinite(x[i] + y[i]) && (x[i] != x[i - 1] || y[i] != y[i - 1]);
  }
  /// Way from row to row [m], for comparisons with headings and speeds.
  bool way(const PlaceColumns& place, std::size_t i, std::size_t j, double& dx, double& dy) const {
    if (place.x != nullptr) {
      dx = place.metres * ((*place.x)[j] - (*place.x)[i]);
      dy = place.metres * ((*place.y)[j] - (*place.y)[i]);
    } else if (lat_ >= 0) {
      constexpr double metres = 111195.0;  // per degree
      dx = metres * std::cos(values(lat_)[i] * pi / 180) * (values(lon_)[j] - values(lon_)[i]);
      dy = metres * (values(lat_)[j] - values(lat_)[i]);
    } else {
      return false;
    }
    return std::isfinite(dx + dy) && std::hypot(dx, dy) > 0.05;
  }

  /// Sums over the path of what is added to a heading, and to the heading counted the other way round, to give the
  /// path's own: sine and cosine of both.
  struct AgainstPath {
    double sine = 0, cosine = 0, mirrored_sine = 0, mirrored_cosine = 0, rows = 0;
    /// How steady the better of both is: the length of its sum.
    double agreement() const { return std::max(std::hypot(sine, cosine), std::hypot(mirrored_sine, mirrored_cosine)); }
    bool counts_clockwise() const { return std::hypot(mirrored_sine, mirrored_cosine) > std::hypot(sine, cosine); }
  };
  AgainstPath against_path(int c, double factor) const {
    AgainstPath sum;
    const PlaceColumns place = place_columns();
    double dx = 0, dy = 0;
    for (std::size_t i = 0; i + window < table_.rows(); i += window)
      if (way(place, i, i + window, dx, dy) && std::isfinite(values(c)[i])) {
        const double a = factor * values(c)[i], path = std::atan2(dy, dx);
        sum.sine += std::sin(path - a), sum.cosine += std::cos(path - a);
        sum.mirrored_sine += std::sin(path + a), sum.mirrored_cosine += std::cos(path + a), sum.rows += 1;
      }
    return sum;
  }
  /// Whether a heading is in degrees. Where no unit is stated: values beyond a turn are, unless they agree better with
  /// the path as radians that were counted on over turns.
  bool is_in_degrees(int c) {
    if (unit_of(c, "rad") == "deg") return true;
    if (!table_.unit[static_cast<std::size_t>(c)].empty() || quantile_of_size(values(c), 0.99) <= 7.0) return false;
    return against_path(c, pi / 180).agreement() >= against_path(c, 1.0).agreement();
  }

  /// Heading against the path: which of yaw, compass, degrees or radians is it?
  void guess_yaw() {
    const int c = column("yaw");
    if (c < 0) return;
    const bool deg = is_in_degrees(c);
    const std::string angle = deg ? "rad(" + quoted(c) + ")" : quoted(c);
    const AgainstPath path = against_path(c, deg ? pi / 180 : 1.0);
    std::string formula = angle;
    if (path.rows > 20) {
      const bool compass = path.counts_clockwise();
      const double offset =
          compass ? std::atan2(path.mirrored_sine, path.mirrored_cosine) : std::atan2(path.sine, path.cosine);
      const double quarter = std::round(offset / (pi / 2)) * (pi / 2);
      const std::string add = quarter == 0 ? "" : std::abs(quarter) > 3 ? "pi" : quarter > 0 ? "pi/2" : "-pi/2";
      if (compass)
        formula = (add.empty() ? "-" : add + " - ") + angle;
      else if (!add.empty())
        formula = angle + " + " + add;
      if (formula != angle)
        remarks_.push_back("yaw: " + name(c) + (compass ? " counts clockwise" : " is turned") + " against the path");
      if (path.agreement() < 0.8 * path.rows)
        remarks_.push_back("yaw: " + name(c) + " follows the path badly; is it the heading?");
    }
    channels_.set("yaw", formula == quoted(c) && !deg ? channel("column", name(c), "rad")
                         : formula == angle && deg    ? channel("column", name(c), "deg")
                                                      : channel("formula", formula, "rad"));
  }

  /// The speed over that of the path, in windows that begin and end where the place is new: loggers repeat it until
  /// the next one is read.
  Values ratios_to_path(int c) const {
    const Values& t = values(column("time"));
    const double second = to_si("1 " + time_.find("unit")->text(), "s");
    const PlaceColumns place = place_columns();
    const double enough = 0.3 * quantile_of_size(values(c), 0.95);
    Values ratios;
    double dx = 0, dy = 0;
    std::size_t from = table_.rows();
    for (std::size_t i = 1; i < table_.rows(); ++i) {
      if (!is_new(place, i) || (from < i && i - from < window)) continue;
      if (from < i && way(place, from, i, dx, dy) && std::abs(values(c)[from]) > enough && t[i] > t[from])
        ratios.push_back(values(c)[from] / (std::hypot(dx, dy) / (second * (t[i] - t[from]))));
      from = i;
    }
    return ratios;
  }

  /// A speed without a unit, against the path.
  void check_speed_unit() {
    const int c = column("vx");
    if (c < 0 || column("time") < 0 || !table_.unit[static_cast<std::size_t>(c)].empty()) return;
    constexpr std::size_t few = 20;
    const Values ratios = ratios_to_path(c);
    const std::string taken = channels_.find("vx")->find("unit")->text();
    const bool told = !unit_of_name(c, "m/s").empty();
    if (ratios.size() < few) {
      if (!told)
        remarks_.push_back("vx: no unit is written, and the place tells none (it changes too seldom); taken for " +
                           taken);
      return;
    }
    const double ratio = quantile_of_size(ratios, 0.5), expected = 1.0 / to_si("1 " + taken, "m/s");
    const std::string found = "vx: " + significant(ratio) + " times the speed of the path";
    if (told && ratio > 0.6 * expected && ratio < 1.6 * expected) return;
    for (const WrongUnit& wrong : wrong_units)
      if (!wrong.of_place && ratio > wrong.low && ratio < wrong.high) {
        if (!told) channels_.set("vx", channel("column", name(c), wrong.unit));
        remarks_.push_back(found + (told ? ", which looks like " : ", taken for ") + wrong.unit +
                           (told ? "; its name says " + taken : ""));
        return;
      }
    if (!(ratio > 0.6 * expected && ratio < 1.6 * expected))
      remarks_.push_back(found + "; its unit is not told by that");
  }

  void guess_yaw_rate() {
    const int c = column("yaw_rate");
    if (c < 0) return;
    std::string unit = unit_of(c, "rad/s");
    if (unit == "rad/s" && table_.unit[static_cast<std::size_t>(c)].empty() && quantile_of_size(values(c), 0.98) > 12) {
      unit = "deg/s";
      remarks_.push_back("yaw_rate: values of " + significant(quantile_of_size(values(c), 0.98)) + ", taken for deg/s");
    }
    channels_.set("yaw_rate", channel("column", name(c), unit));
  }

  /// Whether the logger repeats a command until there is a new one.
  bool is_repeated(int c) {
    if (time_.is_null()) return false;
    Values t = values(column("time"));
    const double second = to_si("1 " + time_.find("unit")->text(), "s");
    for (double& v : t) v *= second;
    const double every = rows_between_new(t, values(c));
    if (!(every > 1.0)) return false;
    remarks_.push_back(name(c) + ": a new value every " + significant(every) +
                       " rows; taken for a command that is held until the next one (\"every\" in place of \"hold\" "
                       "where the car's own "
                       "moves in between)");
    return true;
  }

  /// What makes a pedal's column run from 0 to 1.
  std::string pedal_share(int c) {
    const double most = quantile_of_size(values(c), 1.0);
    const bool pressure = !header_unit(table_.unit[static_cast<std::size_t>(c)], "N/m2").empty();
    if (!pressure && most <= 1.2) return quoted(c);
    if (!pressure && most <= 110) return quoted(c) + " / 100";
    remarks_.push_back(name(c) + ": divided by its largest value in this log, " + significant(most, 5));
    return quoted(c) + " / " + significant(most, 5);
  }

  /// Throttle and brake as one channel, d.
  void guess_throttle() {
    const int d = column("d"), throttle = column("throttle"), brake = column("brake"), enable = column("enable");
    std::string formula;
    if (d >= 0)
      formula = pedal_share(d);
    else if (throttle >= 0)
      formula = pedal_share(throttle) + (brake >= 0 ? " - " + pedal_share(brake) : "");
    if (formula.empty()) {
      remarks_.push_back("d: no throttle found: vx will be taken from the log and the lateral motion judged");
      return;
    }
    if (enable >= 0) {
      // A switch stays where it is until it is read again.
      const bool gaps = std::ranges::any_of(values(enable), [](double v) { return std::isnan(v); });
      const std::string enabled = gaps ? "hold(" + quoted(enable) + ")" : quoted(enable);
      formula = "if(" + enabled + " > 0.5, " + formula + ", 0)";
      remarks_.push_back("d: " + name(enable) + " taken for a switch of the drive");
    }
    Node node = channel("formula", formula, "1", false);
    node.set("kind", Node("command"));
    if (is_repeated(d >= 0 ? d : throttle)) node.set("hold", Node("held"));
    channels_.set("d", std::move(node));
    if (d < 0 && brake < 0) name_brake(pedal_share(throttle));
  }

  /// A brake by a name that no list has: in a map without it, the car would brake unasked.
  void name_brake(const std::string& throttle) {
    for (std::size_t c = 0; c < table_.name.size(); ++c)
      for (const char* part : {"brake", "brems", "frein", "freno", "freio"})
        if (plain_name(known_as(c)).find(part) != std::string::npos && varies(c)) {
          const int column = static_cast<int>(c);
          const double most = quantile_of_size(values(column), 1.0);
          const std::string scale = most > 1.2 ? " / " + significant(most, 5) : "";
          remarks_.push_back("d: " + name(column) + " looks like a brake and is not used; write \"formula\": \"" +
                             throttle + " - " + quoted(column) + scale + "\" if it is one");
          return;
        }
  }

  /// Of the finite values; the first is the larger where there are none.
  std::pair<double, double> range(std::size_t c) const {
    double low = INFINITY, high = -INFINITY;
    for (const double v : table_.column[c])
      if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
    return {low, high};
  }
  bool varies(std::size_t c) const {
    const auto [low, high] = range(c);
    return high > low;
  }
  bool falls(std::size_t c) const {
    double last = -INFINITY;
    for (const double v : table_.column[c]) {
      if (v < last) return true;
      if (std::isfinite(v)) last = v;
    }
    return false;
  }

  /// What the table holds beside what the map reads: a column that was missed should not be so unseen.
  void name_what_is_unused(const Node& map) {
    const Node* const valid = map.find("valid");
    constexpr std::size_t most = 30;
    std::string all;
    std::size_t count = 0;
    for (std::size_t c = 0; c < table_.name.size(); ++c) {
      const int column = static_cast<int>(c);
      if (taken(column) || !varies(c) || (valid != nullptr && valid->text().starts_with(quoted(column)))) continue;
      if (++count <= most) all += (all.empty() ? "" : ", ") + table_.name[c];
    }
    if (count == 0) return;
    if (count > most) all += " and " + std::to_string(count - most) + " more";
    remarks_.push_back("columns not used: " + all);
  }

  /// Steering that runs from -1 to 1: by its name or unit, or by its range where nothing calls it an angle.
  bool is_share_of_lock(int c, double most) const {
    const std::string called = plain_name(known_as(static_cast<std::size_t>(c)));
    const std::string unit = plain_name(table_.unit[static_cast<std::size_t>(c)]);
    const auto calls = [&](const char* word) { return called.find(word) != std::string::npos; };
    if (calls("norm") || unit.starts_with("norm")) return true;
    const bool an_angle = calls("angle") || calls("rad") || calls("deg") || calls("delta");
    return (unit == "1" || (unit.empty() && !an_angle)) && most > 0.7 && most < 1.05;
  }

  /// By its name; "steering angle" may be the steering wheel's.
  bool is_of_road_wheels(int c) const {
    const std::string called = plain_name(known_as(static_cast<std::size_t>(c)));
    return called.find("delta") != std::string::npos || called.find("road") != std::string::npos;
  }

  void guess_steering() {
    const int angle = column("delta"), c = angle < 0 ? column("steering_wheel") : angle;
    if (c < 0) return;
    std::string unit = unit_of(c, "rad");
    const double most = quantile_of_size(values(c), 0.99);
    if (unit == "rad" && most > 1.6) {
      unit = "deg";
      remarks_.push_back("delta: values of " + significant(most) + ", taken for degrees");
    }
    const double radians = most * (unit == "deg" ? pi / 180 : 1.0);
    std::string formula = quoted(c);
    if (angle >= 0 && is_share_of_lock(c, most)) {
      remarks_.push_back("delta: " + name(c) + " (up to " + significant(most) +
                         ") is no angle but a share of full lock; write \"formula\": \"" + quoted(c) +
                         " * LOCK\" with the front wheels' angle at full lock [rad]; until then it is taken as rad at "
                         "full lock 1, which a fitted steer_map puts right");
    } else if (radians > 0.7 || angle < 0) {
      remarks_.push_back("delta: " + (angle < 0 ? name(c) : significant(radians * 180 / pi) + " deg") +
                         " is the steering wheel's: divided by 15, a guess of the steering ratio; write the car's own");
      formula += " / 15";
    } else if (!is_of_road_wheels(c)) {
      remarks_.push_back("delta: " + name(c) + " is taken for the front wheels' angle (up to " +
                         significant(radians * 180 / pi) +
                         " deg); if it is the steering wheel's, write \"formula\": \"" + quoted(c) + " / RATIO\"");
    }
    Node node =
        formula == quoted(c) ? channel("column", name(c), unit, false) : channel("formula", formula, unit, false);
    node.set("kind", Node("command"));
    if (turns_against(c)) {
      node.set("sign", Node(-1.0));
      remarks_.push_back("delta: positive to the right; its sign is turned");
    }
    if (is_repeated(c)) node.set("hold", Node("held"));
    channels_.set("delta", std::move(node));
  }

  /// Whether the steering is positive to the right, as the yaw rate or the heading shows.
  bool turns_against(int c) const {
    const Node* const rate = channels_.find("yaw_rate");
    const int r = column("yaw_rate");
    if (rate == nullptr || r < 0) return false;
    double n = 0, sx = 0, sy = 0, sxx = 0, syy = 0, sxy = 0;
    for (std::size_t i = 0; i < table_.rows(); ++i) {
      const double x = values(c)[i], y = values(r)[i];
      if (std::isnan(x + y)) continue;
      n += 1, sx += x, sy += y, sxx += x * x, syy += y * y, sxy += x * y;
    }
    return (sxy - sx * sy / n) / std::sqrt((sxx - sx * sx / n) * (syy - sy * sy / n)) < -0.3;
  }

  static constexpr std::size_t window = 10;  // rows over which headings and speeds are compared with the path
  const DelimitedTable& table_;
  int lat_ = -1, lon_ = -1;
  Node time_, channels_{Node::Object{}};
  std::vector<std::string> remarks_, open_;
};

}  // namespace

Guess guess_map(const DelimitedTable& table) { return Guesser(table).run(); }

}  // namespace gripline::measured
