#include "measured/log_guess.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "config/errors.hpp"
#include "config/units.hpp"
#include "measured/log_map.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

using std::numbers::pi;
using Values = std::vector<double>;

/// What loggers call a channel, best first; compared in lower case without blanks and signs.
struct Names {
  const char* channel;
  std::vector<const char*> words;
};
const std::vector<Names>& known_names() {
  static const std::vector<Names> all = {
      {"time",
       {"ts", "time", "t", "times", "timestamp", "elapsedtime", "timems", "utctime", "stamp", "logtime", "seconds",
        "datetime"}},
      {"x", {"xm", "x", "posx", "px", "xpos", "east", "xeast", "easting", "positionx", "posxm", "xmm"}},
      {"y", {"ym", "y", "posy", "py", "ypos", "north", "ynorth", "northing", "positiony", "posym", "ymm"}},
      {"yaw",
       {"yawrad", "yaw", "heading", "psi", "psirad", "theta", "yawdeg", "headingrad", "headingdeg", "yawangle",
        "course", "bearing", "gpsheading"}},
      {"vx",
       {"vxmps", "vx", "velx", "speedx", "vxms", "vxkmh", "velocityx", "speed", "speedmps", "groundspeed", "gpsspeed",
        "v", "velocity", "vehiclespeed", "vmps", "speedkn", "speedkts", "speedknots"}},
      {"vy", {"vymps", "vy", "vely", "speedy", "vyms", "vykmh", "velocityy", "lateralvelocity"}},
      {"yaw_rate",
       {"yawrateradps", "yawrate", "yawratedegps", "gyroz", "gyroyawvelocity", "rotz", "zrateofrotation", "omega",
        "omegaz", "angularvelocityz", "r", "psidot", "imuyawrateradps"}},
      {"d", {"d", "throttlebrake", "pedal", "duty", "motor"}},
      {"throttle",
       {"throttlenorm", "throttlepct", "throttle", "throttlepos", "throttleposition", "accelerator", "acceleratorpos",
        "aps", "tps", "throttlecmd", "gas"}},
      {"brake",
       {"brakenorm", "brakepct", "brake", "brakekpa", "brakepres", "brakepressure", "brakepresfront",
        "brakepressurefront", "brakepos", "brakecmd"}},
      {"delta",
       {"deltarad", "delta", "steerrad", "steer", "steering", "steeringangle", "steeredangle", "steercmd",
        "steercmdnorm", "steernorm", "steerangle", "roadwheelangle", "wheelangle", "steeringrad", "deltadeg"}},
      {"steering_wheel",
       {"steeringwheelangle", "steeringwheel", "steerwheelangle", "swa", "handwheelangle", "handwheel"}},
      {"latitude", {"latitude", "lat", "gpslatitude", "latitudedeg"}},
      {"longitude", {"longitude", "lon", "long", "gpslongitude", "longitudedeg", "lng"}},
      {"enable", {"driveenabled", "enable", "enabled", "motorenabled", "deadman", "autonomous"}},
      {"valid", {"posevalid", "valid", "gpsvalid", "fixvalid"}}};
  return all;
}

std::string plain(std::string_view name) {
  std::string out;
  for (const unsigned char c : name)
    if (std::isalnum(c) != 0) out += static_cast<char>(std::tolower(c));
  return out;
}

double quantile_of_size(const Values& values, double q) {
  Values sizes;
  for (const double v : values)
    if (!std::isnan(v)) sizes.push_back(std::abs(v));
  return lower_quantile(std::move(sizes), q, 0.0);
}

class Guesser {
 public:
  explicit Guesser(const DelimitedTable& table) : table_(table) {}

