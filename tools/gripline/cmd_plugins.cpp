// gripline plugins list | describe ID.
#include <iostream>

#include "cli/options.hpp"
#include "config/errors.hpp"
#include "config/node.hpp"
#include "gripline/command.hpp"
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
                << std::string(id.size() < 18 ? 18 - id.size() : 1, ' ') << harmless(entry.decl->summary) << '\n';
    }
  }
  std::cout << "* is told the truth of the world\n";
  for (const Registry::Unusable& one : registry.unusable())
    std::cout << "unusable   " << harmless(one.library.string() + ": " + one.reason) << '\n';
}

std::string range_text(const abi::ParamDecl& p) {
  switch (p.type) {
    case abi::ParamType::boolean:
      return "true or false";
    case abi::ParamType::choice:
      return harmless(p.choices);
    case abi::ParamType::table:
      return "table";
    default:
      return "[" + number_text(p.lo) + ", " + number_text(p.hi) + "]";
  }
}

void describe(const PluginEntry& entry) {
  std::cout << kind_name(entry.decl->kind) << ' ' << entry.decl->id << ' ' << harmless(entry.decl->version) << "\n  "
            << harmless(entry.decl->summary) << '\n';
  if (entry.needs_truth()) std::cout << "  needs the truth of the world\n";
  if (*entry.decl->advice != '\0') std::cout << "  to tell it from others: " << entry.decl->advice << '\n';
  std::cout << "  from " << entry.library.filename().string() << '\n';
  for (const abi::ParamDecl& p : entry.params()) {
    std::cout << "  " << p.name << " [" << harmless(p.unit) << "]";
    if (p.type == abi::ParamType::boolean)
      std::cout << " = " << (p.default_value != 0 ? "true" : "false");
    else if (p.type != abi::ParamType::table && p.type != abi::ParamType::choice)
      std::cout << " = " << number_text(p.default_value);
    std::cout << "  " << range_text(p) << "  " << harmless(p.doc) << '\n';
  }
}

}  // namespace

int run_plugins(Arguments args) {
  po::options_description visible("options");
  add_plugins_option(visible);
  visible.add_options()("help,h", "this text");
  const auto given = parse_options(args, visible, "plugins list | describe ID [options]", "request");
  if (!given) return good;
  const Words words = words_of(*given, "request");
  const Registry registry = open_registry(plugin_dirs_of(*given));
  if (words.size() == 1 && words[0] == "list") {
    list(registry);
    return good;
  }
  if (words.size() != 2 || words[0] != "describe") throw InputError("plugins list, or plugins describe ID");
  bool found = false;
  std::vector<std::string> ids;
  for (const PluginEntry& entry : registry.entries()) {
    ids.emplace_back(entry.decl->id);
    if (words[1] != entry.decl->id) continue;
    describe(entry);
    found = true;
  }
  if (!found) throw PluginError("no plugin \"" + words[1] + "\"" + did_you_mean(words[1], ids));
  return good;
}

}  // namespace gripline::tools
