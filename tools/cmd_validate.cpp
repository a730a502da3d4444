// gripline validate FILE...: reads everything, runs nothing.
#include <algorithm>
#include <iostream>

#include "config/json_file.hpp"
#include "diagnose/diagnose_experiment.hpp"
#include "friction_file.hpp"
#include "geometry/track_file.hpp"
#include "race_options.hpp"
#include "validation.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace {

bool has_any(const Node& tree, std::initializer_list<const char*> keys) {
  return std::any_of(keys.begin(), keys.end(), [&](const char* key) { return tree.find(key) != nullptr; });
}

/// What a file is shows in the keys that only its kind has.
void validate_file(const std::string& file, const Registry& registry) {
  if (file.ends_with(".csv")) {
    load_track(file);
    return;
  }
  Node tree = load_experiment(file, {});
  Errors errors;
  if (experiment_kind(tree) == "offline_validation") {
    check_offline(tree, registry);
  } else if (experiment_kind(tree) == "diagnose") {
    diagnose::check_diagnose_experiment(tree, registry);
  } else if (has_any(tree, {"stacks", "world"})) {
    read_race(file, std::move(tree), registry);
  } else if (has_any(tree, {"plant"})) {
    inline_world_files(tree);
    read_world(tree, registry, errors);
  } else if (has_any(tree, {"segments", "centre", "edges"})) {
    read_track(tree, errors);
  } else if (has_any(tree, {"lf"})) {
    read_car(tree, errors);
  } else if (has_any(tree, {"points", "per_step", "patches"})) {
    read_friction(tree, errors);
  } else {
    errors.add(tree.origin,
               "is no experiment (\"stacks\"), world (\"plant\"), track (\"segments\"), car (\"lf\") or friction "
               "schedule (\"points\")");
  }
  errors.throw_if_any();
}

}  // namespace

int run_validate(Arguments args) {
  po::options_description visible("options");
  visible.add_options()("plugins", po::value<std::vector<std::string>>()->composing(), "a folder of plugins");
  visible.add_options()("help,h", "this text");
  const auto given = parse_options(args, visible, "validate FILE... [options]");
  if (!given) return good;
  if (given->count("experiment") == 0) throw InputError("which file?");
  const Registry registry(Registry::search_path(plugin_dirs_of(*given)));
  Errors errors;
  std::vector<std::string> unusable;
  for (const std::string& file : (*given)["experiment"].as<std::vector<std::string>>()) {
    try {
      validate_file(file, registry);
      std::cout << file << ": good\n";
    } catch (const InputError& e) {
      errors.add(e);
    } catch (const PluginError& e) {
      unusable.push_back(file + ": " + e.what());
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
