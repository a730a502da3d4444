// gripline diagnose on a logger's table (--map), or with a world without a road: the world is calibrated, and effects
// that it lacks are judged by predictions of time that was not fitted.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "plugin/registry.hpp"

namespace gripline::tools {

struct RealDiagnosis {
  std::filesystem::path world;
  std::vector<std::string> logs, held_out;
  std::optional<std::filesystem::path> map, track;
  std::filesystem::path out;
  bool force = false;
};

/// Writes diagnosis.json, augmented_world.json and the imported logs; prints what was found. Gives the exit code.
int diagnose_real(const RealDiagnosis& asked, const Registry& registry);

}  // namespace gripline::tools
