#include "util/process_state.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <clocale>

namespace gripline {

ProcessState::ProcessState() : folder_(open(".", O_PATH | O_DIRECTORY | O_CLOEXEC)) {
  if (const char* const name = std::setlocale(LC_ALL, nullptr); name != nullptr) locale_ = name;
  mask_ = umask(0);
  umask(static_cast<mode_t>(mask_));
  for (int i = 0; i < watched_count; ++i) sigaction(watched[i], nullptr, &actions_[i]);
}

ProcessState::~ProcessState() {
  for (int i = 0; i < watched_count; ++i) sigaction(watched[i], &actions_[i], nullptr);
  umask(static_cast<mode_t>(mask_));
  if (!locale_.empty()) std::setlocale(LC_ALL, locale_.c_str());
  if (folder_ < 0) return;
  [[maybe_unused]] const int failed = fchdir(folder_);
  close(folder_);
}

}  // namespace gripline
