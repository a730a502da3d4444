#include "config/shipped.hpp"

#include <algorithm>
#include <array>
#include <compare>
#include <optional>
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

/// One way to name a shipped file, and its path below the shipped folder.
struct ShippedName {
  std::string name, file;
  auto operator<=>(const ShippedName&) const = default;
};

/// Every way to name the files of these folders: "first_race", "first_race.json", "experiments/first_race.json"; files
/// deeper inside have their whole path only.
std::vector<ShippedName> shipped_names(const fs::path& shipped, std::span<const std::string_view> folders) {
  std::vector<ShippedName> names;
  std::error_code failed;
  for (const std::string_view folder : folders)
    for (fs::recursive_directory_iterator it(shipped / folder, failed), end; !failed && it != end;
         it.increment(failed)) {
      const fs::path& file = it->path();
      if (file.extension() != ".json" && file.extension() != ".csv") continue;
      const std::string name = file.filename().string(), whole = file.lexically_relative(shipped).generic_string();
      names.push_back({whole, whole});
      if (it.depth() > 0) continue;
      names.push_back({name, whole});
      if (file.extension() == ".json") names.push_back({file.stem().string(), whole});
    }
  std::ranges::sort(names);
  return names;
}

/// The shipped file that an absent one was most likely meant to be. A near name in the user's own folder (`why` has it)
/// is the better guess.
std::optional<ShippedName> near_shipped(const fs::path& named, std::string_view why,
                                        std::span<const std::string_view> folders) {
  const fs::path shipped = shipped_folder();
  if (shipped.empty() || named.is_absolute()) return std::nullopt;
  if (!why.starts_with("no such file") || why.find("did you mean") != why.npos) return std::nullopt;
  const std::vector<ShippedName> all = shipped_names(shipped, folders);
  std::vector<std::string> names;
  for (const ShippedName& one : all) names.push_back(one.name);
  const auto near = nearest(named.generic_string(), names);
  if (!near) return std::nullopt;
  return *std::ranges::find(all, *near, &ShippedName::name);
}

std::string shipped_hint(const std::string& name) {
  return "no such file; did you mean \"" + name + "\", which is shipped?";
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
  if (const auto near = near_shipped(named, why_unreadable(named), folders))
    throw InputError(std::vector{Diagnostic{.file = shown(named), .message = shipped_hint(near->name)}});
  return named;
}

std::string why_unreadable_as(std::string_view named, const fs::path& file) {
  std::string why = why_unreadable(file);
  if (const auto near = near_shipped(fs::path(named), why, all_folders)) return shipped_hint(near->file);
  return why;
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
