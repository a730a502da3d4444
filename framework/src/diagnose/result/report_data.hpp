// diagnosis_report.json: the series behind the report's pictures (format: report/inputs.hpp).
#pragma once

#include "config/node.hpp"
#include "diagnose/result/diagnoser.hpp"

namespace gripline::diagnose {

/// `log` and `world` are names to show; `held_out` as given to Diagnoser::run.
Node report_data(const Diagnosis& d, const Diagnoser& diagnoser, std::span<const LogFile> held_out,
                 const std::string& log, const std::string& world, const Node& patch);

}  // namespace gripline::diagnose
