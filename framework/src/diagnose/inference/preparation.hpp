// From logs to a problem: noise levels of the sensors, first references, steps of integration, penalty.
#pragma once

#include <span>
#include <vector>

#include "diagnose/inference/problem.hpp"
#include "measured/log/log_file.hpp"

namespace gripline::diagnose {

struct Prepared {
  Problem problem;
  Channels expected_noise{};              // of the readings: the stated one with what their rounding adds
  std::vector<measured::Finding> health;  // of the logs, then of their noise
};

/// `stated`: standard deviations of the sensors as the world or the case says; 0: not stated. Where the logs show other
/// noise, that is used. The catalogue must outlive the result.
Prepared prepare(const Catalogue& catalogue, const Road& road, std::span<const measured::LogFile> logs,
                 const Channels& stated);

}  // namespace gripline::diagnose
