#include "calibrate/missing_effects.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "calibrate/candidate_effects.hpp"
#include "calibrate/place_effects.hpp"
#include "calibrate/trial_fits.hpp"
#include "calibrate/witnesses.hpp"
#include "calibrate/yaw_hold.hpp"
#include "config/errors.hpp"
#include "measured/noise.hpp"
#include "util/numbers.hpp"

namespace gripline::calibrate {
namespace {

constexpr double horizon = 1.0;  // [s] of what is judged
constexpr double agreed = 2.0;   // standard deviations over blocks of a score that is worth a fit
constexpr double worth = 0.02;   // of the squared errors: a hundredth of the error
// Share of its information that sets an effect apart from what is fitted, below which first order says little of it: a
// dead zone or an end of grip that no command reaches yet.
constexpr double hidden = 1e-2;
constexpr double faint = 0.5 * worth;  // a gain to first order below which even those are not fitted
constexpr double surpassed = 1.5;      // times its gain to first order a fit may reach, where another has reached more

class MissingSearch {
 public:
  MissingSearch(const Node& tree, const WorldSpec& spec, const Registry& registry, const measured::LogMap& map,
                const MissingOptions& options)
      : tree_(tree), spec_(spec), registry_(registry), map_(map), options_(options), forecast_(forecast_options(spec)) {
    forecast_.pose = map.pose;
    forecast_.velocity = map.velocity;
    forecast_.own_commands = false;  // what is judged is one horizon
  }

  MissingEffects run(const std::list<measured::SessionFile>& files, const std::list<measured::SessionFile>& held_out,
                     const std::filesystem::path& folder);

 private:
  void tell(double share, const std::string& what) const {
    if (options_.progress) options_.progress(share, what);
  }
  void split(const std::list<measured::SessionFile>& files, const std::list<measured::SessionFile>& held_out);
  void calibrate(const std::list<measured::SessionFile>& files);
  void measure_noise(const std::list<measured::SessionFile>& files);
  ForecastErrors judge(const Trial& trial, const std::vector<FitLog>& logs) const {
    return forecast_errors(trial.forecaster, trial.params, fits_.weighing, logs);
  }
  const std::vector<FitLog>& told_of() const { return report_.empty() ? judge_ : report_; }
  HorizonRow row_of(const std::string& name, const Trial& trial) const;
  std::unique_ptr<Trial> observed(const Trial& base);
  void begin_with_calibrated();
  struct Best {
    std::unique_ptr<Trial> trial;
    std::string effect;
  };
  void try_one(const CandidateEffect& effect, const EffectScore& score, Best& best, RankedEffect& row);
  bool add_one();
  double determined(const std::string& effect, const Bootstrap& boot) const;
  WitnessErrors errors_of(const Trial& trial) const {
    return {trial.judged, report_.empty() ? ForecastErrors{} : judge(trial, report_)};
  }
  const ForecastErrors& told(const WitnessErrors& errors) const {
    return report_.empty() ? errors.own : errors.held_out;
  }
  struct Asked {
    std::unique_ptr<Trial> rest;  // without it
    ForecastChange told;          // of what is reported
    double sure = 0;              // that it helps, in standard deviations
    bool stays = false;
  };
  Asked ask(std::size_t index, const NormalEquations& blocks, const WitnessErrors& now, const WitnessErrors& first);
  void take_out(std::size_t index, std::unique_ptr<Trial> rest);
  NormalEquations keep_what_is_determined();
  void keep_what_helps();
  std::vector<FittedParameter> parameters_of_found() const;
  void name_values(std::span<const FittedParameter> parameters);
  void compare_sessions(const ForecastErrors& before, const ForecastErrors& after);
  Node world_found(const std::filesystem::path& folder) const;

