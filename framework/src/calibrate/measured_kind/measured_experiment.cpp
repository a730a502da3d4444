#include "calibrate/measured_kind/measured_experiment.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "calibrate/effects/advice.hpp"
#include "calibrate/effects/effect_trial.hpp"
#include "calibrate/effects/place_effects.hpp"
#include "calibrate/effects/start_of_fit.hpp"
#include "calibrate/effects/yaw_limit.hpp"
#include "calibrate/fit/calibrated_world.hpp"
#include "calibrate/fit/fit_starts.hpp"
#include "calibrate/fit/session_adaptation.hpp"
#include "calibrate/forecast/baselines.hpp"
#include "config/errors.hpp"
#include "config/files.hpp"
#include "config/json_file.hpp"
#include "geometry/track_file.hpp"
#include "measured/health/session_health.hpp"
#include "measured/session/session_checks.hpp"
#include "world/world_spec.hpp"

namespace gripline::calibrate {
namespace {

constexpr int ablation_steps = 5;  // of a refit that begins at the fitted world

std::string row_name(std::string name) {
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

/// What rows call an effect: its id, with its index in the world's list where that has the id more than once.
std::string ablation_name(const PluginSpec& effect) {
  return effect.id() + (effect.index_in_list ? "_" + std::to_string(*effect.index_in_list) : "");
}

std::vector<std::string> row_names(const MeasuredSpec& spec) {
  std::vector<std::string> names;
  names.reserve(baseline_names.size() + 2 + spec.ablate.size());
  for (const char* name : baseline_names) names.push_back(row_name(name));
  names.insert(names.end(), {"before", "fitted"});
  for (const std::string& effect : spec.ablate) names.push_back("without_" + effect);
  return names;
}

/// All held-out starts of several logs after one another, their blocks apart.
struct Judged {
  std::vector<double> when, truth;
};
Judged judged_of(std::span<const FitLog> logs) {
  Judged all;
  double offset = 0.0;
  for (const FitLog& log : logs) {
    for (const double t : log.starts.time) all.when.push_back(offset + t - log.session->t.front());
    all.truth.insert(all.truth.end(), log.truth.begin(), log.truth.end());
    offset += 10.0 * std::ceil((log.session->t.back() - log.session->t.front()) / 10.0 + 1.0);
  }
  return all;
}

std::vector<double> joined(const std::vector<std::vector<double>>& parts) {
  std::vector<double> all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

std::vector<double> predictions(const Forecaster& forecaster, std::span<const FitLog> logs,
                                std::span<const double> params, std::span<const Unknown> moving = {},
                                const SessionWeighing& weighing = {}) {
  std::vector<std::vector<double>> parts;
  for (const FitLog& log : logs) parts.push_back(predict_session(forecaster, log, params, moving, weighing));
  return joined(parts);
}

/// An unknown in a world that lacks the parameters `first` to `first + gone`; nothing where it was of those alone.
std::optional<Unknown> without(Unknown u, std::size_t first, std::size_t gone) {
  const auto is_gone = [&](std::size_t index) { return index >= first && index < first + gone; };
  std::erase_if(u.same, [&](const Unknown::Same& s) { return is_gone(s.index); });
  if (is_gone(u.index)) {
    if (u.same.empty()) return std::nullopt;
    u.pointer = u.same.front().pointer;
    u.index = u.same.front().index;
    u.same.erase(u.same.begin());
  }
  if (u.index >= first) u.index -= gone;
  for (Unknown::Same& s : u.same)
    if (s.index >= first) s.index -= gone;
  return u;
}

/// Root mean square of one set of predictions less another's, over the same starts, with drawn blocks.
std::array<HorizonError, quantities> change_of(const Judged& judged, std::span<const double> with,
                                               std::span<const double> without) {
  std::array<HorizonError, quantities> out;
  for (std::size_t q = 0; q < quantities; ++q) out[q] = paired_change(judged.when, with, without, judged.truth, q);
  return out;
}

/// The world as written and as read; its road may be stated beside it.
void read_own_world(ObjectReader& r, const Node& world, const Registry& registry, Errors& errors, MeasuredSpec& spec) {
  spec.tree = world;
  inline_file(spec.tree);
  inline_world_files(spec.tree);
  Node read = spec.tree;
  if (const Node* const track = r.find("track"); track != nullptr) {
    spec.track = *track;
    read.erase("track");
  }
  read.erase("start");
  if (read.find("duration") == nullptr && read.find("laps") == nullptr) read.set("duration", Node(1.0));
  spec.world = read_world(read, registry, errors, RoadRule::optional);
}

void read_log_names(ObjectReader& r, Errors& errors, MeasuredSpec& spec) {
  if (r.has("map")) spec.map = r.input_file("map", json_ending);
  for (const Node& log : r.array("logs"))
    if (log.is_text())
      spec.logs.push_back(resolve_path(log));
    else
      errors.add(log.origin, "expected the name of a log, found " + log.describe());
  if (spec.logs.empty()) r.error_at("logs", "expected one log at least");
}

/// What is held out, and what is judged there.
void read_judged_time(ObjectReader& r, MeasuredSpec& spec) {
  if (r.has("held_out")) {
    ObjectReader held_out = r.object("held_out");
    spec.held_every = held_out.number("every", "s", NumberRange::positive(), spec.held_every);
    spec.held_length = held_out.number("length", "s", NumberRange::positive(), spec.held_length);
    if (!(spec.held_length < spec.held_every)) held_out.error("its length must be less than its period");
  }
  spec.horizon = r.number("horizon", "s", NumberRange::at_most(10.0), spec.horizon);
  spec.every = r.number("every", "s", NumberRange::positive(), spec.every);
  if (spec.horizon >= spec.held_length) r.error_at("horizon", "expected less than a held-out block");
}

/// The effects that "ablate" names, each once; an id that the world has more than once names them all.
void read_ablate(ObjectReader& r, Errors& errors, MeasuredSpec& spec) {
  std::vector<std::string> ids;
  for (const PluginSpec& effect : spec.world.vehicle.effects) ids.push_back(effect.id());
  for (const Node& one : r.array("ablate")) {
    if (ids.empty()) {
      errors.add(one.origin, "the world has no effect to take out");
      continue;
    }
    const std::string& id = ids[read_choice(one, ids, errors)];
    for (const PluginSpec& effect : spec.world.vehicle.effects)
      if (effect.id() == id && std::ranges::find(spec.ablate, ablation_name(effect)) == spec.ablate.end())
        spec.ablate.push_back(ablation_name(effect));
  }
}

/// Effects that are taken out again, all of the world's where none are named, and claims on the rows.
void read_rows(ObjectReader& r, Errors& errors, MeasuredSpec& spec) {
  if (r.has("ablate"))
    read_ablate(r, errors, spec);
  else
    for (const PluginSpec& effect : spec.world.vehicle.effects) spec.ablate.push_back(ablation_name(effect));
  const std::vector<std::string> columns(quantity_names.begin(), quantity_names.end()), rows = row_names(spec);
  for (const Node& claim : r.array("claims", false))
    if (auto read = read_claim(claim, rows, errors, columns)) spec.claims.push_back(*std::move(read));
}

}  // namespace

MeasuredSpec read_measured(const Node& tree, const Registry& registry) {
  Errors errors;
  ObjectReader r(tree, errors);
  MeasuredSpec spec;
  (void)r.find("kind");
  if (const Node* const world = r.require("world", "a world file or an object"); world != nullptr)
    read_own_world(r, *world, registry, errors, spec);
  read_log_names(r, errors, spec);
  read_judged_time(r, spec);
  if (errors.empty() && !spec.world.track && !spec.track)  // before their rows are read: what is not there has none
    spec.left_out = leave_out_place_effects(spec.world.vehicle, spec.world.car.car);
  read_rows(r, errors, spec);
  r.finish();
  errors.throw_if_any();
  require_vehicle_model(spec.world, "a fit");
  if (!spec.map.empty()) (void)measured::load_log_map(spec.map);
  return spec;
}

namespace {

class MeasuredRun {
 public:
  MeasuredRun(const MeasuredSpec& spec, const Registry& registry,
              const std::function<void(std::size_t, std::size_t, const std::string&)>& progress)
      : spec_(spec),
        registry_(registry),
        progress_(progress),
        map_(spec.map.empty() ? measured::gripline_map() : measured::load_log_map(spec.map)) {
    if (spec_.track) {
      Errors errors;
      if (auto track = read_track(*spec_.track, errors))
        spec_.world.track = std::make_shared<const Track>(*std::move(track));
      errors.throw_if_any();
    }
    options_ = forecast_options(spec.world);
    options_.own_commands = false;  // what is judged is one horizon
    fit_.slowest = slowest_start(spec.world);
    fit_.crawling = spec.world.car.car.v_min;
  }

  MeasuredOutcome run() {
    read_logs();
    const Trial given(spec_.world, options_);
    const Forecaster& forecaster = given.forecaster;
    const auto by_yaw = offset_by_yaw(files_, {spec_.held_every, spec_.held_length});
    const StartOfFit start = start_of_fit(spec_.tree, given, map_, files_, by_yaw);
    report_progress("fit");
    out_.fit = fit(forecaster, train_, start.values, start.unknowns, fit_);
    out_.fit.friction = friction_of(given.vehicle.car(), spec_.world.car.car, out_.fit.params, out_.fit.bootstrap_draws,
                                    out_.fit.posterior_draws);
    out_.fit.advice = advise(spec_.world, registry_, options_, train_, out_.fit, by_yaw);
    judge_rows(forecaster, start.values);
    for (const std::string& effect : spec_.ablate) ablate(effect);
    FitSource source;
    for (const auto& file : files_) source.logs.push_back(file.session.name);
    source.map = spec_.map.filename().string();
    out_.fitted = fitted_world(spec_.tree, spec_.world, forecaster, out_.fit, source, ".");
    judge_claims();
    out_.road = spec_.world.track;
    return std::move(out_);
  }

 private:
  void report_progress(const std::string& what) {
    if (progress_) progress_(done_, spec_.ablate.size() + 2, what);
    ++done_;
  }

  void read_logs() {
    report_progress("read");
    for (const auto& log : spec_.logs) {
      if (const std::string why = why_unreadable(log); !why.empty()) throw InputError(shown(log) + ": " + why);
      files_.push_back(measured::read_session(log, map_));
      measured::check_session(files_.back(), spec_.world.car.car.v_ref, spec_.world.car.car.delta_max);
      out_.health.emplace_back(files_.back().session.name, measured::health_of(files_.back()));
    }
    for (const FitLog& log : fit_logs(files_, spec_.world.track, options_.step, fit_)) {
      train_.push_back(part_of(log, {spec_.held_every, spec_.held_length}, false));
      FitLog all(*log.session, options_.step, {spec_.horizon}, spec_.every, fit_.slowest);
      all.track = log.track;
      judge_.push_back(part_of(all, {spec_.held_every, spec_.held_length}, true));
    }
    judged_ = judged_of(judge_);
    if (judged_.when.empty())
      throw InputError("no start lies in a held-out block; expected longer logs or shorter blocks");
  }

  void judge_rows(const Forecaster& forecaster, std::span<const double> values) {
    for (std::size_t b = 0; b < baseline_names.size(); ++b) {
      std::vector<std::vector<double>> parts;
      for (const FitLog& log : judge_)
        parts.push_back(baseline(static_cast<Baseline>(b), *log.session, log.starts, options_.wheelbase));
      out_.rows.push_back(horizon_row(row_name(baseline_names[b]), judged_.when, joined(parts), judged_.truth));
    }
    out_.rows.push_back(horizon_row("before", judged_.when, predictions(forecaster, judge_, values), judged_.truth));
    std::vector<Unknown> all;
    for (const FittedParameter& p : out_.fit.parameters) all.push_back(p.unknown);
    fitted_ = predictions(forecaster, judge_, out_.fit.params, session_unknowns(all), weighing());
    out_.rows.push_back(horizon_row("fitted", judged_.when, fitted_, judged_.truth));
    std::size_t at = 0;
    for (const FitLog& log : judge_) {
      const std::size_t n = log.starts.time.size() * channels;
      out_.held_out.push_back(
          {log.session->name,
           log.session->begin,
           log.starts.time,
           {fitted_.begin() + static_cast<std::ptrdiff_t>(at), fitted_.begin() + static_cast<std::ptrdiff_t>(at + n)},
           log.truth});
      at += n;
    }
  }

  SessionWeighing weighing() const {
    std::array<double, quantities> rms{};
    for (std::size_t q = 0; q < quantities; ++q) rms[q] = out_.fit.errors.back().error[q].rms;
    return session_weighing(rms);
  }

  /// The world without an effect, its other unknowns fitted again from where they stood.
  void ablate(const std::string& effect) {
    report_progress("without " + effect);
    WorldSpec world = spec_.world;
    std::size_t offset = world.vehicle.model.entry->params().size();
    std::size_t index = 0;
    while (ablation_name(world.vehicle.effects[index]) != effect)
      offset += world.vehicle.effects[index++].entry->params().size();
    const std::size_t gone = world.vehicle.effects[index].entry->params().size();
    world.vehicle.effects.erase(world.vehicle.effects.begin() + static_cast<std::ptrdiff_t>(index));
    std::vector<double> params = out_.fit.params;
    params.erase(params.begin() + static_cast<std::ptrdiff_t>(offset),
                 params.begin() + static_cast<std::ptrdiff_t>(offset + gone));
    std::vector<Unknown> unknowns;
    for (const FittedParameter& p : out_.fit.parameters) {
      if (p.status != FittedParameter::Status::determined) continue;
      if (auto left = without(p.unknown, offset, gone)) unknowns.push_back(*std::move(left));
    }
    const Trial rest(std::move(world), options_);
    PredictionErrors errors(rest.forecaster, train_);
    errors.weighing = out_.fit.weighing;
    LeastSquaresOptions steps;
    steps.iterations = ablation_steps;
    double cost = 0.0;
    params = least_squares(errors, unknowns, params, steps, cost);
    const std::vector<double> without =
        predictions(rest.forecaster, judge_, params, session_unknowns(unknowns), weighing());
    out_.ablations.push_back({effect, horizon_row("without_" + effect, judged_.when, without, judged_.truth),
                              change_of(judged_, fitted_, without)});
  }

  void judge_claims() {
    const auto lookup = [&](const std::string& row, const std::string& column, int) -> std::optional<double> {
      const auto at = std::find(quantity_names.begin(), quantity_names.end(), column);
      if (at == quantity_names.end()) return std::nullopt;
      const auto q = static_cast<std::size_t>(at - quantity_names.begin());
      const auto value = [&](const HorizonRow& r) -> std::optional<double> {
        return r.error[q].count > 0 ? std::optional(r.error[q].rms) : std::nullopt;
      };
      for (const HorizonRow& r : out_.rows)
        if (r.name == row) return value(r);
      for (const Ablation& a : out_.ablations)
        if (a.error.name == row) return value(a.error);
      return std::nullopt;
    };
    for (const Claim& claim : spec_.claims) out_.claims.push_back(judge(claim, 1, 1.0, lookup));
  }

  MeasuredSpec spec_;  // with its road
  const Registry& registry_;
  const std::function<void(std::size_t, std::size_t, const std::string&)>& progress_;
  measured::LogMap map_;
  ForecastOptions options_;
  FitOptions fit_;
  std::list<measured::SessionFile> files_;
  std::vector<FitLog> train_, judge_;
  Judged judged_;
  std::vector<double> fitted_;
  MeasuredOutcome out_;
  std::size_t done_ = 0;
};

}  // namespace

MeasuredOutcome run_measured(const MeasuredSpec& spec, const Registry& registry,
                             const std::function<void(std::size_t, std::size_t, const std::string&)>& progress) {
  return MeasuredRun(spec, registry, progress).run();
}

}  // namespace gripline::calibrate
