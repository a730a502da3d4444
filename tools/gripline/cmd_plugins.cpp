// gripline plugins list | describe ID | new KIND NAME | check LIBRARY.so.
#include <algorithm>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "cli/companion.hpp"
#include "cli/options.hpp"
#include "config/errors.hpp"
#include "config/node.hpp"
#include "gripline/command.hpp"
#include "gripline/new_plugin.hpp"
#include "gripline/plugin_equation.hpp"
#include "plugin/plugin_spec.hpp"
#include "plugin/registry.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace {

void list(const Registry& registry) {
  for (int kind = 0; kind < abi::kind_count; ++kind) {
    for (const PluginEntry& entry : registry.entries()) {
      if (static_cast<int>(entry.decl->kind) != kind) continue;
      const std::string id = std::string(entry.decl->id) + (entry.needs_truth() ? " *" : "");
      const std::string name(kind_name(entry.decl->kind));
      std::cout << name << std::string(11 - name.size(), ' ') << id
                << std::string(id.size() < 18 ? 18 - id.size() : 1, ' ') << escape_control(entry.decl->summary) << '\n';
    }
  }
  std::cout << "* is given the ground truth of the world\n";
  for (const Registry::Unusable& one : registry.unusable())
    std::cout << "unusable   " << escape_control(one.library.string() + ": " + one.reason) << '\n';
}

std::string range_text(const abi::ParamDecl& p) {
  switch (p.type) {
    case abi::ParamType::boolean:
      return "true or false";
    case abi::ParamType::choice:
      return escape_control(p.choices);
    case abi::ParamType::table:
      return "table";
    default:
      return "[" + number_text(p.lo) + ", " + number_text(p.hi) + "]";
  }
}

std::string default_text(const abi::ParamDecl& p) {
  switch (p.type) {
    case abi::ParamType::boolean:
      return p.default_value != 0 ? " = true" : " = false";
    case abi::ParamType::table:
      return "";
    case abi::ParamType::choice: {
      const std::vector<std::string> names = choice_names(p);
      const auto chosen = static_cast<std::size_t>(std::max(p.default_value, 0.0));
      return chosen < names.size() ? " = " + escape_control(names[chosen]) : "";  // none: a default that names nothing
    }
    default:
      return " = " + number_text(p.default_value);
  }
}

void describe(const PluginEntry& entry) {
  std::cout << kind_name(entry.decl->kind) << ' ' << entry.decl->id << ' ' << escape_control(entry.decl->version)
            << "\n  " << escape_control(entry.decl->summary) << '\n';
  std::istringstream equation(equation_of(entry));
  for (std::string line; std::getline(equation, line);) std::cout << "    " << escape_control(line) << '\n';
  if (entry.needs_truth()) std::cout << "  needs the truth of the world\n";
  if (*entry.decl->advice != '\0')
    std::cout << "  to distinguish it from similar effects: " << entry.decl->advice << '\n';
  std::cout << "  from " << entry.library.filename().string() << '\n';
  for (const abi::ParamDecl& p : entry.params()) {
    std::cout << "  " << p.name << " [" << escape_control(p.unit) << "]" << default_text(p) << "  " << range_text(p)
              << "  " << escape_control(p.doc) << (p.periodic ? "; a whole number apart is the same place" : "");
    if (p.fit) std::cout << "; diagnose may fit it, " << number_text(p.neutral) << " is no effect";
    std::cout << '\n';
  }
}

/// Describes every plugin of that id, of whatever kind.
void describe_all(const Registry& registry, const std::string& id) {
  bool found = false;
  std::vector<std::string> ids;
  for (const PluginEntry& entry : registry.entries()) {
    ids.emplace_back(entry.decl->id);
    if (id != entry.decl->id) continue;
    describe(entry);
    found = true;
  }
  if (!found) throw PluginError("no plugin \"" + id + "\"" + did_you_mean(id, ids));
}

/// Writes a plugin to start from, and says what comes next.
int make_new(Arguments args) {
  po::options_description visible("options");
  visible.add_options()("out", po::value<std::string>(), "the folder that is made (default: NAME)");
  visible.add_options()("help,h", "this text");
  const auto given = parse_options(args, visible, "plugins new KIND NAME [--out DIR]", "request");
  if (!given) return good;
  const Words words = words_of(*given, "request");
  if (words.size() != 2)
    throw InputError("plugins new KIND NAME; KIND is one of vehicle, effect, estimator, planner, controller, plant");
  const std::string folder = text_of(*given, "out").value_or(words[1]);
  write_new_plugin(words[0], words[1], folder);
  std::cout << folder << ": " << words[1] << ".cpp, CMakeLists.txt, try.json. Next:\n\n"
            << "  cmake -S " << folder << " -B " << folder << "/build && cmake --build " << folder << "/build\n"
            << "  ctest --test-dir " << folder << "/build\n"
            << "  gripline compare " << folder << "/try.json --plugins " << folder << "/build\n";
  return good;
}

}  // namespace

int run_plugins(Arguments args) {
  if (!args.empty() && args[0] == "new") return make_new(args.subspan(1));
  if (!args.empty() && args[0] == "check") exec_companion("gripline-check", "plugins check", args.subspan(1));
  po::options_description visible("options");
  add_plugins_option(visible);
  visible.add_options()("help,h", "this text");
  const auto given = parse_options(
      args, visible, "plugins list | describe ID | new KIND NAME | check LIBRARY.so [options]", "request");
  if (!given) return good;
  const Words words = words_of(*given, "request");
  if (words.empty() || (words[0] != "list" && words[0] != "describe")) {
    const Words known = {"list", "describe", "new", "check"};
    throw InputError("plugins list, describe ID, new KIND NAME or check LIBRARY.so" +
                     (words.empty() ? "" : did_you_mean(words[0], known)));
  }
  if (words.size() != (words[0] == "list" ? 1 : 2))
    throw InputError(words[0] == "list" ? "plugins list takes no further word" : "plugins describe ID");
  const Registry registry = open_registry(plugin_dirs_of(*given));
  if (words[0] == "list")
    list(registry);
  else
    describe_all(registry, words[1]);
  return good;
}

}  // namespace gripline::tools
