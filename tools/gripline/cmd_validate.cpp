// gripline validate FILE...: reads everything, drives nothing.
#include <iostream>
#include <sstream>

#include "cli/options.hpp"
#include "config/errors.hpp"
#include "config/shipped.hpp"
#include "gripline/command.hpp"
#include "gripline/validate_file.hpp"

namespace gripline::tools {
namespace po = boost::program_options;

int run_validate(Arguments args) {
  po::options_description visible("options");
  add_plugins_option(visible);
  visible.add_options()("help,h", "this text");
  const auto given = parse_options(args, visible, "validate FILE... [options]", "files");
  if (!given) return good;
  const Words files = words_of(*given, "files");
  if (files.empty()) throw InputError("which file?");
  const Registry registry = open_registry(plugin_dirs_of(*given));
  Errors errors;
  Words unusable;  // a line for each plugin
  for (const std::string& file : files) {
    try {
      const std::vector<Diagnostic> warnings = validate_file(find_shipped(file), registry);
      print_warnings(file, warnings);
      std::cout << file << ": good";
      if (!warnings.empty()) std::cout << ", " << warnings.size() << (warnings.size() == 1 ? " warning" : " warnings");
      std::cout << '\n';
    } catch (const InputError& e) {
      errors.add(e);
    } catch (const PluginError& e) {
      std::istringstream lines(e.what());
      for (std::string line; std::getline(lines, line);) unusable.push_back(line);
    }
  }
  const std::size_t count = errors.size() + unusable.size();
  if (count == 0) return good;
  for (const Diagnostic& one : errors.sorted()) std::cerr << one.text() << '\n';
  for (const std::string& one : unusable) std::cerr << one << '\n';
  std::cerr << count << (count == 1 ? " error.\n" : " errors.\n");
  return errors.empty() ? plugin_unusable : bad_input;
}

}  // namespace gripline::tools
