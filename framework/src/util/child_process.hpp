// A question asked in a process of its own, for code that may crash, exit or never come back.
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace gripline {

/// What a child told, and how it ended.
struct ChildAnswer {
  std::vector<std::string> told;  ///< in order; what was told before a bad end counts
  bool complete = false;          ///< the work returned
  std::string end;                ///< when it did not: "was ended by signal 6 (Aborted)", "ended its process with exit
                                  ///< code 0", "did not come back within 10 s"
};

using TellParent = std::function<void(std::string_view)>;

/// Runs `work` in a fork of this process: what it changes there stays there, and what it prints goes nowhere. It and
/// all it started are ended when it neither tells something nor returns for `patience_s`. An exception of `work` counts
/// as an end: "threw ...". Throws std::runtime_error when there is no process to be had.
ChildAnswer ask_child(double patience_s, const std::function<void(const TellParent&)>& work);

/// Fuzzers ask the same question a million times of code they trust: then `work` runs here.
inline bool& ask_in_this_process() {
  static bool here = false;
  return here;
}

/// "was ended by signal 11 (Segmentation fault)" or "ended with exit code 3", of a status that waitpid gave.
std::string describe_end(int status);

/// The processes that this one is the parent of. Empty where the system does not say (/proc/self/task/*/children).
std::vector<pid_t> children_of_this_process();

}  // namespace gripline
