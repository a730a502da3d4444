#include "diagnose/inference/newton_step.hpp"

#include <algorithm>
#include <cmath>

namespace gripline::diagnose {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<double> pack(const Catalogue& catalogue, const ModelSpec& model) {
  std::vector<double> theta = model.nuisance;
  for (std::size_t i = 0; i < model.members.size(); ++i)
    for (const std::size_t f : catalogue.candidates()[model.members[i]].fitted) theta.push_back(model.values[i][f]);
  return theta;
}

void unpack(const Catalogue& catalogue, std::span<const double> theta, ModelSpec& model) {
  std::size_t at = 0;
  for (double& n : model.nuisance) n = theta[at++];
  for (std::size_t i = 0; i < model.members.size(); ++i)
    for (const std::size_t f : catalogue.candidates()[model.members[i]].fitted) model.values[i][f] = theta[at++];
}

void clamp_to_ranges(const Catalogue& catalogue, const ModelSpec& model, std::vector<double>& theta) {
  constexpr double limit = thresholds::nuisance_limit;
  std::size_t at = 0;
  for (const Nuisance& n : catalogue.nuisances()) {
    theta[at] = std::clamp(theta[at], n.nominal - limit * n.sigma, n.nominal + limit * n.sigma);
    ++at;
  }
  for (const std::size_t member : model.members) {
    const Candidate& c = catalogue.candidates()[member];
    for (std::size_t f = 0; f < c.fitted.size(); ++f, ++at)
      theta[at] = std::clamp(theta[at], c.decl(f).lo, c.decl(f).hi);
  }
}

VectorXd parameter_scales(const Catalogue& catalogue, const ModelSpec& model) {
  std::vector<double> s;
  for (const Nuisance& n : catalogue.nuisances()) s.push_back(n.sigma);
  for (const std::size_t member : model.members)
    for (std::size_t f = 0; f < catalogue.candidates()[member].fitted.size(); ++f)
      s.push_back(catalogue.candidates()[member].decl(f).scale);
  return Eigen::Map<const VectorXd>(s.data(), static_cast<Index>(s.size()));
}

namespace {

/// Solves (N + damping diag N) d = g by a pseudo-inverse: combinations of parameters that the data do not determine
/// stay.
ParameterStep solve(const MatrixXd& N, const VectorXd& g, const VectorXd& scale, double damping) {
  const MatrixXd scaled = scale.asDiagonal() * N * scale.asDiagonal();
  // Equilibrated: what counts is how well parameters can be told apart, not how strongly they act.
  VectorXd size = scaled.diagonal().cwiseSqrt();
  for (Index i = 0; i < size.size(); ++i)
    if (!(size[i] > 1e-9)) size[i] = 1e-9;
  const MatrixXd unit = size.cwiseInverse().asDiagonal() * scaled * size.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(unit);
  VectorXd inverse = eigen.eigenvalues();
  ParameterStep out;
  for (Index i = 0; i < inverse.size(); ++i) {
    const bool kept = inverse[i] > thresholds::rank_tolerance_fit;
    out.rank += kept ? 1 : 0;
    inverse[i] = kept ? 1.0 / (inverse[i] + damping) : 0.0;
  }
  const MatrixXd back = scale.asDiagonal() * (size.cwiseInverse().asDiagonal() * eigen.eigenvectors());
  const MatrixXd pseudo = back * inverse.asDiagonal() * back.transpose();
  out.step = pseudo * g;
  out.covariance = pseudo;
  return out;
}

}  // namespace

/// An active-set method of one pass: nuisances that would leave their limits are put there one by one, the worst first.
ParameterStep parameter_step(const Catalogue& catalogue, const ModelSpec& model, const NormalEquations& normal,
                             const VectorXd& scale, double damping) {
  NormalEquations reduced = normal;
  fix_at_limits(catalogue, model, reduced);
  VectorXd fixed_step = VectorXd::Zero(normal.g.size());
  std::vector<bool> fixed(catalogue.nuisances().size(), false);
  for (;;) {
    ParameterStep out = solve(reduced.N, reduced.g, scale, damping);
    out.step += fixed_step;
    const auto beyond = farthest_beyond(catalogue, model, out.step, fixed);
    if (!beyond) return out;
    const auto at = static_cast<Index>(beyond->nuisance);
    fixed[beyond->nuisance] = true;
    fixed_step[at] = beyond->step;
    fix_parameter(reduced, at, beyond->step);
  }
}

double least_variance(const Problem& problem, std::size_t acceleration) {
  return std::pow(thresholds::no_process_noise * problem.process_unit[acceleration], 2);
}

double improve_noise(const Problem& problem, const Evaluation& e, Noise& noise) {
  // Gradient and information by the logarithms of the variances.
  Eigen::Vector3d gradient;
  Eigen::Matrix3d information;
  for (Index i = 0; i < 3; ++i) {
    gradient[i] = e.noise_gradient[static_cast<std::size_t>(i)] * noise.process[static_cast<std::size_t>(i)];
    for (Index j = 0; j < 3; ++j)
      information(i, j) = e.noise_information(i, j) * noise.process[static_cast<std::size_t>(i)] *
                          noise.process[static_cast<std::size_t>(j)];
  }
  // A variance at its floor that would fall is left out of the system.
  std::array<bool, 3> fixed{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto r = static_cast<Index>(i);
    fixed[i] = noise.process[i] <= least_variance(problem, i) * 1.0001 && gradient[r] > 0.0;
    if (!fixed[i]) continue;
    information.row(r).setZero();
    information.col(r).setZero();
    information(r, r) = 1.0;
    gradient[r] = 0.0;
  }
  for (Index i = 0; i < 3; ++i) information(i, i) += 1e-6;
  const Eigen::Vector3d step = -information.ldlt().solve(gradient);
  double gain = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (fixed[i]) continue;
    // Downwards the step is taken in the variance itself, upwards in its logarithm: neither then falls short.
    const double moved = step[static_cast<Index>(i)];
    const double before = noise.process[i];
    const double factor = moved < 0.0 ? std::max(1.0 + moved, thresholds::least_noise_factor)
                                      : std::exp(std::min(moved, thresholds::longest_log_noise_step));
    noise.process[i] = std::max(least_variance(problem, i), before * factor);
    gain += std::abs(gradient[static_cast<Index>(i)] * std::log(noise.process[i] / before));
  }
  return gain;
}

}  // namespace gripline::diagnose
