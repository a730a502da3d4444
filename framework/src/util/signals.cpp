#include "util/signals.hpp"

#include <unistd.h>

#include <string_view>

namespace gripline {
namespace {

volatile std::sig_atomic_t signal_seen = 0, code_at_end = 1;

/// Only what a signal handler may do: write and _exit (POSIX.1-2017, 2.4.3).
[[noreturn]] void end_process() {
  constexpr std::string_view text = "\ninterrupted: what was not finished is not written\n";
  [[maybe_unused]] const auto written = write(STDERR_FILENO, text.data(), text.size());
  _exit(code_at_end);
}

void note(int) { signal_seen = 1; }
void note_then_end(int) {
  if (signal_seen != 0) end_process();
  signal_seen = 1;
}
void end(int) { end_process(); }

}  // namespace

StopSignal::StopSignal(Reaction reaction, int exit_code) {
  signal_seen = 0;
  code_at_end = exit_code;
  struct sigaction action {};
  switch (reaction) {
    case Reaction::note:
      action.sa_handler = note;
      break;
    case Reaction::note_then_end:
      action.sa_handler = note_then_end;
      break;
    case Reaction::end:
      action.sa_handler = end;
      break;
  }
  sigaction(SIGINT, &action, &old_int_);
  sigaction(SIGTERM, &action, &old_term_);
}

StopSignal::~StopSignal() {
  sigaction(SIGINT, &old_int_, nullptr);
  sigaction(SIGTERM, &old_term_, nullptr);
}

bool StopSignal::seen() { return signal_seen != 0; }

void StopSignal::forget() { signal_seen = 0; }

}  // namespace gripline
