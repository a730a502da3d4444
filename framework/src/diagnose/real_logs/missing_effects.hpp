// What a real car's world lacks, judged by what a model is for: effects that make predictions of time that no fit saw
// better, beside each other and beside what the logs determine of the world's own unknowns.
//
// The world is calibrated as it is, with an observer that learns no disturbances: they would stand for what is missing.
// Then a score test on the fitted time proposes effects, the best few are fitted with everything else, and the one that
// explains the fitted time best among those that lower the errors of the rest of the same logs stays: the next is
// looked for beside it. In the end each must be missed where it is taken out, by that rest and by the logs held out,
// whose figures are a little optimistic for that; less is asked of the offset of a steering whose one-sided curve
// stays.
#pragma once

#include <functional>
#include <limits>
#include <list>
#include <string>
#include <vector>

#include "calibrate/effects/effect_trial.hpp"
#include "calibrate/fit/calibrated_world.hpp"
#include "calibrate/fit/forecast_errors.hpp"
#include "diagnose/real_logs/remainder.hpp"

namespace gripline::diagnose {

struct MissingEffect {
  struct Value {
    std::string name, unit;
    double value = 0, low = 0, high = 0;
    double least = -std::numeric_limits<double>::infinity();  // the range in which it is looked for
    double most = std::numeric_limits<double>::infinity();
    /// The end of its range at which it stands, "low" or "high", where the logs ask for more than is allowed and
    /// nothing is estimated; empty elsewhere.
    std::string at_end() const;
    bool at_edge() const { return !at_end().empty(); }
    /// "T = 0.0412 s", with `interval` "T = 0.0412 (0.0398 to 0.0431) s", or at an end of its range "T is kept within
    /// its range [0, 0.1] s"; numbers with so many digits.
    std::string text(int digits, bool interval) const;
  };
  calibrate::Addition addition;  // to the calibrated world
  bool measurement = false;      // it changes what the sensors show, not how the car moves
  std::vector<Value> params;
  /// Of predictions of the logs held out, or of time not fitted, by it beside the others.
  calibrate::ForecastChange change;
};

/// A candidate beside the calibrated world alone.
struct ScoredEffect {
  std::string effect;  // the name of its Addition
  /// Relative decrease of squared errors on the fitted time, to first order or, where tried, fitted: as far as the fit
  /// went, which is given up where it stays behind another's.
  double less_error = 0;
  bool tried = false;  // then `error` and `change` are of validation time
  double error = 0;
  calibrate::ForecastChange change;  // against `validation` below
};

/// What the effects named do to one log.
struct SessionChange {
  std::string log;
  double calibrated = 0, found = 0;  // normalised errors (below) of the model alone
  calibrate::ForecastChange change;  // found against calibrated
};

struct MissingOptions {
  calibrate::FitOptions fit;        // slowest, starts, seed
  std::size_t stretches = 24;       // wanted of what is held out of all logs together
  double searched_seconds = 75.0;   // of fitted time that the search looks at
  std::size_t tries = 3, most = 8;  // candidates fitted at each size, and of those that others hide; effects named
  std::function<void(double share, const std::string&)> progress;
};

struct MissingEffects {
  std::vector<MissingEffect> named;   // values by the search; `parameters` and `world` are fitted to all of the time
  std::vector<ScoredEffect> ranking;  // largest decrease first, those that harm last
  /// Of predictions 1 s ahead of time not fitted, as `predict` makes them: rows `given`, `calibrated`, `found`.
  std::vector<calibrate::HorizonRow> rows;
  /// Normalised errors of the model alone, without disturbances that the observer learns: root mean squares over all
  /// channels, each over the root mean square error of the calibrated world, whose own is about 1. `noise`: what sensor
  /// noise alone would leave, 0 where that is not known.
  double given = 0, calibrated = 0, found = 0, noise = 0;
  double validation = 0;  // of the calibrated world on validation time, which `ranking` is by
  /// The quantity whose error 1 s ahead is largest over its own sensors' noise, and how many times that is: in the sum
  /// of all quantities one wrong channel hardly shows.
  struct OverNoise {
    std::string quantity;
    double times = 0;
  } largest_over_noise;
  /// Whether what is left is, in sum, as large as what sensors alone would leave.
  bool sum_at_noise() const;
  /// Whether that holds of each quantity too: these logs show nothing more.
  bool at_noise() const;
  /// Whether predictions are better than noise alone lets them be: then `noise` is wrong, and nothing is told by it.
  bool noise_too_large() const;
  calibrate::ForecastChange calibration;  // calibrated against given, of the model alone
  calibrate::ForecastChange change;       // found against calibrated
  calibrate::ForecastChange all;          // found against given
  std::vector<SessionChange> sessions;    // of what `change` is of, log by log
  Remainder remainder;
  std::vector<calibrate::FittedParameter> parameters;    // of the calibrated world with the effects named
  std::vector<calibrate::FittedParameter> undetermined;  // as GivenAndCalibrated has them
  Node world;                                            // that world
  WorldSpec spec;                                        // its car, with parameters as given
  std::vector<double> params;                            // of a forecaster of that car, as found
  /// Of `parameters` those of the world as given: neither the observer's nor those of effects named.
  std::vector<calibrate::FittedParameter> own_parameters() const;
};

/// `tree` and `spec` are one world. The second half of every 10 to 40 s of `files` is validation time, which chooses
/// effects. It and `held_out` (which does not count below three stretches of at most 10 s) decide together which of
/// them stay; what is reported of them is of `held_out`, or, where that is empty, of validation time too. `held_out`
/// shares no rows with `files`. The world's file names are made relative to `folder`. Deterministic.
MissingEffects find_missing(const Node& tree, const WorldSpec& spec, const Registry& registry,
                            const measured::LogMap& map, const std::list<measured::SessionFile>& files,
                            const std::list<measured::SessionFile>& held_out, const MissingOptions& options,
                            const std::filesystem::path& folder);

}  // namespace gripline::diagnose
