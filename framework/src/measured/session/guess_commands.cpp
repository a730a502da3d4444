#include "measured/session/guess_commands.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "config/units.hpp"
#include "measured/readings/held_readings.hpp"
#include "measured/readings/unit_checks.hpp"
#include "measured/session/session_windows.hpp"
#include "measured/table/column_names.hpp"
#include "measured/table/formula.hpp"
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
    if (draft_.time.is_null()) return false;
    Values t = draft_.values(draft_.column("time"));
    const double second = to_si("1 " + draft_.time.find("unit")->text(), "s");
    for (double& v : t) v *= second;
    const double every = rows_between_new(t, draft_.values(c));
    if (!(every > 1.0)) return false;
    draft_.remarks.push_back(
        draft_.name(c) + ": a new value every " + significant(every) +
        " rows; taken for a command that is held until the next one (\"every\" in place of \"hold\" "
        "where the car's own moves in between)");
    return true;
  }

  /// What makes a pedal's column run from 0 to 1.
  std::string pedal_share(int c) {
    const double most = quantile_of_size(draft_.values(c), 1.0);
    const bool pressure = !header_unit(draft_.table.unit[static_cast<std::size_t>(c)], "N/m2").empty();
    if (!pressure && most <= 1.2) return draft_.quoted(c);
    if (!pressure && most <= 110) return draft_.quoted(c) + " / 100";
    draft_.remarks.push_back(draft_.name(c) + ": divided by its largest value in this log, " + significant(most, 5));
    return draft_.quoted(c) + " / " + significant(most, 5);
  }

  /// Throttle and brake as one channel, d.
  void guess_throttle() {
    const int d = draft_.column("d"), throttle = draft_.column("throttle"), brake = draft_.column("brake"),
              enable = draft_.column("enable");
    std::string formula;
    if (d >= 0)
      formula = pedal_share(d);
    else if (throttle >= 0)
      formula = pedal_share(throttle) + (brake >= 0 ? " - " + pedal_share(brake) : "");
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
    if (is_repeated(d >= 0 ? d : throttle)) node.set("hold", Node("held"));
    draft_.channels.set("d", std::move(node));
    if (d < 0 && brake < 0) name_brake(pedal_share(throttle));
  }

  /// A brake by a name that no list has: in a map without it, the car would brake unasked.
  void name_brake(const std::string& throttle) {
    for (std::size_t c = 0; c < draft_.table.name.size(); ++c)
      for (const char* part : {"brake", "brems", "frein", "freno", "freio"})
        if (plain_name(draft_.known_as(c)).find(part) != std::string::npos && draft_.varies(c)) {
          const int column = static_cast<int>(c);
          const double most = quantile_of_size(draft_.values(column), 1.0);
          const std::string scale = most > 1.2 ? " / " + significant(most, 5) : "";
          draft_.remarks.push_back("d: " + draft_.name(column) +
                                   " looks like a brake and is not used; write \"formula\": \"" + throttle + " - " +
                                   draft_.quoted(column) + scale + "\" if it is one");
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
    return (by_rate ? steering_and_yaw_rate(c) : steering_and_heading(c)).value() < -0.3;
  }
  Correlation steering_and_yaw_rate(int c) const {
    const Values &steering = draft_.values(c), &rate = draft_.values(draft_.column("yaw_rate"));
    Correlation out;
    for (std::size_t i = 0; i < draft_.table.rows(); ++i)
      if (!std::isnan(steering[i] + rate[i])) out.add(steering[i], rate[i]);
    return out;
  }
  /// Mean steering and the heading's change per row, over so many rows that the change is more than noise.
  Correlation steering_and_heading(int c) const {
    constexpr std::size_t long_enough = 10;  // rows
    Correlation out;
    const Values &steering = draft_.values(c), yaw = heading();
    double last = not_a_number, turned = 0.0, steered = 0.0, steers = 0.0;
    std::size_t from = 0;
    for (std::size_t i = 0; i < yaw.size(); ++i) {
      if (!std::isnan(steering[i])) steered += steering[i], steers += 1.0;
      if (std::isnan(yaw[i])) continue;
      turned += std::remainder(yaw[i] - last, 2.0 * pi);
      last = yaw[i];
      if (i - from < long_enough) continue;
      if (std::isfinite(turned) && steers > 0.0) out.add(steered / steers, turned / static_cast<double>(i - from));
      from = i;
      turned = steered = steers = 0.0;
    }
    return out;
  }
  /// By row, as the map makes it [rad]; empty without one.
  Values heading() const {
    const Node* const yaw = draft_.channels.find("yaw");
    if (yaw == nullptr) return {};
    const Node* const made = yaw->find("formula");
    const Formula formula(made != nullptr ? made->text() : draft_.quoted(draft_.column("yaw")), draft_.table, "yaw");
    Values out = formula.evaluate(draft_.table, {});
    const double radian = to_si("1 " + yaw->find("unit")->text(), "rad");
    for (double& v : out) v *= radian;
    return out;
  }

  GuessDraft& draft_;
};

}  // namespace

void guess_commands(GuessDraft& draft) { CommandGuess(draft).run(); }

}  // namespace gripline::measured
