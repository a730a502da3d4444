// Roads that tests of several sources share.
#pragma once

#include <cmath>
#include <numbers>

#include "geometry/road_table.hpp"

namespace gripline::test {

/// An ellipse of 200 m by 120 m, 8 m wide on the left and 4 m on the right.
inline RoadTable ellipse() {
  RoadTable road;
  for (int i = 0; i < 160; ++i) {
    const double a = 2 * std::numbers::pi * i / 160.0;
    road.points.push_back({100 * std::cos(a), 60 * std::sin(a)});
  }
  road.right.assign(road.size(), 4.0);
  road.left.assign(road.size(), 8.0);
  return road;
}

/// A figure of eight of 300 m by 150 m that crosses itself at a right angle in the middle; its first point lies `first`
/// of 240 steps beyond there.
inline RoadTable figure_of_eight(double half_width, double rise, double first = 0.5) {
  RoadTable road;
  for (int i = 0; i < 240; ++i) {
    const double a = 2 * std::numbers::pi * (i + first) / 240.0;
    road.points.push_back({150 * std::sin(a), 75 * std::sin(2 * a)});
    road.height.push_back(rise * std::cos(a));  // the two passes are at a = 0 and a = pi
  }
  road.right.assign(road.size(), half_width);
  road.left = road.right;
  return road;
}

}  // namespace gripline::test
