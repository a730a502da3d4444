// What loggers call the columns of a log, and the units that such names end with.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace gripline {

/// In lower case, without blanks and signs.
std::string plain_name(std::string_view name);

/// Plain names of a channel, best first; beside those of logs ("vx") also "time", "throttle", "brake",
/// "steering_wheel", "latitude", "longitude", "enable" and "valid".
std::span<const char* const> names_of(std::string_view channel);
/// A unit of the kind that a channel's names may end with; null where they end with none.
const char* unit_kind(std::string_view channel);
/// Whether a column is called `word` (plain): by its whole name, or by what stands before a slash in it, "Latitude /
/// Y Position", or with a unit of this kind at its end, "speed_kmh"; null: without a unit.
bool is_called(std::string_view name, std::string_view word, const char* kind);
/// Whether the last words of a path as ROS writes them, "pose.position.x" or "/car/cmd/steering_angle", are called
/// `word`: several of them together ("position.x"), or the last alone, unless it is a letter, a unit or a word of many
/// meanings, or the words before it make it another thing ("accel.lat", "motor.speed").
bool is_called_in_path(std::string_view name, std::string_view word, const char* kind);
/// Whether a path says that it is what the car was told, "cmd_vel.linear.x".
bool is_path_of_command(std::string_view name);
/// Whether a column of this name is the course of the velocity, not the heading: they differ by the sideslip.
bool is_called_course(std::string_view name);
/// The unit that a name ends with, if it is one of this kind and not all of the name; else "".
std::string unit_at_end(std::string_view name, const char* kind);
/// The unit of this kind that is all that stands in a name behind a (plain) word by which it is called, "cm" in
/// "width_left_cm"; else "". "left" has none: unit_at_end takes its end for feet.
std::string unit_behind(std::string_view name, std::string_view word, const char* kind);

/// Whether a column of this name would be looked at for a channel (not for the time).
bool is_channel_name(std::string_view name);

}  // namespace gripline
