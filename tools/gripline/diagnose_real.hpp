// gripline diagnose on a logger's table (--map), or with a world without a road: the world is calibrated, and effects
// that it lacks are judged by predictions of time that was not fitted.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gripline/log_options.hpp"
#include "plugin/registry.hpp"

namespace gripline::tools {

struct RealDiagnosis {
  std::string world;  // its file, for the report
  std::vector<std::string> logs, held_out;
  std::filesystem::path out;
  bool force = false;
};

/// Writes diagnosis.json, augmented_world.json, the imported logs and the report; prints what was found. Gives the exit
/// code.
int diagnose_real(const RealDiagnosis& asked, const LogWorld& world, const measured::LogMap& map,
                  const Registry& registry);

}  // namespace gripline::tools
