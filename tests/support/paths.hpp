// Where a test finds the tree it was built from and what was built. Functions, not macros, so that object files of the
// tests are the same in every checkout and a compiler cache can share them.
#pragma once

#include <filesystem>

namespace gripline::testing_support {

std::filesystem::path source_dir();         // root of the source tree
std::filesystem::path fixture_dir();        // tests/fixtures in it
std::filesystem::path build_dir();          // root of the build tree
std::filesystem::path plugin_dir();         // the built plugin libraries
std::filesystem::path gripline_program();   // the built program
std::filesystem::path compiler();           // the C++ compiler that built all this
std::filesystem::path default_reference();  // the reference data where GRIPLINE_REFERENCE_DIR is not set

}  // namespace gripline::testing_support
