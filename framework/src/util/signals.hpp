// SIGINT (Ctrl-C) and SIGTERM during long work.
#pragma once

#include <csignal>

namespace gripline {

/// Handles both signals for as long as it lives, and puts the handlers before it back afterwards. One at a time.
class StopSignal {
 public:
  enum class Reaction {
    note,           ///< seen() becomes true: the work ends at its next step
    note_then_end,  ///< as note; a second signal ends the process
    end,            ///< the first signal ends the process
  };
  /// A process that is ended says on stderr that it was interrupted and that what was not finished is not written: the
  /// work keeps its results whole (util/whole_file.hpp). Its exit code is `exit_code`.
  explicit StopSignal(Reaction reaction, int exit_code = 1);
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;
  /// Whether a signal came since the last StopSignal was constructed, or since forget().
  static bool seen();
  /// What came before is seen no more. For a process that goes on after work that was stopped.
  static void forget();

 private:
  struct sigaction old_int_ {
  }, old_term_{};
};

}  // namespace gripline
