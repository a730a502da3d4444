#include "calibrate/fit/fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "calibrate/fit/fit_starts.hpp"
#include "calibrate/fit/prediction_rows.hpp"
#include "calibrate/forecast/baselines.hpp"
#include "config/errors.hpp"
#include "util/normal_draw.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::calibrate {
namespace {

constexpr double learned_enough = 0.1;  // of the prior's variance, for a parameter to count as determined
// Relative decrease of the cost below which a search ends from which another one goes on, with other scales or errors.
constexpr double coarse_tolerance = 3e-3;

void print_line(const FitOptions& options, const std::string& text) {
  if (options.print) options.print(text);
}

// Shares of the work that are done when the short searches are, and when the best of them were followed with more
// starts.
constexpr double after_searches = 0.4, after_following = 0.6;
void report_progress(const FitOptions& options, double share, const std::string& what) {
  if (options.progress) options.progress(share, what);
}

/// The prior itself, then draws from it at half its width.
std::vector<double> start_of(int attempt, std::span<const double> values, std::span<const Unknown> unknowns,
                             unsigned seed) {
  std::vector<double> start(values.begin(), values.end());
  if (attempt == 0) return start;
  std::mt19937 random(seed + static_cast<unsigned>(attempt));
  Eigen::VectorXd move(static_cast<Eigen::Index>(unknowns.size()));
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const double draw = nearly_normal(random);
    move(static_cast<Eigen::Index>(i)) = unknowns[i].observer ? 0.0 : 0.5 * unknowns[i].sigma * draw;
  }
  return after_step(values, unknowns, move);
}

/// Logs with their starts, which are asked for one horizon only.
std::vector<FitLog> at_horizon(std::vector<FitLog> logs, double horizon) {
  for (FitLog& log : logs) {
    log.starts.horizons = {horizon};
    log.truth = readings_at(*log.session, log.starts);
  }
  return logs;
}

/// The best of several short searches over few starts. Each begins with short predictions, whose errors are nearly
/// linear in the parameters: errors of a second of wrong driving have many minima.
std::vector<double> search(const Forecaster& forecaster, const std::vector<FitLog>& logs,
                           std::span<const double> values, std::span<const Unknown> unknowns,
                           const FitOptions& options) {
  std::vector<FitLog> few = thinned(logs, 4), near = at_horizon(few, 0.5 * options.horizons.front());
  PredictionErrors errors(forecaster, few), short_errors(forecaster, near);
  errors.weighing.horizon = options.horizon_weight;
  short_errors.weighing.horizon = {1.0};
  LeastSquaresOptions quick;
  quick.tolerance = coarse_tolerance;
  constexpr std::size_t followed = 2;  // attempts: a minimum in which one start spins is found out by all starts
  struct Found {
    std::vector<double> params;
    double cost = 0;
  };
  std::vector<Found> found;
  for (int attempt = 0; attempt < options.tries; ++attempt) {
    report_progress(options, after_searches * attempt / options.tries,
                    "search " + std::to_string(attempt + 1) + " of " + std::to_string(options.tries));
    Found one{start_of(attempt, values, unknowns, options.seed)};
    for (const int steps : {2, 3}) {
      short_errors.set_scales(one.params);
      quick.iterations = steps;
      one.params = least_squares(short_errors, unknowns, one.params, quick, one.cost);
    }
    if (attempt == 0) errors.set_scales(one.params);  // of all attempts, so that they can be compared
    one.cost = errors.cost(one.params) + prior_cost(one.params, unknowns);
    found.push_back(std::move(one));
  }
  std::stable_sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.cost < b.cost; });
  found.resize(std::min(found.size(), followed));
  std::vector<FitLog> all = logs;
  PredictionErrors judge(forecaster, all);
  judge.weighing.horizon = options.horizon_weight;
  for (Found& one : found) {
    const auto number = static_cast<double>(&one - found.data());
    report_progress(options,
                    after_searches + (after_following - after_searches) * number / static_cast<double>(found.size()),
                    "the best searches, with more starts");
    for (const int steps : {3, 4, 4}) {
      errors.set_scales(one.params);
      quick.iterations = steps;
      one.params = least_squares(errors, unknowns, one.params, quick, one.cost);
    }
    if (&one == &found.front()) judge.set_scales(one.params);
    one.cost = judge.cost(one.params) + prior_cost(one.params, unknowns);
  }
  return std::min_element(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.cost < b.cost; })
      ->params;
}

bool at_bound(const Unknown& u, double value) {
  return value <= u.low || value >= u.high;  // a search stops there exactly
}