  const Node& tree_;
  const WorldSpec& spec_;
  const Registry& registry_;
  const measured::LogMap& map_;
  const MissingOptions& options_;
  ForecastOptions forecast_;
  std::vector<FitLog> train_;   // predictions hold it by reference
  std::vector<FitLog> judge_;   // time of the same logs that is not fitted: chooses effects
  std::vector<FitLog> report_;  // logs held out: have a say in what stays, and figures are of them; may be none
  TrialFits fits_{forecast_, train_};
  std::vector<std::string> logs_;
  std::optional<measured::YawRateOffset> by_yaw_;  // what the logs' yaw says of their yaw rate
  std::unique_ptr<Trial> given_, calibrated_, found_;
  std::vector<Unknown> observer_;            // of the given world, disturbances too
  std::vector<double> as_given_;             // its parameters, disturbances too
  std::vector<std::string> added_, tested_;  // effects; pointers of their parameters that move something alone
  MissingEffects out_;
};

/// Starts that are fitted and starts that are judged.
void MissingSearch::split(const std::list<measured::SessionFile>& files,
                          const std::list<measured::SessionFile>& held_out) {
  constexpr double shortest = 10.0, longest = 40.0;  // [s] of a period, half of which is held out
  double seconds = 0.0;
  for (const measured::SessionFile& file : files) seconds += file.session.t.back() - file.session.t.front();
  FitOptions dense = options_.fit;  // as many starts as wanted in what the search looks at
  const double looked_at = std::min(options_.searched_seconds, 0.5 * seconds);
  dense.starts = static_cast<std::size_t>(static_cast<double>(dense.starts) * seconds / looked_at);
  const std::vector<FitLog> logs = fit_logs(files, spec_.track, forecast_.step, dense);
  const double period = std::clamp(seconds / static_cast<double>(options_.stretches), shortest, longest);
  const HeldOutTimes times{period, 0.5 * period};
  for (const FitLog& log : logs) {
    logs_.push_back(log.session->name);
    train_.push_back(part_of(log, times, false));
    FitLog all(*log.session, forecast_.step, {horizon}, judged_every, options_.fit.slowest);
    all.track = log.track;
    judge_.push_back(part_of(all, times, true));
  }
  for (const measured::SessionFile& file : held_out) {
    report_.emplace_back(file.session, forecast_.step, std::vector<double>{horizon}, judged_every,
                         options_.fit.slowest);
    if (spec_.track && lies_on(file.session, *spec_.track)) report_.back().track = spec_.track;
  }
  const auto count = [](const std::vector<FitLog>& logs) {
    std::size_t starts = 0;
    for (const FitLog& log : logs) starts += log.starts.time.size();
    return starts;
  };
  if (count(judge_) == 0 || count(train_) == 0 || (!held_out.empty() && count(report_) == 0))
    throw InputError("no start of predictions lies in what is held out, or none outside; expected longer logs");
  train_ = thinned(train_, static_cast<std::size_t>(std::max(1.0, std::round(0.5 * seconds / looked_at))));
}

/// The slow force and steering angle by which an observer takes up what a model leaves unexplained.
bool is_disturbance(const Trial& trial, std::size_t index) {
  return index == trial.forecaster.index(Extra::gain_force) || index == trial.forecaster.index(Extra::gain_steer);
}

void quieten(const Trial& trial, std::vector<double>& params) {
  params[trial.forecaster.index(Extra::gain_force)] = params[trial.forecaster.index(Extra::gain_steer)] = 0.0;
}

/// The world as it is, its unknowns fitted. How predictions start is kept from then on. The observer learns no
/// disturbance: it would stand for what is missing, and a steering that is off would not be seen.
void MissingSearch::calibrate(const std::list<measured::SessionFile>& files) {
  given_ = std::make_unique<Trial>(spec_, forecast_);
  Errors errors;
  given_->params = parameters_of(tree_, given_->forecaster, errors);
  std::vector<double> values = given_->params;
  std::vector<Unknown> unknowns = read_unknowns(tree_, given_->places, values, {}, errors);
  errors.throw_if_any();
  start_delays(map_, files, given_->forecaster, tree_, values, unknowns);
  by_yaw_ = offset_by_yaw(files);
  hold_to_yaw(spec_, given_->places, by_yaw_, values, unknowns);
  for (const Unknown& u : unknowns)
    if (u.observer) observer_.push_back(u);
  as_given_ = given_->params;
  quieten(*given_, values);
  quieten(*given_, given_->params);
  std::erase_if(unknowns, [&](const Unknown& u) { return is_disturbance(*given_, u.index); });
  FitOptions fit_options = options_.fit;
  fit_options.tries = 1;
  fit_options.iterations = 6;
  const FitResult result = fit(given_->forecaster, train_, values, unknowns, fit_options);
  calibrated_ = std::make_unique<Trial>(spec_, forecast_);
  calibrated_->params = result.params;
  for (const FittedParameter& p : result.parameters)
    if (p.status == FittedParameter::Status::determined && !p.unknown.observer)
      calibrated_->unknowns.push_back(p.unknown);
  fits_.weighing = result.weighing;
  constexpr int more = 6;  // iterations, so that effects do not gain what steps alone would
  fits_.refit(*calibrated_, more);
  calibrated_->judged = judge(*calibrated_, judge_);
  given_->judged = judge(*given_, judge_);
  out_.judged = calibrated_->judged.rms();
}

/// What sensors alone would leave of errors, over what is usual.
void MissingSearch::measure_noise(const std::list<measured::SessionFile>& files) {
  double sum = 0.0, weight = 0.0;
  for (const measured::SessionFile& file : files)
    for (std::size_t c = 0; c < channels; ++c) {
      const auto noise = measured::noise_of(file.session, c, file.row_step);
      if (!noise) continue;
      const double w = fits_.weighing.channel[c] * fits_.weighing.channel[c],
                   z = noise->sigma / fits_.weighing.scale[c];
      sum += w * z * z;
      weight += w;
    }
  out_.noise = weight > 0.0 ? std::sqrt(sum / weight) : 0.0;
}

/// The same world as it predicts: with an observer that learns disturbances.
std::unique_ptr<Trial> MissingSearch::observed(const Trial& base) {
  constexpr int iterations = 4;
  auto trial = std::make_unique<Trial>(base.spec, forecast_);
  take_over(*trial, base);
  Trial start(given_->spec, forecast_);
  for (const Extra gain : {Extra::gain_force, Extra::gain_steer})
    trial->params[trial->forecaster.index(gain)] = as_given_[start.forecaster.index(gain)];
  start.unknowns = observer_;
  take_over_unknowns(*trial, start);
  fits_.refit(*trial, iterations);
  trial->judged = judge(*trial, judge_);
  return trial;
}

HorizonRow MissingSearch::row_of(const std::string& name, const Trial& trial) const {
  std::vector<double> when, predicted, truth;
  std::vector<FitLog> logs = told_of();
  const auto all = PredictionErrors(trial.forecaster, logs).errors(trial.params);
  double offset = 0.0;
  for (std::size_t l = 0; l < logs.size(); ++l) {
    const FitLog& log = logs[l];
    for (const double t : log.starts.time) when.push_back(offset + t - log.session->t.front());
    truth.insert(truth.end(), log.truth.begin(), log.truth.end());
    for (std::size_t k = 0; k < log.truth.size(); ++k) predicted.push_back(all[l][k] + log.truth[k]);
    offset += block_length * std::ceil((log.session->t.back() - log.session->t.front()) / block_length + 1.0);
  }
  return horizon_row(name, when, predicted, truth);
}

/// Fits one candidate, unless it stays behind the best so far, and keeps it if it is the best. Its row is filled if it
/// was judged: in the first round also where its fit was given up, whose gain and change are then of less than it can
/// do; such a fit is never kept.
void MissingSearch::try_one(const CandidateEffect& effect, const EffectScore& score, Best& best, RankedEffect& row) {
  auto trial = fits_.with(*found_, effect, score);
  const double rival = best.trial ? best.trial->cost : (1.0 - worth) * found_->cost;
  const bool near = fits_.refit_near(*trial, rival);
  if (!near && !added_.empty()) return;  // the first ones are told of whatever they do
  trial->judged = judge(*trial, judge_);
  row = {effect.id(), 1.0 - trial->cost / found_->cost, true, trial->judged.rms(),
         change_of(trial->judged, found_->judged)};
  // Whether it surely helps is asked in the end, beside the others: what is still missing is noise here.
  if (near && row.change.change < 0.0 && trial->cost < rival) best = {std::move(trial), effect.id()};
}

/// The effect that explains the fitted time best among those that lower the errors of the time held out. False: none
/// does.
bool MissingSearch::add_one() {
  const bool first = added_.empty();
  auto candidates =
      candidate_effects(found_->spec.vehicle, found_->spec.car.car, registry_, found_->spec.track != nullptr);
  hold_to_yaw(candidates, by_yaw_);
  auto scores = score_candidates(found_->vehicle.car(), candidates, forecast_, train_, found_->params, found_->unknowns,
                                 fits_.weighing);
  std::ranges::stable_sort(scores, std::greater<>(), &EffectScore::gain);
  std::vector<RankedEffect> rows;
  rows.reserve(scores.size());
  for (const EffectScore& one : scores) rows.push_back({candidates[one.candidate].id(), one.gain, false, 0.0, {}});
  std::vector<bool> asked(scores.size(), false);
  Best best;
  const auto try_at = [&](std::size_t i) {
    asked[i] = true;
    try_one(candidates[scores[i].candidate], scores[i], best, rows[i]);
  };
  for (std::size_t i = 0, tried = 0; i < scores.size() && tried < options_.tries; ++i) {
    if (!(scores[i].score > agreed)) continue;
    if (best.trial && !first && surpassed * scores[i].gain < 1.0 - best.trial->cost / found_->cost) break;
    ++tried;
    try_at(i);
  }
  for (std::size_t i = 0, tried = 0; i < scores.size() && best.effect.empty() && tried < options_.tries; ++i) {
    if (asked[i] || !(scores[i].apart < hidden) || !(scores[i].gain > faint)) continue;
    ++tried;
    try_at(i);
  }
  if (first) out_.ranking = std::move(rows);
  if (!best.trial) return false;
  added_.push_back(best.effect);
  const auto& chosen = *std::ranges::find(candidates, best.effect, &CandidateEffect::id);
  for (const std::size_t i : chosen.tested) tested_.push_back(pointer_of(best.effect, chosen.entry->params()[i].name));
  found_ = std::move(best.trial);
  return true;
}

/// The calibrated world without any effect added.
void MissingSearch::begin_with_calibrated() {
  added_.clear();
  out_.named.clear();
  found_ = std::make_unique<Trial>(spec_, forecast_);
  take_over(*found_, *calibrated_);
  found_->cost = calibrated_->cost;
  found_->judged = calibrated_->judged;
}

/// How far from doing nothing the fitted time says that an effect is, in half widths of its 95 % interval on that side:
/// above 1 an interval of one of its parameters leaves out the value that does nothing.
double MissingSearch::determined(const std::string& effect, const Bootstrap& boot) const {
  double most = 0.0;
  for (std::size_t i = 0; i < found_->unknowns.size(); ++i) {
    const Unknown& u = found_->unknowns[i];
    if (!u.pointer.starts_with(pointer_of(effect, "")) || std::ranges::find(tested_, u.pointer) == tested_.end())
      continue;
    const double value = found_->params[u.index], off = value - u.prior;
    const double half = off > 0.0 ? value - boot.interval[i].low : boot.interval[i].high - value;
    if (half > 0.0) most = std::max(most, std::abs(off) / half);
  }
  return most;
}

void MissingSearch::take_out(std::size_t index, std::unique_ptr<Trial> rest) {
  found_ = std::move(rest);
  added_.erase(added_.begin() + static_cast<std::ptrdiff_t>(index));
}

/// Takes out what the fitted time does not determine beside the others, the least determined first. Gives the normal
/// equations of what is left, nothing where that is the calibrated world.
NormalEquations MissingSearch::keep_what_is_determined() {
  while (!added_.empty()) {
    NormalEquations blocks = fits_.errors(*found_).linearise(found_->params, found_->unknowns);
    const Bootstrap boot = bootstrap(blocks, found_->params, found_->unknowns, options_.fit.seed);
    const auto how = [&](const std::string& effect) { return determined(effect, boot); };
    const auto least = std::ranges::min_element(added_, {}, how);
    if (how(*least) > 1.0) return blocks;
    auto rest = fits_.without(*found_, blocks, *least);
    rest->judged = judge(*rest, judge_);
    take_out(static_cast<std::size_t>(least - added_.begin()), std::move(rest));
  }
  return {};
}

/// What the errors without one of the effects say of it, beside the others and beside all that were there at first.
MissingSearch::Asked MissingSearch::ask(std::size_t index, const NormalEquations& blocks, const WitnessErrors& now,
                                        const WitnessErrors& first) {
  Asked one;
  one.rest = fits_.without(*found_, blocks, added_[index]);
  one.rest->judged = judge(*one.rest, judge_);
  const WitnessErrors less = errors_of(*one.rest);
  const WitnessChange by_it = compare(now, less);
  one.told = change_of(told(now), told(less));
  one.sure = by_it.sure;
  // Several may be needed together, none of them surely missed beside the rest: then those that went count with it.
  one.stays = by_it.smaller && std::max(by_it.sure, compare(first, less).sure) > sure_enough;
  return one;
}

/// Takes out what the others have made superfluous, the least sure first, and what logs held out contradict; never so
/// much that what is left is surely worse than all together. What was the least sure of those that are left is asked
/// first, and goes at once. All that stay were asked beside each other.
void MissingSearch::keep_what_helps() {
  if (added_.empty()) return;
  fits_.refit_until_still(*found_);  // as those without one of the effects are that it is compared with
  found_->judged = judge(*found_, judge_);
  const WitnessErrors first = errors_of(*found_);
  std::map<std::string, double> sure;  // of effects that were asked
  const auto known = [&](const std::string& effect) { return sure.contains(effect) ? sure[effect] : 0.0; };
  for (;;) {
    const NormalEquations blocks = keep_what_is_determined();
    if (added_.empty()) return;
    const WitnessErrors now = errors_of(*found_);
    std::ranges::stable_sort(added_, {}, known);
    std::vector<Asked> asked;
    for (std::size_t i = 0; i < added_.size(); ++i) {
      tell(0.75 + 0.2 * static_cast<double>(i) / static_cast<double>(added_.size()), "without " + added_[i]);
      asked.push_back(ask(i, blocks, now, first));
      const bool again = i == 0 && sure.contains(added_[i]);
      sure[added_[i]] = asked[i].sure;
      if (again && !asked[i].stays) break;
    }
    const auto worst =
        std::ranges::min_element(asked, {}, [](const Asked& one) { return one.stays ? INFINITY : one.sure; });
    if (worst->stays) {
      for (std::size_t i = 0; i < added_.size(); ++i) out_.named.push_back({added_[i], false, {}, asked[i].told});
      std::ranges::stable_sort(out_.named, {}, [](const MissingEffect& one) { return one.change.change; });
      return;
    }
    take_out(static_cast<std::size_t>(worst - asked.begin()), std::move(worst->rest));
  }
}

/// What effects do to each of the logs that figures are of.
void MissingSearch::compare_sessions(const ForecastErrors& before, const ForecastErrors& after) {
  const std::vector<FitLog>& logs = told_of();
  for (std::size_t l = 0; l < logs.size(); ++l) {
    const ForecastErrors calibrated = before.of_log(l), found = after.of_log(l);
    out_.sessions.push_back({logs[l].session->name, calibrated.rms(), found.rms(), change_of(found, calibrated)});
  }
}

/// Intervals of what was found.
std::vector<FittedParameter> MissingSearch::parameters_of_found() const {
  const Bootstrap boot = bootstrap(fits_.errors(*found_).linearise(found_->params, found_->unknowns), found_->params,
                                   found_->unknowns, options_.fit.seed);
  std::vector<FittedParameter> all;
  for (std::size_t i = 0; i < found_->unknowns.size(); ++i)
    all.push_back({found_->unknowns[i], found_->params[found_->unknowns[i].index], boot.interval[i],
                   FittedParameter::Status::determined});
  return all;
}

/// Values of the effects named.
void MissingSearch::name_values(std::span<const FittedParameter> parameters) {
  const PluginContext context = Trial::context_of(found_->spec);
  for (MissingEffect& named : out_.named)
    for (const PluginSpec& effect : found_->spec.vehicle.effects) {
      if (effect.id() != named.effect) continue;
      named.measurement = stage_of(effect, context) == Stage::reading;
      for (const abi::ParamDecl& p : effect.entry->params())
        for (const FittedParameter& fitted : parameters)
          if (fitted.unknown.pointer == pointer_of(named.effect, p.name))
            named.params.push_back({p.name, p.unit, fitted.value, fitted.interval.low, fitted.interval.high,
                                    fitted.unknown.low, fitted.unknown.high});
    }
}

/// The world with the effects named, their parameters among its unknowns, so that it can be fitted to more.
Node MissingSearch::world_found(const std::filesystem::path& folder) const {
  FitResult result;
  result.params = found_->params;
  result.parameters = out_.parameters;
  result.errors = out_.rows;
  for (const FitLog& log : train_) result.starts += log.starts.time.size();
  Node world = fitted_world(with_effects(tree_, found_->spec, added_), found_->spec, found_->forecaster, result,
                            {logs_, map_.file.filename().string()}, folder);
  open_parameters(world, added_, out_.parameters);
  return world;
}

MissingEffects MissingSearch::run(const std::list<measured::SessionFile>& files,
                                  const std::list<measured::SessionFile>& held_out,
                                  const std::filesystem::path& folder) {
  split(files, held_out);
  tell(0.05, "calibrating");
  calibrate(files);
  measure_noise(files);
  begin_with_calibrated();
  do {
    tell(0.25 + 0.5 * static_cast<double>(added_.size()) / static_cast<double>(options_.most),
         added_.empty() ? "looking for effects" : "beside " + added_.back());
  } while (added_.size() < options_.most && add_one());
  keep_what_helps();
  const WitnessErrors without = errors_of(*calibrated_);
  WitnessErrors with = errors_of(*found_);
  if (with.rms() > without.rms()) {
    begin_with_calibrated();
    with = without;
  }
  tell(0.9, "measuring");
  const ForecastErrors given = told(errors_of(*given_)), before = told(without), after = told(with);
  out_.calibration = change_of(before, given);
  out_.change = change_of(after, before);
  out_.all = change_of(after, given);
  out_.given = given.rms();
  out_.calibrated = before.rms();
  out_.found = after.rms();
  compare_sessions(before, after);
  out_.remainder = remainder_of(told_of(), after, horizon);
  name_values(parameters_of_found());  // without disturbances, which would stand for a part of an effect
  const auto calibrated = observed(*calibrated_);
  found_ = added_.empty() ? observed(*calibrated_) : observed(*found_);
  out_.parameters = parameters_of_found();
  std::ranges::stable_sort(out_.ranking, std::greater<>(), &RankedEffect::gain);  // fits have moved some
  std::stable_partition(out_.ranking.begin(), out_.ranking.end(),
                        [](const RankedEffect& r) { return !(r.tried && r.change.change > 0.0); });
  given_->params = as_given_;
  out_.rows = {row_of("given", *given_), row_of("calibrated", *calibrated), row_of("found", *found_)};
  out_.world = world_found(folder);
  out_.spec = found_->spec;
  out_.params = found_->params;
  return std::move(out_);
}

}  // namespace

std::string MissingEffect::Value::at_end() const {
  // Each end by itself: the other may be open. Where both are there their distance is a size too, for an end at 0.
  const double wide = std::isfinite(most - least) ? most - least : 0.0;
  const double close = 1e-9 * std::max(std::abs(value), wide);
  if (std::isfinite(least) && value <= least + close) return "low";
  if (std::isfinite(most) && value >= most - close) return "high";
  return {};
}

std::string MissingEffect::Value::text(int digits, bool interval) const {
  const std::string of = unit.empty() || unit == "1" ? "" : " " + unit;
  if (at_edge())
    return name + " is kept within its range [" + significant(least, digits) + ", " + significant(most, digits) + "]" +
           of;
  std::string text = name + " = " + significant(value, digits);
  if (interval) text += " (" + significant(low, digits) + " to " + significant(high, digits) + ")";
  return text + of;
}

bool MissingEffects::at_noise() const {
  // An error this little above the noise hides a tenth of it in squares: less than the noise is known to.
  // Readings that are predicted have their noise: a figure well above the error holds motion too, and tells nothing.
  constexpr double least = 0.9, as_large = 1.05;
  return noise > 0.0 && found >= least * noise && found <= as_large * noise;
}

MissingEffects find_missing(const Node& tree, const WorldSpec& spec, const Registry& registry,
                            const measured::LogMap& map, const std::list<measured::SessionFile>& files,
                            const std::list<measured::SessionFile>& held_out, const MissingOptions& options,
                            const std::filesystem::path& folder) {
  return MissingSearch(tree, spec, registry, map, options).run(files, held_out, folder);
}

}  // namespace gripline::calibrate
