#include "diagnose/result/diagnoser.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "config/errors.hpp"
#include "diagnose/inference/evaluation.hpp"
#include "diagnose/inference/late_place.hpp"
#include "diagnose/inference/preparation.hpp"
#include "diagnose/inference/reference.hpp"
#include "diagnose/inference/search.hpp"
#include "diagnose/result/conclusion.hpp"
#include "diagnose/result/detection_limits.hpp"
#include "diagnose/result/fitted_parameters.hpp"
#include "diagnose/result/judgement.hpp"
#include "diagnose/result/named_delay.hpp"
#include "diagnose/result/noise_health.hpp"
#include "diagnose/result/ranking.hpp"
#include "diagnose/result/sentence.hpp"
#include "diagnose/result/uncertain_parameters.hpp"
#include "diagnose/result/verdict.hpp"
#include "util/numbers.hpp"

namespace gripline::diagnose {
namespace {

/// An error of a channel's readings, as something that no effect explains.
ResidualTest error_of_readings(const std::string& words) {
  ResidualTest unknown;
  unknown.where = Where::reading;
  unknown.quantity = words;
  return unknown;
}

/// Where a channel is wrong the rest was judged with its errors taken for noise: what was found stands beside that.
Explanation beside_wrong_channel(const std::optional<ChannelError>& wrong, Explanation e) {
  if (!wrong) return e;
  e.unknown = error_of_readings(measured::channel_info[wrong->channel].words);
  e.unknown->statistic = wrong->ratio();
  e.equivalent.clear();
  e.manoeuvre.clear();
  for (NamedEffect& n : e.named) n.confidence = std::min(n.confidence, thresholds::most_beside_unknown);
  return e;
}

/// Of logs in which two channels disagree in time, left as they are because predictions are worse with these delays
/// taken off.
Findings with_late_channels(std::span<const ChannelDelay> delays, Findings found) {
  for (const ChannelDelay& one : delays)
    found.health.push_back({measured::Finding::Level::bad, "time of " + one.words() + " against " + one.against(),
                            format("%.3g s later", one.seconds), "left as it is: predictions are worse without it"});
  if (verdict_of(found, {}) == Verdict::nothing_missing) found.unknown = error_of_readings(delays.front().words());
  return found;
}

/// Takes readings for missing that the same samples of other traces do not have. Whether there are the same samples.
bool leave_out_what_others_lack(std::span<Trace> traces, std::span<const Trace> others) {
  if (traces.size() != others.size()) return false;
  for (std::size_t t = 0; t < traces.size(); ++t) {
    std::vector<double>& readings = traces[t].log.reading;
    const std::vector<double>& other = others[t].log.reading;
    if (readings.size() != other.size()) return false;
    for (std::size_t i = 0; i < readings.size(); ++i)
      if (std::isnan(other[i])) readings[i] = not_a_number;
  }
  return true;
}

/// The fit that says what is left of delays.
const Fit& fit_of_delays(const Findings& found) { return found.fit.theta.empty() ? found.null_model : found.fit; }

/// Delays as results, refined by what the model found says of them.
std::vector<NamedEffect> named_delays(std::span<const ChannelDelay> delays, const Catalogue& catalogue,
                                      const Findings& found, const ErrorChange& by_delays) {
  std::vector<NamedEffect> named;
  for (const ChannelDelay& one : delays) {
    named.push_back(named_delay(refined(one, catalogue, fit_of_delays(found))));
    named.back().rollout = by_delays;
  }
  return named;
}

Diagnosis with_sentence(Diagnosis d) {
  d.sentence = sentence(d);
  return d;
}

/// A world whose own effects have more hidden states than the filter takes is refused where it lists them, before
/// anything is searched.
void check_hidden_states(const WorldSpec& world, const Catalogue& catalogue) {
  const ModelSpec own = catalogue.null_model();
  if (catalogue.fits_filter(own)) return;
  std::string list;
  for (const auto& [id, states] : catalogue.own_states())
    list += (list.empty() ? "" : ", ") + id + " " + std::to_string(states);
  throw InputError(world.vehicle.effects_read.origin,
                   "these effects have " + std::to_string(catalogue.hidden_states(own)) + " hidden states (" + list +
                       "); diagnose takes at most " + std::to_string(max_memory));
}

/// Asked before any member is made of the model.
const WorldSpec& with_model(const WorldSpec& world) {
  require_vehicle_model(world, "diagnose");
  return world;
}

}  // namespace

Diagnoser::Diagnoser(const WorldSpec& world, const Registry& registry, const CaseOptions& options)
    : world_(with_model(world)),
      options_(options),
      catalogue_(world.vehicle, world.car.car, registry, options.exclude),
      road_(world.track) {
  check_hidden_states(world, catalogue_);
  check_excluded(options, catalogue_);
  catalogue_.set_nuisances(uncertain_parameters(options, catalogue_));
}

Channels Diagnoser::stated_noise() const {
  if (options_.noise_sigma) return *options_.noise_sigma;
  Channels stated;
  for (std::size_t c = 0; c < channels; ++c) stated[c] = world_.sensors.channels[c].sigma;
  return stated;
}

Diagnosis Diagnoser::run(std::span<const LogFile> given, std::span<const LogFile> given_held_out,
                         const ProgressCallback& progress) {
  check_held_out(given, given_held_out);
  const std::vector<LogFile> logs = each_once(given), held_out = each_once(given_held_out);
  std::vector<ChannelDelay> delays = significant_delays(logs, SpeedsBy::displacements_too);
  keep_open(delays, logs, catalogue_);
  Findings found = search_on_time(logs, held_out, delays, DelaysMovedBy::null_model, progress);
  if (put_late_place_for_lever(delays, logs, found.fit))
    found = search_on_time(logs, held_out, delays, DelaysMovedBy::model_found, progress);
  if (delays.empty()) return with_sentence(assemble(std::move(found), {}));
  // The gap is that of the logs as they came.
  GapsFromDelays from = gaps_from_delays(HoldOut(late_problem(logs), road_, held_out), *hold_out_, catalogue_, found);
  if (from.by_delays.change > thresholds::worse_on_hold_out - 1.0 && found.wrong_channel) {
    catalogue_.forget_late_pose();
    return with_sentence(assemble(with_late_channels(delays, search(logs, held_out, false, progress)), {}));
  }
  static_cast<PredictionGaps&>(found) = std::move(from.gaps);
  std::vector<NamedEffect> named = named_delays(delays, catalogue_, found, from.by_delays);
  return with_sentence(assemble(std::move(found), std::move(named)));
}

/// What is missing of logs with these delays taken off, for which the catalogue must be open. A delay that was off by
/// more than what was left open is taken off anew.
Findings Diagnoser::search_on_time(std::span<const LogFile> logs, std::span<const LogFile> held_out,
                                   std::vector<ChannelDelay>& delays, DelaysMovedBy by,
                                   const ProgressCallback& progress) {
  if (delays.empty()) return search(logs, held_out, false, progress);
  const auto once = [&] {
    return search(without_delays(logs, delays), without_delays(held_out, delays), true, progress);
  };
  Findings found = once();
  constexpr int rounds = 2;
  for (int round = 0; round < rounds; ++round) {
    const Fit& fitted = by == DelaysMovedBy::null_model ? found.null_model : fit_of_delays(found);
    if (!move_limited(delays, catalogue_, fitted)) break;
    keep_open(delays, logs, catalogue_);
    found = once();
  }
  if (!drop_refuted(delays, logs, catalogue_, fit_of_delays(found))) return found;
  keep_open(delays, logs, catalogue_);
  return search_on_time(logs, held_out, delays, by, progress);
}

/// Where a late place explains the logs better than the lever found does, adds its delay to these and opens the
/// catalogue for it; else all stays as it is. Asked after a search, whose noise and commands it takes over. The lever is
/// judged by as many readings: those that would have come after a log's end are missing of a place that was late.
bool Diagnoser::put_late_place_for_lever(std::vector<ChannelDelay>& delays, std::span<const LogFile> logs,
                                         const Fit& found) {
  const std::optional<ChannelDelay> late = delay_for_lever(catalogue_, found, logs);
  if (!late || std::ranges::find(delays, late->group, &ChannelDelay::group) != delays.end()) return false;
  std::vector<ChannelDelay> with_place = delays;
  with_place.insert(with_place.begin(), *late);  // the first group
  keep_open(with_place, logs, catalogue_);
  Problem problem = problem_, with_lever = problem_;
  problem.traces = late_problem(without_delays(logs, with_place)).traces;
  if (!leave_out_what_others_lack(with_lever.traces, problem.traces)) {
    keep_open(delays, logs, catalogue_);
    return false;
  }
  const FitOptions as_found{.purpose = FitFor::result};
  constexpr int first_iterations = 8;
  Fit fitted = fit(problem, with_delays_for_lever(catalogue_, found.model), found.noise, first_iterations, as_found);
  smooth_reference(problem, road_, fitted);
  fitted = fit(problem, fitted.model, fitted.noise, thresholds::result_iterations, as_found);
  with_place.front() = refined(with_place.front(), catalogue_, fitted);
  keep_open(delays, logs, catalogue_);  // as the lever was found
  if (!(fitted.cost + thresholds::equal_evidence < evaluate(with_lever, found.model, found.noise).cost)) return false;
  delays = std::move(with_place);
  keep_open(delays, logs, catalogue_);
  return true;
}

/// What is missing of logs, as they are.
Findings Diagnoser::search(std::span<const LogFile> logs, std::span<const LogFile> held_out, bool delays_taken_off,
                           const ProgressCallback& progress) {
  // Parts that take about equally long: the search is four of them.
  constexpr std::size_t parts = 8;
  const auto at = [&](double done, const char* what) {
    if (progress) progress(done, parts, what);
  };
  at(0, "preparing");
  Prepared prepared = prepare_logs(logs);
  at(1, "searching");
  SearchOptions options;
  if (progress)
    options.progress = [&](double done, std::size_t, const std::string& what) { progress(1 + done, parts, what); };
  SearchResult found = search_effects(std::move(prepared.problem), road_, options);
  at(5, "judging");
  const HoldOut& hold_out = hold_out_.emplace(found.pool.problem(), road_, held_out);
  Conclusion concluded = conclude(found, hold_out);
  at(6, "refining");
  problem_ = found.pool.problem();
  Fit refined = concluded.fit;
  if (!refined.theta.empty()) {
    // Along the trajectory that the found model smooths: changes its parameters by a per mille or so.
    smooth_reference(problem_, road_, refined);
    refined = fit(problem_, refined.model, refined.noise, thresholds::result_iterations, {.purpose = FitFor::result});
  }
  at(7, "measuring the gap");
  const Judgement judged = judge_by_predictions(found, hold_out, {.delays_taken_off = delays_taken_off},
                                                with_fit(catalogue_, refined, concluded));
  std::vector<RankedEffect> ranking = with_predictions(found, hold_out, std::move(concluded.ranking));
  if (hold_out.empty())
    prepared.health.push_back({measured::Finding::Level::bad, "hold-out",
                               "no stretch is long enough to predict a part of it", "the gap is not measured"});
  std::vector<measured::Finding> health = with_noise(problem_, judged.fit.noise, std::move(prepared.health));
  std::ranges::move(straight_commands(problem_, held_out), std::back_inserter(health));
  const std::optional<ChannelError> wrong = wrong_channel(problem_, prepared.expected_noise);
  Explanation explanation = beside_wrong_channel(wrong, judged);
  std::vector<DetectionLimit> limits;
  if (verdict_of(explanation, {}) == Verdict::nothing_missing)
    limits = detection_limits(problem_, found.pool.screen_once(found.null_model));
  return {std::move(explanation), judged,           wrong,          std::move(ranking), std::move(limits),
          std::move(health),      found.null_model, problem_.sensor};
}

/// A problem of the logs, with commands held as the world holds them.
Prepared Diagnoser::prepare_logs(std::span<const LogFile> logs) const {
  Prepared prepared = prepare(catalogue_, road_, logs, stated_noise());
  if (world_.hold != Hold::zoh) return prepared;
  Problem& problem = prepared.problem;
  problem.hold_commands(measured::held_for(world_.dt, problem.traces.front().log.dt));
  if (!problem.hold().until_next) problem.hold_time = world_.dt;
  return prepared;
}

/// The logs as they came, late channels in them, with the noise and the commands that were found on time.
Problem Diagnoser::late_problem(std::span<const LogFile> logs) const {
  Problem late = prepare(catalogue_, road_, logs, stated_noise()).problem;
  late.sensor = problem_.sensor;
  late.hold_commands(problem_.hold());
  if (problem_.unrounded) late.unround_commands();
  for (Trace& trace : late.traces) trace.bend_commands(problem_.bend);
  late.bend = problem_.bend;
  return late;
}

}  // namespace gripline::diagnose