/// What is known of an unknown about a value before any log is read.
Interval interval_of_prior(const Unknown& u, double about, Interval found) {
  const double off = normal_95 * u.sigma;
  found.low = std::clamp(u.log ? about * std::exp(-off) : about - off, u.low, u.high);
  found.high = std::clamp(u.log ? about * std::exp(off) : about + off, u.low, u.high);
  return found;
}

/// Unknowns that are not determined go back to `rest`, by parameter, or to their priors where that is empty. Those at a
/// bound stay there: what the logs want beyond it is nearest to it, and at the prior the others would have to make up
/// for it. What is left is what is fitted then.
std::vector<Unknown> fix_undetermined(FitResult& result, std::span<const Unknown> unknowns,
                                      std::span<const Interval> intervals, std::span<const double> rest) {
  std::vector<Unknown> kept;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    const Unknown& u = unknowns[i];
    auto status = FittedParameter::Status::determined;
    const bool bound = at_bound(u, result.params[u.index]);
    const double value = rest.empty() ? u.prior : rest[u.index];
    // There, which only the logs can do: neither where the fit began nor where the prior draws it.
    const bool moved = result.params[u.index] != value && result.params[u.index] != u.prior;
    if (!u.observer && bound && (moved || intervals[i].learned >= learned_enough))
      status = FittedParameter::Status::at_bound;
    else if (!u.observer && intervals[i].learned < learned_enough)
      status = FittedParameter::Status::undetermined;
    if (status == FittedParameter::Status::determined) {
      kept.push_back(u);
      continue;
    }
    if (status == FittedParameter::Status::at_bound) {
      result.parameters.push_back({u, result.params[u.index], intervals[i], status});
      continue;
    }
    assign(result.params, u, value);
    result.parameters.push_back({u, value, interval_of_prior(u, value, intervals[i]), status});
  }
  return kept;
}

/// The unknowns that are fitted, and behind them those that are not determined: what is not known of these, the values
/// of the others depend on, and their intervals say so.
std::vector<Unknown> with_undetermined(std::vector<Unknown> fitted, std::span<const FittedParameter> fixed) {
  for (const FittedParameter& p : fixed)
    if (p.status == FittedParameter::Status::undetermined) fitted.push_back(p.unknown);
  return fitted;
}

constexpr double start_spacing = 0.1;  // [s] between starts at least

/// A log that is fitted from this speed on, with the time that its car drives so.
struct Driven {
  const measured::SessionFile* file;
  double slowest, seconds;  // [m/s], [s]
};

/// Of a log that is slow throughout, of parking or of a steering test, starts where its car moves at all; nothing where
/// it hardly moves.
std::optional<Driven> driven_in(const measured::SessionFile& file, double grid_step, const FitOptions& options) {
  constexpr std::size_t enough = 5;  // starts, for a log to be fitted
  for (const double slowest : {options.slowest, std::min(options.crawling, options.slowest)}) {
    const FitLog all(file.session, grid_step, options.horizons, start_spacing, slowest);
    if (all.starts.time.size() >= enough)
      return Driven{&file, slowest, start_spacing * static_cast<double>(all.starts.time.size())};
  }
  return std::nullopt;
}

/// The logs that can be fitted; a line is printed on each that is left out.
std::vector<Driven> driven_logs(const std::list<measured::SessionFile>& files, double grid_step,
                                const FitOptions& options) {
  const std::string fast = "faster than " + significant(options.crawling, 3) + " m/s with " +
                           significant(options.horizons.back(), 3) + " s of log to come; ";
  std::vector<Driven> driven;
  for (const measured::SessionFile& file : files) {
    if (const auto one = driven_in(file, grid_step, options)) {
      driven.push_back(*one);
      continue;
    }
    const std::string problem = file.session.name + ": hardly anywhere in it is the car " + fast;
    if (files.size() == 1) throw InputError(problem + "there is nothing to fit");
    print_line(options, problem + "left out");
  }
  if (driven.empty()) throw InputError("in none of the logs is the car " + fast + "there is nothing to fit");
  // Static friction and play, which no model here has, rule a crawl: it counts where nothing else is there.
  const auto is_slow = [&](const Driven& one) { return one.slowest < options.slowest; };
  if (std::ranges::all_of(driven, is_slow)) return driven;
  for (const Driven& one : driven)
    if (is_slow(one))
      print_line(options, one.file->session.name + ": slower than " + significant(options.slowest, 3) +
                              " m/s throughout, other logs are not; left out");
  std::erase_if(driven, is_slow);
  return driven;
}

}  // namespace

