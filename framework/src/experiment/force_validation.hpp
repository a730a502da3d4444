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
  /// Rows that had no lap to judge, as "gp (0 laps driven)", "gp (1 laps driven: still driving after 60 s)" where the
  /// race ended otherwise than it should; empty: none.
  std::string unjudged;
  bool too_short = false;  // whether one of those was driven to the race's end
};

/// The message for rows without a lap, with what helps where a race was too short.
std::string no_lap_to_judge(const ForceScores& found);

/// Races those of the rows that have an estimator and compares, over the first full lap after a stack trusts what it
/// learned, its predictions of e_vx, e_vy, e_omega and of both axle forces, each before it learns from the step.
/// Writes the files of a validation and the runs into OUT. Throws std::runtime_error, after all rows, when none had
/// such a lap.
ForceScores validate_forces(const RaceSpec& race, const std::vector<std::string>& rows,
                            const std::filesystem::path& out, const ProgressCallback& progress = {});

}  // namespace gripline
