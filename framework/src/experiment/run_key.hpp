// The name of a run: a hash of everything that its results depend on.
#pragma once

#include <cstdint>
#include <string>

#include "experiment/experiment.hpp"
#include "util/file_hashes.hpp"

namespace gripline {

struct RunId {
  std::string stack;
  std::uint64_t seed;
};

/// SHA-256 over the run's expanded JSON, the files that it names, the libraries of its plugins and the running program.
std::string run_key(const RaceSpec& race, const RunId& id, FileHashes& hashes);

}  // namespace gripline
