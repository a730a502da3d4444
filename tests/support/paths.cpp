#include "support/paths.hpp"

namespace gripline::testing_support {

std::filesystem::path source_dir() { return GRIPLINE_SOURCE_DIR; }
std::filesystem::path fixture_dir() { return source_dir() / "tests/fixtures"; }
std::filesystem::path build_dir() { return GRIPLINE_BUILD_DIR; }
std::filesystem::path plugin_dir() { return GRIPLINE_PLUGIN_DIR; }
std::filesystem::path gripline_program() { return build_dir() / "bin/gripline"; }
std::filesystem::path compiler() { return GRIPLINE_COMPILER; }
std::filesystem::path default_reference() { return source_dir() / "../shared"; }

}  // namespace gripline::testing_support
