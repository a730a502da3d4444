// The fastest flying lap of a world at one friction factor, with or without its patches, refined until two meshes
// agree.
#pragma once

#include "limit/lap_car.hpp"
#include "limit/lap_mesh.hpp"
#include "world/world_spec.hpp"

namespace gripline {

struct LapCase {
  double factor = 1;
  bool body = false;     ///< the whole car inside the edges, not only its centre of gravity
  bool patches = false;  ///< with the patches of the world's friction
};

struct LapLimit : LapCase {
  double lap_s = 0;    ///< on the finest mesh
  double error_s = 0;  ///< difference to the mesh before
  int nodes = 0;       ///< of the finest mesh
};

/// A lap at the limit: what is kept of it, and the solution on the finest mesh.
struct FastestLap {
  LapLimit limit;
  Lap lap;
  LapMesh mesh;
};

inline constexpr double lap_limit_tolerance = 1e-3;  ///< relative difference of two meshes that is small enough

/// Solves from several lines on a coarse mesh, then halves the best one's intervals until two meshes agree. The car is
/// the world's vehicle model, or the envelope of its plant plugin (plant_envelope.hpp). Throws std::runtime_error when
/// the plant cannot be measured, no start leads to a lap, or the meshes do not agree.
FastestLap find_fastest_lap(const WorldSpec& spec, const LapCase& of);
/// find_fastest_lap() for a given car, which must have been made with the case's factor and patches.
FastestLap find_fastest_lap(const WorldSpec& spec, const LapCar& car, const LapCase& of);
/// The limit of find_fastest_lap().
LapLimit find_lap_limit(const WorldSpec& spec, const LapCase& of);

}  // namespace gripline
