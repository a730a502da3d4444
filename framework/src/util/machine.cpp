#include "util/machine.hpp"

#include <unistd.h>

#include <fstream>
#include <iterator>
#include <sstream>

namespace gripline {

std::string this_machine() {
  char host[256] = "";
  gethostname(host, sizeof host - 1);
  return host;
}

std::optional<std::uint64_t> process_start(pid_t pid) {
  std::ifstream in("/proc/" + std::to_string(pid) + "/stat");
  const std::string line{std::istreambuf_iterator<char>(in), {}};
  // The second word is the program's name in brackets, which may hold blanks and brackets; the 22nd is the start.
  const std::size_t name = line.rfind(')');
  if (name == std::string::npos) return std::nullopt;
  std::istringstream words(line.substr(name + 1));
  std::string word;
  for (int i = 3; i < 22; ++i) words >> word;
  std::uint64_t start = 0;
  if (!(words >> start)) return std::nullopt;
  return start;
}

}  // namespace gripline
