#include "util/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <stdexcept>

#include "util/pipe.hpp"

namespace gripline {
namespace {

using Clock = std::chrono::steady_clock;

// What the child writes to the pipe: a kind, a size in four bytes, that many bytes of text.
enum class Kind : char { message = 't', threw = 'x', done = 'd' };

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

[[noreturn]] void child(int pipe, pid_t parent, const std::function<void(const SendMessage&)>& work) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
  for (const int number : {SIGINT, SIGTERM, SIGCHLD, SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL})
    std::signal(number, SIG_DFL);
  end_at_exit();
  if (const int nowhere = open("/dev/null", O_RDWR); nowhere >= 0) {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
      if (stream != pipe) dup2(nowhere, stream);
  }
  try {
    work([pipe](std::string_view text) { send(pipe, Kind::message, text); });
    send(pipe, Kind::done, "");
  } catch (const std::exception& e) {
    send(pipe, Kind::threw, e.what());
  } catch (...) {
    send(pipe, Kind::threw, "something that is not a std::exception");
  }
  _exit(0);
}

/// Moves complete messages from the front of `bytes` into `result`.
void take_messages(std::string& bytes, ChildResult& result) {
  constexpr std::size_t head = 1 + sizeof(std::uint32_t);
  while (bytes.size() >= head) {
    std::uint32_t size = 0;
    std::memcpy(&size, bytes.data() + 1, sizeof size);
    if (bytes.size() < head + size) return;
    const std::string text = bytes.substr(head, size);
    switch (static_cast<Kind>(bytes.front())) {
      case Kind::message:
        result.messages.push_back(text);
        break;
      case Kind::threw:
        result.failure = "threw " + text;
        break;
      case Kind::done:
        result.completed = true;
    }
    bytes.erase(0, head + size);
  }
}

/// Reads until the child closes the pipe; false when nothing arrived for too long.
bool listen(int pipe, double timeout_s, ChildResult& result) {
  std::string bytes;
  char chunk[4096];
  const auto timeout = std::chrono::duration<double>(timeout_s);
  auto heard = Clock::now();
  while (!result.completed && result.failure.empty()) {
    pollfd watched{pipe, POLLIN, 0};
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(timeout - (Clock::now() - heard)).count();
    if (left <= 0) return false;
    if (poll(&watched, 1, static_cast<int>(std::min<long>(left, 1000))) <= 0) continue;
    const ssize_t got = read(pipe, chunk, sizeof chunk);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return true;
    bytes.append(chunk, static_cast<std::size_t>(got));
    take_messages(bytes, result);
    heard = Clock::now();
  }
  return true;
}

/// Waits for a child that is about to end, at most a second before it is killed.
int collect(pid_t pid) {
  const auto begin = Clock::now();
  for (;;) {
    if (const std::optional<int> status = collect_if_ended(pid)) return *status;
    if (Clock::now() - begin > std::chrono::seconds(1)) kill(-pid, SIGKILL);
    usleep(500);
  }
}

ChildResult run_here(const std::function<void(const SendMessage&)>& work) {
  ChildResult result;
  try {
    work([&](std::string_view text) { result.messages.emplace_back(text); });
    result.completed = true;
  } catch (const std::exception& e) {
    result.failure = std::string("threw ") + e.what();
  }
  return result;
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

pid_t fork_process() {
  std::cout.flush();
  std::cerr.flush();
  const pid_t pid = fork();
  if (pid < 0) throw std::runtime_error(std::string("cannot start a process: ") + std::strerror(errno));
  return pid;
}

UsualChildSignal::UsualChildSignal() {
  struct sigaction usual {};
  usual.sa_handler = SIG_DFL;
  sigaction(SIGCHLD, &usual, &before_);
}

UsualChildSignal::~UsualChildSignal() { sigaction(SIGCHLD, &before_, nullptr); }

std::optional<int> collect_if_ended(pid_t pid) {
  siginfo_t info{};
  const int result = waitid(P_PID, static_cast<id_t>(pid), &info, WEXITED | WNOHANG | WNOWAIT);
  if (result == 0 && info.si_pid == 0) return std::nullopt;
  if (result != 0) return 0;  // collected: the group's number may be another's by now
  kill(-pid, SIGKILL);
  return wait_for_end(pid).value_or(0);
}

std::optional<int> wait_for_end(pid_t pid) {
  int status = 0;
  pid_t ended = -1;
  do ended = waitpid(pid, &status, 0);
  while (ended < 0 && errno == EINTR);
  return ended == pid ? std::optional(status) : std::nullopt;
}

void limit_data(std::size_t megabytes) {
  if (megabytes == 0) return;
  const rlim_t bytes = static_cast<rlim_t>(megabytes) << 20U;
  const rlimit limit{bytes, bytes};
  setrlimit(RLIMIT_DATA, &limit);
}

void end_at_exit() {
  on_exit(
      [](int status, void*) {
        std::fflush(nullptr);
        _exit(status);
      },
      nullptr);
}

std::string describe_end(int status) {
  if (WIFSIGNALED(status))
    return "was ended by signal " + std::to_string(WTERMSIG(status)) + " (" + strsignal(WTERMSIG(status)) + ")";
  return "ended with exit code " + std::to_string(WEXITSTATUS(status));
}

bool ends_from_outside(int signal) { return signal == SIGKILL || signal == SIGTERM; }

ChildResult run_in_child(double timeout_s, const std::function<void(const SendMessage&)>& work) {
  if (run_children_here()) return run_here(work);
  Pipe pipe;
  const UsualChildSignal statuses_are_kept;
  const pid_t parent = getpid(), pid = fork_process();
  if (pid == 0) {
    pipe.read.close();
    child(pipe.write.number(), parent, work);
  }
  setpgid(pid, pid);
  pipe.write.close();
  ChildResult result;
  if (!listen(pipe.read.number(), timeout_s, result)) {
    kill(-pid, SIGKILL);
    char digits[32];
    const auto end = std::to_chars(digits, std::end(digits), timeout_s, std::chars_format::general, 3).ptr;
    result.failure = "did not come back within " + std::string(digits, end) + " s";
  }
  const int status = collect(pid);
  if (!result.completed && result.failure.empty()) {
    result.failure = describe_end(status);
    if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  }
  return result;
}

}  // namespace gripline
