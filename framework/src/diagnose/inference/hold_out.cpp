#include "diagnose/inference/hold_out.hpp"

#include <algorithm>
#include <cmath>

#include "diagnose/inference/reference.hpp"
#include "measured/log/rounding.hpp"

namespace gripline::diagnose {
namespace {

/// First sample held out: of the last whole laps, about a third of the log (thresholds::hold_out_part); below three
/// laps of its last third.
std::size_t hold_out_from(const Trace& trace) {
  std::vector<double> laps(trace.size(), 0.0);
  for (std::size_t k = 1; k < trace.size(); ++k) {
    double step = trace.at[k].lap_fraction - trace.at[k - 1].lap_fraction;
    laps[k] = laps[k - 1] + std::abs(step - std::round(step));
  }
  const double third = laps.back() / static_cast<double>(thresholds::hold_out_part);
  if (third < 1.0) return trace.size() - trace.size() / thresholds::hold_out_part;
  const double from = laps.back() - std::floor(third);
  return static_cast<std::size_t>(std::lower_bound(laps.begin(), laps.end(), from) - laps.begin());
}

constexpr std::size_t burn_in = 10;  // first sample of a part that predictions start from
constexpr double judged = 1.0;       // [s] duration of the predictions that a model is judged by

std::size_t samples_in(double seconds, const Trace& trace) {
  return static_cast<std::size_t>(std::max(1.0, std::round(seconds / trace.log.dt)));
}

/// Whether both parts of a trace, before a sample and from it on, hold a whole prediction: else nothing would be
/// judged, or next to nothing fitted. Ten samples are long at a low rate, and short at a high one.
bool can_be_parted(const Trace& trace, std::size_t from) {
  const std::size_t least = burn_in + samples_in(judged, trace) + 1;
  return from >= least && trace.size() >= from + least;
}

/// Appends the squared errors of every start.
void add_errors(const measured::Rollouts& r, const Channels& sigma, StartErrors& to) {
  const std::size_t width = r.samples * channels;
  for (std::size_t s = 0; s < r.start.size(); ++s) {
    const measured::SquaredErrors of_start = squared_errors(r, s * width, (s + 1) * width, sigma);
    to.square.push_back(of_start.sum);
    to.readings.push_back(static_cast<double>(of_start.readings));
  }
}

}  // namespace

bool shares_bend(const Log& log, const Problem& problem) {
  return std::ranges::any_of(problem.traces, [&](const Trace& trace) {
    return std::abs(log.dt - trace.log.dt) <= thresholds::same_rate * trace.log.dt;
  });
}

Trace as_fitted(const Log& log, const Problem& problem, const Road& road) {
  Trace trace;
  trace.log = log;
  if (problem.unrounded) trace.unround_commands(problem.command_step);
  const double held = problem.hold().seconds(problem.traces.front().log.dt);
  measured::hold_commands(trace.log, problem.hold().until_next ? problem.hold() : measured::held_for(held, log.dt));
  trace.bend_commands(shares_bend(log, problem) ? problem.bend : Commands{});
  trace.set_motion(smooth_readings(log, 3), road);
  return trace;
}

measured::RolloutOptions rollout_options(const Problem& problem, const Trace& trace, double horizon, std::size_t from) {
  measured::RolloutOptions options;
  options.horizon = horizon;
  options.first = from + burn_in;
  options.every = samples_in(thresholds::start_spacing, trace);
  options.substeps = problem.substeps;
  return options;
}

HoldOut::HoldOut(const Problem& problem, const Road& road, std::span<const LogFile> held_out)
    : road_(road), training_(problem), holds_out_laps_(held_out.empty()) {
  for (const LogFile& log : held_out)
    for (const Log& m : log.stretches) {
      traces_.push_back(as_fitted(m, problem, road_));
      from_.push_back(0);
    }
  if (!holds_out_laps_) return;
  training_.shape_prior = true;
  for (Trace& trace : training_.traces) {
    const std::size_t from = hold_out_from(trace);
    if (!can_be_parted(trace, from)) continue;  // training data as a whole
    traces_.push_back(trace);
    from_.push_back(from);
    trace.cut(from);
  }
}

Fit HoldOut::refit(const Fit& f) const {
  return holds_out_laps_ && !f.theta.empty() ? fit(training_, f.model, f.noise, 3) : f;
}

std::vector<StartErrors> HoldOut::predict(const Fit& f, std::span<const double> horizons) const {
  return predict_along(traces_, from_, f, horizons);
}

StartErrors HoldOut::predict_refitted(const Fit& f) const {
  constexpr std::array<double, 1> second = {judged};
  return std::move(predict(refit(f), second).front());
}

measured::Rollouts HoldOut::predict_in_turn(const Fit& f) const {
  Problem first = training_;
  first.traces.assign(1, traces_.front());
  iterate_reference(first, road_, f);
  const Trace& trace = first.traces.front();
  measured::RolloutOptions options = rollout_options(training_, trace, judged, from_.front());
  options.every = samples_in(judged, trace);
  return roll_out(training_.catalogue->build(f.model), trace, road_, options);
}

StartErrors HoldOut::predict_training(const Fit& f) const {
  constexpr std::array<double, 1> second = {judged};
  const std::vector<std::size_t> from(training_.traces.size(), 0);
  return std::move(predict_along(training_.traces, from, f, second).front());
}

ErrorChange HoldOut::change(const Fit& with, const Fit& without) const {
  const ErrorChange held_out = compare(predict_refitted(with), predict_refitted(without));
  return held_out.measured() ? held_out : compare(predict_training(with), predict_training(without));
}

std::vector<StartErrors> HoldOut::predict_along(std::vector<Trace> traces, std::span<const std::size_t> from,
                                                const Fit& f, std::span<const double> horizons) const {
  Problem other = training_;
  other.traces = std::move(traces);
  iterate_reference(other, road_, f);
  const StagedCar car = training_.catalogue->build(f.model);
  std::vector<StartErrors> all;
  for (const double horizon : horizons) {
    StartErrors& errors = all.emplace_back();
    for (std::size_t i = 0; i < other.traces.size(); ++i) {
      const Trace& trace = other.traces[i];
      add_errors(roll_out(car, trace, road_, rollout_options(training_, trace, horizon, from[i])), training_.sensor,
                 errors);
    }
  }
  return all;
}

}  // namespace gripline::diagnose
