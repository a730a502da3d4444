// State of the whole process that the code of a plugin may change: saved before a call and restored after it.
#pragma once

#include <csignal>
#include <string>

namespace gripline {

/// Saves the working folder, the locale, the mask of new files' modes (umask) and the handlers of signals; the
/// destructor restores them.
class ProcessState {
 public:
  ProcessState();
  ~ProcessState();
  ProcessState(const ProcessState&) = delete;
  ProcessState& operator=(const ProcessState&) = delete;

 private:
  static constexpr int watched[] = {SIGINT, SIGTERM, SIGCHLD, SIGPIPE, SIGTSTP, SIGXFSZ};
  static constexpr int watched_count = sizeof watched / sizeof watched[0];
  int folder_ = -1;
  std::string locale_;
  unsigned mask_ = 0;
  struct sigaction actions_[watched_count] {};
};

}  // namespace gripline
