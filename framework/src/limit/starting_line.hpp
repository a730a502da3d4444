// Where a search for the fastest lap begins: lines along the road, driven carefully.
#pragma once

#include <string>
#include <vector>

#include "limit/lap_car.hpp"
#include "limit/lap_mesh.hpp"

namespace gripline {

/// A closed line as offsets from the centre line over its station.
struct StartingLine {
  std::string name;
  std::vector<double> s, n;  ///< [m], s rising
  double at(double station, double length) const;
};

/// The centre line, the line of least curvature, and lines that give up some of it for less length. Programs that begin
/// from different lines may end in different local optima.
std::vector<StartingLine> starting_lines(const Track& track, const Car& car);

/// Stations closer to each other where a car is slow: half evenly by way, half by time on this line.
std::vector<double> stations_on(const Track& track, const StartingLine& line, const LapCar& plant, std::size_t count);

/// The line driven at a little less than the speed that its curvature, the drive and the brakes allow.
Lap drive_along(const Track& track, const LapMesh& mesh, const StartingLine& line, const LapCar& plant);

}  // namespace gripline
