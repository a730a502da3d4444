#include "diagnose/result/diagnoser.hpp"

#include <algorithm>

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
#include "util/numbers.hpp"

namespace gripline::diagnose {
namespace {

/// What no effect explains is an error of a channel's readings.
void leave_to_channel(const std::string& words, Diagnosis& d) {
  d.verdict = Verdict::unknown;
  d.unknown = ResidualTest{};
  d.unknown->where = Where::reading;
  d.unknown->quantity = words;
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
  std::vector<ChannelDelay> delays = sure_delays(logs, SpeedsBy::displacements_too);
  delays_taken_off_ = !delays.empty();
  keep_open(delays, logs, catalogue_);
  if (delays.empty()) return search(logs, held_out, progress);
  const auto on_time = [&](const std::vector<LogFile>& late) {
    std::vector<LogFile> out;
    out.reserve(late.size());
    for (const LogFile& log : late) out.push_back(without_delays(log, delays));
    return out;
  };
  Diagnosis d = search(on_time(logs), on_time(held_out), progress);
  // A delay that was off by more than what was left open is taken off anew.
  constexpr int rounds = 2;
  for (int round = 0; round < rounds && move_limited(delays, catalogue_, d.null_model); ++round) {
    keep_open(delays, logs, catalogue_);
    d = search(on_time(logs), on_time(held_out), progress);
  }
  name_delays(logs, held_out, delays, d);
  const bool harm = std::ranges::any_of(d.delays, [](const NamedEffect& delay) { return delay.rollout.harms(); });
  if (harm && d.wrong_channel) return search_beside_delays(logs, held_out, delays, progress);
  d.sentence = sentence(d);
  return d;
}

/// What is missing of logs in which two channels disagree in time and predictions are worse with these delays taken
/// off: the log is left as it is.
Diagnosis Diagnoser::search_beside_delays(std::span<const LogFile> logs, std::span<const LogFile> held_out,
                                          std::span<const ChannelDelay> delays, const ProgressCallback& progress) {
  delays_taken_off_ = false;
  catalogue_.forget_late_pose();
  Diagnosis d = search(logs, held_out, progress);
  for (const ChannelDelay& one : delays)
    d.health.push_back({measured::Finding::Level::bad, "time of " + one.words() + " against " + one.against(),
                        format("%.3g s later", one.seconds), "left as it is: predictions are worse without it"});
  if (d.verdict != Verdict::nothing_missing) return d;
  leave_to_channel(delays.front().words(), d);
  d.sentence = sentence(d);
  return d;
}

/// What is missing of logs whose channels are on time.
Diagnosis Diagnoser::search(std::span<const LogFile> logs, std::span<const LogFile> held_out,
                            const ProgressCallback& progress) {
  // Parts that take about equally long: the search is four of them.
  constexpr std::size_t parts = 8;
  const auto at = [&](double done, const char* what) {
    if (progress) progress(done, parts, what);
  };
  at(0, "preparing");
  Prepared prepared = prepare(catalogue_, road_, logs, stated_noise());
  if (world_.hold == Hold::zoh) {
    Problem& problem = prepared.problem;
    problem.hold_commands(measured::held_for(world_.dt, problem.traces.front().log.dt));
    if (!problem.hold().until_next) problem.hold_time = world_.dt;
  }
  at(1, "searching");
  SearchOptions options;
  if (progress)
    options.progress = [&](double done, std::size_t, const std::string& what) { progress(1 + done, parts, what); };
  SearchResult found = search_effects(std::move(prepared.problem), road_, options);
  at(5, "judging");
  const HoldOut& hold_out = hold_out_.emplace(found.pool.problem(), road_, held_out);
  Diagnosis d = conclude(found, hold_out);
  d.health = std::move(prepared.health);
  if (hold_out.empty())
    d.health.push_back({measured::Finding::Level::bad, "hold-out", "no stretch is long enough to predict a part of it",
                        "the gap is not measured"});
  at(6, "refining");
  problem_ = found.pool.problem();
  d.sensor = problem_.sensor;
  if (!d.fit.theta.empty()) {
    // Along the trajectory that the found model smooths: changes its parameters by a per mille or so.
    smooth_reference(problem_, road_, d.fit);
    d.fit = fit(problem_, d.fit.model, d.fit.noise, thresholds::result_iterations);
  }
  set_parameters(catalogue_, d);
  at(7, "measuring the gap");
  judge_by_predictions(found, hold_out, {.delays_taken_off = delays_taken_off_}, d);
  add_predictions(found, hold_out, d.ranking);
  report_noise(problem_, d.fit.noise, d.health);
  report_straight_commands(problem_, held_out, d.health);
  allow_for_wrong_channel(prepared.expected_noise, d);
  if (d.verdict == Verdict::nothing_missing)
    d.detection_limits = detection_limits(problem_, found.pool.screen_once(found.null_model));
  d.sentence = sentence(d);
  return d;
}

/// Puts delays before everything else that was found: the gap is then that of the logs as they came.
void Diagnoser::name_delays(std::span<const LogFile> logs, std::span<const LogFile> held_out,
                            std::span<const ChannelDelay> delays, Diagnosis& d) const {
  Problem late = prepare(catalogue_, road_, logs, stated_noise()).problem;
  late.sensor = problem_.sensor;
  late.hold_commands(problem_.hold());
  if (problem_.unrounded) late.unround_commands();
  for (Trace& trace : late.traces) trace.bend_commands(problem_.bend);
  late.bend = problem_.bend;
  const ErrorChange by_delays = begin_with_delays(HoldOut(late, road_, held_out), *hold_out_, catalogue_, d);
  for (const ChannelDelay& one : delays) {
    d.delays.push_back(named_delay(refined(one, catalogue_, d.fit.theta.empty() ? d.null_model : d.fit)));
    d.delays.back().rollout = by_delays;
  }
  if (d.verdict == Verdict::nothing_missing) d.verdict = Verdict::named;
}

/// Where a channel is wrong the rest was judged with its errors taken for noise: what was found stands beside that.
void Diagnoser::allow_for_wrong_channel(const Channels& expected_noise, Diagnosis& d) const {
  d.wrong_channel = wrong_channel(problem_, expected_noise);
  if (!d.wrong_channel) return;
  leave_to_channel(measured::channel_info[d.wrong_channel->channel].words, d);
  d.unknown->statistic = d.wrong_channel->ratio();
  d.equivalent.clear();
  d.manoeuvre.clear();
  for (NamedEffect& n : d.named) n.confidence = std::min(n.confidence, thresholds::most_beside_unknown);
}

}  // namespace gripline::diagnose
