// Tells what a process started, and what that started, from all other processes.
#pragma once

#include <sys/resource.h>
#include <sys/types.h>

namespace gripline {

/// A mark on the process that puts it on and on all that it starts from then on, through fork and exec, whatever group,
/// session or parent they have later. Every object is another mark. It is a value of RLIMIT_LOCKS, a limit that
/// processes inherit and Linux has had no use for since 2.4.25; where it cannot be set no process has the mark.
class FamilyMark {
 public:
  FamilyMark();
  /// On this process.
  void put_on() const;
  /// Whether a process has it; also one that has ended and was not collected.
  bool is_on(pid_t pid) const;

 private:
  rlim_t value_;
};

}  // namespace gripline
