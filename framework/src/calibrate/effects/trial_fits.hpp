// Worlds with an effect more or less, fitted to the same starts.
#pragma once

#include <memory>

#include "calibrate/effects/effect_trial.hpp"
#include "calibrate/fit/least_squares.hpp"

namespace gripline::calibrate {

// Relative decrease of the cost below which a fit of a trial ends: gains by trade between drive and drag come slowly.
inline constexpr double trial_tolerance = 3e-3;

/// Holds references.
class TrialFits {
 public:
  TrialFits(const ForecastOptions& forecast, std::vector<FitLog>& logs) : forecast_(forecast), logs_(logs) {}
  Weighing weighing;  // of errors

  PredictionErrors errors(const Trial& trial) const;
  void refit(Trial& trial, int iterations, double tolerance = LeastSquaresOptions{}.tolerance) const;
  /// Fits until little changes, however long that takes.
  void refit_until_still(Trial& trial) const;
  /// Fits until little changes; given up (false) where it will hardly come down to a rival's cost.
  bool refit_near(Trial& trial, double rival) const;
  /// A candidate for `base` more, from where its score test says. Not fitted yet.
  std::unique_ptr<Trial> with(const Trial& base, const CandidateEffect& effect, const EffectScore& score) const;
  /// One addition less, and everything else fitted again, from where `blocks`, of all the unknowns, say that it will
  /// lie.
  std::unique_ptr<Trial> without(const Trial& base, const BlockedNormalEquations& blocks, const Addition& less) const;

 private:
  const ForecastOptions& forecast_;
  std::vector<FitLog>& logs_;
};

}  // namespace gripline::calibrate
