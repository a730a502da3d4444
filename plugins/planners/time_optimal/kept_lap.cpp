#include "planners/time_optimal/kept_lap.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <initializer_list>

#include "planners/time_optimal/lap_dynamics.hpp"

namespace gripline::time_optimal {
namespace {

/// Friction over that which was solved for, where it is less.
double share_of(double solved_for, double mu) { return std::min(1.0, mu / std::max(solved_for, 1e-6)); }

}  // namespace

KeptLap::KeptLap(const LapSetup& setup, const AxleTyres& tyres)
    : nodes_(setup.nodes().s.size()),
      solved_for_(nodes_.size(), mu_of(tyres)),
      first_lap_(setup.cold_guess(tyres).z),
      first_mu_(mu_of(tyres)) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) nodes_[i].z = first_lap_[i];
}

KeptLap::States KeptLap::at_share(States z, double share, Inputs inputs) {
  const double slower = std::sqrt(share);
  for (const std::size_t j : {lap_vx, lap_vy, lap_omega}) z[j] *= slower;
  if (inputs != Inputs::none) z[lap_a] *= share;
  if (inputs == Inputs::all) z[lap_rate] *= slower;
  return z;
}

KeptLap::States KeptLap::slowed(std::size_t node, double mu) const {
  return at_share(nodes_[node].z, share_of(solved_for_[node], mu));
}

void KeptLap::slow_down(std::size_t node, double mu) {
  if (mu >= 0.97 * solved_for_[node]) return;
  nodes_[node].z = at_share(nodes_[node].z, share_of(solved_for_[node], mu), Inputs::acceleration);
  solved_for_[node] = mu;
}

void KeptLap::scale(std::size_t i, double share, double mu) {
  const double slower = std::sqrt(share);
  WindowNode& node = nodes_[i];
  node.z = at_share(node.z, share, Inputs::all);
  // Time per typical size: of ways and angles it grows as time does, of speeds once more.
  for (const std::size_t j : {lap_n, lap_xi, lap_delta}) node.pi[j] /= slower;
  for (const std::size_t j : {lap_vx, lap_vy, lap_omega}) node.pi[j] /= share;
  solved_for_[i] = std::min(solved_for_[i], mu);
}

void KeptLap::remember() {
  for (std::size_t i = 0; i < nodes_.size(); ++i) first_lap_[i] = nodes_[i].z;
}

void KeptLap::reset(std::size_t i, double mu) {
  nodes_[i].started = false;
  nodes_[i].pi = {};
  nodes_[i].z = at_share(first_lap_[i], share_of(first_mu_, mu));
  solved_for_[i] = std::min(first_mu_, mu);
}

}  // namespace gripline::time_optimal
