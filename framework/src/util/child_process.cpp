#include "util/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <stdexcept>

namespace gripline {
namespace {

using Clock = std::chrono::steady_clock;

// A message: its kind, its size in four bytes, its bytes.
enum class Kind : char { told = 't', threw = 'x', done = 'd' };

void send(int pipe, Kind kind, std::string_view text) {
  const auto size = static_cast<std::uint32_t>(text.size());
  std::string message(1, static_cast<char>(kind));
  message.append(reinterpret_cast<const char*>(&size), sizeof size);
  message += text;
  for (std::string_view rest = message; !rest.empty();) {
    const ssize_t sent = write(pipe, rest.data(), rest.size());
    if (sent < 0 && errno != EINTR) _exit(1);
    if (sent > 0) rest.remove_prefix(static_cast<std::size_t>(sent));
  }
}

[[noreturn]] void child(int pipe, pid_t parent, const std::function<void(const TellParent&)>& work) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
  for (const int number : {SIGINT, SIGTERM, SIGCHLD, SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL})
    std::signal(number, SIG_DFL);
  if (const int nowhere = open("/dev/null", O_RDWR); nowhere >= 0) {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
      if (stream != pipe) dup2(nowhere, stream);
  }
  try {
    work([pipe](std::string_view text) { send(pipe, Kind::told, text); });
    send(pipe, Kind::done, "");
  } catch (const std::exception& e) {
    send(pipe, Kind::threw, e.what());
  } catch (...) {
    send(pipe, Kind::threw, "something that is not a std::exception");
  }
  _exit(0);
}

/// Takes whole messages off the front of what was read.
void take_messages(std::string& bytes, ChildAnswer& answer) {
  constexpr std::size_t head = 1 + sizeof(std::uint32_t);
  while (bytes.size() >= head) {
    std::uint32_t size = 0;
    std::memcpy(&size, bytes.data() + 1, sizeof size);
    if (bytes.size() < head + size) return;
    const std::string text = bytes.substr(head, size);
    switch (static_cast<Kind>(bytes.front())) {
      case Kind::told:
        answer.told.push_back(text);
        break;
      case Kind::threw:
        answer.end = "threw " + text;
        break;
      case Kind::done:
        answer.complete = true;
    }
    bytes.erase(0, head + size);
  }
}

/// Reads until the child closes the pipe; false when it was silent for too long.
bool listen(int pipe, double patience_s, ChildAnswer& answer) {
  std::string bytes;
  char chunk[4096];
  const auto patience = std::chrono::duration<double>(patience_s);
  auto heard = Clock::now();
  while (!answer.complete && answer.end.empty()) {
    pollfd watched{pipe, POLLIN, 0};
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(patience - (Clock::now() - heard)).count();
    if (left <= 0) return false;
    if (poll(&watched, 1, static_cast<int>(std::min<long>(left, 1000))) <= 0) continue;
    const ssize_t got = read(pipe, chunk, sizeof chunk);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return true;
    bytes.append(chunk, static_cast<std::size_t>(got));
    take_messages(bytes, answer);
    heard = Clock::now();
  }
  return true;
}

/// Waits for a child that is at its end, not for long; what is left of its group goes with it.
int collect(pid_t pid) {
  const auto begin = Clock::now();
  siginfo_t info{};
  while (waitid(P_PID, static_cast<id_t>(pid), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == 0) {
    if (Clock::now() - begin > std::chrono::seconds(1)) kill(-pid, SIGKILL);
    usleep(500);
  }
  kill(-pid, SIGKILL);  // while its number is still its own
  int status = 0;
  waitpid(pid, &status, 0);
  return status;
}

ChildAnswer ask_here(const std::function<void(const TellParent&)>& work) {
  ChildAnswer answer;
  try {
    work([&](std::string_view text) { answer.told.emplace_back(text); });
    answer.complete = true;
  } catch (const std::exception& e) {
    answer.end = std::string("threw ") + e.what();
  }
  return answer;
}

}  // namespace

std::vector<pid_t> children_of_this_process() {
  std::vector<pid_t> all;
  std::error_code failed;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task", failed)) {
    std::ifstream in(task.path() / "children");
    for (pid_t pid = 0; in >> pid;) all.push_back(pid);
  }
  return all;
}

std::string describe_end(int status) {
  if (WIFSIGNALED(status))
    return "was ended by signal " + std::to_string(WTERMSIG(status)) + " (" + strsignal(WTERMSIG(status)) + ")";
  return "ended with exit code " + std::to_string(WEXITSTATUS(status));
}

ChildAnswer ask_child(double patience_s, const std::function<void(const TellParent&)>& work) {
  if (ask_in_this_process()) return ask_here(work);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error(std::string("no pipe: ") + std::strerror(errno));
  // Ignored, the end of a child leaves nothing to wait for.
  struct sigaction usual {
  }, before{};
  usual.sa_handler = SIG_DFL;
  sigaction(SIGCHLD, &usual, &before);
  std::cout.flush();
  std::cerr.flush();
  const pid_t parent = getpid(), pid = fork();
  if (pid == 0) {
    close(ends[0]);
    child(ends[1], parent, work);
  }
  const int failed = errno;
  close(ends[1]);
  ChildAnswer answer;
  if (pid > 0) {
    setpgid(pid, pid);
    const bool in_time = listen(ends[0], patience_s, answer);
    if (!in_time) {
      kill(-pid, SIGKILL);
      char digits[32];
      const auto end = std::to_chars(digits, std::end(digits), patience_s, std::chars_format::general, 3).ptr;
      answer.end = "did not come back within " + std::string(digits, end) + " s";
    }
    const int status = collect(pid);
    if (!answer.complete && answer.end.empty()) answer.end = describe_end(status);
  }
  close(ends[0]);
  sigaction(SIGCHLD, &before, nullptr);
  if (pid < 0) throw std::runtime_error(std::string("cannot start a process: ") + std::strerror(failed));
  return answer;
}

}  // namespace gripline
