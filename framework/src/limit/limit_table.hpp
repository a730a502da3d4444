// Limits over friction factors: computed by several processes, kept in a cache, written as a table.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "limit/lap_limit.hpp"

namespace gripline {

struct LimitRequest {
  std::vector<double> factors;
  bool body = false;              ///< also with the whole car inside
  bool patches = false;           ///< with the patches of the world's friction
  int jobs = 1;                   ///< processes at the same time
  std::filesystem::path cache{};  ///< folder where finished laps are kept; empty: none
  std::string key{};              ///< of everything besides factor and body that decides a lap
};

/// Factors rising, first those of the centre of gravity. Each lap is a process of its own, since Ipopt's linear solver
/// is not made for threads. `progress(done, total)` is called while it waits; a stop signal (Ctrl-C) ends the processes
/// and throws. Throws std::runtime_error with the words of the first lap that failed.
std::vector<LapLimit> compute_limits(const WorldSpec& spec, const LimitRequest& request,
                                     const std::function<void(std::size_t, std::size_t)>& progress);

/// factor, lap_s, error_s, body, and patches where a lap has them. Throws std::runtime_error when the disk refuses.
void write_limits(const std::filesystem::path& file, const std::vector<LapLimit>& limits);

}  // namespace gripline