  Guess run() {
    time();
    for (const char* name : {"x", "y"}) simple(name, "m");
    if (!found("x") || !found("y")) degrees();
    yaw();
    for (const char* name : {"vx", "vy"}) simple(name, "m/s");
    speed_unit();
    yaw_rate();
    pedals();
    steering();
    name_what_is_missing();
    Node map = Node::empty_object();
    map.set("note", Node("A first guess from names, units and numbers. Read every line; units and signs are checked "
                         "when the log is read."));
    map.set("time", time_);
    map.set("channels", channels_);
    if (const int valid = column("valid"); valid >= 0) map.set("valid", Node(quoted(valid) + " > 0.5"));
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
    for (const Names& names : known_names()) {
      if (std::string_view(names.channel) != channel) continue;
      for (const char* word : names.words)
        for (std::size_t c = 0; c < table_.name.size(); ++c)
          if (is_called(known_as(c), word) && quantile_of_size(table_.column[c], 1.0) > 0.0) return static_cast<int>(c);
    }
    return -1;
  }
  /// By its whole name, or by what stands before a slash in it: "Latitude / Y Position".
  static bool is_called(std::string_view name, const char* word) {
    return plain(name) == word || plain(name.substr(0, name.find(" / "))) == word;
  }
  /// Columns that vary and no channel has taken, each with its range; `rising`: those that never fall.
  std::string candidates(bool rising) const {
    constexpr std::size_t most = 12;
    std::string all;
    std::size_t shown = 0;
    for (std::size_t c = 0; c < table_.name.size(); ++c) {
      double low = INFINITY, high = -INFINITY, last = -INFINITY;
      bool falls = false;
      for (const double v : table_.column[c]) {
        if (!std::isfinite(v)) continue;
        falls = falls || v < last;
        last = v;
        low = std::min(low, v), high = std::max(high, v);
      }
      if (!(high > low) || taken(static_cast<int>(c)) || (rising && falls)) continue;
      if (++shown > most) continue;
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

  /// The unit in the header, or in the name's ending, if it is one of the kind wanted.
  std::string unit_of(int c, const char* wanted) {
    const std::string& written = table_.unit[static_cast<std::size_t>(c)];
    std::vector<std::string> tries = {written};
    const std::string p = plain(known_as(static_cast<std::size_t>(c)));
    for (const auto& [ending, unit] : {std::pair("kmh", "km/h"),
                                       {"mph", "mph"},
                                       {"knots", "kn"},
                                       {"kts", "kn"},
                                       {"kn", "kn"},
                                       {"mmps", "mm/s"},
                                       {"degps", "deg/s"},
                                       {"deg", "deg"},
                                       {"ms", "ms"},
                                       {"mm", "mm"},
                                       {"cm", "cm"}})
      if (p.ends_with(ending)) tries.emplace_back(unit);
    for (const std::string& unit : tries)
      if (std::string known = header_unit(unit, wanted); !known.empty()) return known;
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

  void time() {
    const int c = column("time");
    if (c < 0) return;
    std::string unit = unit_of(c, "s");
    Values steps;
    const Values& t = values(c);
    for (std::size_t i = 1; i < t.size(); ++i)
      if (t[i] > t[i - 1]) steps.push_back(t[i] - t[i - 1]);
    const double step = quantile_of_size(steps, 0.5);
    for (const auto& [name_of, factor] : {std::pair("ms", 1e3), {"us", 1e6}, {"ns", 1e9}})
      if (!table_.is_clock(static_cast<std::size_t>(c)) && unit == "s" && step > 0.9e-3 * factor &&
          step < 0.3 * factor && step > 0.9) {
        unit = name_of;
        remarks_.push_back("time: steps of " + significant(step) + ", taken for " + name_of);
      }
    time_ = channel("column", name(c), unit, false);
  }

  void simple(const char* which, const char* unit) {
    if (const int c = column(which); c >= 0) channels_.set(which, channel("column", name(c), unit_of(c, unit)));
  }

  void degrees() {
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
  /// Way from row to row [m], for comparisons with headings and speeds.
  bool way(const PlaceColumns& place, std::size_t i, double& dx, double& dy) const {
    if (place.x != nullptr) {
      dx = place.metres * ((*place.x)[i + lag] - (*place.x)[i]);
      dy = place.metres * ((*place.y)[i + lag] - (*place.y)[i]);
    } else if (lat_ >= 0) {
      constexpr double metres = 111195.0;  // per degree
      dx = metres * std::cos(values(lat_)[i] * pi / 180) * (values(lon_)[i + lag] - values(lon_)[i]);
      dy = metres * (values(lat_)[i + lag] - values(lat_)[i]);
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
  };
  AgainstPath against_path(int c, double factor) const {
    AgainstPath sum;
    const PlaceColumns place = place_columns();
    double dx = 0, dy = 0;
    for (std::size_t i = 0; i + lag < table_.rows(); i += lag)
      if (way(place, i, dx, dy) && std::isfinite(values(c)[i])) {
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
  void yaw() {
    const int c = column("yaw");
    if (c < 0) return;
    const bool deg = is_in_degrees(c);
    const std::string angle = deg ? "rad(" + quoted(c) + ")" : quoted(c);
    const auto [s, co, ms, mc, n] = against_path(c, deg ? pi / 180 : 1.0);
    std::string formula = angle;
    if (n > 20) {
      const bool compass = std::hypot(ms, mc) > std::hypot(s, co);
      const double offset = compass ? std::atan2(ms, mc) : std::atan2(s, co);
      const double quarter = std::round(offset / (pi / 2)) * (pi / 2);
      const std::string add = quarter == 0 ? "" : std::abs(quarter) > 3 ? "pi" : quarter > 0 ? "pi/2" : "-pi/2";
      if (compass)
        formula = (add.empty() ? "-" : add + " - ") + angle;
      else if (!add.empty())
        formula = angle + " + " + add;
      if (formula != angle)
        remarks_.push_back("yaw: " + name(c) + (compass ? " counts clockwise" : " is turned") + " against the path");
      if (std::hypot(compass ? ms : s, compass ? mc : co) < 0.8 * n)
        remarks_.push_back("yaw: " + name(c) + " follows the path badly; is it the heading?");
    }
    channels_.set("yaw", formula == quoted(c) && !deg ? channel("column", name(c), "rad")
                         : formula == angle && deg    ? channel("column", name(c), "deg")
                                                      : channel("formula", formula, "rad"));
  }

  /// A speed without a unit, against the path.
  void speed_unit() {
    const int c = column("vx"), t = column("time");
    if (c < 0 || t < 0 || !table_.unit[static_cast<std::size_t>(c)].empty()) return;
    const double second = to_si("1 " + time_.find("unit")->text(), "s");
    Values ratios;
    const PlaceColumns place = place_columns();
    double dx = 0, dy = 0;
    const double enough = 0.3 * quantile_of_size(values(c), 0.95);
    for (std::size_t i = 0; i + lag < table_.rows(); i += lag)
      if (way(place, i, dx, dy) && std::abs(values(c)[i]) > enough)
        ratios.push_back(values(c)[i] / (std::hypot(dx, dy) / (second * (values(t)[i + lag] - values(t)[i]))));
    if (ratios.size() < 20) return;
    const double ratio = quantile_of_size(ratios, 0.5);
    for (const auto& [unit, low, high] :
         {std::tuple("km/h", 3.45, 3.8), {"ft/s", 3.1, 3.42}, {"mph", 2.1, 2.4}, {"kn", 1.85, 2.05}})
      if (ratio > low && ratio < high) {
        channels_.set("vx", channel("column", name(c), unit));
        remarks_.push_back(std::string("vx: ") + significant(ratio) + " times the speed of the path, taken for " +
                           unit);
        return;
      }
    const Node* const unit = channels_.find("vx")->find("unit");
    if (unit->text() == "m/s" && !(ratio > 0.6 && ratio < 1.6))
      remarks_.push_back("vx: " + significant(ratio) + " times the speed of the path; its unit is not told by that");
  }

  void yaw_rate() {
    const int c = column("yaw_rate");
    if (c < 0) return;
    std::string unit = unit_of(c, "rad/s");
    if (unit == "rad/s" && table_.unit[static_cast<std::size_t>(c)].empty() && quantile_of_size(values(c), 0.98) > 12) {
      unit = "deg/s";
      remarks_.push_back("yaw_rate: values of " + significant(quantile_of_size(values(c), 0.98)) + ", taken for deg/s");
    }
    channels_.set("yaw_rate", channel("column", name(c), unit));
  }

  /// What makes a pedal's column run from 0 to 1.
  std::string share(int c) {
    const double most = quantile_of_size(values(c), 1.0);
    if (most <= 1.2) return quoted(c);
    if (most <= 110) return quoted(c) + " / 100";
    remarks_.push_back(name(c) + ": divided by its largest value in this log, " + significant(most, 5));
    return quoted(c) + " / " + significant(most, 5);
  }

  void pedals() {
    const int d = column("d"), throttle = column("throttle"), brake = column("brake"), enable = column("enable");
    std::string formula;
    if (d >= 0)
      formula = share(d);
    else if (throttle >= 0)
      formula = share(throttle) + (brake >= 0 ? " - " + share(brake) : "");
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
    channels_.set("d", std::move(node));
  }

  /// Steering that runs from -1 to 1: by its name or unit, or by its range where nothing calls it an angle.
  bool is_share_of_lock(int c, double most) const {
    const std::string called = plain(known_as(static_cast<std::size_t>(c)));
    const std::string unit = plain(table_.unit[static_cast<std::size_t>(c)]);
    const auto calls = [&](const char* word) { return called.find(word) != std::string::npos; };
    if (calls("norm") || unit.starts_with("norm")) return true;
    const bool an_angle = calls("angle") || calls("rad") || calls("deg") || calls("delta");
    return (unit == "1" || (unit.empty() && !an_angle)) && most > 0.7 && most < 1.05;
  }

  void steering() {
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
    }
    Node node =
        formula == quoted(c) ? channel("column", name(c), unit, false) : channel("formula", formula, unit, false);
    node.set("kind", Node("command"));
    if (turns_against(c)) {
      node.set("sign", Node(-1.0));
      remarks_.push_back("delta: positive to the right; its sign is turned");
    }
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

  static constexpr std::size_t lag = 10;  // rows
  const DelimitedTable& table_;
  int lat_ = -1, lon_ = -1;
  Node time_, channels_{Node::Object{}};
  std::vector<std::string> remarks_, open_;
};

}  // namespace

Guess guess_map(const DelimitedTable& table) { return Guesser(table).run(); }

bool is_channel_name(std::string_view name) {
  const std::string wanted = plain(name);
  return std::any_of(known_names().begin(), known_names().end(), [&](const Names& names) {
    return std::string_view(names.channel) != "time" &&
           std::find(names.words.begin(), names.words.end(), wanted) != names.words.end();
  });
}

}  // namespace gripline::measured
