#include "gripline/stop_signal.hpp"

#include <unistd.h>

#include <string_view>

#include "gripline/command.hpp"

namespace gripline::tools {
namespace {

volatile std::sig_atomic_t stopped = 0;

/// Only what a signal handler may do: write and _exit.
[[noreturn]] void end_now() {
  constexpr std::string_view text = "\ninterrupted: nothing was written\n";
  [[maybe_unused]] const auto written = write(STDERR_FILENO, text.data(), text.size());
  _exit(run_broke);
}
void note(int) {
  if (stopped != 0) end_now();
  stopped = 1;
}
void end_here(int) { end_now(); }

}  // namespace

StopSignal::StopSignal(Reaction reaction) {
  stopped = 0;
  struct sigaction action {};
  action.sa_handler = reaction == Reaction::note ? note : end_here;
  sigaction(SIGINT, &action, &old_int_);
  sigaction(SIGTERM, &action, &old_term_);
}

StopSignal::~StopSignal() {
  sigaction(SIGINT, &old_int_, nullptr);
  sigaction(SIGTERM, &old_term_, nullptr);
}

bool StopSignal::seen() { return stopped != 0; }

}  // namespace gripline::tools
