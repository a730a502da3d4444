// What surveys and loggers call the columns of a road's table.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace gripline {

/// What a column is to the road.
enum class RoadRole : std::size_t { x, y, longitude, latitude, height, right, left, width, grade, bank };
inline constexpr std::size_t road_roles = 10;

/// How a column is called as what it is to the road.
struct RoadName {
  std::size_t rank = 0;  ///< the least is the best of several names for the same
  std::string frame;     ///< the same in both names of a pair: in px and py, not in px and northing
  std::string unit;      ///< for Unit::parse; where none is stated m or deg; "" with a foreign one
  bool stated = false;   ///< the unit, in the name or beside it
  std::string foreign;   ///< the unit as it is written where it cannot be that of the role, else ""
  bool own = false;      ///< a name of gripline's own files, of which nothing is said
};

/// Whether a column with this name, and with what its header writes as its unit beside it ("": nothing), may have a
/// role; nullopt: it has not. Slopes are what they are only with their unit: an angle, or a number as % is.
std::optional<RoadName> road_name(RoadRole role, std::string_view name, std::string_view unit);

/// What a role is called in messages.
const char* what_of(RoadRole role);
/// The units of a role, for messages: "a length: m, km, cm, mm or ft".
const char* units_of(RoadRole role);

/// Whether a column of this name has some role.
bool is_road_column(std::string_view name, std::string_view unit = {});
/// Whether it would be read as a width.
bool is_road_width(std::string_view name);

}  // namespace gripline
