#include "util/started_program.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

namespace gripline {
namespace {

/// Only what may be called between fork and exec: nothing allocates.
[[noreturn]] void execute(char* const* words, std::vector<std::pair<int, int>>& handles,
                          const StartedProgram::Setup& setup) {
  constexpr int above = 10;
  for (const int number : setup.usual_signals) std::signal(number, SIG_DFL);
  if (setup.own_group) setpgid(0, 0);
  // Away from the program's numbers first: dup2 of a handle onto itself keeps its close-on-exec flag, and onto one that
  // is still to be copied loses that one.
  for (auto& [number, here] : handles) here = fcntl(here, F_DUPFD_CLOEXEC, above);
  for (const auto& [number, here] : handles) dup2(here, number);
  execvp(words[0], words);
  constexpr int not_executed = 127;  // as shells say it
  _exit(not_executed);
}

}  // namespace

StartedProgram::StartedProgram(const std::vector<std::string>& words, const Setup& setup)
    : own_group_(setup.own_group) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  std::vector<std::pair<int, int>> handles = setup.handles;
  pid_ = fork_process();
  if (pid_ == 0) execute(arguments.data(), handles, setup);
  if (own_group_) setpgid(pid_, pid_);
}

std::optional<int> StartedProgram::exit_code() {
  if (pid_ <= 0) return std::nullopt;
  const std::optional<int> status = wait_for_end(std::exchange(pid_, -1));
  signal_.reset();
  if (!status || !WIFEXITED(*status)) return std::nullopt;
  return WEXITSTATUS(*status);
}

void StartedProgram::kill() {
  if (pid_ <= 0) return;
  if (own_group_) ::kill(-pid_, SIGKILL);
  ::kill(pid_, SIGKILL);
  wait_for_end(std::exchange(pid_, -1));
  signal_.reset();
}

}  // namespace gripline
