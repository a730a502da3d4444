#include "diagnose/inference/fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "diagnose/inference/normal_equations.hpp"

namespace gripline::diagnose {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Cost of a model at its parameters, its gradient and its expected curvature.
struct Evaluation {
  double cost = 0, work = 0;
  NormalEquations normal;
  std::array<double, noise_states> slope{};
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
};

namespace {

void add_shape_prior(const Catalogue& catalogue, const ModelSpec& model, Evaluation& e) {
  auto at = static_cast<Index>(catalogue.nuisances().size());
  for (std::size_t i = 0; i < model.members.size(); ++i) {
    const Candidate& c = catalogue.candidates()[model.members[i]];
    for (std::size_t f = 0; f < c.fitted.size(); ++f, ++at) {
      if (c.fitted.size() <= Problem::full_charge) continue;
      const double scale = c.decl(f).scale;
      const double off = (model.values[i][c.fitted[f]] - c.decl(f).neutral) / scale;
      e.cost += 0.5 * off * off;
      e.normal.add_belief(at, off, scale);
    }
  }
}

Evaluation evaluate(const Problem& problem, const ModelSpec& model, const Noise& noise) {
  Evaluation e;
  for (const Trace& trace : problem.traces) {
    const auto [lm, directions, work] = linearise_own(*problem.catalogue, model, trace, problem.substeps);
    e.work += work * static_cast<double>(trace.size());
    std::vector<const Direction*> list;
    for (const Direction& d : directions) list.push_back(&d);
    FilterWants wants;
    wants.directions = &list;
    wants.process_slope = true;
    const Likelihood l = filter(lm, noise, wants);
    e.cost += l.cost;
    e.normal.add(l);
    for (std::size_t i = 0; i < noise_states; ++i) {
      e.slope[i] += l.slope[i];
      for (std::size_t j = 0; j < noise_states; ++j)
        e.information(static_cast<Index>(i), static_cast<Index>(j)) += l.information[i][j];
    }
  }
  e.cost += e.normal.add_nuisances(*problem.catalogue, model);
  if (problem.calm_shapes) add_shape_prior(*problem.catalogue, model, e);
  return e;
}

/// Scale of each free parameter, to judge rank and steps without units.
VectorXd scales(const Catalogue& catalogue, const ModelSpec& model) {
  std::vector<double> s;
  for (const Nuisance& n : catalogue.nuisances()) s.push_back(n.sigma);
  for (const std::size_t member : model.members)
    for (std::size_t f = 0; f < catalogue.candidates()[member].fitted.size(); ++f)
      s.push_back(catalogue.candidates()[member].decl(f).scale);
  return Eigen::Map<const VectorXd>(s.data(), static_cast<Index>(s.size()));
}

/// Solves N d = g leaving out directions the data say nothing about; `rank` counts those kept.
VectorXd solve(const MatrixXd& N, const VectorXd& g, const VectorXd& scale, std::size_t& rank, MatrixXd* covariance) {
  const MatrixXd scaled = scale.asDiagonal() * N * scale.asDiagonal();
  // Equilibrated: what counts is how well directions can be told apart, not how strongly they act.
  VectorXd size = scaled.diagonal().cwiseSqrt();
  for (Index i = 0; i < size.size(); ++i)
    if (!(size[i] > 1e-9)) size[i] = 1e-9;
  const MatrixXd unit = size.cwiseInverse().asDiagonal() * scaled * size.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(unit);
  VectorXd inverse = eigen.eigenvalues();
  rank = 0;
  for (Index i = 0; i < inverse.size(); ++i) {
    const bool kept = inverse[i] > 1e-10;
    rank += kept ? 1 : 0;
    inverse[i] = kept ? 1.0 / inverse[i] : 0.0;
  }
  const MatrixXd back = scale.asDiagonal() * (size.cwiseInverse().asDiagonal() * eigen.eigenvectors());
  const MatrixXd pseudo = back * inverse.asDiagonal() * back.transpose();
  if (covariance != nullptr) *covariance = pseudo;
  return pseudo * g;
}

/// The step of all parameters when nuisances may not leave their limits: those that would are put there one by one.
VectorXd bounded_step(const Catalogue& catalogue, const ModelSpec& model, NormalEquations normal, const VectorXd& scale,
                      std::size_t& rank, MatrixXd* covariance) {
  const auto nuisances = catalogue.nuisances();
  hold_at_limits(catalogue, model, normal);
  VectorXd moved = VectorXd::Zero(normal.g.size());
  std::vector<bool> held(nuisances.size(), false);
  for (;;) {
    const VectorXd step = solve(normal.N, normal.g, scale, rank, covariance) + moved;
    std::size_t worst = nuisances.size();
    double over = 1e-9, end = 0.0;
    for (std::size_t i = 0; i < nuisances.size(); ++i) {
      const Nuisance& n = nuisances[i];
      const double off = model.nuisance[i] + step[static_cast<Index>(i)] - n.nominal;
      const double beyond = std::abs(off) / n.sigma - nuisance_limit;
      if (held[i] || beyond <= over) continue;
      over = beyond;
      worst = i;
      end = n.nominal + (off > 0.0 ? 1.0 : -1.0) * nuisance_limit * n.sigma;
    }
    if (worst == nuisances.size()) return step;
    const auto at = static_cast<Index>(worst);
    held[worst] = true;
    moved[at] = end - model.nuisance[worst];
    hold(normal, at, moved[at]);
  }
}

/// Keeps parameters inside their ranges.
void clamp_to_ranges(const Catalogue& catalogue, const ModelSpec& model, std::vector<double>& theta) {
  std::size_t at = 0;
  for (const Nuisance& n : catalogue.nuisances()) {
    theta[at] = std::clamp(theta[at], n.nominal - nuisance_limit * n.sigma, n.nominal + nuisance_limit * n.sigma);
    ++at;
  }
  for (const std::size_t member : model.members) {
    const Candidate& c = catalogue.candidates()[member];
    for (std::size_t f = 0; f < c.fitted.size(); ++f, ++at)
      theta[at] = std::clamp(theta[at], c.decl(f).lo, c.decl(f).hi);
  }
}

/// Random accelerations below this size mean nothing.
double least_variance(const Problem& problem, std::size_t i) { return std::pow(0.003 * problem.process_unit[i], 2); }

/// True when some variance is small enough to be a remnant of parameters that are not there yet, and is not at its floor.
bool remnant(const Problem& problem, const Noise& noise) {
  bool any = false;
  for (std::size_t c = 0; c < noise_states; ++c) {
    if (noise.process[c] > std::pow(0.5 * problem.process_unit[c], 2)) return false;
    any |= noise.process[c] > 4.0 * least_variance(problem, c);
  }
  return any;
}

/// What a model's effects cost when the data determine only `free` of their parameters.
double penalty_of(const Problem& problem, const ModelSpec& model, std::size_t free) {
  double sum = 0.0;
  std::size_t all = 0, most = 0;
  for (const std::size_t member : model.members) {
    const std::size_t count = problem.catalogue->candidates()[member].fitted.size();
    sum += problem.charge(count);
    all += count;
    most = std::max(most, count);
  }
  const double each = problem.charge(most) - problem.charge(most - std::min<std::size_t>(most, 1));
  return sum - each * static_cast<double>(all - std::min(all, free));
}

/// Next variances by Fisher scoring in their logarithms; steps of at most a factor of thirty.
double improve_noise(const Problem& problem, const Evaluation& e, Noise& noise) {
  Eigen::Vector3d slope;
  Eigen::Matrix3d information;
  for (Index i = 0; i < 3; ++i) {
    slope[i] = e.slope[static_cast<std::size_t>(i)] * noise.process[static_cast<std::size_t>(i)];
    for (Index j = 0; j < 3; ++j)
      information(i, j) =
          e.information(i, j) * noise.process[static_cast<std::size_t>(i)] * noise.process[static_cast<std::size_t>(j)];
  }
  const auto floor = [&](std::size_t i) { return least_variance(problem, i); };
  // A variance at its floor that wants to fall stays out of the system.
  std::array<bool, 3> held{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto r = static_cast<Index>(i);
    held[i] = noise.process[i] <= floor(i) * 1.0001 && slope[r] > 0.0;
    if (!held[i]) continue;
    information.row(r).setZero();
    information.col(r).setZero();
    information(r, r) = 1.0;
    slope[r] = 0.0;
  }
  for (Index i = 0; i < 3; ++i) information(i, i) += 1e-6;
  const Eigen::Vector3d step = -information.ldlt().solve(slope);
  double gain = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (held[i]) continue;
    // Downwards the step is taken in the variance itself, upwards in its logarithm: both then never fall short.
    const double moved = step[static_cast<Index>(i)];
    const double before = noise.process[i];
    const double factor = moved < 0.0 ? std::max(1.0 + moved, 0.01) : std::exp(std::min(moved, 3.4));
    noise.process[i] = std::max(floor(i), before * factor);
    gain += std::abs(slope[static_cast<Index>(i)] * std::log(noise.process[i] / before));
  }
  return gain;
}

}  // namespace

