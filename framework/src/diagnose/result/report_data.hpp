// diagnosis_report.json: the series behind the report's pictures (format: report/inputs.hpp).
#pragma once

#include "config/node.hpp"
#include "diagnose/result/diagnoser.hpp"

namespace gripline::diagnose {

/// Of the diagnoser's last run. `log` and `world` are names to show.
Node report_data(const Diagnosis& d, const Diagnoser& diagnoser, const std::string& log, const std::string& world,
                 const Node& patch);

}  // namespace gripline::diagnose
