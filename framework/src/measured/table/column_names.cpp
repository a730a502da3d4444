#include "measured/table/column_names.hpp"

#include <algorithm>
#include <cctype>
#include <utility>
#include <vector>

#include "config/units.hpp"

namespace gripline::measured {
namespace {

/// What loggers call a channel, best first; compared in lower case without blanks and signs.
struct Names {
  const char* channel;
  std::vector<const char*> words;
};
const std::vector<Names>& known_names() {
  static const std::vector<Names> all = {
      {"time",
       {"ts", "time", "t", "times", "timestamp", "elapsedtime", "timems", "utctime", "stamp", "logtime", "seconds",
        "datetime", "elapsed", "unixtime", "epoch", "sec", "zeit"}},
      {"x",
       {"xm", "x", "posx", "px", "xpos", "east", "xeast", "easting", "positionx", "posxm", "xmm", "utmx", "localx"}},
      {"y",
       {"ym", "y", "posy", "py", "ypos", "north", "ynorth", "northing", "positiony", "posym", "ymm", "utmy", "localy"}},
      {"yaw",
       {"yawrad", "yaw", "heading", "psi", "psirad", "theta", "yawdeg", "headingrad", "headingdeg", "yawangle",
        "course", "bearing", "gpsheading", "cog", "courseoverground", "gierwinkel"}},
      {"vx",
       {"vx", "velx", "speedx", "velocityx", "twistlinearx", "speed", "groundspeed", "gpsspeed", "v", "velocity",
        "vehiclespeed", "longitudinalvelocity", "longitudinalspeed", "vlong", "wheelspeed", "geschwindigkeit"}},
      {"vy", {"vy", "vely", "speedy", "velocityy", "lateralvelocity"}},
      {"yaw_rate",
       {"yawrateradps", "yawrate", "yawratedegps", "gyroz", "gyroyawvelocity", "rotz", "zrateofrotation", "omega",
        "omegaz", "angularvelocityz", "r", "psidot", "imuyawrateradps", "wz", "gz", "angvelz", "imugz", "gierrate"}},
      {"d", {"d", "throttlebrake", "pedal", "duty", "motor"}},
      {"throttle",
       {"throttlenorm", "throttlepct", "throttle", "throttlepos", "throttleposition", "accelerator", "acceleratorpos",
        "aps", "tps", "throttlecmd", "gas", "throttlepedal", "accelpedal", "acceleratorpedal", "gaspedal", "app",
        "fahrpedal"}},
      {"brake",
       {"brakenorm", "brakepct", "brake", "brakekpa", "brakepres", "brakepressure", "brakepresfront",
        "brakepressurefront", "brakepos", "brakecmd", "brakepedal"}},
      {"delta",
       {"deltarad", "delta", "steerrad", "steer", "steering", "steeringangle", "steeredangle", "steercmd",
        "steercmdnorm", "steernorm", "steerangle", "roadwheelangle", "wheelangle", "steeringrad", "deltadeg",
        "lenkwinkel"}},
      {"steering_wheel",
       {"steeringwheelangle", "steeringwheel", "steerwheelangle", "swa", "handwheelangle", "handwheel", "sas",
        "sasangle", "lenkradwinkel"}},
      {"latitude", {"latitude", "lat", "gpslatitude", "latitudedeg"}},
      {"longitude", {"longitude", "lon", "long", "gpslongitude", "longitudedeg", "lng"}},
      {"enable", {"driveenabled", "enable", "enabled", "motorenabled", "deadman", "autonomous"}},
      {"valid", {"posevalid", "valid", "gpsvalid", "fixvalid"}}};
  return all;
}

/// Endings of plain names by their units; of one dimension longer endings stand before those that they end with.
struct Endings {
  const char* unit;
  std::vector<std::string_view> letters;
};
const std::vector<Endings>& unit_endings() {
  static const std::vector<Endings> all = {{"km/h", {"kmph", "kmh", "kph"}},
                                           {"mph", {"mph"}},
                                           {"kn", {"knots", "kts", "kn"}},
                                           {"mm/s", {"mmps"}},
                                           {"cm/s", {"cmps"}},
                                           {"m/s", {"mps", "ms"}},
                                           {"ft/s", {"fps", "fts"}},
                                           {"rad/s", {"radpersec", "radsec", "radps", "rads"}},
                                           {"deg/s", {"degpersec", "degsec", "degps", "degs", "dps"}},
                                           {"rad", {"radians", "rad"}},
                                           {"deg", {"degrees", "degree", "deg"}},
                                           {"%", {"percent", "perc", "pct"}},
                                           {"ms", {"millis", "msec", "ms"}},
                                           {"us", {"usec", "us"}},
                                           {"ns", {"nsec", "ns"}},
                                           {"s", {"seconds", "sec", "s"}},
                                           {"mm", {"mm"}},
                                           {"cm", {"cm"}},
                                           {"km", {"km"}},
                                           {"ft", {"ft"}},
                                           {"m", {"m"}}};
  return all;
}

}  // namespace

std::span<const char* const> names_of(std::string_view channel) {
  for (const Names& names : known_names())
    if (channel == names.channel) return names.words;
  return {};
}

const char* unit_kind(std::string_view channel) {
  for (const auto& [name, unit] : {std::pair("time", "s"),
                                   {"x", "m"},
                                   {"y", "m"},
                                   {"vx", "m/s"},
                                   {"vy", "m/s"},
                                   {"yaw_rate", "rad/s"},
                                   {"d", "1"},
                                   {"throttle", "1"},
                                   {"brake", "1"}})
    if (channel == name) return unit;
  return channel == "enable" || channel == "valid" ? nullptr : "rad";
}

std::string plain_name(std::string_view name) {
  std::string out;
  for (const unsigned char c : name)
    if (std::isalnum(c) != 0) out += static_cast<char>(std::tolower(c));
  return out;
}

std::string unit_at_end(std::string_view name, const char* kind) {
  const std::string plain = plain_name(name);
  for (const Endings& endings : unit_endings())
    for (const std::string_view letters : endings.letters)
      if (plain.size() > letters.size() && plain.ends_with(letters))
        if (std::string known = header_unit(endings.unit, kind); !known.empty()) return known;
  return {};
}

bool is_called(std::string_view name, std::string_view word, const char* kind) {
  const std::string p = plain_name(name);
  if (p == word || plain_name(name.substr(0, name.find(" / "))) == word) return true;
  if (kind == nullptr || !p.starts_with(word)) return false;
  const std::string_view rest = std::string_view(p).substr(word.size());
  return std::ranges::any_of(unit_endings(), [&](const Endings& endings) {
    return std::ranges::find(endings.letters, rest) != endings.letters.end() &&
           !header_unit(endings.unit, kind).empty();
  });
}

bool is_channel_name(std::string_view name) {
  return std::ranges::any_of(known_names(), [&](const Names& names) {
    const std::string_view channel = names.channel;
    return channel != "time" && std::ranges::any_of(names.words, [&](const char* word) {
             return is_called(name, word, unit_kind(channel));
           });
  });
}

}  // namespace gripline::measured
