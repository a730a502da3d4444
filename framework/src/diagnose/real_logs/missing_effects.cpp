#include "diagnose/real_logs/missing_effects.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "calibrate/fit/handling.hpp"
#include "calibrate/fit/prediction_rows.hpp"
#include "diagnose/real_logs/backward_elimination.hpp"
#include "diagnose/real_logs/effect_search.hpp"
#include "diagnose/real_logs/forward_selection.hpp"
#include "diagnose/thresholds.hpp"
#include "measured/estimates/session_noise.hpp"
#include "measured/session/session_windows.hpp"
#include "util/numbers.hpp"

namespace gripline::diagnose {

using calibrate::FitLog;
using calibrate::FittedParameter;
using calibrate::ForecastErrors;
using calibrate::Trial;

namespace {

/// Logs with the readings of rows in which the car moves, as it does where predictions start.
std::list<measured::SessionFile> while_moving(std::list<measured::SessionFile> files) {
  for (measured::SessionFile& file : files) file.session = measured::while_moving(std::move(file.session));
  return files;
}

/// Noise of each channel over all files, in its unit; 0 where none is measured.
measured::Channels noise_of_channels(const std::list<measured::SessionFile>& files) {
  measured::Channels sum{}, count{};
  for (const measured::SessionFile& file : files)
    for (std::size_t c = 0; c < measured::channels; ++c)
      if (const auto noise = measured::noise_of(file.session, c, file.row_step)) {
        sum[c] += noise->sigma * noise->sigma;
        count[c] += 1.0;
      }
  for (std::size_t c = 0; c < measured::channels; ++c) sum[c] = count[c] > 0.0 ? std::sqrt(sum[c] / count[c]) : 0.0;
  return sum;
}

/// Of the quantities that errors are weighed by.
MissingEffects::OverNoise largest_over_noise_of(const calibrate::HorizonRow& row,
                                                const std::list<measured::SessionFile>& files,
                                                const calibrate::Weighing& weighing) {
  using measured::Channel;
  const measured::Channels noise = noise_of_channels(files);
  const std::array<double, calibrate::quantities> of = {std::hypot(noise[Channel::x], noise[Channel::y]),
                                                        noise[Channel::yaw], noise[Channel::vx], noise[Channel::vy],
                                                        noise[Channel::yaw_rate]};
  constexpr std::array<const char*, calibrate::quantities> words = {"position", "yaw", "vx", "vy", "yaw rate"};
  MissingEffects::OverNoise out;
  constexpr std::array<std::size_t, calibrate::quantities> channel = {Channel::x, Channel::yaw, Channel::vx,
                                                                      Channel::vy, Channel::yaw_rate};
  for (std::size_t q = 0; q < calibrate::quantities; ++q)
    if (const double times = row.error[q].rms / of[q];
        weighing.channel[channel[q]] > 0.0 && of[q] > 0.0 && times > out.times)
      out = {words[q], times};
  return out;
}

/// The normalised error that sensor noise alone would leave; 0 where it is not known, for a channel that is judged
/// and has too few readings to show its noise.
double noise_of_sensors(const std::list<measured::SessionFile>& files, const calibrate::Weighing& weighing) {
  double sum = 0.0, weight = 0.0;
  for (std::size_t c = 0; c < calibrate::channels; ++c) {
    const double w = weighing.channel[c] * weighing.channel[c];
    constexpr std::size_t stray = 20;  // readings that hardly count
    std::size_t readings = 0;
    bool measured = false;
    for (const measured::SessionFile& file : files) {
      for (std::size_t i = 0; i < file.session.rows(); ++i) readings += std::isnan(file.session.at(i, c)) ? 0 : 1;
      const auto noise = measured::noise_of(file.session, c, file.row_step);
      if (!noise) continue;
      measured = true;
      const double z = noise->sigma / weighing.scale[c];
      sum += w * z * z;
      weight += w;
    }
    if (readings > stray && w > 0.0 && !measured) return 0.0;
  }
  return weight > 0.0 ? std::sqrt(sum / weight) : 0.0;
}

calibrate::HorizonRow reported_row(const EffectSearch& search, const std::string& name, const Trial& trial) {
  std::vector<FitLog> logs = search.logs.reported();
  return row_of_model(name, calibrate::PredictionErrors(trial.forecaster, logs), trial.params);
}

/// What effects do to each of the logs that figures are of.
std::vector<SessionChange> compare_sessions(const SearchLogs& logs, const ForecastErrors& before,
                                            const ForecastErrors& after) {
  std::vector<SessionChange> out;
  for (std::size_t l = 0; l < logs.reported().size(); ++l) {
    const ForecastErrors calibrated = before.of_log(l), found = after.of_log(l);
    out.push_back({logs.reported()[l].session->name, calibrated.rms(), found.rms(), change_of(found, calibrated)});
  }
  return out;
}

/// A world's unknowns with their intervals.
std::vector<FittedParameter> parameters_with_intervals(const EffectSearch& search, const Trial& found) {
  const calibrate::Bootstrap boot =
      calibrate::bootstrap(search.fits.errors(found).linearise(found.params, found.unknowns), found.params,
                           found.unknowns, search.options.fit.seed);
  std::vector<FittedParameter> all;
  for (std::size_t i = 0; i < found.unknowns.size(); ++i)
    all.push_back({found.unknowns[i], found.params[found.unknowns[i].index], boot.interval[i],
                   FittedParameter::Status::determined});
  return all;
}

/// Values of the effects named.
void fill_values(std::vector<MissingEffect>& named, const WorldSpec& found,
                 std::span<const FittedParameter> parameters) {
  const PluginContext context = Trial::context_of(found);
  for (MissingEffect& one : named)
    for (const PluginSpec& effect : found.vehicle.effects) {
      const std::string pointer = calibrate::pointer_of(effect.id(), "");
      if (!one.addition.pointer.starts_with(pointer)) continue;
      one.measurement = calibrate::stage_of(effect, context) == Stage::reading;
      for (const abi::ParamDecl& p : effect.entry->params())
        for (const FittedParameter& fitted : parameters)
          if (one.addition.owns(fitted.unknown.pointer) && fitted.unknown.pointer == pointer + p.name)
            one.params.push_back({p.name, p.unit, fitted.value, fitted.interval.low, fitted.interval.high,
                                  fitted.unknown.low, fitted.unknown.high});
    }
}

/// By the decrease, which fits have moved, those last that harm.
void order_ranking(std::vector<ScoredEffect>& ranking) {
  std::ranges::stable_sort(ranking, std::greater<>(), &ScoredEffect::less_error);
  std::stable_partition(ranking.begin(), ranking.end(),
                        [](const ScoredEffect& r) { return !(r.tried && r.change.change > 0.0); });
}

/// The world with the effects named, their parameters among its unknowns, so that it can be fitted to more.
Node world_of(const EffectSearch& search, const Selection& selection, const calibrate::FitResult& result,
              const std::filesystem::path& folder) {
  const Trial& trial = *selection.trial;
  Node world = fitted_world(calibrate::with_effects(search.tree, trial.spec, selection.added), trial.spec,
                            trial.forecaster, result, {search.logs.names, search.map.file.filename().string()}, folder);
  calibrate::open_parameters(world, selection.added, result.parameters, search.logs.names.size());
  return world;
}

/// Takes out what is not missed and looks once more beside what is left: what was taken out may have stood in the place
/// of another effect, which is worth its fit now. Gives what is left in the end.
std::vector<MissingEffect> eliminate_and_extend(const EffectSearch& search, Selection& selection) {
  std::vector<MissingEffect> named;
  std::vector<std::string> gone;
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<std::string> before;
    for (const calibrate::Addition& one : selection.added) before.push_back(one.name);
    named = eliminate_backward(search, selection);
    // Parameters that were opened beside a reading are none of the calibrated world.
    if (selection.added.empty()) selection = nothing_added(search);
    const std::size_t left = selection.added.size();
    if (left == before.size()) break;
    for (const std::string& name : before)
      if (std::ranges::find(selection.added, name, &calibrate::Addition::name) == selection.added.end())
        gone.push_back(name);
    if (pass == 0) extend_forward(search, selection, gone);
    if (selection.added.size() == left) break;
  }
  return named;
}

/// Reported errors of the world given, calibrated and found.
void measure_errors(const EffectSearch& search, const UnfittedErrors& without, const UnfittedErrors& with,
                    MissingEffects& out) {
  const UnfittedErrors of_given = search.unfitted_errors(*search.worlds.given);
  const ForecastErrors &given = search.reported(of_given), &before = search.reported(without),
                       &after = search.reported(with);
  out.calibration = change_of(before, given);
  out.change = change_of(after, before);
  out.all = change_of(after, given);
  out.given = given.rms();
  out.calibrated = before.rms();
  out.found = after.rms();
  out.validation = search.worlds.calibrated->validation.rms();
  out.sessions = compare_sessions(search.logs, before, after);
  out.remainder = remainder_of(search.logs.reported(), after, judged_horizon);
}

/// A trial fitted as `fit` does, to all of the time of the logs: what was held out has chosen the effects.
calibrate::FitResult fit_to_all(const EffectSearch& search, Trial& trial,
                                const std::list<measured::SessionFile>& files) {
  open_undetermined(search, trial);
  std::vector<FitLog> logs = fit_logs(files, search.spec.track, search.forecast.step, search.options.fit);
  calibrate::FitOptions once = search.options.fit;
  once.tries = 1;  // it begins where the search has ended, and leaves what these logs do not determine there
  once.undetermined_stay = true;
  calibrate::FitResult result = fit(trial.forecaster, logs, trial.params, trial.unknowns, once);
  result.friction = calibrate::friction_of(trial.vehicle.car(), trial.spec.car.car, result.params,
                                           result.bootstrap_draws, result.posterior_draws);
  return result;
}

/// The world with effects, fitted to all of the time of the logs with the observer that the calibrated world then has.
calibrate::FitResult fit_effects_to_all(const EffectSearch& search, Trial& calibrated, Trial& found,
                                        const std::list<measured::SessionFile>& files) {
  const calibrate::FitResult base = fit_to_all(search, calibrated, files);
  take_observer(search, calibrated, base.params, found);
  calibrate::FitResult result = fit_to_all(search, found, files);
  for (FittedParameter p : base.parameters) {
    if (!p.unknown.observer) continue;
    p.unknown.index += found.forecaster.car_params() - calibrated.forecaster.car_params();
    result.parameters.push_back(p);
  }
  return result;
}

/// Errors of the worlds as `predict` uses them, on time that none of them was fitted to, and the world that is
/// returned.
void write_worlds(const EffectSearch& search, Selection& selection, const std::list<measured::SessionFile>& files,
                  const std::filesystem::path& folder, MissingEffects& out) {
  Trial given(search.spec, search.forecast);
  given.params = search.worlds.given_params;
  const auto calibrated = with_disturbances(search, *search.worlds.calibrated);
  const bool none = selection.added.empty();
  selection.trial = none ? with_disturbances(search, *search.worlds.calibrated)
                         : with_observer_of(search, *calibrated, *selection.trial);
  Trial& found = *selection.trial;
  out.rows = {reported_row(search, "given", given), reported_row(search, "calibrated", *calibrated),
              reported_row(search, "found", found)};
  const calibrate::FitResult fitted =
      none ? fit_to_all(search, found, files) : fit_effects_to_all(search, *calibrated, found, files);
  for (const FittedParameter& p : fitted.parameters)
    (p.status == FittedParameter::Status::determined ? out.parameters : out.undetermined).push_back(p);
  out.spec = found.spec;
  out.params = fitted.params;
  out.world = world_of(search, selection, fitted, folder);
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
  return sum_at_noise() && !(largest_over_noise.times > thresholds::far_above_noise);
}

bool MissingEffects::sum_at_noise() const {
  // An error this little above the noise hides a tenth of it in squares: less than the noise is known to.
  constexpr double as_large = 1.05;
  return noise > 0.0 && !noise_too_large() && found <= as_large * noise;
}

bool MissingEffects::noise_too_large() const {
  // Readings that are predicted have their noise: a figure well above the error holds motion too, and tells nothing.
  constexpr double least = 0.9;
  return noise > 0.0 && found < least * noise;
}

std::vector<calibrate::FittedParameter> MissingEffects::own_parameters() const {
  std::vector<calibrate::FittedParameter> own;
  std::ranges::copy_if(parameters, std::back_inserter(own), [&](const calibrate::FittedParameter& p) {
    const auto owns = [&](const MissingEffect& n) { return n.addition.owns(p.unknown.pointer); };
    return !p.unknown.observer && std::ranges::none_of(named, owns);
  });
  return own;
}

MissingEffects find_missing(const Node& tree, const WorldSpec& spec, const Registry& registry,
                            const measured::LogMap& map, const std::list<measured::SessionFile>& files,
                            const std::list<measured::SessionFile>& held_out, const MissingOptions& options,
                            const std::filesystem::path& folder) {
  const EffectSearch search(tree, spec, registry, map, files, held_out, options);
  auto [selection, ranking] = select_forward(search);
  MissingEffects out;
  out.named = eliminate_and_extend(search, selection);
  const UnfittedErrors without = search.unfitted_errors(*search.worlds.calibrated);
  UnfittedErrors with = search.unfitted_errors(*selection.trial);
  if (with.rms() > without.rms()) {
    out.named.clear();
    selection = nothing_added(search);
    with = without;
  }
  search.tell(0.9, "measuring");
  measure_errors(search, without, with, out);
  const std::list<measured::SessionFile> moving = while_moving(files);
  out.noise = noise_of_sensors(moving, search.fits.weighing);
  order_ranking(ranking);
  out.ranking = std::move(ranking);
  // Without disturbances, which would stand for a part of an effect.
  fill_values(out.named, selection.trial->spec, parameters_with_intervals(search, *selection.trial));
  write_worlds(search, selection, files, folder, out);
  out.largest_over_noise = largest_over_noise_of(out.rows.back(), moving, search.fits.weighing);
  return out;
}

}  // namespace gripline::diagnose
