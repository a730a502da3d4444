// Steps towards the maximum of the likelihood: of the parameters by Gauss-Newton, of the process variances by Fisher
// scoring.
#pragma once

#include <Eigen/Dense>

#include "diagnose/inference/evaluation.hpp"

namespace gripline::diagnose {

/// Free parameters of a model as a vector, nuisances first, and back.
std::vector<double> pack(const Catalogue& catalogue, const ModelSpec& model);
void unpack(const Catalogue& catalogue, std::span<const double> theta, ModelSpec& model);
/// Keeps packed parameters inside their declared ranges and nuisances inside thresholds::nuisance_limit.
void clamp_to_ranges(const Catalogue& catalogue, const ModelSpec& model, std::vector<double>& theta);
/// Scale of each free parameter, in its own unit.
Eigen::VectorXd parameter_scales(const Catalogue& catalogue, const ModelSpec& model);

/// The Gauss-Newton step with nuisances kept inside their limits. `damping` above 0 adds that share of each parameter's
/// own information (Levenberg-Marquardt): combinations that the data hardly determine then move little.
struct ParameterStep {
  Eigen::VectorXd step;
  Eigen::MatrixXd covariance;  // pseudo-inverse of the information
  std::size_t rank = 0;        // combinations of parameters that the data determine
};
ParameterStep parameter_step(const Catalogue& catalogue, const ModelSpec& model, const NormalEquations& normal,
                             const Eigen::VectorXd& scale, double damping = 0.0);

/// The variance below which a process noise counts as zero [m2/s4 or rad2/s4].
double least_variance(const Problem& problem, std::size_t acceleration);
/// One step of the process variances in their logarithms, written to `noise`. Returns the gain in log likelihood it
/// predicts.
double improve_noise(const Problem& problem, const Evaluation& e, Noise& noise);

}  // namespace gripline::diagnose
