// From a learned force curve to a tyre that a program can be solved with: D sin(C atan(B slip)) through the learned
// forces over the slips that were visited, weighted by their uncertainty, near what is believed where they say nothing.
#pragma once

#include <array>
#include <span>

#include <gripline/interfaces.hpp>

#include "planners/time_optimal/lap_dynamics.hpp"

namespace gripline::time_optimal {

/// Counts the slips of an axle, for the range over which its learned curve is supported by samples.
class SlipRange {
 public:
  void add(double slip);
  /// Below this lie 99.5 % of the slips seen [rad].
  double visited() const;

 private:
  static constexpr double bin = 0.01;
  std::array<double, 120> counts_{};
  double total_ = 0;
};

struct AxlePrior {
  MagicFormula shape;     // what is believed without the curve
  double sigma_D = 0.08;  // of its D, relative
};

/// Forces over mass [m/s2] at positive slips, averaged over both sides by the caller; sigma may be empty. Levenberg
/// steps in (ln B, C, ln D). Throws std::invalid_argument for more than 24 points.
MagicFormula fit_axle(std::span<const double> slip, std::span<const double> force, std::span<const double> sigma,
                      const AxlePrior& prior);

/// Fits the curve that `learned` gives for an axle; the prior's shape when it knows no tyre.
MagicFormula fit_learned(const TyreCurve& learned, Axle axle, double mass, double visited, const AxlePrior& prior);

/// Largest difference of two pairs of curves over |slip| <= range, relative to the first pair's peaks.
double difference(const AxleTyres& a, const AxleTyres& b, double range);

}  // namespace gripline::time_optimal
