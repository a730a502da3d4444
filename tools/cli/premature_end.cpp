#include "cli/premature_end.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "cli/program.hpp"
#include "plugin/guard.hpp"

namespace gripline::tools {
namespace {

LastCall called;
pid_t program = 0;
bool expected = false;

void say(std::string_view text) {
  [[maybe_unused]] const auto written = write(STDERR_FILENO, text.data(), text.size());
}

/// Only what a signal handler may do (POSIX.1-2017, 2.4.3).
void say_plugin() {
  char who[64] = "";
  called.who.copy(who, sizeof who);
  if (who[0] == '\0') return;
  say("; the plugin called last was ");
  say(who);
}

const char* name_of(int number) {
  switch (number) {
    case SIGSEGV:
      return "signal 11 (Segmentation fault)";
    case SIGABRT:
      return "signal 6 (Aborted)";
    case SIGFPE:
      return "signal 8 (Floating point exception)";
    case SIGBUS:
      return "signal 7 (Bus error)";
    default:
      return "signal 4 (Illegal instruction)";
  }
}

/// The handler was reset to the default on entry: raised again, the signal ends the process as usual.
void on_signal(int number) {
  if (getpid() == program) {
    say("gripline: ended by ");
    say(name_of(number));
    say_plugin();
    say("\n");
  }
  raise(number);
}

void on_exit() {
  if (expected || getpid() != program) return;
  say("gripline: something called exit() before the work was done");
  say_plugin();
  say("\n");
  _exit(run_broke);
}

void take_closed_streams() {
  // Opened for the wrong direction, so that using them still fails.
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(stream, F_GETFD) < 0 && open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY) != stream) return;
}

}  // namespace

void report_premature_end() {
  take_closed_streams();
  program = getpid();
  last_call() = &called;
  std::atexit(on_exit);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // these report it themselves
  static std::array<char, 65536> room;                               // for the handler after a stack overflow
  const stack_t stack{room.data(), 0, room.size()};
  sigaltstack(&stack, nullptr);
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = static_cast<int>(SA_ONSTACK | SA_RESETHAND | SA_NODEFER);
  for (const int number : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL}) sigaction(number, &action, nullptr);
#endif
}

void expect_end() { expected = true; }

}  // namespace gripline::tools
