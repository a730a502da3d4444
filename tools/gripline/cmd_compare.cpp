// gripline compare EXPERIMENT: runs an experiment of any kind and judges its claims.
#include <memory>

#include "config/errors.hpp"
#include "gripline/command.hpp"
#include "gripline/experiment_kinds.hpp"
#include "gripline/race_options.hpp"
#include "gripline/validate_file.hpp"

namespace gripline::tools {
namespace po = boost::program_options;

namespace {

/// An experiment's seeds are its own here.
void refuse_seeds(Arguments args) {
  for (const std::string& word : args)
    if (word == "--seeds" || word.starts_with("--seeds="))
      throw InputError("--seeds is of sweep only; here --set /seeds/count=5 (and --set /seeds/first=1)");
}

}  // namespace

int run_compare(Arguments args) {
  refuse_seeds(args);
  po::options_description visible("options");
  auto add = visible.add_options();
  add("only", po::value<std::string>(), "stacks (of a diagnose experiment, cases) to run, a,b,c (default: all)");
  add("baseline", po::value<std::string>(), "a stack: writes pairs.csv, the others minus it, draw by draw");
  add("seeds-from", po::value<std::string>(),
      "draws as many seeds as the experiment has from the hash of this text, such as a commit's");
  add_race_options(visible);
  const auto given = parse_options(args, visible, "compare EXPERIMENT [options]", experiment_word);
  if (!given) return good;
  const RaceOptions options = read_race_options(*given);
  const Registry registry = open_registry(options.plugin_dirs);
  std::unique_ptr<Experiment> experiment;
  read_telling_assignments(options, [&](std::span<const std::string> assignments) {
    experiment = read_experiment(options.experiment, assignments, registry);
  });
  ExperimentRequest request;
  request.out = options.out;
  request.jobs = options.jobs;
  request.force = options.force;
  request.timeout_s = options.timeout_s;
  request.memory_mb = options.memory_mb;
  request.baseline = text_of(*given, "baseline").value_or("");
  request.seeds_from = text_of(*given, "seeds-from").value_or("");
  if (given->count("baseline") > 0 && request.baseline.empty()) throw InputError("--baseline names no stack");
  if (given->count("seeds-from") > 0 && request.seeds_from.empty()) throw InputError("--seeds-from has no text");
  if (const auto only = text_of(*given, "only")) request.only = names_of("--only", *only, "stack");
  print_warnings(options.experiment.string(), experiment->warnings(request.only));
  return experiment->run(request);
}

}  // namespace gripline::tools
