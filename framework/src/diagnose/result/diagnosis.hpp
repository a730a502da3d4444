// What a diagnosis says (framework/doc/diagnose.md).
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "diagnose/inference/error_change.hpp"
#include "diagnose/inference/fit.hpp"
#include "diagnose/inference/residual_test.hpp"
#include "diagnose/result/channel_error.hpp"
#include "measured/finding.hpp"
#include "util/numbers.hpp"

namespace gripline::diagnose {

/// An effect that is missing, with its fitted parameters and their 95 % intervals.
struct NamedEffect {
  struct Value {
    std::string name, unit;
    double value = 0, low = 0, high = 0;
    std::string at_end{};  // "low" or "high" where it is kept within that end of its range: not an estimate
  };
  std::string effect;
  bool measurement = false;  // it changes what the sensors show, not how the car moves
  std::vector<Value> params;
  double confidence = 0;  // probability that it is in the true model
  ErrorChange rollout;    // of 1 s predictions of hold-out data, by it beside the other effects named
};

/// A candidate by itself.
struct RankedEffect {
  std::string effect;
  // Log evidence over the null model, fitted or, where it was not, predicted; none of logs of real cars.
  std::optional<double> gain = {};
  // Relative decrease of squared errors (ScoredEffect), of logs of real cars.
  std::optional<double> less_error = {};
  // Error of 1 s predictions on hold-out data, in sensor standard deviations; NaN where it was not fitted.
  double held_out = not_a_number;
  double selected_fraction = 0;  // of resampled logs whose best model has it
  ErrorChange rollout = {};      // of 1 s predictions of hold-out data, by it alone
};

/// The smallest size of an effect that would have been detected in this log; NaN where the log does not show it.
struct DetectionLimit {
  std::string effect, param, unit;
  double size = 0;
};

enum class Verdict { named, nothing_missing, indistinguishable, unknown };
inline constexpr std::array<const char*, 4> verdict_names = {"named", "nothing_missing", "indistinguishable",
                                                             "unknown"};

/// Root mean square errors of predictions on hold-out data, in sensor standard deviations, by the nominal model and by
/// the one found.
struct PredictionError {
  double seconds = 0, before = 0, after = 0;
};

/// The error at the horizon that is reported, and the share of what can be closed of it that the found model closes; 0
/// where the error is not significantly smaller.
struct Gap {
  double horizon = 1, before = 0, after = 0, closure = 0;
  double closure_low = 0, closure_high = 0;  // 95 %
  ErrorChange change{};                      // of the error
};

/// What a log shows to be missing, as one of the stages says. The verdict follows from it (verdict.hpp).
struct Explanation {
  std::vector<NamedEffect> named;                    // in the order of the fit's members
  std::vector<std::vector<std::string>> equivalent;  // sets of effects that explain the log as well; empty or >= 2
  std::string manoeuvre;  // that would tell equivalent sets apart; empty: none, or they are names of one thing
  std::optional<ResidualTest> unknown;                      // where something is left that no effect explains
  Fit fit;                                                  // the model returned
  std::vector<std::pair<std::string, double>> nominal_fit;  // its nuisance parameters
  std::vector<ResidualTest> tests;                          // of the model found
};

/// What the model found does to predictions of hold-out data.
struct PredictionGaps {
  Gap gap;        // before: the nominal model, delays of channels left in
  Gap named_gap;  // before: the nominal model with its parameters refitted, delays taken off; closed by effects alone
  std::vector<PredictionError> horizons;
};

/// What all stages say of the logs that were searched, once delays of channels are taken off them.
struct Findings : Explanation, PredictionGaps {
  std::optional<ChannelError> wrong_channel;  // the channel, where `unknown` is one of Where::reading
  std::vector<RankedEffect> ranking;
  std::vector<DetectionLimit> detection_limits;
  std::vector<measured::Finding> health;
  Fit null_model;  // no effect, nuisances fitted
  Channels sensor{};
};

struct Diagnosis : Findings {
  Verdict verdict = Verdict::nothing_missing;
  std::vector<NamedEffect> delays;  // of channels: found before everything else, taken off the logs
  std::string sentence;
};

}  // namespace gripline::diagnose
