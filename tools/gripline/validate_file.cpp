#include "gripline/validate_file.hpp"

#include <iostream>

#include "config/errors.hpp"
#include "config/file_kind.hpp"
#include "config/json_file.hpp"
#include "geometry/track_file.hpp"
#include "gripline/experiment_kinds.hpp"
#include "measured/session/log_map.hpp"
#include "world/friction_file.hpp"
#include "world/plausibility.hpp"
#include "world/world_spec.hpp"

namespace gripline::tools {

std::vector<Diagnostic> validate_file(const std::filesystem::path& file, const Registry& registry) {
  if (file.extension() == ".csv") {
    load_track(file);
    return {};
  }
  std::vector<Diagnostic> warnings;
  const Node tree = load_json(file);
  Errors errors;
  switch (kind_of(tree)) {
    case FileKind::experiment:
      warnings = read_experiment(file, {}, registry)->warnings({});
      break;
    case FileKind::world: {
      const Node whole = load_world(file);
      if (const WorldSpec world = read_world(whole, registry, errors, RoadRule::optional); errors.empty())
        warnings = plausibility_warnings(world, whole);
      break;
    }
    case FileKind::track:
      load_track(file);
      break;
    case FileKind::car:
      warnings = plausibility_warnings(read_car(tree, errors).car, tree);
      check_known_params(tree, registry, errors);
      break;
    case FileKind::friction:
      warnings = plausibility_warnings(read_friction(tree, errors), tree);
      break;
    case FileKind::log_map:
      measured::read_log_map(tree, errors);
      break;
    case FileKind::unknown:
      errors.add(tree.origin,
                 "is not an experiment (\"stacks\"), world (\"plant\"), track (\"segments\"), car (\"lf\"), friction "
                 "schedule (\"points\") or map of a log (\"channels\")");
  }
  errors.throw_if_any();
  return warnings;
}

void print_warnings(const std::string& file, const std::vector<Diagnostic>& warnings) {
  for (Diagnostic warning : warnings) {
    if (warning.file.empty()) warning.file = file;
    std::cerr << "warning: " << warning.text() << '\n';
  }
}

}  // namespace gripline::tools
