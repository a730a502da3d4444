// A world's unknowns from logs: those under which predictions miss the logs least.
#pragma once

#include <array>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <vector>

#include "calibrate/fit/handling.hpp"
#include "calibrate/fit/least_squares.hpp"
#include "calibrate/forecast/horizon_table.hpp"

namespace gripline::calibrate {

struct FitOptions {
  std::vector<double> horizons{0.5, 1.0};  // [s]
  std::vector<double> horizon_weight{0.5, 1.0};
  double slowest = 1.0;      // [m/s] of a start
  double crawling = 0.25;    // [m/s] of a start in a log that has none as fast as that
  std::size_t starts = 200;  // wanted of all logs together
  // Of least squares over all starts, in three rounds, each with the scales of errors that the one before it left: a
  // third of them in the first, up to two thirds in the second and in the third, which is of what the second
  // determined.
  int iterations = 12;
  int tries = 3;  // starts of the search; the first is the world itself, the others are draws around it
  unsigned seed = 1;
  bool undetermined_stay = false;  // unknowns that the logs do not determine: where the fit begins, not at their priors
  std::function<void(const std::string&)> print;                   // a line on each log that is left out; may be empty
  std::function<void(double share, const std::string&)> progress;  // what is done, and what is under way; may be empty
};

struct FittedParameter {
  Unknown unknown;
  double value = 0;
  Interval interval;
  enum class Status {
    determined,
    undetermined,  // by the logs: kept at its prior, or where the fit began (FitOptions)
    at_bound,      // ran into the end of its range: kept there
  } status = Status::determined;
};
/// By the number of a status, for files and tables.
inline constexpr std::array<const char*, 3> status_names = {"determined", "undetermined", "at its bound"};

/// An effect that is not in the world: how much its first parameter would lower the cost, to first order.
struct Advice {
  std::string effect;
  double gain = 0;   // relative decrease of the squared errors
  double score = 0;  // in standard deviations over blocks
  struct Value {
    std::string name, unit;
    double value = 0;
  };
  std::vector<Value> values;  // what its parameters that are tested would be, inside their ranges; at least one
};

struct FitResult {
  std::vector<double> params;  // of the forecaster
  std::vector<FittedParameter> parameters;
  double cost_after = 0;  // PredictionErrors::cost with prior_cost of `params`, by `weighing`
  std::size_t starts = 0, dropped = 0;
  Friction friction;
  std::vector<Advice> advice;      // of advise(), where that was asked
  std::vector<HorizonRow> errors;  // at the last horizon over all logs: baselines, the world before, after
  std::vector<std::vector<double>> bootstrap_draws;  // parameters by draw
  // By draw from the posterior, of parameters that are kept at their priors too.
  std::vector<std::vector<double>> posterior_draws;
  Weighing weighing;  // of the last step
};

/// Logs with their starts, evenly spread over all of them. Longer logs count more, by the root of their length. `track`
/// goes to the logs that lie on it. A log without a usable start is left out; throws InputError when none is left.
std::vector<FitLog> fit_logs(const std::list<measured::SessionFile>& files, const std::shared_ptr<const Track>& track,
                             double grid_step, const FitOptions& options);

/// `values`: all parameters as the world has them. `logs` hold their starts. Deterministic.
FitResult fit(const Forecaster& forecaster, std::vector<FitLog>& logs, std::vector<double> values,
              std::vector<Unknown> unknowns, const FitOptions& options);

}  // namespace gripline::calibrate
