// Hold-out data: what no model was fitted to, and how well a model predicts it.
#pragma once

#include "diagnose/inference/error_change.hpp"
#include "diagnose/inference/fit.hpp"
#include "measured/log/log_file.hpp"
#include "measured/replay/rollout.hpp"

namespace gripline::diagnose {

using measured::LogFile;

/// Whether the bend of a problem's commands is that of a log too: it was measured between samples as far apart.
bool shares_bend(const Log& log, const Problem& problem);

/// A log that no fit saw, its commands taken as the fit took those of its own: steps that were rounded to, bends and
/// holding are properties of the recorder, and a short log shows them badly. At another rate commands are not bent.
Trace as_fitted(const Log& log, const Problem& problem, const Road& road);

/// How models are rolled out along a log of a problem: from the tenth sample after `from` on, in starts that lie
/// thresholds::start_spacing apart.
measured::RolloutOptions rollout_options(const Problem& problem, const Trace& trace, double horizon,
                                         std::size_t from = 0);

/// Logs to predict: those held out, else the last whole laps (about a third) of the fitted logs, whose models are then
/// refitted on what comes before. Of stretches too short for that nothing is predicted. Holds references.
class HoldOut {
 public:
  HoldOut(const Problem& problem, const Road& road, std::span<const LogFile> held_out);
  /// Whether there is nothing to predict: no log is held out, and no stretch is long enough to be parted.
  bool empty() const { return traces_.empty(); }
  /// The logs to predict; where parts of fitted ones are, whole.
  const std::vector<Trace>& traces() const { return traces_; }
  /// Errors of the predictions over each horizon [s] from every start.
  std::vector<StartErrors> predict(const Fit& fitted, std::span<const double> horizons) const;
  /// Errors over 1 s of a model as the training data alone would have it.
  StartErrors predict_refitted(const Fit& fitted) const;
  /// Predictions of the first log, each of the second after the one before. There must be one.
  measured::Rollouts predict_in_turn(const Fit& fitted) const;
  /// Errors over 1 s on the training data: those that are not held out.
  StartErrors predict_training(const Fit& fitted) const;
  /// What one model's predictions over 1 s are worth beside another's: of the data held out or, where these are too
  /// short for an interval, of the training data.
  ErrorChange change(const Fit& with, const Fit& without) const;
  /// The model as the training data alone would have it.
  Fit refit(const Fit& fitted) const;

 private:
  std::vector<StartErrors> predict_along(std::vector<Trace> traces, std::span<const std::size_t> from,
                                         const Fit& fitted, std::span<const double> horizons) const;

  const Road& road_;
  Problem training_;  // the logs fitted, less what of them is held out
  std::vector<Trace> traces_;
  std::vector<std::size_t> from_;  // sample of each trace
  bool holds_out_laps_ = false;    // of the logs fitted, as no others are held out
};

}  // namespace gripline::diagnose
