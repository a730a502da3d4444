#include "gripline/plugin_equation.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <sstream>
#include <vector>

#include <gripline/equation.hpp>

#include "config/ascii.hpp"
#include "gripline/new_plugin.hpp"

namespace gripline::tools {

/// framework/doc/effects.md and models.md, compiled in (tools/CMakeLists.txt).
std::span<const Template> equation_pages();

namespace {

#define GRIPLINE_TEXT_OF(name) #name
#define GRIPLINE_NAME_OF(symbol) GRIPLINE_TEXT_OF(symbol)

std::string stated_equation(const PluginEntry& entry) {
  void* const library = dlopen(entry.library.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NOLOAD);  // the registry loaded it
  if (library == nullptr) return {};
  std::string text;
  const auto* one = static_cast<const Equation*>(dlsym(library, GRIPLINE_NAME_OF(GRIPLINE_EQUATIONS_SYMBOL)));
  for (; one != nullptr && one->id != nullptr; ++one)
    if (std::string_view(entry.decl->id) == one->id) text = one->text;
  dlclose(library);
  return text;
}

/// The cells of a line of a Markdown table, without blanks around them.
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream rest(line.substr(std::min<std::size_t>(line.size(), 1)));
  for (std::string cell; std::getline(rest, cell, '|');) {
    cells.emplace_back(trim(cell, " "));
  }
  return cells;
}

/// Of an effect: the cell behind the one that names it. Of a model: the indented lines below the heading of its name.
std::string documented_equation(const std::string& page, const std::string& id, bool effect) {
  std::istringstream lines(page);
  std::string text;
  bool here = false;
  for (std::string line; std::getline(lines, line);) {
    if (effect && line.starts_with('|')) {
      const std::vector<std::string> cells = cells_of(line);
      const std::string name = "`" + id + "`";
      if (cells.size() > 2 && cells[1].find(name) != std::string::npos) return cells[2];
    } else if (!effect && line.starts_with("## ")) {
      here = line == "## " + id;
    } else if (here && line.starts_with("    ")) {
      text.append(text.empty() ? "" : "\n").append(line.substr(4));
    }
  }
  return text;
}

}  // namespace

std::string equation_of(const PluginEntry& entry) {
  std::string text = stated_equation(entry);
  const bool effect = entry.decl->kind == abi::Kind::effect;
  if (!text.empty() || (!effect && entry.decl->kind != abi::Kind::vehicle)) return text;
  for (const Template& page : equation_pages())
    if (page.name == (effect ? "effects.md" : "models.md"))
      text = documented_equation(std::string(page.text), entry.decl->id, effect);
  return text;
}

}  // namespace gripline::tools
