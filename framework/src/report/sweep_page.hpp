// The page of a sweep, from sweep_report.json in its folder: which factor makes how much of the variance, every
// response over every factor, parallel coordinates, the best settings.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "report/figures.hpp"

namespace gripline::report {

/// Figures of the data in sweep_report.json: multiples_RESPONSE, parallel.
std::vector<FigureFile> sweep_figures(const nlohmann::json& data);

/// A self-contained page without scripts.
std::string sweep_page(const nlohmann::json& data);

}  // namespace gripline::report
