// gripline bench: hands over to the program gripline-bench, which knows the plugins that are compared and counts every
// allocation of its process; no other command should.
#include <unistd.h>

#include <boost/dll/runtime_symbol_info.hpp>
#include <cerrno>
#include <cstring>
#include <iostream>
#include <stdexcept>
#include <vector>

#include "gripline/command.hpp"

namespace gripline::tools {
namespace {

namespace fs = std::filesystem;

/// Beside this program as it is built, in libexec as it is installed.
fs::path bench_program() {
  const fs::path here = fs::path(boost::dll::program_location().string()).parent_path();
  std::string searched;
  for (const fs::path& folder : {here, here.parent_path() / "libexec"}) {
    const fs::path program = folder / "gripline-bench";
    std::error_code ignored;
    if (fs::is_regular_file(program, ignored)) return program;
    searched += " " + program.string();
  }
  throw std::runtime_error("bench needs the program gripline-bench, which is not installed; searched" + searched);
}

}  // namespace

int run_bench_command(Arguments args) {
  const std::string program = bench_program().string();
  std::vector<char*> words = {const_cast<char*>(program.c_str())};
  for (const std::string& arg : args) words.push_back(const_cast<char*>(arg.c_str()));
  words.push_back(nullptr);
  std::cout.flush();
  execv(program.c_str(), words.data());
  throw std::runtime_error(program + ": cannot be started: " + std::strerror(errno));
}

}  // namespace gripline::tools
