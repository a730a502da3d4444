// Programs that come with gripline and are run by its commands: apart from it because they replace malloc or need a
// library that the other commands do not.
#pragma once

#include "cli/program.hpp"

namespace gripline::tools {

/// Replaces this process by that program with these arguments. It is beside this program where built, in libexec where
/// installed. Throws std::runtime_error, which says what `purpose` needs, if it is missing.
[[noreturn]] void exec_companion(const char* program, const char* purpose, Arguments args);

}  // namespace gripline::tools
