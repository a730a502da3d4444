// Where the shared reference data are, and whether a test may do without them.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "support/paths.hpp"

namespace gripline::testing_support {

/// Folder that holds reference/, measured/ and discrepancy/: GRIPLINE_REFERENCE_DIR, else beside the repository.
inline std::filesystem::path reference_root() {
  const char* set = std::getenv("GRIPLINE_REFERENCE_DIR");
  return set != nullptr && *set != '\0' ? set : default_reference();
}

inline bool reference_required() {
  const char* set = std::getenv("GRIPLINE_REQUIRE_REFERENCE");
  return set != nullptr && std::string(set) == "1";
}

/// Fixture of tests that need the folder: they are skipped without it, or fail if GRIPLINE_REQUIRE_REFERENCE is 1.
class WithReference : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::filesystem::is_directory(reference_root() / "reference")) return;
    if (reference_required()) FAIL() << "no reference data in " << reference_root();
    GTEST_SKIP() << "no reference data in " << reference_root();
  }
  static std::filesystem::path reference(const std::string& name) { return reference_root() / "reference" / name; }
};

}  // namespace gripline::testing_support
