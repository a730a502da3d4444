// An experiment as JSON describes it: one world, named stacks, seeds, and the claims that must hold between them.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "experiment/claims.hpp"
#include "experiment/perturb.hpp"
#include "race/stack.hpp"
#include "world/world_spec.hpp"

namespace gripline {

/// The tree of an experiment file, everything it names by JSON files put in its place, and `--set` assignments applied.
/// Throws InputError.
Node load_experiment(const std::filesystem::path& file, std::span<const std::string> assignments);

/// One more assignment on a loaded tree, files that it names put in their places. Throws InputError.
void assign_in_experiment(Node& tree, const std::string& assignment);

/// The "kind" of a loaded tree; "race" when it says none. Which there are: tools/gripline/experiment_kinds.cpp.
std::string experiment_kind(const Node& tree);
/// Which of these kinds an experiment is; the first where it says none. Throws InputError for another.
std::size_t read_kind(const Node& tree, const std::vector<std::string>& names);

inline constexpr std::int64_t largest_seed = 1'000'000'000;
/// The "seeds" of an experiment, {"first", "count"}: ascending.
std::vector<std::uint64_t> read_seeds(const Node& node, Errors& errors);

struct RaceSpec {
  std::string name;  // of the file, without its ending
  Node tree;
  WorldSpec world;
  std::vector<StackSpec> stacks;
  std::vector<std::uint64_t> seeds;
  std::string seeds_text;  // what the seeds were drawn from (--seeds-from); empty: they are the file's
  PerturbSpec perturb;
  std::vector<Claim> claims;
  double claim_share = 0.8;

  /// The tree of one run: the same experiment with one stack and one seed, claims left out; can be given back to `run`.
  Node run_tree(const std::string& stack, std::uint64_t seed) const;
};

/// The files that the texts of a run's tree name, sorted.
std::vector<std::filesystem::path> files_named(const Node& tree);
/// The libraries that a world and stacks are made of, sorted.
std::set<std::filesystem::path> libraries_of(const WorldSpec& world, std::span<const StackSpec> stacks);

/// Throws InputError with every error of the tree, PluginError when a plugin is missing.
RaceSpec read_race(const std::filesystem::path& file, Node tree, const Registry& registry);

}  // namespace gripline
