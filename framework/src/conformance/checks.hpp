// What the conformance kit asks of a plugin.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <gripline/abi.h>

namespace gripline::conformance {

/// A plugin of the library that is checked.
struct Subject {
  abi::Kind kind = abi::Kind::effect;
  std::string id;
  bool needs_truth = false;
};

/// A contract that is not kept: one line of why.
class Broken : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Where checks run. None of the library's code ever runs in this process.
struct Workshop {
  std::filesystem::path folder;             ///< holds the library alone
  std::filesystem::path cache;              ///< for plugins' expensive results
  std::int64_t (*allocations)() = nullptr;  ///< counts every allocation of this process; null: nobody counts
};

struct Check {
  const char* name;
  const char* asks;  ///< what is asked, a sentence
  unsigned kinds;    ///< bits of abi::Kind it is asked of
  /// Returns words for a check that passed (may be empty); throws Broken.
  std::string (*run)(const Workshop&, const Subject&);
};

/// All checks of a plugin, in the order in which they are asked.
std::span<const Check> checks();

/// The plugins of the library, its manifest read in a process of its own. Throws Broken when it cannot be used.
std::vector<Subject> subjects_in(const Workshop& workshop);

/// How long opening the library takes [s of CPU]. Throws Broken.
double opening_time(const Workshop& workshop);

}  // namespace gripline::conformance
