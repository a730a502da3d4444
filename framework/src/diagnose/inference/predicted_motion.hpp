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

/// Whether what is not known of the commands turns the car: they were rounded, or a recorder left samples out.
bool commands_are_noise(const Problem& problem);

/// The same models with derivatives by their own parameters along `predicted`. Along smoothed motion that holds noise
/// of the commands these do not vanish where the likelihood has its maximum.
std::vector<Linearised> with_own_along(const Problem& predicted, const Fit& fitted, std::span<const Linearised> along);

}  // namespace gripline::diagnose
