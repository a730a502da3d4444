// A world from its JSON tree, with the shipped plugins.
#pragma once

#include "config/errors.hpp"
#include "config/node.hpp"
#include "plugin/registry.hpp"
#include "support/paths.hpp"
#include "world/world_spec.hpp"

namespace gripline::testing_support {

inline const Registry& shipped_plugins() {
  static const Registry all({plugin_dir()});
  return all;
}

/// The files that the tree names are read, relative to its own. Throws InputError.
inline WorldSpec world_from(Node tree, const Registry& registry = shipped_plugins()) {
  inline_world_files(tree);
  Errors errors;
  WorldSpec spec = read_world(tree, registry, errors);
  errors.throw_if_any();
  return spec;
}

}  // namespace gripline::testing_support
