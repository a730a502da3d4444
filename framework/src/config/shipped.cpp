#include "config/shipped.hpp"

#include <string>

namespace gripline {
namespace fs = std::filesystem;

namespace {

struct Program {
  fs::path file = "/proc/self/exe", prefix;
};

Program& program() {
  static Program running = [] {
    Program found;
    std::error_code failed;
    found.prefix = fs::read_symlink(found.file, failed).parent_path().parent_path();
    return found;
  }();
  return running;
}

}  // namespace

const fs::path& prefix() { return program().prefix; }

const fs::path& program_file() { return program().file; }

void set_program(const fs::path& file, const fs::path& prefix) { program() = {file, prefix}; }

fs::path shipped_folder() {
  std::error_code failed;
  const fs::path folder = prefix() / "share" / "gripline";
  return fs::is_directory(folder, failed) ? folder : fs::path();
}

fs::path find_shipped(const fs::path& named, std::string_view kind) {
  std::error_code failed;
  if (named.empty() || named.is_absolute() || shipped_folder().empty() || fs::exists(named, failed)) return named;
  const fs::path in_kind = shipped_folder() / kind / named;
  for (const fs::path& candidate : {shipped_folder() / named, in_kind, fs::path(in_kind.string() + ".json")})
    if (fs::is_regular_file(candidate, failed)) return candidate.lexically_normal();
  return named;
}

}  // namespace gripline
