#include "cli/companion.hpp"

#include <unistd.h>

#include <boost/dll/runtime_symbol_info.hpp>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <vector>

namespace gripline::tools {
namespace {

namespace fs = std::filesystem;

std::string find_companion(const std::string& name, const std::string& purpose) {
  const fs::path here = fs::path(boost::dll::program_location().string()).parent_path();
  std::string searched;
  for (const fs::path& folder : {here, here.parent_path() / "libexec"}) {
    const fs::path program = folder / name;
    std::error_code ignored;
    if (fs::is_regular_file(program, ignored)) return program;
    searched += " " + program.string();
  }
  throw std::runtime_error(purpose + " needs the program " + name + ", which is not installed; searched" + searched);
}

}  // namespace

void exec_companion(const char* program, const char* purpose, Arguments args) {
  const std::string file = find_companion(program, purpose);
  std::vector<char*> words = {const_cast<char*>(file.c_str())};
  for (const std::string& arg : args) words.push_back(const_cast<char*>(arg.c_str()));
  words.push_back(nullptr);
  std::cout.flush();
  execv(file.c_str(), words.data());
  throw std::runtime_error(file + ": cannot be started: " + std::strerror(errno));
}

}  // namespace gripline::tools
