// What was measured of a log's noise, as rows of its health table.
#pragma once

#include <span>
#include <vector>

#include "diagnose/inference/problem.hpp"
#include "measured/finding.hpp"
#include "measured/log/log_file.hpp"

namespace gripline::diagnose {

/// A health table with level and colour of every sensor whose noise was measured with the model, and size and
/// correlation time of the unknown accelerations where there are any. Rows of the levels of these sensors are replaced.
std::vector<measured::Finding> with_noise(const Problem& problem, const Noise& noise,
                                          std::vector<measured::Finding> health);

/// A row for each log held out whose commands stay straight between samples where those of the fitted logs are bent:
/// how far theirs would be, at another rate, was not measured.
std::vector<measured::Finding> straight_commands(const Problem& problem, std::span<const measured::LogFile> held_out);

}  // namespace gripline::diagnose