double Problem::seconds() const {
  double sum = 0.0;
  for (const Trace& trace : traces) sum += static_cast<double>(trace.size()) * trace.log.dt;
  return sum;
}

std::array<double, noise_states> roughness(const Problem& problem, const Noise& noise) {
  std::array<double, noise_states> ratio;
  for (std::size_t c = 0; c < noise_states; ++c) ratio[c] = std::sqrt(noise.process[c]) / problem.process_unit[c];
  return ratio;
}

bool rough_road(const Problem& problem, const Noise& noise) {
  return std::ranges::min(roughness(problem, noise)) > 0.2;
}

void charge_for(const Problem& problem, Fit& fitted) {
  fitted.penalty = penalty_of(problem, fitted.model, fitted.free);
  fitted.score = -fitted.cost - fitted.penalty;
}

std::vector<Linearised> linearise_all(const Problem& problem, const ModelSpec& model) {
  std::vector<Linearised> all;
  for (const Trace& trace : problem.traces)
    all.push_back(linearise_own(*problem.catalogue, model, trace, problem.substeps));
  return all;
}

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

Fit fit(const Problem& problem, const ModelSpec& start, const Noise& noise, int iterations, const FitLimits& limits) {
  Fit from;
  from.model = start;
  from.noise = noise;
  return go_on(problem, from, iterations, limits);
}

