// One race in this process: a small world, a driver, and the files it leaves.
#pragma once

#include <functional>
#include <utility>

#include "race/assembly.hpp"
#include "support/host_support.hpp"
#include "util/csv.hpp"

namespace gripline::testing_support {

class Race {
 public:
  /// JSON merge patches of the small world and the driver (host_support.hpp).
  Race(const std::filesystem::path& folder, std::string_view world = "{}", std::string_view stack = "{}",
       std::uint64_t seed = 1)
      : folder_(folder), seed_(seed), world_spec_(world_of(world)), stack_spec_(stack_of(world_spec_.car, stack)) {}

  WorldSpec& world() { return world_spec_; }

  RunSummary run(std::function<void(double share)> on_progress = {}) {
    RaceAssembly race(world_spec_, stack_spec_, {.seed = seed_, .folder = folder_});
    race.simulation().on_progress(std::move(on_progress));
    return race.run();
  }
  CsvTable steps() const { return read_csv(folder_ / "steps.csv"); }

 private:
  std::filesystem::path folder_;
  std::uint64_t seed_;
  WorldSpec world_spec_;
  StackSpec stack_spec_;
};

}  // namespace gripline::testing_support
