// gripline bench: hands over to the program gripline-bench, which knows the plugins that are compared and counts every
// allocation of its process; no other command should.
#include "cli/companion.hpp"
#include "gripline/command.hpp"

namespace gripline::tools {

int run_bench_command(Arguments args) { exec_companion("gripline-bench", "bench", args); }

}  // namespace gripline::tools
