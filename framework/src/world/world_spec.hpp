// A world as JSON describes it: car, track, plant, friction, sensors, start and end.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>

#include "car/vehicle.hpp"
#include "geometry/track.hpp"
#include "world/friction.hpp"
#include "world/sensors.hpp"

namespace gripline {

/// Time-optimal flying laps [s] by friction factor, rising; for tables, never for stacks.
struct LapTable {
  std::vector<std::pair<double, double>> laps;
  double error = 0.0;  ///< [s] largest error stated with them
  /// Linear in the factor between the laps; empty beyond them, and where there are none.
  std::optional<double> at(double factor) const;
};

struct WorldSpec {
  CarFile car;
  std::shared_ptr<const Track> track;  // null where RoadRule::optional allows it
  double dt = 0.02;
  Hold hold = Hold::zoh;
  /// Either a vehicle model with effects, integrated by the framework,
  /// or a plant plugin that integrates itself (`plant` not empty).
  VehicleSpec vehicle;
  PluginSpec plant;
  Origin plant_at;  // where the one or the other is written
  FrictionSpec friction;
  SensorSpec sensors;
  Pose start;
  double start_speed = 0.1;
  int laps = 0;                    // 0: until the duration
  std::optional<double> duration;  // [s]
  double timeout = 0.0;            // [s]
  LapTable time_optimal;           // with the centre of gravity inside
  LapTable time_optimal_body;      // with the whole car inside
};

/// A race needs a road; what is only compared with logs can do without one (`track` is then null).
enum class RoadRule { required, optional };

/// What is wrong goes to errors, also a plugin that is missing (read_plugin).
WorldSpec read_world(const Node& node, const Registry& registry, Errors& errors, RoadRule road = RoadRule::required);

/// What plugins of this world are made from: its car, step and hold; without seed, road and truth.
PluginContext plugin_context(const WorldSpec& world);

/// Refuses a black box, at its place: `who` needs the equations of a vehicle model.
void require_vehicle_model(const WorldSpec& world, std::string_view who);

/// The tree of a world file with everything it names in its place, on another track if one is given. Throws InputError.
Node load_world(const std::filesystem::path& file, const std::optional<std::filesystem::path>& track = {});

/// Replaces the file names in a world (car, track, friction) by the contents of those files, so that the tree is
/// complete without them.
void inline_world_files(Node& world);

}  // namespace gripline
