// The line along which a lap is optimised: the minimum-curvature line, with how far the edges are on its normals.
#pragma once

#include <vector>

#include <gripline/interfaces.hpp>

#include "common/planning/closed_line.hpp"
#include "planners/time_optimal/lap_solver.hpp"

namespace gripline::time_optimal {

/// Nodes of the program on the base line.
struct LapNodes {
  std::vector<double> s;               // station on the base line [m]
  std::vector<double> n_lo, n_hi;      // where the normal leaves the road, shrunk by the margin [m]
  std::vector<double> mid_lo, mid_hi;  // the same half-way to the next node
  std::vector<double> ds;              // to the next node [m]
  std::vector<LapPlace> places;        // between them
};

/// `count` nodes, closer to each other where `speed` (at the samples of `base`) is low: half evenly by way, half by
/// time. The edges are where the signed distance from the centre line reaches the half width less `margin`.
LapNodes place_nodes(const planning::ClosedLine& base, const std::vector<double>& speed, const Course& course,
                     double margin, std::size_t count);

}  // namespace gripline::time_optimal
