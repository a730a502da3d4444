// A program that this one starts, hands pipes to and waits for.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "util/child_process.hpp"

namespace gripline {

/// A program in a process of its own, which is killed with this object. Of several that run at once the last one
/// started goes first (UsualChildSignal).
class StartedProgram {
 public:
  struct Setup {
    std::vector<std::pair<int, int>> handles{};  ///< the program's number of a handle, and the number it has here
    bool own_group = false;  ///< in a process group of its own, which is killed with all that the program started
    std::vector<int> usual_signals{};  ///< that it does not ignore although this process may
  };

  /// The program, looked for on the PATH where it is no path itself, and its arguments. One that cannot be executed
  /// ends with exit code 127. Throws std::runtime_error when there is no process to be had.
  StartedProgram(const std::vector<std::string>& words, const Setup& setup);
  ~StartedProgram() { kill(); }
  StartedProgram(const StartedProgram&) = delete;
  StartedProgram& operator=(const StartedProgram&) = delete;

  /// Waits for its end, once. Nothing where a signal ended it, or where nobody knows how it ended.
  std::optional<int> exit_code();
  /// Ends it if it still runs.
  void kill();

 private:
  std::optional<UsualChildSignal> signal_{std::in_place};
  pid_t pid_ = -1;
  bool own_group_;
};

}  // namespace gripline
