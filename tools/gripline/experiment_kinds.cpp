#include "gripline/experiment_kinds.hpp"

#include "config/errors.hpp"
#include "experiment/experiment.hpp"

namespace gripline::tools {
namespace {

constexpr ExperimentKind kinds[] = {
    {"race", read_race_experiment},  // the first is the one of an experiment that says none
    {"offline_validation", read_offline_validation},
    {"force_validation", read_force_validation},
    {"diagnose", read_diagnose_experiment},
    {"measured", read_measured_experiment},
};

}  // namespace

void refuse_race_options(const ExperimentRequest& request) {
  if (!request.baseline.empty())
    throw InputError("--baseline compares the rows of a race; this experiment is not a race");
  if (!request.seeds_from.empty())
    throw InputError("--seeds-from draws the seeds of a race; this experiment is not a race");
  const char* option = request.jobs != 1         ? "-j"
                       : request.timeout_s > 0.0 ? "--timeout"
                       : request.memory_mb > 0   ? "--memory"
                                                 : nullptr;
  if (option != nullptr)
    throw InputError(
        option + std::string(" is for the runs of a race, each a process of its own; this experiment is not a race"));
}

void refuse_only(const ExperimentRequest& request) {
  if (!request.only.empty())
    throw InputError(
        "--only chooses among the rows of a race or the cases of a diagnose experiment; this experiment is run whole");
}

const ExperimentKind& kind_of_experiment(const Node& tree) {
  std::vector<std::string> names;
  for (const ExperimentKind& one : kinds) names.emplace_back(one.name);
  return kinds[read_kind(tree, names)];
}

std::unique_ptr<Experiment> read_experiment(const std::filesystem::path& file, std::span<const std::string> assignments,
                                            const Registry& registry) {
  Node tree = load_experiment(file, assignments);
  const ExperimentKind& kind = kind_of_experiment(tree);
  return kind.read(file, std::move(tree), registry);
}

}  // namespace gripline::tools
