// What belongs to the whole process and a plugin's code may have changed when it comes back.
#pragma once

#include <csignal>
#include <string>

namespace gripline {

/// Remembers the working folder, the locale, the mask of new files' modes and what signals do, and puts them back when
/// it dies.
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
