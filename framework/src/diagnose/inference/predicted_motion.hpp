// The motion of a car as a fitted model predicts it at every sample from those before.
#pragma once

#include <span>

#include "diagnose/inference/fit.hpp"

namespace gripline::diagnose {

/// A problem along the motion that is predicted at every sample from those before. A smoothed motion holds the noise
/// of the very readings that a function of it is to explain: unknown commands turn the car, the smoothed yaw rate shows
/// it, and the score of a yaw acceleration that follows the yaw rate is no longer zero at the mean. A function of what
/// came before is uncorrelated with every innovation (White 1984, Asymptotic Theory for Econometricians, martingale
/// differences).
/// `along` is linearise_all of the fitted model.
Problem along_predictions(const Problem& problem, const Fit& fitted, std::span<const Linearised> along);

/// Whether what is not known turns the car: commands that were rounded or left out, or unknown accelerations.
bool motion_holds_noise(const Problem& problem, const Noise& noise);

/// The models of `along` with derivatives by their own parameters along `predicted`. Where motion holds noise, those
/// along smoothed motion vanish at other values than these, and a function of predicted motion finds the difference.
std::vector<Linearised> with_own_along(const Problem& predicted, const Fit& fitted, std::span<const Linearised> along);

}  // namespace gripline::diagnose
