// Files that helpers of a test program write for its tests: unique to the process, gone when it ends.
#pragma once

#include <filesystem>
#include <string>

#include "support/host_support.hpp"

namespace gripline::testing_support {

inline std::filesystem::path scratch(const std::string& name) {
  static const Folder folder;
  return folder / name;
}

}  // namespace gripline::testing_support
