// The kinds of experiments: what "kind" may say, and who reads and runs each. A new kind is a row of the table in
// experiment_kinds.cpp, and one in framework/src/sweep/kinds.cpp for its sweeps, which neither print nor judge claims.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "config/errors.hpp"
#include "config/node.hpp"
#include "plugin/registry.hpp"

namespace gripline::tools {

/// What was asked for on the command line.
struct ExperimentRequest {
  std::filesystem::path out;
  std::vector<std::string> only;  // rows of a race, or cases of diagnose; empty: all
  bool force = false;             // replaces another experiment's results
  // Of races only; other kinds refuse them (refuse_race_options).
  int jobs = 1;
  double timeout_s = 0;       // wall clock of one run; 0: from the world
  std::size_t memory_mb = 0;  // of one run; 0: no limit
  std::string baseline;       // the row that pairs.csv compares the others with; empty: none is written
  std::string seeds_from;     // the text that seeds are drawn from; empty: those of the file
};

/// An experiment that was read whole, without an error.
class Experiment {
 public:
  virtual ~Experiment() = default;
  /// Runs it, writes and prints its results, judges its claims. Returns the program's exit code; throws InputError when
  /// the request does not fit the experiment.
  virtual int run(const ExperimentRequest& request) = 0;
  /// What is allowed but was most likely not meant, of the rows that `only` names (none: of all).
  virtual std::vector<Diagnostic> warnings(const std::vector<std::string>& only) const {
    (void)only;
    return {};
  }
};

struct ExperimentKind {
  const char* name;
  /// Throws InputError with everything that is wrong, PluginError when a plugin is missing. `file` gives it its name;
  /// the registry must outlive the experiment.
  std::unique_ptr<Experiment> (*read)(const std::filesystem::path& file, Node tree, const Registry& registry);
};

/// Throws InputError when the request holds what only races have.
void refuse_race_options(const ExperimentRequest& request);
/// Throws InputError when the request names rows to run: of kinds that run as a whole.
void refuse_only(const ExperimentRequest& request);

/// The kind of a loaded tree; throws InputError at its "kind" when there is none of that name.
const ExperimentKind& kind_of_experiment(const Node& tree);

/// Loads an experiment file of any kind, applies `--set` assignments and reads it. Throws as ExperimentKind::read.
std::unique_ptr<Experiment> read_experiment(const std::filesystem::path& file, std::span<const std::string> assignments,
                                            const Registry& registry);

// The readers of the table, each in the file of its kind.
std::unique_ptr<Experiment> read_race_experiment(const std::filesystem::path&, Node, const Registry&);
std::unique_ptr<Experiment> read_force_validation(const std::filesystem::path&, Node, const Registry&);
std::unique_ptr<Experiment> read_offline_validation(const std::filesystem::path&, Node, const Registry&);
std::unique_ptr<Experiment> read_diagnose_experiment(const std::filesystem::path&, Node, const Registry&);
std::unique_ptr<Experiment> read_measured_experiment(const std::filesystem::path&, Node, const Registry&);

}  // namespace gripline::tools
