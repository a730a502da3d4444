// The program as its users call it: a process with arguments, what it says, and its exit code.
#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <map>
#include <string>
#include <vector>

#include "support/host_support.hpp"
#include "support/paths.hpp"

namespace gripline::testing_support {

struct Outcome {
  int code = -1;  // 128 + signal when a signal ended it
  std::string out, err;
};

/// Where and how to run it.
struct Call {
  std::filesystem::path folder = fixture_dir();  // working folder
  std::map<std::string, std::string> environment;
};

/// A process that runs: its words go to files in a folder that must outlive it.
class Process {
 public:
  Process(const std::vector<std::string>& words, const std::filesystem::path& scratch, const Call& call = {})
      : out_(scratch / "stdout"), err_(scratch / "stderr") {
    pid_ = fork();
    if (pid_ == 0) begin(words, call);
  }
  void signal(int number) const { kill(pid_, number); }
  pid_t pid() const { return pid_; }
  Outcome wait() const {
    int status = 0;
    waitpid(pid_, &status, 0);
    return {WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status), contents(out_), contents(err_)};
  }

 private:
  [[noreturn]] void begin(const std::vector<std::string>& words, const Call& call) const {
    dup2(open(out_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644), STDOUT_FILENO);
    dup2(open(err_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644), STDERR_FILENO);
    unsetenv("GRIPLINE_PLUGIN_PATH");
    setenv("XDG_CACHE_HOME", (build_dir() / "cache").c_str(), 1);  // tests leave nothing at home
    setenv("XDG_DATA_HOME", (build_dir() / "data").c_str(), 1);    // and take no plugins from there
    for (const auto& [name, value] : call.environment) setenv(name.c_str(), value.c_str(), 1);
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    if (chdir(call.folder.c_str()) == 0) execvp(arguments[0], arguments.data());
    _exit(127);
  }
  std::filesystem::path out_, err_;
  pid_t pid_ = -1;
};

inline Outcome run_program(const std::vector<std::string>& words, const Call& call = {}) {
  std::string scratch = std::filesystem::temp_directory_path() / "gripline_call_XXXXXX";
  const std::filesystem::path folder = mkdtemp(scratch.data());
  const Outcome outcome = Process(words, folder, call).wait();
  std::filesystem::remove_all(folder);
  return outcome;
}

/// gripline WORDS...
inline Outcome gripline_with(std::vector<std::string> words, const Call& call = {}) {
  words.insert(words.begin(), gripline_program());
  return run_program(words, call);
}

}  // namespace gripline::testing_support
