#include "diagnose/inference/fit.hpp"

#include <algorithm>
#include <cmath>

#include "diagnose/inference/newton_step.hpp"

namespace gripline::diagnose {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Whether the process noise is small enough to be parameters that are still on their way, and not at its floor
/// already.
bool noise_may_vanish(const Problem& problem, const Noise& noise) {
  bool any = false;
  for (std::size_t c = 0; c < noise_states; ++c) {
    if (noise.process[c] > std::pow(thresholds::may_vanish * problem.process_unit[c], 2)) return false;
    any |= noise.process[c] > thresholds::above_least * least_variance(problem, c);
  }
  return any;
}

/// Penalty of a model's effects when the data determine only `rank` of their parameters.
double penalty_of(const Problem& problem, const ModelSpec& model, std::size_t rank) {
  double sum = 0.0;
  std::size_t all = 0, most = 0;
  for (const std::size_t member : model.members) {
    const std::size_t count = problem.catalogue->candidates()[member].fitted.size();
    sum += problem.penalty(count);
    all += count;
    most = std::max(most, count);
  }
  const double each = problem.penalty(most) - problem.penalty(most - std::min<std::size_t>(most, 1));
  return sum - each * static_cast<double>(all - std::min(all, rank));
}

/// The iterations of one fit: a trial is evaluated, becomes the best or shortens the next step, and the next is
/// proposed.
class Iteration {
 public:
  Iteration(const Problem& problem, const Fit& from, const FitOptions& options)
      : problem_(problem), catalogue_(*problem.catalogue), options_(options), first_evaluation_(from.evaluation) {
    trial_.model = best_.model = from.model;
    trial_.noise = best_.noise = from.noise;
    best_.cost = std::numeric_limits<double>::infinity();
  }

  /// False when the fit has converged, cannot improve or cannot become good enough.
  bool run(int iteration);
  Fit result();

 private:
  /// What a trial changed against the best.
  enum class Change { parameters, parameters_and_noise, no_noise };
  struct Trial {
    ModelSpec model;
    Noise noise;
    Change change = Change::parameters;
  };
  /// Gains in log likelihood that the second-order model predicts for a full step.
  struct PredictedGain {
    double parameters = 0, noise = 0;
  };

  bool accept_if_better(Evaluation& e);
  bool try_corrected(const Evaluation& failed);
  bool shorten_step();
  void propose_without_noise();
  PredictedGain propose(bool parameters_only);

