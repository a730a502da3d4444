// What the search for missing effects works on: the logs' time by its use, the world given and that world calibrated.
// The steps of the search (forward_selection, backward_elimination) only read it.
#pragma once

#include <list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "calibrate/effects/trial_fits.hpp"
#include "diagnose/real_logs/held_out_comparison.hpp"
#include "diagnose/real_logs/missing_effects.hpp"
#include "measured/estimates/yaw_rate_offset.hpp"
#include "world/world_spec.hpp"

namespace gripline::diagnose {

inline constexpr double judged_horizon = 1.0;  // [s] of the predictions that effects are judged by

/// Starts of predictions by what they are used for.
struct SearchLogs {
  std::vector<calibrate::FitLog> fitted;
  std::vector<calibrate::FitLog> validation;  // of the same logs, not fitted: chooses effects
  std::vector<calibrate::FitLog> held_out;    // other logs: help to decide what stays; may be none
  std::vector<std::string> names;             // of the logs fitted
  /// What reported errors are of.
  const std::vector<calibrate::FitLog>& reported() const { return held_out.empty() ? validation : held_out; }
};

/// The two worlds that a search begins from: as it is given, and with its unknowns fitted. Neither learns disturbances
/// while it predicts.
struct GivenAndCalibrated {
  std::unique_ptr<calibrate::Trial> given, calibrated;
  std::vector<calibrate::FittedParameter> undetermined;  // by the logs: kept at a prior, or at an end of a range
  std::vector<calibrate::Unknown> observer;              // of the given world, gains of disturbances too
  std::vector<double> given_params;                      // with those gains as the world has them
};

/// Of one search; holds references to what it was made from.
struct EffectSearch {
  EffectSearch(const Node& tree, const WorldSpec& spec, const Registry& registry, const measured::LogMap& map,
               const std::list<measured::SessionFile>& files, const std::list<measured::SessionFile>& held_out,
               const MissingOptions& options);
  EffectSearch(const EffectSearch&) = delete;
  EffectSearch& operator=(const EffectSearch&) = delete;

  void tell(double share, const std::string& what) const {
    if (options.progress) options.progress(share, what);
  }
  calibrate::ForecastErrors errors_on(const std::vector<calibrate::FitLog>& logs, const calibrate::Trial& trial) const {
    return forecast_errors(trial.forecaster, trial.params, fits.weighing, logs);
  }
  void validate(calibrate::Trial& trial) const { trial.validation = errors_on(logs.validation, trial); }
  /// Of a world that was validated.
  UnfittedErrors unfitted_errors(const calibrate::Trial& trial) const {
    return {trial.validation, logs.held_out.empty() ? calibrate::ForecastErrors{} : errors_on(logs.held_out, trial)};
  }
  const calibrate::ForecastErrors& reported(const UnfittedErrors& errors) const {
    return logs.held_out.empty() ? errors.validation : errors.held_out;
  }

  const Node& tree;
  const WorldSpec& spec;
  const Registry& registry;
  const measured::LogMap& map;
  const MissingOptions& options;
  calibrate::ForecastOptions forecast;
  SearchLogs logs;
  std::optional<measured::YawRateOffset> by_yaw;     // what the logs' yaw says of their yaw rate
  calibrate::TrialFits fits{forecast, logs.fitted};  // its weighing is that of the calibration
  GivenAndCalibrated worlds;
};

/// A world with effects added to the calibrated one, or with idle parameters of its effects opened.
struct Selection {
  std::unique_ptr<calibrate::Trial> trial;
  std::vector<calibrate::Addition> added;
  std::vector<std::string> tested;  // pointers of those of their parameters that change something by themselves
};

/// The calibrated world without any effect added.
Selection nothing_added(const EffectSearch& search);

/// Adds those of a world's unknowns that its logs did not determine, or that ended at a bound, to what a trial fits.
void open_undetermined(const EffectSearch& search, calibrate::Trial& trial);

/// A world as `predict` uses it: with an observer that learns disturbances, fitted anew.
std::unique_ptr<calibrate::Trial> with_disturbances(const EffectSearch& search, const calibrate::Trial& base);

/// A world with effects as `predict` uses it: with the observer of the calibrated one, which with_disturbances() made,
/// the rest fitted anew beside it. An observer that is fitted beside effects takes up what they do on the course that
/// was driven, and misleads on another (framework/doc/history.md, "Logs of real cars").
std::unique_ptr<calibrate::Trial> with_observer_of(const EffectSearch& search, const calibrate::Trial& calibrated,
                                                   const calibrate::Trial& base);

/// Copies the observer's parameters from those of a world to those of the same world with effects.
void take_observer(const EffectSearch& search, const calibrate::Trial& from, std::span<const double> values,
                   calibrate::Trial& to);

}  // namespace gripline::diagnose
