// Nodes of a lap on the centre line, and a lap on them.
#pragma once

#include <array>
#include <vector>

#include "car/staged_car.hpp"
#include "geometry/track.hpp"

namespace gripline {

/// Interval k leads from node k to node k + 1, the last back to node 0.
struct LapMesh {
  std::vector<double> s;               ///< [m] stations of the nodes
  std::vector<double> ds;              ///< [m] lengths of the intervals
  std::vector<double> kappa;           ///< [1/m] of the centre line, mean over each interval
  std::vector<double> n_lo, n_hi;      ///< [m] edges at the nodes
  std::vector<double> mid_lo, mid_hi;  ///< [m] edges half-way through the intervals
  std::vector<Place> places;           ///< half-way through the intervals
  std::size_t size() const { return s.size(); }
};

/// A mesh with its nodes at these stations, ascending in [0, length).
LapMesh make_mesh(const Track& track, std::vector<double> stations);
/// The same with every interval halved.
LapMesh halved(const Track& track, const LapMesh& mesh);

/// Variables of a node: state there, and the commands of the interval that begins there.
enum LapVariable : int { lap_n, lap_xi, lap_vx, lap_vy, lap_omega, lap_delta, lap_d, lap_rate };
inline constexpr int lap_states = 6, lap_variables = 8;

struct Lap {
  std::vector<std::array<double, lap_variables>> z;
  double time = 0;  ///< [s]
  bool solved = false;
};
/// The lap as a guess on the halved mesh.
Lap halved(const Lap& lap);

}  // namespace gripline
