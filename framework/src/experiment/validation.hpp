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

/// Kind "offline_validation": drives a lap with the same driver in the worlds "train" and "test", shows every estimator
/// the first and asks it about the second.
///   {"kind": "offline_validation", "train": {"world", "laps"}, "test": {"world", "laps"}, "model": {...},
///    "driver": {"planner", "controller"}, "estimators": {name: {"plugin", "params"}}, "seed": 1}
/// Kind "force_validation": a race; the rows with an estimator are asked, before they learn from a step, about the
/// first full lap after they trust what they learned: e_vx, e_vy, e_omega and both axle forces. Writes
/// OUT/validation.csv (estimator,channel,unit,n,r2,rmse) and OUT/validation_traces.csv.
/// Reads an offline validation whole and runs nothing. Throws InputError.
void check_offline(const Node& tree, const Registry& registry);
std::vector<ChannelScore> validate_offline(const Node& tree, const Registry& registry, const std::filesystem::path& out,
                                           const Tell& tell = {});
std::vector<ChannelScore> validate_forces(const RaceSpec& race, const std::vector<std::string>& rows,
                                          const std::filesystem::path& out, const Tell& tell = {});

}  // namespace gripline
