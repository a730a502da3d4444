#include "diagnose/real_logs/effect_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "calibrate/effects/start_of_fit.hpp"
#include "calibrate/effects/yaw_limit.hpp"
#include "calibrate/forecast/forecaster.hpp"
#include "config/errors.hpp"
#include "util/numbers.hpp"

namespace gripline::diagnose {

using calibrate::FitLog;
using calibrate::FittedParameter;
using calibrate::ForecastParameter;
using calibrate::Trial;
using calibrate::Unknown;

namespace {

constexpr int iterations_as_predicted = 4;  // of a world that was fitted without disturbances
constexpr std::array disturbance_gains = {ForecastParameter::gain_force, ForecastParameter::gain_steer};

calibrate::ForecastOptions search_forecast(const WorldSpec& spec) {
  calibrate::ForecastOptions out = calibrate::forecast_options(spec);
  out.own_commands = false;  // what is judged is one horizon
  return out;
}

std::size_t count_starts(const std::vector<FitLog>& logs) {
  std::size_t starts = 0;
  for (const FitLog& log : logs) starts += log.starts.time.size();
  return starts;
}

SearchLogs split_logs(const std::list<measured::SessionFile>& files, const std::list<measured::SessionFile>& held_out,
                      const std::shared_ptr<const Track>& track, double step, const MissingOptions& options) {
  constexpr double shortest = 10.0, longest = 40.0;  // [s] of a period, the second half of which is for validation
  SearchLogs out;
  double seconds = 0.0;
  for (const measured::SessionFile& file : files) seconds += file.session.t.back() - file.session.t.front();
  calibrate::FitOptions dense = options.fit;  // as many starts as wanted in what the search looks at
  const double looked_at = std::min(options.searched_seconds, 0.5 * seconds);
  dense.starts = static_cast<std::size_t>(static_cast<double>(dense.starts) * seconds / looked_at);
  const double period = std::clamp(seconds / static_cast<double>(options.stretches), shortest, longest);
  const calibrate::HeldOutTimes times{period, 0.5 * period};
  for (const FitLog& log : fit_logs(files, track, step, dense)) {
    out.names.push_back(log.session->name);
    out.fitted.push_back(part_of(log, times, false));
    FitLog all(*log.session, step, {judged_horizon}, calibrate::judged_every, options.fit.slowest);
    all.track = log.track;
    out.validation.push_back(part_of(all, times, true));
  }
  for (const measured::SessionFile& file : held_out) {
    out.held_out.emplace_back(file.session, step, std::vector<double>{judged_horizon}, calibrate::judged_every,
                              options.fit.slowest);
    if (track && calibrate::lies_on(file.session, *track)) out.held_out.back().track = track;
  }
  if (count_starts(out.validation) == 0 || count_starts(out.fitted) == 0 ||
      (!held_out.empty() && count_starts(out.held_out) == 0))
    throw InputError("no start of predictions lies in what is held out, or none outside; expected longer logs");
  out.fitted = thinned(out.fitted, static_cast<std::size_t>(std::max(1.0, std::round(0.5 * seconds / looked_at))));
  return out;
}

/// Whether an unknown is how fast the observer takes up what a model leaves unexplained, as a slow force or steering
/// angle.
bool is_disturbance(const Trial& trial, const Unknown& unknown) {
  return std::ranges::any_of(disturbance_gains,
                             [&](ForecastParameter gain) { return unknown.index == trial.forecaster.index(gain); });
}

/// The observer learns no disturbance any more.
void stop_disturbances(const Trial& trial, std::vector<double>& params) {
  for (const ForecastParameter gain : disturbance_gains) params[trial.forecaster.index(gain)] = 0.0;
}

/// Fits the world's unknowns; how predictions start and how errors are weighed is kept from then on. The observer
/// learns no disturbance: it would stand for what is missing, and a steering that is off would not be seen.
GivenAndCalibrated calibrate_given(EffectSearch& search, const std::list<measured::SessionFile>& files) {
  GivenAndCalibrated out;
  out.given = std::make_unique<Trial>(search.spec, search.forecast);
  Trial& given = *out.given;
  auto [as_given, values, unknowns, limited] =
      calibrate::start_of_fit(search.tree, given, search.map, files, search.by_yaw);
  given.params = std::move(as_given);
  for (const Unknown& u : unknowns)
    if (u.observer) out.observer.push_back(u);
  out.given_params = given.params;
  stop_disturbances(given, values);
  stop_disturbances(given, given.params);
  std::erase_if(unknowns, [&](const Unknown& u) { return is_disturbance(given, u); });
  calibrate::FitOptions fit_options = search.options.fit;
  fit_options.tries = 1;
  fit_options.iterations = 6;
  const calibrate::FitResult result =
      calibrate::fit(given.forecaster, search.logs.fitted, values, unknowns, fit_options);
  out.calibrated = std::make_unique<Trial>(search.spec, search.forecast);
  out.calibrated->params = result.params;
  for (const FittedParameter& p : result.parameters)
    if (p.status != FittedParameter::Status::determined)
      out.undetermined.push_back(p);
    else if (!p.unknown.observer)
      out.calibrated->unknowns.push_back(p.unknown);
  search.fits.weighing = result.weighing;
  constexpr int more = 6;  // iterations, so that effects do not gain what steps alone would
  search.fits.refit(*out.calibrated, more);
  search.validate(*out.calibrated);
  search.validate(given);
  return out;
}

}  // namespace

EffectSearch::EffectSearch(const Node& world_tree, const WorldSpec& world_spec, const Registry& plugins,
                           const measured::LogMap& log_map, const std::list<measured::SessionFile>& files,
                           const std::list<measured::SessionFile>& others, const MissingOptions& search_options)
    : tree(world_tree),
      spec(world_spec),
      registry(plugins),
      map(log_map),
      options(search_options),
      forecast(search_forecast(spec)),
      logs(split_logs(files, others, spec.track, forecast.step, options)),
      by_yaw(calibrate::offset_by_yaw(files)) {
  tell(0.05, "calibrating");
  worlds = calibrate_given(*this, files);
}

Selection nothing_added(const EffectSearch& search) {
  const Trial& calibrated = *search.worlds.calibrated;
  Selection out;
  out.trial = std::make_unique<Trial>(search.spec, search.forecast);
  take_over(*out.trial, calibrated);
  out.trial->cost = calibrated.cost;
  out.trial->validation = calibrated.validation;
  return out;
}

void open_undetermined(const EffectSearch& search, Trial& trial) {
  Trial closed(search.spec, search.forecast);
  for (const FittedParameter& p : search.worlds.undetermined)
    if (std::ranges::find(trial.unknowns, p.unknown.pointer, &Unknown::pointer) == trial.unknowns.end())
      closed.unknowns.push_back(p.unknown);
  if (closed.unknowns.empty()) return;
  take_over_unknowns(trial, closed);
  trial.cost = not_a_number;
}

void take_observer(const EffectSearch& search, const Trial& from, std::span<const double> values, Trial& to) {
  // Effects add parameters of the car, which stand before the observer's.
  const std::size_t before = from.forecaster.car_params(), now = to.forecaster.car_params();
  for (const Unknown& u : search.worlds.observer) to.params[u.index - before + now] = values[u.index];
}

std::unique_ptr<Trial> with_observer_of(const EffectSearch& search, const Trial& calibrated, const Trial& base) {
  auto trial = std::make_unique<Trial>(base.spec, search.forecast);
  take_over(*trial, base);
  take_observer(search, calibrated, calibrated.params, *trial);
  search.fits.refit(*trial, iterations_as_predicted);
  return trial;
}

std::unique_ptr<Trial> with_disturbances(const EffectSearch& search, const Trial& base) {
  auto trial = std::make_unique<Trial>(base.spec, search.forecast);
  take_over(*trial, base);
  Trial start(search.spec, search.forecast);
  for (const ForecastParameter gain : disturbance_gains)
    trial->params[trial->forecaster.index(gain)] = search.worlds.given_params[start.forecaster.index(gain)];
  start.unknowns = search.worlds.observer;
  take_over_unknowns(*trial, start);
  search.fits.refit(*trial, iterations_as_predicted);
  return trial;
}

}  // namespace gripline::diagnose
