// A lap that windows are solved of: a road whose curvature swings, for the 1:43 car.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "planners/time_optimal/lap_solver.hpp"
#include "support/planner_support.hpp"

namespace gripline::testing_support {

/// Nodes of the lap.
inline constexpr std::size_t swinging_nodes = 200;

/// A lap of 12 m whose curvature swings, for the 1:43 car.
inline time_optimal::LapProblem swinging_road(double mu) {
  using namespace time_optimal;
  constexpr std::size_t nodes = swinging_nodes;
  const Car car = car_1_43();
  const double weight = mu * gravity / (car.lf + car.lr);
  LapProblem p{.car = car,
               .tyres = {{4.0, 1.3, weight * car.lr}, {4.0, 1.3, weight * car.lf}},
               .drive = {CubicSpline(0, 4, std::vector<double>{-0.5, -0.6, -0.8, -1.2, -1.6}),
                         CubicSpline(0, 4, std::vector<double>{7, 5.5, 4, 2.5, 1.6}),
                         CubicSpline(0, 4, std::vector<double>{1, 1.5, 1.8, 1.9, 2})},
               .top_speed = 4.0,
               .use = {.slip_bound = 0.7},
               .places = {},
               .ds = std::vector<double>(nodes, 12.0 / nodes),
               .n_lo = std::vector<double>(nodes, -0.15),
               .n_hi = std::vector<double>(nodes, 0.15),
               .mid_lo = std::vector<double>(nodes, -0.15),
               .mid_hi = std::vector<double>(nodes, 0.15)};
  for (std::size_t k = 0; k < nodes; ++k) {
    const double turn = 2.0 * std::numbers::pi, u = turn * static_cast<double>(k) / nodes;
    p.places.push_back({turn / 12.0 * (1.0 + 1.6 * std::cos(2.0 * u) + 0.8 * std::sin(5.0 * u)), 0.0, 0.0});
  }
  return p;
}

/// On the centre line, at 0.7 of a speed for which turns take the side force over mass `accel`, and straights `most`.
inline time_optimal::LapSolution guess_for(const time_optimal::LapProblem& p, double most = 2.5, double accel = 5.5) {
  using namespace time_optimal;
  LapSolution guess;
  for (const LapPlace& place : p.places) {
    const double v = 0.7 * std::min(most, std::sqrt(accel / std::max(1e-6, std::abs(place.kappa))));
    guess.z.push_back({0.0, 0.0, v, 0.0, v * place.kappa, (p.car.lf + p.car.lr) * place.kappa, 0.0, 0.0});
  }
  return guess;
}

}  // namespace gripline::testing_support
