#include "diagnose/result/diagnoser.hpp"

#include <algorithm>
#include <cmath>

#include "config/errors.hpp"
#include "diagnose/inference/adequacy.hpp"
#include "diagnose/inference/preparation.hpp"
#include "diagnose/inference/reference.hpp"
#include "diagnose/result/closing.hpp"
#include "diagnose/result/detection_limits.hpp"
#include "diagnose/result/manoeuvre.hpp"
#include "diagnose/result/named_delay.hpp"
#include "diagnose/result/noise_health.hpp"
#include "diagnose/result/ranking.hpp"
#include "diagnose/result/sentence.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::diagnose {
namespace {

std::vector<Nuisance> nuisances_of(const CaseOptions& options, const Catalogue& catalogue) {
  std::vector<Nuisance> nuisances;
  const bool stated = !options.uncertainty.empty();
  for (const auto& [key, size] : stated ? options.uncertainty : options.guessed) {
    Nuisance n;
    const std::string over_m = "_over_m";
    const bool per_mass = key.ends_with(over_m);
    n.name = per_mass ? key.substr(0, key.size() - over_m.size()) : key;
    n.nominal = catalogue.nominal(n.name, &n.index);
    if (std::isnan(n.nominal) && !stated) continue;
    if (std::isnan(n.nominal))
      throw InputError("nominal_uncertainty names \"" + key + "\", which is no parameter of the nominal model");
    // A relative deviation of nothing is nothing: where the nominal value is 0 the size is that of the parameter.
    n.sigma = size * (per_mass ? catalogue.car().m : n.nominal != 0.0 ? std::abs(n.nominal) : 1.0);
    if (n.sigma > 0.0) nuisances.push_back(n);
  }
  return nuisances;
}

void check_excluded(const CaseOptions& options, const Catalogue& catalogue) {
  for (const std::string& id : options.exclude) {
    if (catalogue.find(id) != catalogue.candidates().size()) continue;
    std::vector<std::string> known;
    for (const Candidate& c : catalogue.candidates()) known.push_back(c.id);
    throw InputError("\"exclude\" names \"" + id + "\", which is no effect that could be found" +
                     did_you_mean(id, known));
  }
}

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
  catalogue_.set_nuisances(nuisances_of(options, catalogue_));
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
  prepared.problem.hold_commands(world_.hold == Hold::zoh);
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
  add_parameters(d);
  at(7, "measuring the gap");
  measure_gap(hold_out, d);
  compare_named(hold_out, found, d);
  drop_harmful(hold_out, found, d);
  add_predictions(hold_out, found, d.ranking);
  if (!stands(hold_out, d)) withdraw(hold_out, found, d);
  report_noise(problem_, d.fit.noise, d.health);
  report_straight_commands(problem_, held_out, d.health);
  allow_for_wrong_channel(prepared.expected_noise, d);
  if (d.verdict == Verdict::nothing_missing)
    d.detection_limits = detection_limits(problem_, found.pool.screen_once(found.null_model));
  d.sentence = sentence(d);
  return d;
}

std::vector<std::string> Diagnoser::ids(const ModelSpec& model) const {
  std::vector<std::string> list;
  for (const std::size_t m : model.members) list.push_back(catalogue_.candidates()[m].id);
  return list;
}

/// The selected model's effects with their confidences.
std::vector<NamedEffect> Diagnoser::name_effects(const Problem& problem, const SelectedModel& selected,
                                                 const Rivals& rivals) const {
  std::vector<NamedEffect> named;
  for (const std::size_t member : selected.fit.model.members) {
    NamedEffect one;
    one.effect = catalogue_.candidates()[member].id;
    one.measurement = catalogue_.candidates()[member].effect->stage() == Stage::reading;
    one.confidence = std::min({rivals.bootstrap_of(member), rivals.posterior_of(member), thresholds::most_confidence});
    if (selected.unknown) one.confidence = std::min(one.confidence, thresholds::most_beside_unknown);
    if (place_may_be_time(problem, selected.fit.model, member))
      one.confidence = std::min(one.confidence, thresholds::most_in_one_lap);
    named.push_back(std::move(one));
  }
  return named;
}

