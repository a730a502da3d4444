// The motion of a car as a fitted model predicts it at every sample from those before.
#pragma once

#include <optional>
#include <span>

#include "diagnose/inference/fit.hpp"

namespace gripline::diagnose {

/// A trace along the motion that a model predicts at every sample from those before. A smoothed motion holds the noise
/// of the very readings that a function of it is to explain: unknown commands turn the car, the smoothed yaw rate shows
/// it, and the score of a yaw acceleration that follows the yaw rate is no longer zero at the mean. A function of what
/// came before is uncorrelated with every innovation (White 1984, Asymptotic Theory for Econometricians, martingale
/// differences).
Trace along_predictions(const Trace& trace, const LinearModel& model, const Noise& noise);

/// Likewise a problem; `along` is linearise_all of the fitted model.
Problem along_predictions(const Problem& problem, const Fit& fitted, std::span<const Linearised> along);

/// Whether what is not known turns the car: commands that were rounded or left out, or unknown accelerations.
bool motion_holds_noise(const Problem& problem, const Noise& noise);

/// The models of `along` with derivatives by their own parameters along `predicted`. Where motion holds noise, those
/// along smoothed motion vanish at other values than these, and a function of predicted motion finds the difference.
std::vector<Linearised> with_own_along(const Problem& predicted, const Fit& fitted, std::span<const Linearised> along);

/// A model along a trace, with what its likelihood is differentiated by.
struct Differentiated {
  Linearised linearised;
  std::optional<Trace> predicted;  // where FitFor says so; the regressors are those along it
  /// Along which motion regressors of further parameters belong.
  const Trace& motion_of(const Trace& trace) const { return predicted ? *predicted : trace; }
};
/// The derivative of an innovation by a parameter theta is that of the rates f where the filter is, f_theta(x). Along
/// the reference r only f_theta(r) is known, and with the reference smoothed by readings to come, the score that lacks
/// f_theta_x (x - r) is not zero at the truth: in strong process noise a yaw inertia of 1.25 came out as 1.45.
Differentiated differentiate(const Problem& problem, const ModelSpec& model, const Trace& trace, const Noise& noise,
                             FitFor purpose = FitFor::comparison);

}  // namespace gripline::diagnose
