// What is believed of a car's tyres: those of a generic shape with the friction that an estimator states, or what it
// has learned of their curves over the slips that were driven.
#pragma once

#include <gripline/interfaces.hpp>

#include "planners/time_optimal/lap_parameters.hpp"
#include "planners/time_optimal/tyre_fit.hpp"

namespace gripline::time_optimal {

class TyreBelief {
 public:
  TyreBelief(const Car& car, const LapParams& params);

  /// The slips of a control step, those of front wheels that stand as commanded.
  void see(const State& x);
  /// `learned`: null where nothing is.
  AxleTyres tyres(const Belief& belief, const TyreCurve* learned) const;
  /// Tyres with the shapes and the balance that the parameters state, at a friction of 1.
  const AxleTyres& generic() const { return generic_; }
  /// Slip that the front or the rear axle exceeded in one of 200 steps [rad].
  double visited_slip() const;

 private:
  Car car_;
  AxleTyres generic_;
  SlipRange front_seen_, rear_seen_;
};

}  // namespace gripline::time_optimal
