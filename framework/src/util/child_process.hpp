// Work in a process of its own, for code that may crash, exit or never return.
#pragma once

#include <signal.h>  // NOLINT(modernize-deprecated-headers): struct sigaction is POSIX
#include <sys/types.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gripline {

/// What a child process sent, and how it ended.
struct ChildResult {
  std::vector<std::string> messages;  ///< in order; those sent before a failure count
  bool completed = false;             ///< the work returned
  std::string failure;  ///< if it did not: "was ended by signal 6 (Aborted)", "ended with exit code 0", "did not come
                        ///< back within 10 s", "threw ..."
  int signal = 0;       ///< that ended it, if one did before its time was over
};

using SendMessage = std::function<void(std::string_view)>;

/// Runs `work` in a fork of this process, its standard streams connected to /dev/null. The child and everything it
/// started are ended when it neither sends a message nor returns for `timeout_s`. An exception of `work` counts as a
/// failure. Throws std::runtime_error when no process can be started.
ChildResult run_in_child(double timeout_s, const std::function<void(const SendMessage&)>& work);

/// Set to true, run_in_child() runs `work` in this process: for fuzzers, which call it a million times with code that
/// they trust.
inline bool& run_children_here() {
  static bool here = false;
  return here;
}

/// "was ended by signal 11 (Segmentation fault)" or "ended with exit code 3", from a status that waitpid gave.
std::string describe_end(int status);

/// Whether a process that this signal ended was killed by somebody, or by a system without memory: SIGKILL or SIGTERM.
/// Its own mistakes end it by others.
bool ends_from_outside(int signal);

/// fork(), with nothing left in the buffers of std::cout and std::cerr that both processes would write. Throws
/// std::runtime_error with the system's reason.
pid_t fork_process();

/// SIGCHLD is handled as usual for as long as it lives, and then as before. Where it is ignored, as this process may
/// have been started, children that end leave no status. Of several the last one made goes first.
class UsualChildSignal {
 public:
  UsualChildSignal();
  ~UsualChildSignal();
  UsualChildSignal(const UsualChildSignal&) = delete;
  UsualChildSignal& operator=(const UsualChildSignal&) = delete;

 private:
  struct sigaction before_ {};
};

/// The status of a child if it has ended, else nothing. What is left of its process group is ended first, while its
/// process id cannot have been given to another. 0 where there is none: SIGCHLD is ignored, or another part of the
/// program collected it.
std::optional<int> collect_if_ended(pid_t pid);

/// Waits for the end of a child, whatever signals come. Its status, or nothing where there is none.
std::optional<int> wait_for_end(pid_t pid);

/// The processes that this one is the parent of. Empty where the system does not say (/proc/self/task/*/children).
std::vector<pid_t> children_of_this_process();

/// Limits the data of this process from now on (RLIMIT_DATA): allocations beyond it fail. 0: no limit.
void limit_data(std::size_t megabytes);

/// For a process that was forked: exit(), called by a library, ends it at once with its status. What libraries do at
/// exit may wait for threads that a forked process does not have (MPI, under Debian 13's Ipopt).
void end_at_exit();

}  // namespace gripline