/// Sets of effects that explain the log as well as the selected ones, these first; empty when there are no others.
std::vector<std::vector<std::string>> Diagnoser::equivalents(std::span<const Fit* const> equals, const Fit& selected,
                                                             const SearchResult& found) const {
  std::vector<std::vector<std::string>> sets;
  if (equals.size() > 1)
    for (const Fit* one : equals) sets.push_back(ids(one->model));
  // Names for one and the same thing.
  for (const auto& [kept, others] : found.synonyms)
    for (const std::size_t other : others) {
      if (!selected.model.has(kept)) continue;
      std::vector<std::string> same = ids(selected.model);
      std::replace(same.begin(), same.end(), catalogue_.candidates()[kept].id, catalogue_.candidates()[other].id);
      if (sets.empty()) sets.push_back(ids(selected.model));
      sets.push_back(std::move(same));
    }
  return sets;
}

/// The verdict and the names, before they are measured on hold-out data.
Diagnosis Diagnoser::conclude(SearchResult& found, const HoldOut& hold_out) const {
  SelectedModel selected = select_model(found, hold_out);
  const Rivals rivals = rivals_of(found, selected.fit);
  Diagnosis d;
  d.null_model = found.null_model;
  d.ranking = ranking_by_evidence(found, rivals);
  d.named = name_effects(found.pool.problem(), selected, rivals);
  d.verdict = selected.unknown ? Verdict::unknown : d.named.empty() ? Verdict::nothing_missing : Verdict::named;
  if (d.verdict == Verdict::named) {
    const std::vector<const Fit*> equals = indistinguishable_from(selected.fit, rivals, found, hold_out);
    d.equivalent = equivalents(equals, selected.fit, found);
    if (equals.size() > 1) {
      d.verdict = Verdict::indistinguishable;
      d.manoeuvre = distinguishing_manoeuvre(std::span(d.equivalent).first(equals.size()), catalogue_);
    }
  }
  d.unknown = selected.unknown;
  d.tests = std::move(selected.tests);
  d.fit = std::move(selected.fit);
  return d;
}

/// Fitted values of nuisances and of the named effects' parameters, with their intervals.
void Diagnoser::add_parameters(Diagnosis& d) const {
  const Fit& fitted = d.fit;
  std::size_t at = 0;
  const std::size_t p = fitted.theta.size();
  d.nominal_fit.clear();
  for (const Nuisance& n : catalogue_.nuisances()) {
    if (!n.delay) d.nominal_fit.emplace_back(n.name, fitted.theta[at]);
    ++at;
  }
  for (std::size_t i = 0; i < fitted.model.members.size(); ++i) {
    const Candidate& c = catalogue_.candidates()[fitted.model.members[i]];
    d.named[i].params.clear();
    for (std::size_t f = 0; f < c.fitted.size(); ++f, ++at) {
      const abi::ParamDecl& decl = c.decl(f);
      const double sigma = std::sqrt(std::max(0.0, fitted.covariance[at * p + at]));
      d.named[i].params.push_back({decl.name, decl.unit, fitted.theta[at], fitted.theta[at] - normal_95 * sigma,
                                   fitted.theta[at] + normal_95 * sigma});
    }
  }
}

namespace {

constexpr std::array<double, 5> horizons = {0.1, 0.2, 0.5, 1.0, 2.0};  // [s]
constexpr std::size_t reported = 3;                                    // the horizon of Gap
static_assert(horizons[reported] == Gap{}.horizon);

/// How much of the gap is closed, by the change of its error. A perfect model still shows the sensors' own noise: one
/// standard deviation.
void set_closure(Gap& gap, const ErrorChange& change) {
  const auto closed = [&](double after) { return (gap.before - after) / (gap.before - std::min(1.0, after)); };
  gap.change = change;
  gap.closure = gap.closure_low = gap.closure_high = 0.0;
  if (!change.helps()) return;
  gap.closure = closed(gap.after);
  gap.closure_low = closed(gap.before * (1.0 + change.high));
  gap.closure_high = closed(gap.before * (1.0 + change.low));
}

}  // namespace