Fit go_on(const Problem& problem, const Fit& from, int iterations, const FitLimits& limits) {
  const Catalogue& catalogue = *problem.catalogue;
  Fit best;
  best.model = from.model;
  best.noise = from.noise;
  best.cost = std::numeric_limits<double>::infinity();
  Evaluation at_best;
  ModelSpec trial = from.model;
  Noise trial_noise = from.noise;
  // How much of a step is taken: of the parameters, and of the variances, whose steps overshoot more easily.
  double share = 1.0, noise_share = 1.0;
  bool with_noise = false, asking = false, asked = false;
  for (int i = 0; i < iterations; ++i) {
    const bool known = i == 0 && from.evaluation != nullptr;
    Evaluation e = known ? *from.evaluation : evaluate(problem, trial, trial_noise);
    if (!known) best.work += e.work;
    const bool better = e.cost <= best.cost + 1e-6;
    const double gained = best.cost - e.cost;
    const bool whole = with_noise && share == 1.0 && noise_share == 1.0;  // the step that led here was not shortened
    if (better) {
      best.model = trial;
      best.noise = trial_noise;
      best.cost = e.cost;
      at_best = std::move(e);
      share = 1.0;
      if (with_noise) noise_share = std::min(1.0, 3.0 * noise_share);
    } else if (!asking) {
      // Not better: first the parameters alone, then a shorter step from the best.
      if (with_noise)
        noise_share *= 0.25;
      else
        share *= 0.35;
      if (share < 0.02) break;
    }
    if (!std::isfinite(best.cost)) break;  // the model cannot be evaluated at its start values
    asking = false;
    if (!asked && i >= 3 && (i >= 5 || share == 1.0) && remnant(problem, best.noise)) {
      // What is left may be parameters still on their way, and the way down is long and flat: would no noise do as well?
      asked = asking = true;
      trial = best.model;
      trial_noise = best.noise;
      for (std::size_t c = 0; c < noise_states; ++c)
        trial_noise.process[c] = std::min(trial_noise.process[c], least_variance(problem, c));
      with_noise = false;
      continue;
    }
    const bool alone = !better && with_noise;
    std::vector<double> theta = pack(catalogue, best.model);
    double gain = 0.0;
    if (!theta.empty()) {
      const VectorXd scale = scales(catalogue, best.model);
      MatrixXd covariance;
      std::size_t rank = 0;
      const VectorXd full = bounded_step(catalogue, best.model, at_best.normal, scale, rank, &covariance);
      gain = 0.5 * at_best.normal.g.dot(full);
      for (std::size_t p = 0; p < theta.size(); ++p) {
        // Very long steps leave the region where the linearisation means anything.
        const double limit = 30.0 * scale[static_cast<Index>(p)];
        theta[p] += share * std::clamp(full[static_cast<Index>(p)], -limit, limit);
      }
      clamp_to_ranges(catalogue, best.model, theta);
    }
    trial = best.model;
    unpack(catalogue, theta, trial);
    trial_noise = best.noise;
    const double noise_gain = improve_noise(problem, at_best, trial_noise);
    const double part = std::min(share, noise_share);
    with_noise = !(alone && !theta.empty());
    for (std::size_t c = 0; c < noise_states; ++c)
      trial_noise.process[c] =
          with_noise ? best.noise.process[c] * std::pow(trial_noise.process[c] / best.noise.process[c], part)
                     : best.noise.process[c];
    // Variances near their floor promise more than they keep: then what a whole step brought counts.
    if (better && gain < limits.tolerance &&
        (noise_gain < 5.0 * limits.tolerance || (whole && gained < limits.tolerance))) {
      best.converged = true;
      break;
    }
    // Far from the best, a step promises no more than a part of what a fit ends up with.
    if (i > 0 && best.cost - 4.0 * (gain + noise_gain) > -limits.wanted) break;
  }
  best.theta = pack(catalogue, best.model);
  best.free = 0;
  if (!best.theta.empty() && at_best.normal.g.size() > 0) {
    const VectorXd scale = scales(catalogue, best.model);
    MatrixXd covariance;
    std::size_t rank = 0;
    bounded_step(catalogue, best.model, at_best.normal, scale, rank, &covariance);
    best.covariance.assign(covariance.data(), covariance.data() + covariance.size());
    best.free = rank - std::min(rank, catalogue.nuisances().size());
  }
  if (std::isfinite(best.cost)) best.evaluation = std::make_shared<const Evaluation>(std::move(at_best));
  charge_for(problem, best);
  return best;
}

