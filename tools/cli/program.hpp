// What every program of the project does around its work: errors become one message and an exit code.
#pragma once

#include <span>
#include <string>

namespace gripline::tools {

/// Exit codes of the programs.
enum Exit : int { good = 0, claim_failed = 1, bad_input = 2, plugin_unusable = 3, run_broke = 4, try_again = 75 };

/// The words after the program's name, or after a command's.
using Arguments = std::span<const std::string>;

/// The body of main(): runs `body` and gives its exit code, or that of the exception it ends with, whose message goes
/// to stderr. Folders that were made for results are removed again where it failed before it wrote any. Output that
/// could not be written (a full disk) is an error too. `command` is what users type for this work ("gripline bench"),
/// for hints; with a trailing space the first argument belongs to it ("gripline ").
int run_program(int argc, char** argv, int (*body)(Arguments), const std::string& command);

}  // namespace gripline::tools
