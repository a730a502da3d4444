#include "diagnose/inference/noise_remeasurement.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "diagnose/inference/newton_step.hpp"
#include "diagnose/inference/noise_estimate.hpp"

namespace gripline::diagnose {
namespace {

/// The best model without any and without each of its effects, where those are not far from it or could come near it by
/// bent commands: effects imitate what commands do between samples, and where that explains a log as well, it does.
std::vector<const Fit*> smaller_than_best(ModelPool& pool, const Fit& null_model, const Fit& best) {
  std::vector<const Fit*> all;
  if (&best == &null_model) return all;
  all.push_back(&null_model);
  for (const std::size_t member : best.model.members)
    if (best.model.members.size() > 1)
      all.push_back(&pool.fit_once(pool.problem().catalogue->without(best.model, member), best.noise));
  const double least = best.evidence - 2.0 * thresholds::rival_range;
  std::erase_if(all, [&](const Fit* less) {
    return less->evidence < least && less->evidence + gain_of_bends(pool.problem(), *less) < least;
  });
  return all;
}

/// Whether a log may have left out what commands did between samples: whether any of these models asks for it.
bool may_leave_out_commands(ModelPool& pool, const Fit& null_model, const Fit& best) {
  const Problem& problem = pool.problem();
  // What was assumed before effects were found is asked again: a missing effect can look like bent commands.
  if (problem.command != UnknownCommands{} || problem.bend != Commands{}) return true;
  // Unknown accelerations, however small, can be what was left out: the score would then be that of more noise still.
  for (std::size_t i = 0; i < noise_states; ++i)
    if (best.noise.process[i] > thresholds::may_be_left_out * least_variance(problem, i)) return true;
  const auto asks = [&](const Fit* one) {
    return unknown_commands_statistic(problem, *one) > thresholds::asks_for_commands;
  };
  return asks(&best) || std::ranges::any_of(smaller_than_best(pool, null_model, best), asks);
}

/// What commands may do between samples other than what is assumed.
std::vector<measured::CommandHold> other_holds(const Problem& problem) {
  std::vector<measured::CommandHold> all{{}, {.until_next = true}};
  if (problem.hold_time > 0.0) all.push_back(measured::held_for(problem.hold_time, problem.traces.front().log.dt));
  std::erase(all, problem.hold());
  return all;
}

/// The noise measured with a model from what is assumed and, where that may be an offset taken for noise, from white
/// sensors: the likelihood can have a maximum on either side.
MeasuredNoise measure_from_both_sides(const Problem& problem, const Fit& fitted, NoiseEstimateOptions unknowns) {
  MeasuredNoise noise = measure_noise(problem, fitted, unknowns);
  const auto may_be_offset = [](double colour) { return colour > thresholds::offset_colour; };
  if (std::ranges::none_of(problem.colour, may_be_offset)) return noise;
  unknowns.begin_white = true;
  const MeasuredNoise white = measure_noise(problem, fitted, unknowns);
  const double simpler = is_simpler(problem, white) && !is_simpler(problem, noise) ? thresholds::noise_gain : 0.0;
  return white.gain + simpler > noise.gain ? white : noise;
}

}  // namespace

const Fit* hold_commands_anew(ModelPool& pool, const Road& road, const Fit& null_model, const Fit& found) {
  std::vector<const Fit*> asked{&null_model};
  if (&found != &null_model) asked.push_back(&found);
  for (const std::size_t member : found.model.members)
    if (found.model.members.size() > 1)
      asked.push_back(&pool.fit_once(pool.problem().catalogue->without(found.model, member), found.noise));
  Fit best;
  best.evidence = -INFINITY;
  measured::CommandHold hold;
  for (const measured::CommandHold& how : other_holds(pool.problem())) {
    Problem other = pool.problem();  // parameters cost the same in it, so that evidences compare
    other.hold_commands(how);
    for (const Fit* one : asked) {
      const double enough = one == &found ? found.evidence + thresholds::noise_gain : found.evidence;
      Fit there =
          fit(other, one->model, one->noise, thresholds::rough_iterations, {thresholds::rough_tolerance, enough});
      if (there.evidence > enough - unfinished_margin(enough, null_model.evidence))
        there = continue_fit(other, there, thresholds::finish_iterations, {thresholds::rough_tolerance});
      if (!(there.evidence > std::max(enough, best.evidence))) continue;
      best = std::move(there);
      hold = how;
    }
  }
  if (best.evidence == -INFINITY) return nullptr;
  const ModelSpec nothing = null_model.model;
  pool.restart(road, best, hold);
  return &pool.fit_once(nothing, best.noise);
}

const Fit* measure_noise_anew(ModelPool& pool, const Road& road, const Fit& null_model, const Fit& best) {
  const Problem& problem = pool.problem();
  NoiseEstimateOptions unknowns;
  unknowns.sensors = problem.colour != Channels{} || colour_statistic(problem, best) > thresholds::coloured_innovations;
  unknowns.correlation_time = has_strong_process_noise(problem, best.noise);
  unknowns.commands = may_leave_out_commands(pool, null_model, best);
  if (!unknowns.sensors && !unknowns.correlation_time && !unknowns.commands) return nullptr;
  MeasuredNoise noise = measure_from_both_sides(problem, best, unknowns);
  if (unknowns.sensors && unknowns.commands) {
    NoiseEstimateOptions fewer = unknowns;
    fewer.commands = false;
    noise = higher_peak(noise, measure_noise(problem, best, fewer));
  }
  const Fit* by = &best;
  if (unknowns.commands)
    for (const Fit* less : smaller_than_best(pool, null_model, best)) {
      const MeasuredNoise alone = measure_from_both_sides(problem, *less, unknowns);
      if (less->evidence + alone.gain > by->evidence + noise.gain) noise = alone, by = less;
    }
  // What was assumed must be worth assuming still: where the log is about as likely without it, it was an effect.
  const double enough = is_simpler(problem, noise) ? -thresholds::noise_gain : thresholds::noise_gain;
  if (noise.gain < enough) return nullptr;
  if (noise.gain < thresholds::noise_gain_before && !differs_from_assumed(problem, noise)) return nullptr;
  const ModelSpec nothing = null_model.model;
  pool.restart(road, *by, noise);
  return &pool.fit_once(nothing, noise.noise);
}

}  // namespace gripline::diagnose
