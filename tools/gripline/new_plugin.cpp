#include "gripline/new_plugin.hpp"

#include <algorithm>
#include <boost/algorithm/string/replace.hpp>
#include <cctype>
#include <fstream>
#include <vector>

#include "config/errors.hpp"
#include "plugin/registry.hpp"

namespace gripline::tools {
namespace fs = std::filesystem;
namespace {

std::string_view template_text(const std::string& name) {
  const auto found = std::ranges::find(templates(), name, &Template::name);
  if (found == templates().end()) throw std::logic_error("no template " + name);
  return found->text;
}

/// "my_drag" as a class is called: MyDrag.
std::string class_name(const std::string& name) {
  std::string out;
  bool upper = true;
  for (const char c : name) {
    if (c != '_') out += upper ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    upper = c == '_';
  }
  return out;
}

void require_kind(const std::string& kind) {
  std::vector<std::string> kinds;
  for (int i = 0; i < abi::kind_count; ++i) kinds.emplace_back(kind_name(static_cast<abi::Kind>(i)));
  if (std::ranges::find(kinds, kind) != kinds.end()) return;
  std::string all;
  for (const std::string& one : kinds) all += (all.empty() ? "" : ", ") + one;
  throw InputError("no kind of plugin \"" + kind + "\": expected one of " + all + did_you_mean(kind, kinds));
}

void require_name(const std::string& name) {
  const auto letter = [](char c) {
    return std::string_view("abcdefghijklmnopqrstuvwxyz").find(c) != std::string_view::npos;
  };
  const bool good = !name.empty() && letter(name.front()) && name.size() <= 60 &&
                    std::ranges::all_of(name, [&](char c) { return letter(c) || (c >= '0' && c <= '9') || c == '_'; });
  if (!good)
    throw InputError("\"" + name +
                     "\" cannot be a plugin's name: expected lower case letters, digits and '_', a letter first");
}

void write(const fs::path& file, std::string text, const std::string& name) {
  boost::replace_all(text, "NewPlugin", class_name(name));
  boost::replace_all(text, "new_plugin", name);
  std::ofstream out(file, std::ios::binary);
  out << text;
  if (!out.flush()) throw InputError(file.string() + ": cannot be written");
}

}  // namespace

void write_new_plugin(const std::string& kind, const std::string& name, const fs::path& folder) {
  require_kind(kind);
  require_name(name);
  std::error_code failed;
  if (fs::exists(folder, failed)) throw InputError(folder.string() + ": is there already; --out names another folder");
  fs::create_directories(folder, failed);
  if (failed) throw InputError(folder.string() + ": cannot be made: " + failed.message());
  write(folder / (name + ".cpp"), std::string(template_text(kind + ".cpp")), name);
  write(folder / "CMakeLists.txt", std::string(template_text("CMakeLists.txt.in")), name);
  write(folder / "try.json", std::string(template_text(kind + ".json")), name);
}

}  // namespace gripline::tools
