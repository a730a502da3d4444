// Kind "offline_validation": what estimators learn on one drive, asked about another (the paper's figure offline_val).
#pragma once

#include "config/node.hpp"
#include "experiment/validation_files.hpp"
#include "plugin/registry.hpp"
#include "util/progress.hpp"

namespace gripline {

/// Reads an experiment of kind "offline_validation" whole and runs nothing. Throws InputError.
///   {"kind": "offline_validation", "train": {"world", "laps"}, "test": {"world", "laps"}, "model": {...},
///    "driver": {"planner", "controller"}, "estimators": {name: {"plugin", "params"}}, "seed": 1}
/// Both worlds have the same car, dt and input_hold.
void check_offline(const Node& tree, const Registry& registry);
/// Drives with the same driver in the worlds "train" and "test", shows every estimator the first drive and compares its
/// predictions of the second one's e_vx, e_vy, e_omega. Writes the files of a validation and both drives into OUT.
/// Throws std::runtime_error when the driver does not finish or a drive has no step.
std::vector<ChannelScore> validate_offline(const Node& tree, const Registry& registry, const std::filesystem::path& out,
                                           const ProgressCallback& progress = {});

}  // namespace gripline
