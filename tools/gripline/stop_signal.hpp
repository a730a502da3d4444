// Ctrl-C during work that is not split into runs.
#pragma once

#include <csignal>

namespace gripline::tools {

/// Notes SIGINT and SIGTERM for as long as it lives; a second one ends the program at once.
class StopSignal {
 public:
  enum class Reaction {
    note,      ///< seen() becomes true: the work ends at its next step
    end_here,  ///< says that it was interrupted and ends the program with the exit code of a run that broke
  };
  explicit StopSignal(Reaction reaction);
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;
  static bool seen();

 private:
  struct sigaction old_int_ {
  }, old_term_{};
};

}  // namespace gripline::tools
