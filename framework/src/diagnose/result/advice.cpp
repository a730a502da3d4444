#include "diagnose/result/advice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {
namespace {

struct Separation {
  std::vector<std::string> among;  // at least two of these are in question
  const char* drive;
};

const std::vector<Separation>& separations() {
  static const std::vector<Separation> all = {
      {{"aero_drag", "rolling_res"}, "coast down from top speed to half of it on a level straight"},
      {{"rolling_res", "aero_drag", "grade", "drive_gain"},
       "drive the same lap in the other direction, and coast down once"},
      {{"drive_gain", "back_emf", "aero_drag"}, "full throttle from a quarter of top speed to top speed"},
      {{"friction_scale", "downforce", "friction_drift"},
       "the same corner at the limit slowly and fast, early and late"},
      {{"front_grip", "front_stiff", "rear_grip", "rear_stiff"}, "a slow ramp of steering into saturation, twice"},
      {{"front_grip", "rear_grip", "diff_yaw", "torque_vec", "load_transfer", "comb_slip"},
       "power on and lift off in a steady corner, then brake in a turn"},
      {{"vx_bias", "vx_scale"}, "two straights at constant speeds a factor of two apart"},
      {{"input_delay", "steer_lag", "yaw_inertia", "relaxation", "sensor_latency"},
       "a steering chirp up to 3 Hz at two speeds"},
      {{"motor_lag", "input_delay"}, "steps of throttle on a straight"},
      {{"wind", "plane_tilt", "grade", "bank"}, "drive the same lap in the other direction"},
      {{"brake_fade", "brake_gain"}, "brake hard ten times in a row, then once after a minute"},
      {{"friction_patch", "bank", "grade"}, "the same place at two speeds, for three laps or more"},
  };
  return all;
}

std::string number(double value) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.3g", value);
  return buffer;
}

std::string list(const Diagnosis& d) {
  std::string text;
  for (const NamedEffect& n : d.named) {
    text += (text.empty() ? "" : " and ") + n.effect;
    if (n.params.size() > 3) continue;
    std::string sizes;
    for (const NamedEffect::Value& v : n.params)
      sizes += (sizes.empty() ? " (" : ", ") + v.name + " = " + number(v.value) + (v.unit == "1" ? "" : " " + v.unit);
    text += sizes + ")";
  }
  return text;
}

std::string where_text(const BasisTest& test) {
  if (test.quantity == "noise")
    return std::string("as accelerations that look random, but in some directions only, and most by ") +
           where_names[static_cast<std::size_t>(test.where)];
  switch (test.where) {
    case Where::position:
      return "at lap fractions " + number(test.from) + " to " + number(test.to);
    case Where::time:
      if (test.quantity == "frequency") return "as an oscillation of " + number(test.from) + " Hz";
      return "between " + number(test.from) + " s and " + number(test.to) + " s";
    case Where::state:
      return "as a function of the state";
    case Where::input:
      return "as a function of the inputs";
  }
  return {};
}

}  // namespace

std::string advice(const std::vector<std::vector<std::string>>& equals) {
  // Effects that are in some of the sets only: those in all of them are not in question.
  std::set<std::string> doubtful;
  for (const auto& set : equals)
    for (const std::string& id : set)
      if (std::any_of(equals.begin(), equals.end(),
                      [&](const auto& other) { return std::find(other.begin(), other.end(), id) == other.end(); }))
        doubtful.insert(id);
  const Separation* best = nullptr;
  std::size_t most = 1;
  for (const Separation& s : separations()) {
    const auto hits = static_cast<std::size_t>(
        std::count_if(s.among.begin(), s.among.end(), [&](const std::string& id) { return doubtful.count(id) > 0; }));
    if (hits > most) {
      most = hits;
      best = &s;
    }
  }
  return best != nullptr ? best->drive
                         : "three laps or more at two different paces, and the same lap in the other direction";
}

std::string sentence(const Diagnosis& d) {
  double least = 1.0;
  for (const NamedEffect& n : d.named) least = std::min(least, n.confidence);
  const std::string gap = "; on data not fitted the 1 s prediction error goes from " + number(d.gap.before) + " to " +
                          number(d.gap.after) + " sensor standard deviations";
  switch (d.verdict) {
    case Verdict::named:
      return list(d) + (d.named.size() == 1 ? " is" : " are") + " missing, with confidence " + number(least) + gap +
             ".";
    case Verdict::nothing_missing:
      return "Nothing is missing: no effect is supported at a false-alarm level of 1 %.";
    case Verdict::indistinguishable:
      return "Something is missing, but this log cannot tell apart " + std::to_string(d.equivalent.size()) +
             " explanations, of which " + list(d) + " fits best" + gap + "; to decide, " + d.manoeuvre + ".";
    case Verdict::unknown:
      return "Something is missing that no effect of the catalogue explains; it shows " + where_text(*d.unknown) +
             (d.named.empty() ? std::string() : ", besides " + list(d)) + ".";
  }
  return {};
}

}  // namespace gripline::diagnose
