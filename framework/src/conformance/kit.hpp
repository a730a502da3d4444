// The conformance kit: all checks of all plugins of a library.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "conformance/checks.hpp"

namespace gripline::conformance {

/// The answer to one check.
struct Verdict {
  std::string plugin;  ///< "estimator demo.learned_drag"; empty for what is asked of the library
  std::string check;   ///< its name
  bool passed = false;
  std::string words;   ///< why not, or what was measured; may be empty
  double seconds = 0;  ///< it took, by the clock on the wall
};

struct KitOptions {
  std::vector<std::string> only;            ///< names of checks; empty: all of them
  std::int64_t (*allocations)() = nullptr;  ///< as in Workshop
};

/// Checks every plugin of the library, each check in a process of its own; `tell` hears every verdict as it is given.
/// Throws InputError when the library is not there or a check of that name is not.
std::vector<Verdict> check_library(const std::filesystem::path& library, const KitOptions& options,
                                   const std::function<void(const Verdict&)>& tell);

}  // namespace gripline::conformance
