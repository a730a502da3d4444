// The cost of a model at given parameters and variances, with its first and expected second derivatives.
#pragma once

#include <Eigen/Dense>

#include "diagnose/inference/normal_equations.hpp"
#include "diagnose/inference/problem.hpp"

namespace gripline::diagnose {

/// cost: negative log likelihood plus negative log priors, up to constants of the problem.
struct Evaluation {
  double cost = 0;
  double work = 0;                                              // units of Linearised::work times samples
  NormalEquations normal;                                       // by the free parameters
  std::array<double, noise_states> noise_gradient{};            // of the cost, by process variances
  Eigen::Matrix3d noise_information = Eigen::Matrix3d::Zero();  // expected, by the same
};

/// Negative log density of the priors on a model's parameters, up to a constant of the problem.
double cost_of_priors(const Problem& problem, const ModelSpec& model);

/// `purpose` decides how the cost is differentiated, and not what it is.
Evaluation evaluate(const Problem& problem, const ModelSpec& model, const Noise& noise,
                    FitFor purpose = FitFor::comparison);

}  // namespace gripline::diagnose
