// A steady oscillation in what a model leaves: a line that stands out of the spectrum of the smoothed unknown
// accelerations.
#pragma once

#include <span>
#include <vector>

#include "diagnose/inference/fit.hpp"
#include "diagnose/inference/residual_test.hpp"
#include "diagnose/model/regressors.hpp"

namespace gripline::diagnose {

/// Periodogram of equally spaced values, with von Hann's taper against leakage: squared magnitudes at 1 / T, 2 / T, ...
/// (T: the duration of all), in squares of the values' unit. So many ordinates, or as many as lie below Nyquist's
/// frequency, beyond which they would come again.
std::vector<double> tapered_periodogram(std::span<const double> values, std::size_t ordinates);

/// Score test of a sine wave at the frequency of the strongest line; where == time, quantity "frequency", from = to
/// [Hz]. The statistic is 0 when no line stands out. A filter with free process noise explains an oscillation by more
/// noise; once the frequency is known the likelihood tells the two apart. `along` is linearise_all of the model.
ResidualTest test_spectral_line(const Problem& problem, const Fit& fitted, std::span<const Linearised> along);

}  // namespace gripline::diagnose