Fit Diagnoser::nominal(const Diagnosis& d) const {
  Fit given = d.null_model;
  given.model = catalogue_.null_model();
  // What is left of delays that were taken off is no part of the car: what effects close lies beyond it.
  for (std::size_t i = 0; i < given.model.nuisance.size(); ++i)
    if (catalogue_.nuisances()[i].delay) given.model.nuisance[i] = d.null_model.model.nuisance[i];
  given.evaluation.reset();
  given.theta.clear();
  given.covariance.clear();
  return given;
}

/// Errors of predictions on hold-out data by the nominal model, with its parameters refitted, and by the one found.
void Diagnoser::measure_gap(const HoldOut& hold_out, Diagnosis& d) const {
  const auto before = hold_out.predict(nominal(d), horizons);
  const auto after = d.fit.theta.empty() ? before : hold_out.predict(hold_out.refit(d.fit), horizons);
  d.horizons.clear();
  for (std::size_t i = 0; i < horizons.size(); ++i)
    d.horizons.push_back({horizons[i], before[i].rms(), after[i].rms()});
  d.gap.before = before[reported].rms();
  d.gap.after = after[reported].rms();
  const ErrorChange change = compare(after[reported], before[reported]);
  set_closure(d.gap, change);
  d.named_gap = d.gap;
  if (!d.null_model.theta.empty()) {
    const StartErrors refitted = hold_out.predict_refitted(d.null_model);
    d.named_gap.before = refitted.rms();
    set_closure(d.named_gap, compare(after[reported], refitted));
  }
  if (d.named.size() == 1 && catalogue_.nuisances().empty()) d.named.front().rollout = change;
}

/// Puts delays before everything else that was found: the gap is then that of the logs as they came.
void Diagnoser::name_delays(std::span<const LogFile> logs, std::span<const LogFile> held_out,
                            std::span<const ChannelDelay> delays, Diagnosis& d) const {
  Problem late = prepare(catalogue_, road_, logs, stated_noise()).problem;
  late.sensor = problem_.sensor;
  late.hold_commands(problem_.commands_held);
  if (problem_.unrounded) late.unround_commands();
  for (Trace& trace : late.traces) trace.bend_commands(problem_.bend);
  late.bend = problem_.bend;
  const HoldOut before(late, road_, held_out);
  const HoldOut& after = *hold_out_;  // of logs on time, held out ones too
  const auto errors = before.predict(nominal(d), horizons);
  for (std::size_t i = 0; i < horizons.size(); ++i) d.horizons[i].before = errors[i].rms();
  const ErrorChange by_delays = compare(after.predict_refitted(nominal(d)), errors[reported]);
  d.gap.before = errors[reported].rms();
  set_closure(d.gap, compare(after.predict_refitted(d.fit), errors[reported]));
  for (const ChannelDelay& one : delays) {
    d.delays.push_back(named_delay(refined(one, catalogue_, d.fit.theta.empty() ? d.null_model : d.fit)));
    d.delays.back().rollout = by_delays;
  }
  if (d.verdict == Verdict::nothing_missing) d.verdict = Verdict::named;
}

/// What each named effect does to predictions, beside the others.
void Diagnoser::compare_named(const HoldOut& hold_out, SearchResult& found, Diagnosis& d) const {
  if (d.named.empty() || (d.named.size() == 1 && catalogue_.nuisances().empty())) return;  // the gap has said it
  const StartErrors with = hold_out.predict_refitted(d.fit);
  for (std::size_t i = 0; i < d.named.size(); ++i) {
    const Fit& without = found.pool.fit_once(catalogue_.without(d.fit.model, d.fit.model.members[i]), d.fit.noise);
    d.named[i].rollout = compare(with, hold_out.predict_refitted(without));
  }
}

