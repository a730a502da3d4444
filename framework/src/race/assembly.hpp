// Assembles a race: connects a world, a stack, metrics, result files and Algorithm 1; done nowhere else. Who steps a
// world without Algorithm 1 makes its stack with the same stack_context and asks the same RaceEnd.
#pragma once

#include <filesystem>
#include <optional>

#include "race/simulation.hpp"

namespace gripline {

/// A race besides its world and its stack.
struct RaceSetup {
  std::uint64_t seed = 1;
  std::filesystem::path folder{};     ///< where the run's files go, made when absent; empty: none are written
  std::filesystem::path cache_dir{};  ///< where plugins keep expensive results between runs; empty: nothing is kept
  PreparingCallback on_preparing{};   ///< may be empty
};

/// What a stack is given of a world that was not made: neither course nor truth is there. For offline work.
StackContext stack_context(const WorldSpec& spec, std::uint64_t seed);
/// What a stack is given of its world; the truth reaches only plugins that declare they need it (stack.cpp). Of `setup`
/// the folder is not used.
StackContext stack_context(const World& world, const RaceSetup& setup);

/// Owns all parts of a race, made in this order: world, stack, files, metrics, simulation.
class RaceAssembly {
 public:
  /// Both specs must outlive the race. Throws PluginError when a plugin cannot be created, PluginFailure when one
  /// cannot race, std::runtime_error when a file cannot be made.
  RaceAssembly(const WorldSpec& world, const StackSpec& stack, const RaceSetup& setup = {});

  World& world() { return world_; }
  Stack& stack() { return stack_; }
  Simulation& simulation() { return simulation_; }
  /// Races, and returns when the files are on the disk.
  RunSummary run();

 private:
  World world_;
  Stack stack_;
  std::optional<Recorder> recorder_;
  Metrics metrics_;
  Simulation simulation_;
};

}  // namespace gripline
