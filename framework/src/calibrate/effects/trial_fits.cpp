#include "calibrate/effects/trial_fits.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace gripline::calibrate {
namespace {

/// How the other unknowns move, to first order, when an addition is taken out.
Eigen::VectorXd move_without(const Trial& base, const BlockedNormalEquations& blocks, const Addition& less) {
  using Index = Eigen::Index;
  const auto n = static_cast<Index>(base.unknowns.size());
  Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n);
  for (const Eigen::MatrixXd& h : blocks.hessian) hessian += h;
  for (const Eigen::VectorXd& g : blocks.gradient) gradient += g;
  prior_cost(base.params, base.unknowns, &hessian, &gradient);
  std::vector<Index> stay;
  Eigen::VectorXd off = Eigen::VectorXd::Zero(n);  // of its parameters, to where they do nothing
  for (Index i = 0; i < n; ++i) {
    const Unknown& u = base.unknowns[static_cast<std::size_t>(i)];
    if (less.owns(u.pointer))
      off(i) = u.prior - base.params[u.index];
    else
      stay.push_back(i);
  }
  const Eigen::VectorXd slope = gradient + hessian * off;
  return -hessian(stay, stay).ldlt().solve(slope(stay));
}

}  // namespace

PredictionErrors TrialFits::errors(const Trial& trial) const {
  PredictionErrors out(trial.forecaster, logs_);
  out.weighing = weighing;
  return out;
}

void TrialFits::refit(Trial& trial, int iterations, double tolerance) const {
  LeastSquaresOptions steps;
  steps.iterations = iterations;
  steps.tolerance = tolerance;
  steps.initial_cost = trial.cost;
  trial.params = least_squares(errors(trial), trial.unknowns, trial.params, steps, trial.cost);
}

void TrialFits::refit_until_still(Trial& trial) const {
  constexpr int most_iterations = 60;  // one without an end of grip moves far
  refit(trial, most_iterations, trial_tolerance);
}

bool TrialFits::refit_near(Trial& trial, double rival) const {
  constexpr int at_a_time = 2, most_times = 6;
  constexpr double hope = 3.0;  // times what the last iterations took off may still come
  for (int i = 0; i < most_times; ++i) {
    const double before = trial.cost;
    refit(trial, at_a_time, trial_tolerance);
    const double decrease = before - trial.cost;
    if (trial.cost - hope * decrease > rival) return false;
    if (decrease < 2.0 * trial_tolerance * before) return true;
  }
  return true;
}

std::unique_ptr<Trial> TrialFits::with(const Trial& base, const CandidateEffect& effect,
                                       const EffectScore& score) const {
  auto trial = std::make_unique<Trial>(with_effect(base.spec, effect), forecast_);
  take_over(*trial, base);
  const std::size_t before = trial->unknowns.size();
  const Addition added = addition_of(effect, base);
  for (const std::size_t i : effect.open) {
    const ParameterPlace* const place =
        trial->find(effect.listed ? added.pointer : added.pointer + effect.entry->params()[i].name);
    Unknown open = open_parameter(*place, effect.numbers[i]);
    open.low = std::max(open.low, effect.low[i]);
    open.high = std::min(open.high, effect.high[i]);
    trial->unknowns.push_back(std::move(open));
  }
  Eigen::VectorXd move = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(trial->unknowns.size()));
  move.head(score.move.size()) = score.move;
  for (std::size_t k = 0; k < effect.tested.size(); ++k) {
    const auto at = std::ranges::find(effect.open, effect.tested[k]) - effect.open.begin();
    move(static_cast<Eigen::Index>(before) + at) = score.value[k];
  }
  const PredictionErrors from = errors(*trial);
  const auto cost = [&](const std::vector<double>& p) { return from.cost(p) + prior_cost(p, trial->unknowns); };
  std::vector<double> best = trial->params;
  trial->cost = cost(best);
  for (const double part : {1.0, 0.3}) {
    std::vector<double> next = after_step(trial->params, trial->unknowns, part * move);
    const double less = cost(next);
    if (!(less < trial->cost)) continue;
    trial->cost = less;
    best = std::move(next);
  }
  trial->params = std::move(best);
  return trial;
}

std::unique_ptr<Trial> TrialFits::without(const Trial& base, const BlockedNormalEquations& blocks,
                                          const Addition& less) const {
  auto trial = std::make_unique<Trial>(less.opened ? base.spec : without_effect(base.spec, less.name), forecast_);
  take_over(*trial, base);
  std::erase_if(trial->unknowns, [&](const Unknown& u) {
    if (!less.owns(u.pointer)) return false;
    assign(trial->params, u, u.prior);
    return true;
  });
  const PredictionErrors from = errors(*trial);
  const auto cost = [&](const std::vector<double>& p) { return from.cost(p) + prior_cost(p, trial->unknowns); };
  std::vector<double> next = after_step(trial->params, trial->unknowns, move_without(base, blocks, less));
  trial->cost = cost(trial->params);
  if (const double less = cost(next); less < trial->cost) {
    trial->cost = less;
    trial->params = std::move(next);
  }
  refit_until_still(*trial);
  return trial;
}

}  // namespace gripline::calibrate
