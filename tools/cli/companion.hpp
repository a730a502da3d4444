// Programs that come with gripline and are run by its commands: apart from it because they replace malloc.
#pragma once

#include "cli/program.hpp"

namespace gripline::tools {

/// Replaces this process by that program with these words: beside this one as it is built, in libexec as it is
/// installed. Throws std::runtime_error, which says what `purpose` needs, when it is not there.
[[noreturn]] void become(const char* program, const char* purpose, Arguments args);

}  // namespace gripline::tools
