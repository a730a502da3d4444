#include "race/race_end.hpp"

#include <gtest/gtest.h>

#include "race/assembly.hpp"
#include "support/host_support.hpp"

namespace gripline {
namespace test_race_end {

using namespace testing_support;

/// A world and a driver (JSON merge patches), and how a race of them ends.
struct Ending {
  const char* name;
  const char* world;
  const char* stack;
  Status status;
  friend std::ostream& operator<<(std::ostream& out, const Ending& one) { return out << one.name; }
};
const Ending endings[] = {
    {"AtItsDuration", R"({"duration": "0.5 s"})", "{}", Status::finished},
    {"AfterItsLaps", R"({"duration": null, "laps": 1, "timeout": "30 s", "start": {"speed": 1}})", "{}",
     Status::finished},
    {"AtItsTimeout", R"({"duration": null, "laps": 1, "timeout": "0.6 s"})", "{}", Status::timeout},
    {"Standing", R"({"duration": "20 s", "start": {"speed": 0}})",
     R"({"controller": {"plugin": "spy.constant", "params": {"d": 0}}})", Status::stuck},
    {"AtTheWall", R"({"duration": "20 s", "start": {"speed": 1}, "track": {"walls": {"right": 0}}})",
     R"({"controller": {"plugin": "spy.constant", "params": {"d": 0.4}}})", Status::crashed},
    {"WithoutAState", R"({"plant": {"effects": [{"plugin": "fault.nan_force", "params": {"t": 0.19}}]}})", "{}",
     Status::error},
};

class RaceEnds : public testing::TestWithParam<Ending> {};

/// Simulation races; another loop steps a world under the same commands, as the Python package's does.
TEST_P(RaceEnds, AlikeForEveryLoopThatDrivesAWorld) {
  const WorldSpec world = world_of(GetParam().world);
  const StackSpec stack = stack_of(world.car, GetParam().stack);
  const RunSummary raced = RaceAssembly(world, stack).run();
  EXPECT_EQ(raced.status, GetParam().status);

  RaceAssembly driver(world, stack);
  driver.simulation().start();
  World stepped(world, 1);
  RaceEnd end(stepped);
  for (; !end.status() && stepped.step() < 2000; end.watch()) {
    stepped.advance(driver.simulation().command().u);
    driver.simulation().step();
  }
  EXPECT_EQ(end.status(), GetParam().status);
  EXPECT_EQ(stepped.step(), driver.world().step());
  // A step that leaves the car without a state is none of the race's.
  EXPECT_EQ(stepped.step(), raced.steps + (raced.status == Status::error ? 1 : 0));
}

INSTANTIATE_TEST_SUITE_P(All, RaceEnds, testing::ValuesIn(endings), [](const auto& one) { return one.param.name; });

/// Half a step decides: durations need not be whole numbers of steps.
TEST(RaceEnd, IsAtTheStepNearestToItsTime) {
  const auto steps = [](const char* patch) {
    const WorldSpec spec = world_of(patch);
    World world(spec, 1);
    RaceEnd end(world);
    for (; !end.status(); end.watch()) world.advance({0.3, 0});
    return world.step();
  };
  EXPECT_EQ(steps(R"({"duration": "0.2 s"})"), 10);
  EXPECT_EQ(steps(R"({"duration": "0.209 s"})"), 10);
  EXPECT_EQ(steps(R"({"duration": "0.211 s"})"), 11);
  EXPECT_EQ(steps(R"({"duration": null, "laps": 1, "timeout": "0.209 s"})"), 10);
  EXPECT_EQ(steps(R"({"duration": null, "laps": 1, "timeout": "0.211 s"})"), 11);
}

/// A car is stuck when it has not moved by a tenth of its length for five seconds, wherever it stands.
TEST(RaceEnd, TellsSinceWhenTheCarStands) {
  const WorldSpec spec = world_of(R"({"duration": "20 s", "start": {"speed": 1}})");
  World world(spec, 1);
  RaceEnd end(world);
  EXPECT_EQ(end.moved_at(), 0);
  for (; !end.status(); end.watch()) world.advance({0, 0});  // it rolls to a halt
  ASSERT_EQ(end.status(), Status::stuck);
  EXPECT_GT(end.moved_at(), 0.3);
  EXPECT_NEAR(world.time() - end.moved_at(), 5, 0.011);
}

}  // namespace test_race_end
}  // namespace gripline
