#include "util/family_mark.hpp"

#include <unistd.h>

#include <atomic>

namespace gripline {
namespace {

std::atomic<unsigned> marks_made{0};

}  // namespace

FamilyMark::FamilyMark() {
  constexpr unsigned bits = 24;  // for the count; the other 40 are this process's number
  value_ = static_cast<rlim_t>(getpid()) << bits | marks_made.fetch_add(1) % (1U << bits);
}

void FamilyMark::put_on() const {
  rlimit limit{};
  if (getrlimit(RLIMIT_LOCKS, &limit) != 0) return;
  limit.rlim_cur = value_;
  setrlimit(RLIMIT_LOCKS, &limit);
}

bool FamilyMark::is_on(pid_t pid) const {
  rlimit limit{};
  return prlimit(pid, RLIMIT_LOCKS, nullptr, &limit) == 0 && limit.rlim_cur == value_;
}

}  // namespace gripline