/// An effect that makes predictions worse is not kept, whatever its evidence: it stands for something else.
void Diagnoser::drop_harmful(const HoldOut& hold_out, SearchResult& found, Diagnosis& d) const {
  for (;;) {
    const auto worst = std::ranges::max_element(d.named, {}, [](const NamedEffect& n) { return n.rollout.low; });
    if (worst == d.named.end() || !worst->rollout.harms()) return;
    const std::size_t member = d.fit.model.members[static_cast<std::size_t>(worst - d.named.begin())];
    d.named.erase(worst);
    d.fit = found.pool.fit_once(catalogue_.without(d.fit.model, member), d.fit.noise);
    d.verdict = Verdict::unknown;
    d.equivalent.clear();
    d.manoeuvre.clear();
    d.tests = residual_tests(found.pool.problem(), d.fit);
    d.unknown = strongest(d.tests);
    for (NamedEffect& n : d.named) n.confidence = std::min(n.confidence, thresholds::most_beside_unknown);
    add_parameters(d);
    measure_gap(hold_out, d);
    compare_named(hold_out, found, d);
  }
}

/// Whether what was found closes some of the gap on the laps held out or, where these cannot tell, on the others.
/// Refitted parameters count with it: they take up most of an effect, and what predictions show of the rest is less
/// sure than its evidence. That it does no harm beside them is asked before (drop_harmful).
bool Diagnoser::closes(const HoldOut& hold_out, const Diagnosis& d) const {
  if (d.named.empty()) return true;
  const bool noisy = has_strong_process_noise(problem_, d.fit.noise) || problem_.command != UnknownCommands{};
  const Closing answer = hold_out.empty()
                             ? Closing::ask_fitted
                             : closing(d.gap, d.fit.evidence - d.null_model.evidence, noisy || delays_taken_off_);
  if (answer != Closing::ask_fitted) return answer == Closing::closes;
  // What delays that were taken off are wrong by shows in all data alike, as a small effect.
  if (delays_taken_off_ && !hold_out.empty()) return false;
  return closes_fitted(compare(hold_out.predict_training(d.fit), hold_out.predict_training(d.null_model)), noisy);
}

/// Whether the result predicts hold-out data well enough to be kept.
bool Diagnoser::stands(const HoldOut& hold_out, const Diagnosis& d) const {
  if (!closes(hold_out, d)) return false;
  if (hold_out.empty()) return true;
  // Beside something unknown, effects that leave most of the gap open are imitations of it, unless each of them helps.
  const bool all_help = std::ranges::all_of(d.named, [](const NamedEffect& n) { return n.rollout.helps(); });
  if (d.verdict == Verdict::unknown && !all_help && d.gap.closure < thresholds::closure_beside_unknown) return false;
  const bool process_noise = has_strong_process_noise(problem_, d.fit.noise);
  // Where nothing is named only nuisances differ, and what has ample evidence may be small or rest during the laps held
  // out or drown in process noise: these must only do no harm.
  const bool ample =
      d.named.empty() || d.fit.evidence - d.null_model.evidence > thresholds::ample_evidence || process_noise;
  if (!ample) return !(d.gap.after >= d.gap.before);
  const double worse = process_noise ? thresholds::worse_with_process_noise : thresholds::worse_on_hold_out;
  return !(d.gap.after > worse * d.gap.before);
}

/// What was found does not predict, and what is missing is not known: nothing, where the bare model leaves nothing to
/// find. The nominal model is returned, with its parameters refitted where that makes predictions better.
void Diagnoser::withdraw(const HoldOut& hold_out, const SearchResult& found, Diagnosis& d) const {
  const bool was_known = d.verdict == Verdict::named || d.verdict == Verdict::indistinguishable;
  if (was_known && !closes(hold_out, d)) {
    d.tests = residual_tests(found.pool.problem(), found.null_model);
    if (!(strongest(d.tests).statistic > thresholds::misfit)) d.verdict = Verdict::nothing_missing;
  }
  if (d.verdict != Verdict::nothing_missing) {
    d.verdict = Verdict::unknown;
    if (!d.unknown) d.unknown = strongest(d.tests);
  }
  d.named.clear();
  d.equivalent.clear();
  d.manoeuvre.clear();
  d.nominal_fit.clear();
  d.fit = found.null_model;
  if (!d.fit.theta.empty()) {
    add_parameters(d);
    measure_gap(hold_out, d);
    if (d.gap.closure > 0.0) return;
    d.nominal_fit.clear();
  }
  d.fit = nominal(d);
  for (PredictionError& row : d.horizons) row.after = row.before;
  d.gap.after = d.gap.before;
  set_closure(d.gap, {});
  d.named_gap = d.gap;
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