double renew_reference(Problem& problem, const Road& road, const Fit& fitted) {
  const StagedCar car = problem.catalogue->build(fitted.model);
  double moved = 0.0, rows = 0.0;
  for (Trace& trace : problem.traces) {
    const LinearModel lm = linearise(car, trace, problem.substeps);
    FilterWants wants;
    wants.smooth = true;
    const Likelihood l = filter(lm, fitted.noise, wants);
    std::vector<double> motion = trace.motion;
    for (std::size_t k = 0; k < trace.size(); ++k)
      for (std::size_t c = 0; c < channels; ++c) {
        const double by = l.smoothed[k * lm.states + c];
        motion[k * channels + c] += by;
        moved += std::pow(by / problem.sensor[c], 2);
      }
    rows += static_cast<double>(trace.size() * channels);
    trace.set_motion(std::move(motion), road);
  }
  return std::sqrt(moved / rows);
}

void settle_reference(Problem& problem, const Road& road, const Fit& fitted) {
  // What is left after a move is of second order in it: below a few hundredths of a sensor's deviation it is nothing.
  constexpr double still = 0.03;
  constexpr int most = 5;
  double before = std::numeric_limits<double>::infinity();
  for (int i = 0; i < most; ++i) {
    const double moved = renew_reference(problem, road, fitted);
    if (!(moved > still) || moved > before) return;
    before = moved;
  }
}

}  // namespace gripline::diagnose
