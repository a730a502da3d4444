#include "race/assembly.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/host_support.hpp"
#include "util/csv.hpp"

namespace gripline {
namespace test_assembly {

using testing::IsEmpty;
using testing::UnorderedElementsAre;
using namespace testing_support;

std::vector<std::string> files_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) names.push_back(entry.path().filename());
  return names;
}

TEST(RaceAssembly, RacesAndLeavesItsFilesInAFolderItMakes) {
  const Folder folder;
  const WorldSpec world = world_of(R"({"duration": "0.1 s"})");
  const StackSpec stack = stack_of(world.car);
  RaceAssembly race(world, stack, {.seed = 3, .folder = folder / "a/b"});
  const RunSummary summary = race.run();
  EXPECT_EQ(summary.status, Status::finished);
  EXPECT_EQ(summary.seed, 3u);
  EXPECT_THAT(files_in(folder / "a/b"),
              UnorderedElementsAre("steps.csv", "timing.csv", "replay.csv", "tyres.csv", "line.csv"));
  EXPECT_EQ(read_csv(folder / "a/b/steps.csv").rows(), 6u);
}

TEST(RaceAssembly, WithoutAFolderItRacesTheSameAndWritesNothing) {
  const Folder folder;
  const WorldSpec world = world_of(R"({"start": {"speed": 1}, "sensors": {"sigma": {"vx": 0.05}}})");
  const StackSpec stack = stack_of(world.car);
  RaceAssembly written(world, stack, {.seed = 2, .folder = folder / "run"});
  RaceAssembly silent(world, stack, {.seed = 2});
  EXPECT_EQ(written.run().mean_deviation_m.value(), silent.run().mean_deviation_m.value());
  EXPECT_EQ(written.world().state().x, silent.world().state().x);
  std::filesystem::remove_all(folder / "run");
  EXPECT_THAT(files_in(folder.path()), IsEmpty());
}

/// The seed is the sensors': another one, another race.
TEST(RaceAssembly, TheSeedReachesTheWorld) {
  const WorldSpec world = world_of(R"({"start": {"speed": 1}, "sensors": {"sigma": {"vx": 0.05}}})");
  const StackSpec stack = stack_of(world.car);
  RaceAssembly one(world, stack, {.seed = 1}), two(world, stack, {.seed = 2});
  EXPECT_NE(one.world().observe().x.vx, two.world().observe().x.vx);
}

/// spy.order believes of the rear axle how many calls there were when it was updated last.
TEST(RaceAssembly, CanBeStoppedAtEveryStepAndLearnNoMore) {
  const WorldSpec world = world_of();
  const StackSpec stack = stack_of(world.car, R"({"estimator": {"plugin": "spy.order"},
    "planner": {"plugin": "spy.order", "params": null}, "controller": {"plugin": "spy.constant"}})");
  RaceAssembly race(world, stack);
  Simulation& simulation = race.simulation();
  const auto updated = [&] { return race.stack().belief(simulation.now().t).mu.mu_rear; };
  simulation.start();
  EXPECT_EQ(simulation.now().step, 0);
  simulation.step();
  const double first = updated();
  simulation.step();
  EXPECT_EQ(simulation.now().step, 2);
  EXPECT_EQ(simulation.sample().step, 1);
  const double second = updated();
  EXPECT_GT(second, first);
  simulation.stop_learning();
  simulation.step();
  EXPECT_EQ(updated(), second);
  EXPECT_EQ(simulation.now().step, 3);
}

}  // namespace test_assembly
}  // namespace gripline
