// What is not known of a world, how well it is known before any log is read, and where it stands in the JSON.
//
//   "unknowns": {
//     "/plant/params/Bf": {"group": "tyres", "sigma": 0.5, "scale": "log"},
//     "/plant/effects/steer_map/params/g": {"group": "steer", "sigma": 0.2},
//     "/calibration/delays/yaw_rate": {"group": "delays", "sigma": "0.2 s"} }
//
// An effect is named by its id or by its index. "session" beside "sigma" says how far a parameter differs from one
// session to the next. The value in the world is the prior's centre, unless "prior" gives another; `sigma` its standard
// deviation, relative where the scale is "log". `low` and `high` narrow the plugin's own range.
//
//     "/calibration/delays/yaw": {"same_as": "/calibration/delays/position"}
//
// says that two parameters are one: channels of one clock, units in one box.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "calibrate/forecast/forecaster.hpp"
#include "world/world_spec.hpp"

namespace gripline::calibrate {

struct Unknown {
  /// Another parameter that has the same value always.
  struct Same {
    std::string pointer;
    std::size_t index = 0;
  };
  std::string pointer;  // as above
  std::string group;
  std::size_t index = 0;  // in the forecaster's parameters
  double prior = 0, sigma = 1;
  bool log = false;  // moves by its logarithm
  double low = 0, high = 0;
  double session = 0;  // standard deviation from session to session, as sigma; 0: the same in all
  /// Part of how predictions start rather than of the car.
  bool observer = false;
  std::vector<Same> same;
};

/// The value as a search moves it, "in its own units": the logarithm where that is asked.
inline double search_value(const Unknown& unknown, double value) { return unknown.log ? std::log(value) : value; }
/// Gives an unknown, and the parameters that are the same, a value.
void assign(std::span<double> params, const Unknown& unknown, double value);
/// Gives all parameters that are the same as an unknown its value.
void unite(std::span<double> params, std::span<const Unknown> unknowns);

/// Every parameter of a world by its pointer.
struct ParameterPlace {
  std::string pointer, unit, group;  // the group it has where "unknowns" gives none: model, a stage's name, delays...
  std::size_t index = 0;
  double low = 0, high = 0;
};
/// What is unknown of a parameter, with the bounds of its place and its prior; how well it is known is the caller's to
/// set.
Unknown unknown_at(const ParameterPlace& place, double prior);
std::vector<ParameterPlace> parameter_places(const WorldSpec& world, const Forecaster& forecaster);

/// All parameters of a forecaster as the world has them: the car's, then what "calibration" says of delays and
/// observer.
std::vector<double> parameters_of(const Node& world, const Forecaster& forecaster, Errors& errors);

/// The unknowns of a world, or, where it lists none, everything that can be a guess. Delays and the observer belong to
/// it always. `chosen`: pointers or groups to keep; empty for all. `values`: priors.
std::vector<Unknown> read_unknowns(const Node& world, std::span<const ParameterPlace> places,
                                   std::span<const double> values, std::span<const std::string> chosen, Errors& errors);

/// Writes a value where a pointer says; members on the way are made. Throws std::invalid_argument when the world lists
/// no such effect.
void set_value(Node& world, const std::string& pointer, double value);

}  // namespace gripline::calibrate