  const Problem& problem_;
  const Catalogue& catalogue_;
  FitOptions options_;
  std::shared_ptr<const Evaluation> first_evaluation_;  // of the first trial, or null
  Fit best_;
  Evaluation at_best_;
  Trial trial_;
  // Parts taken of a step: of the parameters', and of the variances', which overshoots more easily.
  double part_ = 1.0, noise_part_ = 1.0;
  bool tried_without_noise_ = false;
};

bool Iteration::accept_if_better(Evaluation& e) {
  if (!(e.cost <= best_.cost + thresholds::cost_rounding)) return false;
  best_.model = trial_.model;
  best_.noise = trial_.noise;
  best_.cost = e.cost;
  at_best_ = std::move(e);
  part_ = 1.0;
  if (trial_.change == Change::parameters_and_noise)
    noise_part_ = std::min(1.0, thresholds::longer_noise_step * noise_part_);
  return true;
}

/// An effect and a nuisance that do nearly the same trade places along a valley that is curved. A whole step along it
/// ends on its side, from where a step in what the data determine leads back to its floor, far on. True if that is
/// better than the best.
bool Iteration::try_corrected(const Evaluation& failed) {
  const bool whole = trial_.change == Change::parameters && part_ == 1.0;
  if (!whole || catalogue_.nuisances().empty() || !std::isfinite(failed.cost)) return false;
  const VectorXd scale = parameter_scales(catalogue_, trial_.model);
  const VectorXd step =
      parameter_step(catalogue_, trial_.model, failed.normal, scale, thresholds::correction_damping).step;
  std::vector<double> theta = pack(catalogue_, trial_.model);
  for (std::size_t p = 0; p < theta.size(); ++p) theta[p] += step[static_cast<Index>(p)];
  clamp_to_ranges(catalogue_, trial_.model, theta);
  unpack(catalogue_, theta, trial_.model);
  Evaluation e = evaluate(problem_, trial_.model, trial_.noise, options_.purpose);
  best_.work += e.work;
  return accept_if_better(e);
}

/// After a failure: first the parameters are tried alone, then a shorter step. False when steps are too short to
/// matter.
bool Iteration::shorten_step() {
  if (trial_.change == Change::no_noise) return true;
  if (trial_.change == Change::parameters_and_noise)
    noise_part_ *= thresholds::shorter_noise_step;
  else
    part_ *= thresholds::shorter_step;
  return !(part_ < thresholds::shortest_step);
}

void Iteration::propose_without_noise() {
  tried_without_noise_ = true;
  trial_.model = best_.model;
  trial_.noise = best_.noise;
  for (std::size_t c = 0; c < noise_states; ++c)
    trial_.noise.process[c] = std::min(trial_.noise.process[c], least_variance(problem_, c));
  trial_.change = Change::no_noise;
}

Iteration::PredictedGain Iteration::propose(bool parameters_only) {
  PredictedGain gain;
  std::vector<double> theta = pack(catalogue_, best_.model);
  if (!theta.empty()) {
    const VectorXd scale = parameter_scales(catalogue_, best_.model);
    const VectorXd full = parameter_step(catalogue_, best_.model, at_best_.normal, scale).step;
    gain.parameters = 0.5 * at_best_.normal.g.dot(full);
    for (std::size_t p = 0; p < theta.size(); ++p) {
      const double limit = thresholds::longest_step * scale[static_cast<Index>(p)];
      theta[p] += part_ * std::clamp(full[static_cast<Index>(p)], -limit, limit);
    }
    clamp_to_ranges(catalogue_, best_.model, theta);
  }
  trial_.model = best_.model;
  unpack(catalogue_, theta, trial_.model);
  Noise improved = best_.noise;
  gain.noise = improve_noise(problem_, at_best_, improved);
  trial_.noise = best_.noise;
  trial_.change = parameters_only && !theta.empty() ? Change::parameters : Change::parameters_and_noise;
  if (trial_.change == Change::parameters) return gain;
  const double part = std::min(part_, noise_part_);
  for (std::size_t c = 0; c < noise_states; ++c)
    trial_.noise.process[c] = best_.noise.process[c] * std::pow(improved.process[c] / best_.noise.process[c], part);
  return gain;
}

bool Iteration::run(int iteration) {
  const Change change = trial_.change;
  const bool whole_step = change == Change::parameters_and_noise && part_ == 1.0 && noise_part_ == 1.0;
  const double before = best_.cost;
  const bool evaluated = iteration == 0 && first_evaluation_ != nullptr;
  Evaluation e = evaluated ? *first_evaluation_ : evaluate(problem_, trial_.model, trial_.noise, options_.purpose);
  if (!evaluated) best_.work += e.work;
  const bool better = accept_if_better(e) || try_corrected(e);
  if (!better && !shorten_step()) return false;
  if (!std::isfinite(best_.cost)) return false;  // the model cannot be evaluated at its start values
  if (!tried_without_noise_ && iteration >= thresholds::without_noise_from &&
      (iteration >= thresholds::without_noise_at_last || part_ == 1.0) && noise_may_vanish(problem_, best_.noise)) {
    propose_without_noise();
    return true;
  }
  const PredictedGain gain = propose(!better && change == Change::parameters_and_noise);
  const double tolerance = options_.tolerance;
  // The gain predicted for variances near their floor is too large: there the gain of the last whole step counts.
  if (better && gain.parameters < tolerance &&
      (gain.noise < thresholds::noise_tolerance * tolerance || (whole_step && before - best_.cost < tolerance))) {
    best_.converged = true;
    return false;
  }
  const double reachable = best_.cost - thresholds::reachable_factor * (gain.parameters + gain.noise);
  return iteration == 0 || !(reachable > -options_.needed);
}

Fit Iteration::result() {
  best_.theta = pack(catalogue_, best_.model);
  best_.rank = 0;
  if (!best_.theta.empty() && at_best_.normal.g.size() > 0) {
    const VectorXd scale = parameter_scales(catalogue_, best_.model);
    const ParameterStep last = parameter_step(catalogue_, best_.model, at_best_.normal, scale);
    best_.covariance.assign(last.covariance.data(), last.covariance.data() + last.covariance.size());
    best_.rank = last.rank - std::min(last.rank, catalogue_.nuisances().size());
  }
  if (std::isfinite(best_.cost)) best_.evaluation = std::make_shared<const Evaluation>(std::move(at_best_));
  update_penalty(problem_, best_);
  return std::move(best_);
}

}  // namespace

void update_penalty(const Problem& problem, Fit& fitted) {
  fitted.penalty = penalty_of(problem, fitted.model, fitted.rank);
  fitted.evidence = -fitted.cost - fitted.penalty;
}

Fit fit(const Problem& problem, const ModelSpec& start, const Noise& noise, int iterations, const FitOptions& options) {
  Fit from;
  from.model = start;
  from.noise = noise;
  return continue_fit(problem, from, iterations, options);
}

Fit continue_fit(const Problem& problem, const Fit& from, int iterations, const FitOptions& options) {
  Iteration iteration(problem, from, options);
  for (int i = 0; i < iterations && iteration.run(i); ++i) continue;
  return iteration.result();
}

}  // namespace gripline::diagnose
