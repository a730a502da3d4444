// Generic functions of place, time, state and inputs, for accelerations that no effect describes.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "diagnose/inference/residual_test.hpp"
#include "diagnose/inference/score_test.hpp"

namespace gripline::diagnose {

/// Values of some functions at every sample of one trace: n x functions.
struct Basis {
  std::size_t functions = 0;
  std::vector<double> value;
};

/// The functions of one kind: periodic cubic B-splines of the lap fraction, cubic B-splines of time, features of speeds
/// or features of the commands and their rates.
Basis basis_of(const Problem& problem, const Trace& trace, Where where);
/// Number of B-splines in time, and the end of the longest trace [s].
std::size_t time_knots(const Problem& problem);
double end_time(const Problem& problem);

/// Few functions that most effects of a car resemble: of speed and throttle for the longitudinal acceleration (the
/// first along_functions), of slip, yaw rate and steering for the others.
inline constexpr std::size_t along_functions = 8, across_functions = 9;
Basis simple_basis(const Trace& trace);

/// A cosine and a sine in time; frequency [Hz].
Basis wave(const Trace& trace, double frequency);

/// Accelerations vx', vy' and omega' by each function: regressors in the order channel, function.
std::vector<Regressor> accelerations(const Basis& basis, std::size_t samples);

/// Normal equations of a fitted model's own parameters, then of the accelerations by a basis. `along` is linearise_all
/// of it.
using BasisOf = std::function<Basis(const Trace&)>;
ScoreSystem basis_system(const Problem& problem, const Fit& fitted, std::span<const Linearised> along,
                         const BasisOf& basis);

}  // namespace gripline::diagnose
