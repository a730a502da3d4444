// The paper's figures as SVG files, without a browser.
#pragma once

#include <string>
#include <vector>

#include "report/inputs.hpp"

namespace gripline::report {

struct FigureFile {
  std::string name;  ///< "friction.svg"
  std::string svg;
};

/// Figures of a race, from the first seed of every stack: trajectories, speed, friction, tyre_curves, g_g, laps,
/// step_times (all seeds), pareto (all seeds). What the logs do not hold is left out.
std::vector<FigureFile> race_figures(const Inputs& inputs);

/// Figures of a validation: offline_validation (over time), force_validation (over slip). Of a diagnosis:
/// diagnosis_gap, diagnosis_residual, diagnosis_traces.
std::vector<FigureFile> model_figures(const Inputs& inputs);

}  // namespace gripline::report