std::vector<FitLog> fit_logs(const std::list<measured::SessionFile>& files, const std::shared_ptr<const Track>& track,
                             double grid_step, const FitOptions& options) {
  const std::vector<Driven> driven = driven_logs(files, grid_step, options);
  double seconds = 0.0, mean = 0.0;
  for (const Driven& one : driven) seconds += one.seconds;
  const double every = std::max(start_spacing, seconds / static_cast<double>(options.starts));
  std::vector<FitLog> logs;
  for (const Driven& one : driven) {
    const measured::Session& session = one.file->session;
    logs.emplace_back(session, grid_step, options.horizons, std::min(every, std::max(start_spacing, one.seconds / 20)),
                      one.slowest);
    if (const std::string channels = never_compared(logs.back()); !channels.empty())
      print_line(options, "warning: " + session.name + ": " + channels);
    if (track && lies_on(session, *track)) logs.back().track = track;
    mean += static_cast<double>(logs.back().starts.time.size()) / static_cast<double>(driven.size());
  }
  // Long sessions count more than short ones, by the root of their length.
  for (FitLog& log : logs)
    log.weight = std::sqrt(mean / static_cast<double>(std::max<std::size_t>(1, log.starts.time.size())));
  return logs;
}

namespace {

/// Errors of the models that know nothing.
std::vector<HorizonRow> baseline_rows(const std::vector<FitLog>& logs, double wheelbase) {
  std::vector<HorizonRow> rows;
  for (std::size_t b = 0; b < baseline_names.size(); ++b) {
    std::vector<std::vector<double>> predicted;
    predicted.reserve(logs.size());
    for (const FitLog& log : logs)
      predicted.push_back(baseline(static_cast<Baseline>(b), *log.session, log.starts, wheelbase));
    rows.push_back(row_of_predictions(baseline_names[b], logs, predicted));
  }
  return rows;
}

}  // namespace

FitResult fit(const Forecaster& forecaster, std::vector<FitLog>& logs, std::vector<double> values,
              std::vector<Unknown> unknowns, const FitOptions& options) {
  FitResult result;
  unite(values, unknowns);
  for (const FitLog& log : logs) result.starts += log.starts.time.size();
  PredictionErrors errors(forecaster, logs);
  errors.weighing.horizon = options.horizon_weight;
  result.errors = baseline_rows(logs, forecaster.options().wheelbase);
  result.errors.push_back(row_of_model("before", errors, values));

  result.params = unknowns.empty() ? values : search(forecaster, logs, values, unknowns, options);
  LeastSquaresOptions full;
  const double fine_tolerance = full.tolerance;
  constexpr int rounds = 3;
  int round = 0;
  full.progress = [&](const FitStep& step) {
    const double part = std::min(1.0, static_cast<double>(step.iteration) / std::max(1, full.iterations));
    report_progress(options, after_following + (1.0 - after_following) * (round + part) / rounds,
                    "all starts, round " + std::to_string(round + 1) + " of " + std::to_string(rounds));
  };
  std::vector<Unknown> free_unknowns = unknowns;
  std::vector<Eigen::VectorXd> posterior_moves;  // of all unknowns
  Bootstrap boot;
  for (; round < rounds && !free_unknowns.empty(); ++round) {
    errors.set_scales(result.params);
    full.tolerance = round < 2 ? coarse_tolerance : fine_tolerance;
    full.iterations = round == 0 ? options.iterations / 3 : 2 * options.iterations / 3;
    result.params = least_squares(errors, free_unknowns, result.params, full, result.cost_after);
    if (round == 0) continue;  // scales were those of the search
    const std::vector<Unknown> uncertain = with_undetermined(free_unknowns, result.parameters);
    const BlockedNormalEquations blocks = errors.linearise(result.params, uncertain);
    result.dropped = blocks.dropped;
    boot = bootstrap(blocks, result.params, uncertain, options.seed);
    if (round > 1) continue;
    posterior_moves = boot.posterior_moves;
    free_unknowns =
        fix_undetermined(result, free_unknowns, boot.interval,
                         options.undetermined_stay ? std::span<const double>(values) : std::span<const double>());
  }
  for (std::size_t i = 0; i < free_unknowns.size(); ++i)
    result.parameters.push_back({free_unknowns[i], result.params[free_unknowns[i].index], boot.interval[i],
                                 FittedParameter::Status::determined});
  std::stable_sort(result.parameters.begin(), result.parameters.end(),
                   [](const auto& a, const auto& b) { return a.unknown.index < b.unknown.index; });
  result.bootstrap_draws = std::move(boot.params);
  for (const Eigen::VectorXd& move : posterior_moves)
    result.posterior_draws.push_back(after_step(result.params, unknowns, move));
  result.weighing = errors.weighing;
  result.errors.push_back(row_of_model("fitted", errors, result.params));
  return result;
}

}  // namespace gripline::calibrate
