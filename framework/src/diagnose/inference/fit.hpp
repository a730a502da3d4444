// Maximum likelihood of a model on logs: parameters by Gauss-Newton on the filter's innovations, the variances of the
// unknown accelerations by Fisher scoring in the same iterations.
#pragma once

#include <limits>
#include <memory>

#include "diagnose/inference/problem.hpp"

namespace gripline::diagnose {

struct Evaluation;

/// A model with its best parameters.
struct Fit {
  ModelSpec model;
  Noise noise;
  double cost = 0;                 // negative log likelihood plus half the squared deviations from priors
  std::size_t rank = 0;            // effect parameters that the data determine
  double penalty = 0;              // for the effects' parameters (Schwarz)
  double evidence = 0;             // log evidence up to a constant of the problem: -cost - penalty
  std::vector<double> theta;       // free parameters: nuisances, then the members' in order
  std::vector<double> covariance;  // theta x theta
  bool converged = false;
  bool finished = false;  // further iterations are not worth their work
  /// At these parameters, along the references and with the priors of the fit; null when it could not be evaluated.
  std::shared_ptr<const Evaluation> evaluation;
  double work = 0;  // spent on it: Linearised::work times samples
};

/// Sets a fit's penalty and evidence by the problem's present penalty per parameter.
void update_penalty(const Problem& problem, Fit& fitted);

/// When a fit may stop before its iterations are used up, and what it is for.
struct FitOptions {
  double tolerance = thresholds::fine_tolerance;  // log likelihood that may be left unfound
  /// Evidence that it must be able to reach to be of interest.
  double needed = -std::numeric_limits<double>::infinity();
  FitFor purpose = FitFor::comparison;
};

/// Fits from the given values and variances. Where process noise remains it is tried whether none would do as well:
/// parameters far from their optimum look like noise, and the way down is long and flat.
Fit fit(const Problem& problem, const ModelSpec& start, const Noise& noise, int iterations = 8,
        const FitOptions& options = {});
/// Goes on from where a fit of the same problem ended.
Fit continue_fit(const Problem& problem, const Fit& from, int iterations, const FitOptions& options);

}  // namespace gripline::diagnose
