// gripline run EXPERIMENT --stack S --seed N: one run of a race.
#include "config/errors.hpp"
#include "gripline/command.hpp"
#include "gripline/experiment_kinds.hpp"
#include "gripline/race_kind.hpp"
#include "gripline/race_options.hpp"
#include "gripline/validate_file.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace {

std::string stack_of(const po::variables_map& given, const RaceSpec& race) {
  const std::optional<std::string> asked = text_of(given, "stack");
  if (!asked && race.stacks.size() != 1) {
    std::string names;
    for (const StackSpec& stack : race.stacks) names += (names.empty() ? "" : ", ") + stack.name;
    throw InputError("which stack? --stack one of: " + names);
  }
  const std::string stack = asked.value_or(race.stacks[0].name);
  require_stack(race, stack);
  return stack;
}

std::uint64_t seed_of(const po::variables_map& given, const RaceSpec& race) {
  const std::optional<std::string> text = text_of(given, "seed");
  return text ? static_cast<std::uint64_t>(whole_number("--seed", *text, {0, largest_seed})) : race.seeds.front();
}

}  // namespace

int run_one(Arguments args) {
  po::options_description visible("options");
  visible.add_options()("stack", po::value<std::string>(), "the stack to run");
  visible.add_options()("seed", po::value<std::string>(), "the seed (default: the experiment's first)");
  add_race_options(visible);
  const auto given = parse_options(args, visible, "run EXPERIMENT --stack S [--seed N] [options]", experiment_word);
  if (!given) return good;
  const RaceOptions options = read_race_options(*given);
  const Registry registry = open_registry(options.plugin_dirs);
  std::optional<RaceSpec> race;
  read_telling_assignments(options, [&](std::span<const std::string> assignments) {
    race.reset();
    Node tree = load_experiment(options.experiment, assignments);
    kind_of_experiment(tree);  // refuses a kind that is not there
    race.emplace(read_race(options.experiment, std::move(tree), registry));
  });
  const RunSelection one = {{stack_of(*given, *race)}, {seed_of(*given, *race)}, false};
  ExperimentRequest request;
  request.out = options.out;
  request.jobs = options.jobs;
  request.force = options.force;
  request.timeout_s = options.timeout_s;
  request.memory_mb = options.memory_mb;
  print_warnings(options.experiment.string(), race_warnings(*race, one.stacks, one.judged));
  return race_and_report(*race, one, registry, request);
}

}  // namespace gripline::tools
