#include "measured/session/guess_commands.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "config/units.hpp"
#include "measured/readings/unit_checks.hpp"
#include "measured/session/guess_heading.hpp"
#include "measured/session/session_windows.hpp"
#include "tables/column_names.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {
namespace {

using std::numbers::pi;
using Values = std::vector<double>;

class CommandGuess {
 public:
  explicit CommandGuess(GuessDraft& draft) : draft_(draft) {}

  void run() {
    guess_throttle();
    guess_steering();
  }

 private:
  /// Whether the logger repeats a command until there is a new one.
  bool is_repeated(int c) {
    const double every = draft_.rows_between_new_values(c);
    if (!(every > 1.0)) return false;
    draft_.remarks.push_back(
        draft_.name(c) + ": a new value every " + significant(every) +
        " rows; taken for a command that is held until the next one (\"every\" in place of \"hold\" "
        "where the car's own moves in between)");
    return true;
  }

  /// What a pedal's column is divided by to run from 0 to 1.
  struct PedalShare {
    std::string formula, remark;
    bool in_doubt = false;
  };
  /// By its unit, its name and, where neither says it, its size. A brake of up to 60 may be a pressure as well.
  PedalShare pedal_share(int c, bool brake) const {
    const std::string column = draft_.quoted(c), name = draft_.name(c);
    const std::string& unit = draft_.table.unit[static_cast<std::size_t>(c)];
    const double most = quantile_of_size(draft_.values(c), 1.0);
    const std::string size = significant(most, 5);
    const std::string as_pressure = column + " / " + size;
    const bool pressure = !header_unit(unit, "N/m2").empty();
    if (!pressure && is_percentage(c)) return {column + " / 100", {}};
    if (!pressure && most <= 1.2) return {column, {}};
    const bool share = unit.empty() || !header_unit(unit, "1").empty();
    if (pressure || !share || most > most_percent || is_called_pressure(c))
      return {as_pressure, name + ": divided by its largest value in this log, " + size};
    if (most >= least_full) return {column + " / 100", {}};
    const std::string without = name + ": up to " + size + " without a unit";
    if (!brake) return {column + " / 100", without + ", taken for per cent"};
    return {as_pressure,
            without + " may be per cent or a pressure: divided by its largest value in this log; write \"" + column +
                " / 100\" if it is per cent",
            true};
  }
  bool is_percentage(int c) const {
    const std::string& unit = draft_.table.unit[static_cast<std::size_t>(c)];
    const std::string plain = plain_name(unit);
    return header_unit(unit, "1") == "%" || plain.starts_with("perc") || plain == "pct" ||
           (unit.empty() && draft_.unit_of_name(c, "1") == "%");
  }
  bool is_called_pressure(int c) const {
    const std::string called = plain_name(draft_.known_as(static_cast<std::size_t>(c)));
    const auto ends = [&](const char* unit) { return called.ends_with(unit); };
    return called.find("pres") != std::string::npos || called.find("druck") != std::string::npos || ends("bar") ||
           ends("kpa") || ends("psi");
  }
  /// The formula, with what is to be said of it; `doubt`: what is to stand in the map too.
  std::string stated_pedal_share(int c, bool brake, std::string* doubt = nullptr) {
    PedalShare share = pedal_share(c, brake);
    if (!share.remark.empty()) draft_.remarks.push_back(share.remark);
    if (share.in_doubt && doubt != nullptr) *doubt = share.remark;
    return share.formula;
  }

  /// Throttle and brake as one channel, d.
  void guess_throttle() {
    const int d = draft_.column("d"), throttle = draft_.column("throttle"), brake = draft_.column("brake"),
              enable = draft_.column("enable");
    std::string formula, doubt;
    if (d >= 0)
      formula = stated_pedal_share(d, false);
    else if (throttle >= 0)
      formula = stated_pedal_share(throttle, false);
    if (d < 0 && throttle >= 0 && brake >= 0) formula += " - " + stated_pedal_share(brake, true, &doubt);
    if (formula.empty()) {
      draft_.remarks.push_back("d: no throttle found: vx will be taken from the log and the lateral motion judged");
      return;
    }
    if (enable >= 0) {
      // A switch stays where it is until it is read again.
      const bool gaps = std::ranges::any_of(draft_.values(enable), [](double v) { return std::isnan(v); });
      const std::string enabled = gaps ? "hold(" + draft_.quoted(enable) + ")" : draft_.quoted(enable);
      formula = "if(" + enabled + " > 0.5, " + formula + ", 0)";
      draft_.remarks.push_back("d: " + draft_.name(enable) + " taken for a switch of the drive");
    }
    Node node = guessed_channel("formula", formula, "1", false);
    node.set("kind", Node("command"));
    if (!doubt.empty()) node.set("note", Node(doubt));
    if (is_repeated(d >= 0 ? d : throttle)) node.set("hold", Node("held"));
    draft_.channels.set("d", std::move(node));
    if (d < 0 && brake < 0) name_brake(pedal_share(throttle, false).formula);
  }

