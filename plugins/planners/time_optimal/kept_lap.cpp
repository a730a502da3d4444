#include "planners/time_optimal/kept_lap.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "planners/time_optimal/lap_dynamics.hpp"

namespace gripline::time_optimal {
namespace {

void multiply(KeptLap::States& z, std::initializer_list<LapVariable> which, double factor) {
  for (const LapVariable j : which) z[static_cast<std::size_t>(j)] *= factor;
}

}  // namespace

KeptLap::KeptLap(const LapSetup& setup, const AxleTyres& tyres)
    : nodes_(setup.nodes().s.size()),
      solved_for_(nodes_.size(), mu_of(tyres)),
      first_lap_(setup.cold_guess(tyres).z),
      first_mu_(mu_of(tyres)) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) nodes_[i].z = first_lap_[i];
}

KeptLap::States KeptLap::slowed(std::size_t node, double mu) const {
  States z = nodes_[node].z;
  multiply(z, {lap_vx, lap_vy, lap_omega}, std::min(1.0, std::sqrt(mu / std::max(solved_for_[node], 1e-6))));
  return z;
}

void KeptLap::slow_down(std::size_t node, double mu) {
  if (mu >= 0.97 * solved_for_[node]) return;
  nodes_[node].z = slowed(node, mu);
  nodes_[node].z[lap_a] *= mu / solved_for_[node];
  solved_for_[node] = mu;
}

void KeptLap::scale(std::size_t i, double share, double mu) {
  const double slower = std::sqrt(share);
  WindowNode& node = nodes_[i];
  multiply(node.z, {lap_vx, lap_vy, lap_omega, lap_rate}, slower);
  node.z[lap_a] *= share;
  // Time per typical size: of ways and angles it grows as time does, of speeds once more.
  for (const int j : {lap_n, lap_xi, lap_delta}) node.pi[static_cast<std::size_t>(j)] /= slower;
  for (const int j : {lap_vx, lap_vy, lap_omega}) node.pi[static_cast<std::size_t>(j)] /= share;
  solved_for_[i] = std::min(solved_for_[i], mu);
}

void KeptLap::remember() {
  for (std::size_t i = 0; i < nodes_.size(); ++i) first_lap_[i] = nodes_[i].z;
}

void KeptLap::reset(std::size_t i, double mu) {
  nodes_[i].started = false;
  nodes_[i].pi = {};
  nodes_[i].z = first_lap_[i];
  solved_for_[i] = first_mu_;
  nodes_[i].z = slowed(i, mu);
  solved_for_[i] = std::min(first_mu_, mu);
}

}  // namespace gripline::time_optimal
