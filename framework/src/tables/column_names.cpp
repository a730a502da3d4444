#include "tables/column_names.hpp"

#include <algorithm>
#include <cctype>
#include <initializer_list>
#include <iterator>
#include <utility>
#include <vector>

#include "config/units.hpp"

namespace gripline {
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
       {"xm", "x", "posx", "px", "xpos", "east", "xeast", "easting", "positionx", "posxm", "xmm", "utmx", "localx",
        "posex"}},
      {"y",
       {"ym", "y", "posy", "py", "ypos", "north", "ynorth", "northing", "positiony", "posym", "ymm", "utmy", "localy",
        "posey"}},
      {"yaw",
       {"yawrad", "yaw", "heading", "psi", "psirad", "theta", "yawdeg", "headingrad", "headingdeg", "yawangle",
        "gpsheading", "gierwinkel", "course", "bearing", "cog", "courseoverground", "gpscourse", "gpscog"}},
      {"vx",
       {"vx", "velx", "speedx", "velocityx", "twistlinearx", "linearvelocityx", "u", "speed", "groundspeed", "gpsspeed",
        "v", "velocity", "vehiclespeed", "longitudinalvelocity", "longitudinalspeed", "vlong", "wheelspeed",
        "geschwindigkeit"}},
      {"vy", {"vy", "vely", "speedy", "velocityy", "twistlineary", "linearvelocityy", "lateralvelocity", "v"}},
      {"yaw_rate",
       {"yawrateradps", "yawrate", "yawratedegps", "gyroz", "gyroyawvelocity", "rotz", "zrateofrotation", "omega",
        "omegaz", "angularvelocityz", "r", "psidot", "imuyawrateradps", "wz", "gz", "angvelz", "imugz", "gierrate",
        "twistangularz"}},
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
      {"latitude", {"latitude", "lat", "gpslatitude", "latitudedeg", "gpslat"}},
      {"longitude", {"longitude", "lon", "long", "gpslongitude", "longitudedeg", "lng", "gpslon", "gpslong"}},
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

/// Whether a word is a unit of this kind and nothing else.
bool is_unit(std::string_view word, const char* kind) {
  const std::string plain = plain_name(word);
  return !header_unit(word, kind).empty() || std::ranges::any_of(unit_endings(), [&](const Endings& endings) {
    return std::ranges::find(endings.letters, std::string_view(plain)) != endings.letters.end() &&
           !header_unit(endings.unit, kind).empty();
  });
}

/// The words of "pose.position.x" or "/car/speed"; of a name that is no path itself. A slash or a dot beside a blank
/// separates nothing: "Latitude / Y Position", "No. of laps".
std::vector<std::string_view> words_of_path(std::string_view name) {
  std::vector<std::string_view> words;
  std::size_t begin = 0;
  for (std::size_t i = 0; i <= name.size(); ++i) {
    const bool end = i == name.size();
    if (!end && name[i] != '.' && name[i] != '/') continue;
    if (!end && ((i > 0 && name[i - 1] == ' ') || (i + 1 < name.size() && name[i + 1] == ' '))) continue;
    if (i > begin) words.push_back(name.substr(begin, i - begin));
    begin = i + 1;
  }
  return words;
}

/// Whether a word before the last one makes it something else than a place, an angle or a motion of the car.
bool is_of_another_thing(std::string_view before, std::string_view kind) {
  const std::string plain = plain_name(before);
  const auto has = [&](const char* part) { return plain.find(part) != std::string::npos; };
  if (kind == "m" || kind == "rad")
    return has("vel") || has("speed") || has("rate") || has("gyro") || has("twist") || has("omega") || has("acc");
  if (kind == "m/s" || kind == "rad/s")
    return has("acc") || has("engine") || has("motor") || has("wheel") || has("wind");
  return false;
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

std::string unit_behind(std::string_view name, std::string_view word, const char* kind) {
  const std::string plain = plain_name(name);
  const std::size_t at = plain.rfind(word);
  if (at == std::string::npos) return {};
  const std::string_view rest = std::string_view(plain).substr(at + word.size());
  for (const Endings& endings : unit_endings())
    if (std::ranges::find(endings.letters, rest) != endings.letters.end())
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

bool is_called_in_path(std::string_view name, std::string_view word, const char* kind) {
  constexpr std::string_view of_many_meanings[] = {"pedal", "motor", "enable", "enabled", "valid", "lat", "long"};
  const std::vector<std::string_view> words = words_of_path(name);
  if (words.size() < 2) return false;
  // "stamp.sec" beside "stamp.nanosec" is not the whole time.
  if (kind != nullptr && kind == std::string_view("s") && is_unit(words.back(), kind)) return false;
  const auto from = [&](std::size_t first) {
    return name.substr(static_cast<std::size_t>(words[first].data() - name.data()));
  };
  for (std::size_t first = 1; first + 1 < words.size(); ++first)
    if (is_called(from(first), word, kind)) return true;
  if (!is_called(words.back(), word, kind) || word.size() < 2 ||
      std::ranges::find(of_many_meanings, word) != std::end(of_many_meanings))
    return false;
  if (kind == nullptr) return true;
  return !is_unit(word, kind) && std::none_of(words.begin(), words.end() - 1, [&](std::string_view before) {
    return is_of_another_thing(before, kind);
  });
}

bool is_path_of_command(std::string_view name) {
  const std::vector<std::string_view> words = words_of_path(name);
  return words.size() > 1 && std::ranges::any_of(words, [](std::string_view word) {
           const std::string plain = plain_name(word);
           if (plain == "ref" || plain == "drive") return true;  // as of ackermann_msgs
           return std::ranges::any_of(std::initializer_list<std::string_view>{"cmd", "command", "desired", "target",
                                                                              "setpoint", "reference", "goal"},
                                      [&](std::string_view start) { return plain.starts_with(start); });
         });
}

bool is_called_course(std::string_view name) {
  constexpr std::string_view words[] = {"course", "bearing", "cog", "courseoverground", "gpscourse", "gpscog"};
  return std::ranges::any_of(words, [&](std::string_view word) {
    return is_called(name, word, "rad") || is_called_in_path(name, word, "rad");
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

}  // namespace gripline