  /// A brake by a name that no list has: in a map without it, the car would brake unasked.
  void name_brake(const std::string& throttle) {
    for (std::size_t c = 0; c < draft_.table.name.size(); ++c)
      for (const char* part : {"brake", "brems", "frein", "freno", "freio"})
        if (plain_name(draft_.known_as(c)).find(part) != std::string::npos && draft_.varies(c)) {
          const int column = static_cast<int>(c);
          draft_.remarks.push_back("d: " + draft_.name(column) +
                                   " looks like a brake and is not used; write \"formula\": \"" + throttle + " - " +
                                   pedal_share(column, true).formula + "\" if it is one");
          return;
        }
  }

  /// Steering that runs from -1 to 1: by its name or unit, or by its range where nothing calls it an angle.
  bool is_share_of_lock(int c, double most) const {
    const std::string called = plain_name(draft_.known_as(static_cast<std::size_t>(c)));
    const std::string unit = plain_name(draft_.table.unit[static_cast<std::size_t>(c)]);
    const auto calls = [&](const char* word) { return called.find(word) != std::string::npos; };
    if (calls("norm") || unit.starts_with("norm")) return true;
    const bool an_angle = calls("angle") || calls("rad") || calls("deg") || calls("delta");
    return (unit == "1" || (unit.empty() && !an_angle)) && most > 0.7 && most < 1.05;
  }

  /// By its name; "steering angle" may be the steering wheel's.
  bool is_of_road_wheels(int c) const {
    const std::string called = plain_name(draft_.known_as(static_cast<std::size_t>(c)));
    return called.find("delta") != std::string::npos || called.find("road") != std::string::npos;
  }

  void guess_steering() {
    const int angle = draft_.column("delta"), c = angle < 0 ? draft_.column("steering_wheel") : angle;
    if (c < 0) return;
    std::string unit = draft_.unit_of(c, "rad");
    const double most = quantile_of_size(draft_.values(c), 0.99);
    if (unit == "rad" && most > most_steering) {
      unit = "deg";
      draft_.remarks.push_back("delta: values of " + significant(most) + ", taken for degrees");
    }
    const double radians = most * (unit == "deg" ? pi / 180 : 1.0);
    std::string formula = draft_.quoted(c);
    if (angle >= 0 && is_share_of_lock(c, most)) {
      draft_.remarks.push_back(
          "delta: " + draft_.name(c) + " (up to " + significant(most) +
          ") is not an angle but a share of full lock; write \"formula\": \"" + draft_.quoted(c) +
          " * LOCK\" with the front wheels' angle at full lock [rad]; until then it is taken as rad at "
          "full lock 1, which a fitted steer_map puts right");
    } else if (radians > 0.7 || angle < 0) {
      draft_.remarks.push_back(
          "delta: " + (angle < 0 ? draft_.name(c) : significant(radians * 180 / pi) + " deg") +
          " is the steering wheel's: divided by 15, a guess of the steering ratio; write the car's own");
      formula += " / 15";
    } else if (!is_of_road_wheels(c)) {
      draft_.remarks.push_back("delta: " + draft_.name(c) + " is taken for the front wheels' angle (up to " +
                               significant(radians * 180 / pi) +
                               " deg); if it is the steering wheel's, write \"formula\": \"" + draft_.quoted(c) +
                               " / RATIO\"");
    }
    Node node = formula == draft_.quoted(c) ? guessed_channel("column", draft_.name(c), unit, false)
                                            : guessed_channel("formula", formula, unit, false);
    node.set("kind", Node("command"));
    if (turns_against(c)) {
      node.set("sign", Node(-1.0));
      draft_.remarks.push_back("delta: positive to the right; its sign is turned");
    }
    if (is_repeated(c)) node.set("hold", Node("held"));
    draft_.channels.set("delta", std::move(node));
  }

  /// Whether the steering is positive to the right, as the yaw rate shows, or where there is none, the heading.
  bool turns_against(int c) const {
    const bool by_rate = draft_.found("yaw_rate") && draft_.column("yaw_rate") >= 0;
    return (by_rate ? steering_and_yaw_rate(c) : heading_follows(draft_, c)).value() < -0.3;
  }
  Correlation steering_and_yaw_rate(int c) const {
    const Values &steering = draft_.values(c), &rate = draft_.values(draft_.column("yaw_rate"));
    const double sign = draft_.channels.find("yaw_rate")->find("sign") != nullptr ? -1.0 : 1.0;
    Correlation out;
    for (std::size_t i = 0; i < draft_.table.rows(); ++i)
      if (!std::isnan(steering[i] + rate[i])) out.add(steering[i], sign * rate[i]);
    return out;
  }
  static constexpr double least_full = 90.0, most_percent = 110.0;  // a pedal's largest value in per cent
  GuessDraft& draft_;
};

}  // namespace

void guess_commands(GuessDraft& draft) { CommandGuess(draft).run(); }

}  // namespace gripline::measured
