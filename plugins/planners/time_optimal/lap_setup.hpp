// Everything about a road and a car that all laps of one planner share, and the way from tyres to a lap.
#pragma once

#include <cstddef>
#include <vector>

#include "common/planning/speed_profile.hpp"
#include "planners/time_optimal/base_line.hpp"
#include "planners/time_optimal/lap_solver.hpp"

namespace gripline::time_optimal {

struct SetupOptions {
  double margin = 0;   // kept by the centre of gravity from both edges [m]
  double spacing = 0;  // mean distance of the nodes [m]
  double brakes = 1;   // share of them that is planned with
  TyreUse use;         // the loads of its `sharing` are those of the nominal model
};

class LapSetup {
 public:
  /// Computes the base line (Course::minimum_curvature). `typical` places the nodes and shapes cold guesses.
  LapSetup(const PluginContext& context, const SetupOptions& options, const CarBelief& typical);

  const planning::ClosedLine& base() const { return base_; }
  const LapNodes& nodes() const { return nodes_; }
  /// The node after one, and the one before it: the lap is closed.
  std::size_t after(std::size_t node) const { return node + 1 < nodes_.s.size() ? node + 1 : 0; }
  std::size_t before(std::size_t node) const { return node > 0 ? node - 1 : nodes_.s.size() - 1; }
  /// The base line at a node.
  const LinePoint& base_at(std::size_t node) const { return base_at_nodes_[node]; }
  /// The node before a station of the base line.
  std::size_t node_at(double station) const;
  double top_speed() const { return limits_.top_speed(); }
  /// Acceleration at full throttle on a straight [m/s2].
  double full_throttle(double v, const SpecificResistance& resistance) const {
    return limits_.coast(v) + limits_.drive(v) - (resistance.at(v) - typical_.resistance.at(v));
  }
  const Car& car() const { return car_; }
  const CarBelief& typical() const { return typical_; }

  LapProblem problem(const CarBelief& belief) const;
  /// The base line driven at nearly the speed these tyres allow on it: where a cold solve begins.
  LapSolution cold_guess(const AxleTyres& tyres) const;
  /// Everything that decides the result of a solve except what is believed of the car, as numbers to be hashed.
  std::vector<double> fingerprint() const;

 private:
  std::vector<double> profile(const AxleTyres& tyres) const;

  Car car_;
  SetupOptions options_;
  CarBelief typical_;
  planning::DriveLimits limits_;
  planning::ClosedLine base_;
  planning::CornerLimits corner_;  // of the typical tyres
  DriveCurves curves_;
  LapNodes nodes_;
  std::vector<LinePoint> base_at_nodes_;
  std::vector<std::size_t> first_node_;  // of equal parts of the lap, as many as nodes: the node before each
};

}  // namespace gripline::time_optimal
