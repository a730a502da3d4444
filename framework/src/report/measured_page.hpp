// The page of an experiment of kind "measured", from measured.json in its folder: errors beside those of baselines that
// need no car, ablations, parameters with intervals, traces, the car on its road, where errors are large.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "report/figures.hpp"

namespace gripline::report {

/// Figures of the data in measured.json: errors, ablation, parameters, traces_LOG, road_LOG.
std::vector<FigureFile> measured_figures(const nlohmann::json& data);

/// A self-contained page without scripts; `scene` and `claims` are the folder's, null if absent.
std::string measured_page(const nlohmann::json& data, const nlohmann::json& scene, const nlohmann::json& claims);

}  // namespace gripline::report
