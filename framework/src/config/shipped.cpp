#include "config/shipped.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <vector>

#include "config/errors.hpp"
#include "config/files.hpp"

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

constexpr std::array<std::string_view, 5> all_folders = {"experiments", "worlds", "worlds/cars", "worlds/tracks",
                                                         "worlds/friction"};

/// Every way to name the files of these folders: "first_race", "first_race.json", "experiments/first_race.json".
std::vector<std::string> shipped_names(const fs::path& shipped, std::span<const std::string_view> folders) {
  std::vector<std::string> names;
  std::error_code failed;
  for (const std::string_view folder : folders)
    for (fs::directory_iterator it(shipped / folder, failed), end; !failed && it != end; it.increment(failed)) {
      const fs::path& file = it->path();
      if (file.extension() == ".json") names.push_back(file.stem().string());
      if (file.extension() == ".json" || file.extension() == ".csv") {
        names.push_back(file.filename().string());
        names.push_back(std::string(folder) + "/" + file.filename().string());
      }
    }
  std::ranges::sort(names);
  return names;
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
  const fs::path shipped = shipped_folder();
  if (named.empty() || named.is_absolute() || shipped.empty() || fs::exists(named, failed)) return named;
  const std::span<const std::string_view> folders =
      kind.empty() ? std::span<const std::string_view>(all_folders) : std::span(&kind, 1);
  std::vector<fs::path> candidates = {shipped / named};
  for (const std::string_view folder : folders) {
    candidates.push_back(shipped / folder / named);
    candidates.emplace_back(candidates.back().string() + ".json");
  }
  for (const fs::path& candidate : candidates)
    if (fs::is_regular_file(candidate, failed)) return candidate.lexically_normal();
  // A near name in the user's own folder is the better guess; who reads the file tells it.
  if (const std::string why = why_unreadable(named); why.find("did you mean") == why.npos)
    if (const auto near = nearest(named.generic_string(), shipped_names(shipped, folders)))
      throw InputError(std::vector{Diagnostic{
          .file = shown(named), .message = "no such file; did you mean \"" + *near + "\", which is shipped?"}});
  return named;
}

std::string name_from(const fs::path& file, const fs::path& folder) {
  const auto whole = [](const fs::path& path) { return fs::absolute(path).lexically_normal(); };
  if (const fs::path shipped = shipped_folder(); !shipped.empty()) {
    fs::path inside = whole(file).lexically_relative(whole(shipped));
    if (!inside.empty() && *inside.begin() != "..") return inside.generic_string();
  }
  return whole(file).lexically_proximate(whole(folder.empty() ? fs::current_path() : folder)).generic_string();
}

}  // namespace gripline
