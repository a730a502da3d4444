// How well an estimator predicts what the nominal model misses: the paper's figures offline_val and offline_val_carla.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiment/experiment.hpp"
#include "util/progress.hpp"

namespace gripline {

/// One channel's agreement: coefficient of determination 1 - sum (e - p)^2 / sum (e - mean e)^2, and error in `unit`.
struct ChannelScore {
  std::string estimator, channel, unit;
  std::size_t n = 0;
  double r2 = 0, rmse = 0;
};

// Both kinds write OUT/validation.csv (estimator,channel,unit,n,r2,rmse) and OUT/validation_traces.csv and return the
// scores. They throw std::runtime_error when a driver does not finish or the disk refuses.

/// Reads an experiment of kind "offline_validation" whole and runs nothing. Throws InputError.
///   {"kind": "offline_validation", "train": {"world", "laps"}, "test": {"world", "laps"}, "model": {...},
///    "driver": {"planner", "controller"}, "estimators": {name: {"plugin", "params"}}, "seed": 1}
void check_offline(const Node& tree, const Registry& registry);
/// Drives with the same driver in the worlds "train" and "test", shows every estimator the first drive and compares its
/// predictions of the second one's e_vx, e_vy, e_omega.
std::vector<ChannelScore> validate_offline(const Node& tree, const Registry& registry, const std::filesystem::path& out,
                                           const ProgressCallback& progress = {});
/// Kind "force_validation", a race: the first full lap after a stack trusts what it learned, for the rows that have an
/// estimator. Predictions of e_vx, e_vy, e_omega and of both axle forces, each before the stack learns from the step.
std::vector<ChannelScore> validate_forces(const RaceSpec& race, const std::vector<std::string>& rows,
                                          const std::filesystem::path& out, const ProgressCallback& progress = {});

}  // namespace gripline
