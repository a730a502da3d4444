// Kind "force_validation": how well racing stacks predict with what they have learned so far
// (the paper's figure offline_val_carla).
#pragma once

#include <string>
#include <vector>

#include "experiment/experiment.hpp"
#include "experiment/validation_files.hpp"
#include "util/progress.hpp"

namespace gripline {

struct ForceScores {
  std::vector<ChannelScore> scores;
  std::string unjudged;  // rows that had no lap to judge, as "gp (0 laps driven)"; empty: none
};

/// The message for a row without a lap.
std::string no_lap_to_judge(const std::string& rows);

/// Races those of the rows that have an estimator and compares, over the first full lap after a stack trusts what it
/// learned, its predictions of e_vx, e_vy, e_omega and of both axle forces, each before it learns from the step.
/// Writes the files of a validation and the runs into OUT. Throws std::runtime_error, after all rows, when none had
/// such a lap.
ForceScores validate_forces(const RaceSpec& race, const std::vector<std::string>& rows,
                            const std::filesystem::path& out, const ProgressCallback& progress = {});

}  // namespace gripline
