#include "geometry/corner_room.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/racing_line.hpp"

namespace gripline {
namespace {

/// One place of a lap: the centre of gravity, heading [rad] and curvature [1/m] of its path, station of the road.
struct LapPlace {
  double x, y, yaw, kappa, s;
};

/// How far the corners of a car come beyond the edges on a lap.
struct CornersOfLap {
  FarthestCorner farthest{-INFINITY, 0.0};
  double beyond_left = -INFINITY, beyond_right = -INFINITY;  // [m]
};

/// Rolling without slip, the rear axle follows the car's heading, which is not that of the centre of gravity's path.
void take_corners(const Track& track, const Car& car, const LapPlace& at, CornersOfLap& lap) {
  const double yaw = at.yaw - std::asin(std::clamp(car.lr * at.kappa, -1.0, 1.0));
  const double c = std::cos(yaw), s = std::sin(yaw);
  for (const double forward : {-0.5 * car.length, 0.5 * car.length}) {
    for (const double left : {-0.5 * car.width, 0.5 * car.width}) {
      const CurveLocation corner = track.locate(at.x + forward * c - left * s, at.y + forward * s + left * c, at.s);
      const double beyond = track.beyond_edge(corner);
      double& on_its_side = corner.n >= 0.0 ? lap.beyond_left : lap.beyond_right;
      on_its_side = std::max(on_its_side, beyond);
      if (beyond > lap.farthest.beyond) lap.farthest = {beyond, at.s};
    }
  }
}

FarthestCorner along_centre(const Track& track, const Car& car, double least_radius) {
  CornersOfLap lap;
  const auto count = static_cast<int>(std::clamp(track.length() / (0.25 * car.length), 100.0, 100000.0));
  for (int i = 0; i < count; ++i) {
    const CurvePoint at = track.at(track.length() * i / count);
    if (std::abs(at.kappa) * least_radius > 1.0) return {INFINITY, at.s};
    take_corners(track, car, {at.x, at.y, at.yaw, at.kappa, at.s}, lap);
  }
  return lap.farthest;
}

CornersOfLap along_line(const Track& track, const Car& car, const RacingLine& line) {
  CornersOfLap lap;
  for (const RacingLineSample& at : line.samples)
    take_corners(track, car, {at.x, at.y, at.yaw, at.kappa, at.centre_s}, lap);
  return lap;
}

}  // namespace

FarthestCorner farthest_corner(const Track& track, const Car& car) {
  constexpr int most_lines = 4;
  constexpr double slides = 0.95;    // of the least radius, as check_car_turns accepts
  constexpr double beyond_by = 1.5;  // a margin of what was lacking moves corners by less than itself
  const double least_radius = least_turning_radius(car);
  FarthestCorner best = along_centre(track, car, least_radius);
  double left = 0.0, right = 0.0;  // margins to the edges: one is no reason to keep away from the other
  for (int i = 0; i < most_lines && best.beyond > 0.0; ++i) {
    try {
      const RacingLine line = minimum_curvature_line(
          track,
          {.car_width = car.width, .margin_left = left, .margin_right = right, .max_curvature = 0.98 / least_radius});
      if (i > 0 && line.largest_curvature * slides * least_radius > 1.0) break;
      const CornersOfLap found = along_line(track, car, line);
      if (found.farthest.beyond < best.beyond) best = found.farthest;
      left += beyond_by * std::max(0.0, found.beyond_left);
      right += beyond_by * std::max(0.0, found.beyond_right);
    } catch (const GeometryError&) {
      if (i == 0) throw;
      break;  // no room for such margins
    }
  }
  return best;
}

}  // namespace gripline
