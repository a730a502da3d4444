#include "race/simulation.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "plugin/guard.hpp"
#include "support/race_rig.hpp"

namespace gripline {
namespace test_simulation {

using testing::HasSubstr;
using namespace testing_support;

/// Algorithm 1: update, belief, plan, control, each once per step and in this order.
TEST(Simulation, CallsInTheOrderOfTheAlgorithm) {
  const Folder folder;
  Race race(folder.path(), R"({"duration": "0.2 s"})", R"({"estimator": {"plugin": "spy.order"},
    "planner": {"plugin": "spy.order", "params": null}, "controller": {"plugin": "spy.constant"}})");
  EXPECT_EQ(race.run().status, Status::finished);
  const CsvTable steps = race.steps();
  const auto updated = steps.column("mu_belief_rear"), believed = steps.column("mu_belief_front"),
             planned = steps.column("v_ref_mps"), controlled = steps.column("iterations");
  ASSERT_EQ(steps.rows(), 11u);
  const double first = planned[0];  // at the start there is nothing to learn from, and nothing is trusted
  EXPECT_EQ(controlled[0], first + 1);
  for (std::size_t k = 1; k < 11; ++k) {
    const double n = first + 1 + 4 * static_cast<double>(k - 1);
    EXPECT_EQ(updated[k], n + 1);
    EXPECT_EQ(believed[k], n + 2);
    EXPECT_EQ(planned[k], n + 3);
    EXPECT_EQ(controlled[k], n + 4);
  }
}

TEST(Simulation, FinishesAtItsDuration) {
  const Folder folder;
  Race race(folder.path(), R"({"duration": "0.5 s"})");
  const RunSummary summary = race.run();
  EXPECT_EQ(summary.status, Status::finished);
  EXPECT_EQ(summary.message, "");
  EXPECT_EQ(summary.steps, 25);
  EXPECT_DOUBLE_EQ(summary.simulated_s, 0.5);
  EXPECT_EQ(race.steps().rows(), 26u);
  EXPECT_EQ(summary.stack, "driver");
}

TEST(Simulation, FinishesAfterItsLapsAndTimesOutWithoutThem) {
  const Folder folder;
  Race laps(folder / "laps", R"({"duration": null, "laps": 1, "timeout": "30 s", "start": {"speed": 1}})");
  const RunSummary done = laps.run();
  EXPECT_EQ(done.status, Status::finished);
  ASSERT_EQ(done.laps.size(), 1u);
  EXPECT_NEAR(done.laps[0], done.simulated_s, 0.02);
  Race late(folder / "late", R"({"duration": null, "laps": 1, "timeout": "0.6 s"})");
  const RunSummary timeout = late.run();
  EXPECT_EQ(timeout.status, Status::timeout);
  EXPECT_THAT(timeout.message, HasSubstr("still driving after 0.6 s"));
  EXPECT_EQ(timeout.steps, 30);
}

TEST(Simulation, ACrashEndsItAtOnceAndSaysWhere) {
  const Folder folder;
  Race race(folder.path(), R"({"duration": "20 s", "start": {"speed": 1}, "track": {"walls": {"right": 0}}})",
            R"({"controller": {"plugin": "spy.constant", "params": {"d": 0.4}}})");
  const RunSummary summary = race.run();
  EXPECT_EQ(summary.status, Status::crashed);
  EXPECT_THAT(summary.message, HasSubstr("hit the wall at s = "));
  EXPECT_LT(summary.simulated_s, 10);
  EXPECT_EQ(race.steps().rows(), static_cast<std::size_t>(summary.steps) + 1);
}

/// Not at the timeout a minute later.
TEST(Simulation, ACarThatStandsIsStuck) {
  const Folder folder;
  Race race(folder.path(), R"({"duration": null, "laps": 1, "timeout": "60 s", "start": {"speed": 0}})",
            R"({"controller": {"plugin": "spy.constant", "params": {"d": 0}}})");
  const RunSummary summary = race.run();
  EXPECT_EQ(summary.status, Status::stuck);
  EXPECT_EQ(status_name(summary.status), "stuck");
  EXPECT_THAT(summary.message, HasSubstr("stationary at s = "));
  EXPECT_NEAR(summary.simulated_s, 5, 0.03);
  EXPECT_EQ(race.steps().rows(), static_cast<std::size_t>(summary.steps) + 1);
}

/// Something goes wrong at step 10 or at t = 0.19 s; every complete row is kept.
struct Fault {
  const char* name;
  const char* world;
  const char* stack;
  Status status;
  const char* message;
  std::size_t rows;
  friend std::ostream& operator<<(std::ostream& out, const Fault& one) { return out << one.name; }
};
const Fault faults[] = {
    {"controller_throws", "{}", R"({"controller": {"plugin": "fault.throws"}})", Status::plugin_error,
     "fault.throws at t = 0.200000 s: lost the road", 10},
    {"controller_throws_a_number", "{}", R"({"controller": {"plugin": "fault.throws_odd"}})", Status::plugin_error,
     "fault.throws_odd at t = 0.200000 s: threw something that is not a std::exception", 10},
    {"controller_commands_nan", "{}", R"({"controller": {"plugin": "fault.nan_command"}})", Status::plugin_error,
     "fault.nan_command at t = 0.200000 s: returned a command that is not a number", 10},
    {"planner_plans_nan", "{}", R"({"planner": {"plugin": "fault.nan_reference", "params": null}})",
     Status::plugin_error, "fault.nan_reference at t = 0.200000 s: returned a reference that is not a number", 10},
    {"planner_plans_endless_room", "{}", R"({"planner": {"plugin": "fault.endless_room", "params": null}})",
     Status::plugin_error, "fault.endless_room at t = 0.200000 s: returned a reference that is not finite", 10},
    {"planner_plans_for_a_place_of_nan", "{}", R"({"planner": {"plugin": "fault.nan_place", "params": null}})",
     Status::plugin_error, "fault.nan_place at t = 0.200000 s: returned a reference that is not a number", 10},
    {"estimator_throws", "{}", R"({"estimator": {"plugin": "fault.throws_learning"}})", Status::plugin_error,
     "fault.throws_learning at t = 0.220000 s: matrix is singular", 11},
    {"estimator_believes_nan", "{}", R"({"estimator": {"plugin": "fault.nan_friction"}})", Status::plugin_error,
     "fault.nan_friction at t = 0.220000 s: returned a friction that is not a number", 11},
    {"estimator_believes_less_than_nothing", "{}", R"({"estimator": {"plugin": "fault.negative_friction"}})",
     Status::plugin_error,
     "fault.negative_friction at t = 0.220000 s: returned a friction of 1 and -0.5, sigma 0 and 0; expected none below "
     "0",
     11},
    {"estimator_corrects_by_nan", "{}",
     R"({"estimator": {"plugin": "fault.nan_correction"}, "controller": {"plugin": "spy.constant"}})",
     Status::plugin_error, "fault.nan_correction at t = 0.240000 s: returned a correction that is not a number", 12},
    {"estimator_throws_when_asked", "{}",
     R"({"estimator": {"plugin": "fault.throws_correction"}, "controller": {"plugin": "spy.constant"}})",
     Status::plugin_error, "fault.throws_correction at t = 0.240000 s: no data there", 12},
    {"nominal_model_throws", "{}",
     R"({"model": {"effects": [{"plugin": "fault.throws_force", "params": {"t": 0.19}}]}})", Status::plugin_error,
     "ekinematic at t = 0.200000 s: out of its table", 10},
    {"nominal_model_gives_nan", "{}",
     R"({"model": {"effects": [{"plugin": "fault.nan_force", "params": {"t": 0.19}}]}})", Status::plugin_error,
     "ekinematic at t = 0.200000 s: returned a prediction that is not a number", 10},
    {"plant_throws", R"({"plant": {"effects": [{"plugin": "fault.throws_force", "params": {"t": 0.19}}]}})", "{}",
     Status::plugin_error, "dynamic at t = 0.180000 s: out of its table", 10},
    {"plant_gives_nan", R"({"plant": {"effects": [{"plugin": "fault.nan_force", "params": {"t": 0.19}}]}})", "{}",
     Status::error, "dynamic at t = 0.180000 s: gave the world's car a state that is not a number", 10},
};

class Faults : public testing::TestWithParam<Fault> {};

TEST_P(Faults, EndTheRunWithTheNameOfWhoDidIt) {
  const Folder folder;
  Race race(folder.path(), GetParam().world, GetParam().stack);
  const RunSummary summary = race.run();
  EXPECT_EQ(summary.status, GetParam().status);
  EXPECT_EQ(summary.message, GetParam().message);
  const CsvTable steps = race.steps();
  EXPECT_EQ(steps.rows(), GetParam().rows);
  EXPECT_EQ(contents(folder / "steps.csv").back(), '\n');
}

INSTANTIATE_TEST_SUITE_P(All, Faults, testing::ValuesIn(faults), [](const auto& one) { return one.param.name; });

/// The world has driven the step in which a plugin breaks, and the lap that ends there.
TEST(Simulation, AStepWhoseDecisionFailsIsDrivenAllTheSame) {
  const Folder folder;
  const auto drive = [&](const char* name, std::int64_t step) {
    const std::string failing =
        R"({"estimator": {"plugin": "fault.throws_learning", "params": {"step": )" + std::to_string(step) + "}}}";
    return Race(folder / name, R"({"duration": null, "laps": 1, "timeout": "30 s", "start": {"speed": 1}})", failing)
        .run();
  };
  const RunSummary whole = drive("whole", 1'000'000);
  ASSERT_EQ(whole.laps.size(), 1u);
  const RunSummary broken = drive("broken", whole.steps - 1);  // when it is to learn from the last step
  EXPECT_EQ(broken.status, Status::plugin_error);
  EXPECT_EQ(broken.steps, whole.steps);
  EXPECT_EQ(broken.simulated_s, whole.simulated_s);
  EXPECT_EQ(broken.laps, whole.laps);
  EXPECT_EQ(broken.lap_mean_factors, whole.lap_mean_factors);
}

TEST(Simulation, AControllerMustWantAReference) {
  const Folder folder;
  Race race(folder.path(), "{}", R"({"controller": {"plugin": "fault.no_horizon"}})");
  try {
    race.run();
    FAIL() << "raced";
  } catch (const PluginFailure& failure) {
    EXPECT_STREQ(failure.what(), "fault.no_horizon: wants a horizon of 0 points");
  }
}

TEST(Simulation, AConstructorThatThrowsIsToldByItsName) {
  const Folder folder;
  Race race(folder.path(), "{}", R"({"controller": {"plugin": "fault.throws_at_start"}})");
  EXPECT_EQ(refusal([&] { race.run(); }), "fault.throws_at_start: no fuel");
}

TEST(Simulation, EveryStatusButSolvedIsAFailedSolve) {
  const Folder folder;
  Race race(folder.path(), "{}", R"({"controller": {"plugin": "fault.unsolved", "params": {"step": 10}}})");
  const RunSummary summary = race.run();
  EXPECT_EQ(summary.steps, 50);
  EXPECT_EQ(summary.solver_failures, 41);
  const std::vector<double> solved = race.steps().column("solved");
  EXPECT_EQ(solved[9], 1);
  EXPECT_EQ(solved[10], 0);
}

/// The command of the first step is decided before it.
TEST(Simulation, TheFirstSolveCountsToo) {
  const Folder folder;
  Race race(folder.path(), "{}", R"({"controller": {"plugin": "fault.unsolved", "params": {"step": 0}}})");
  const RunSummary summary = race.run();
  EXPECT_EQ(summary.steps, 50);
  EXPECT_EQ(summary.solver_failures, 51);
  EXPECT_EQ(summary.message, "51 of 51 solves failed");
  const std::vector<double> solved = race.steps().column("solved");
  EXPECT_EQ(std::count(solved.begin(), solved.end(), 0.0), 51);
}

/// A car that stands has not kept to a line that there is not.
TEST(Simulation, APlannerWithoutALineHasNoDeviation) {
  const Folder folder;
  Race race(folder.path(), R"({"start": {"speed": 0}})", R"({"planner": {"plugin": "spy.blind", "params": null},
    "controller": {"plugin": "spy.constant", "params": {"d": 0}}})");
  const RunSummary summary = race.run();
  EXPECT_EQ(summary.steps, 50);
  EXPECT_FALSE(summary.mean_deviation_m.has_value());
}

TEST(Simulation, TheSameRunTwiceIsTheSameBytes) {
  const Folder folder;
  constexpr const char* world =
      R"({"sensors": {"sigma": {"x": 0.002, "vx": 0.02, "yaw_rate": 0.05}}, "start": {"speed": 1}})";
  Race(folder / "a", world, R"({"estimator": {"plugin": "oracle"}})", 3).run();
  Race(folder / "b", world, R"({"estimator": {"plugin": "oracle"}})", 3).run();
  Race(folder / "c", world, R"({"estimator": {"plugin": "oracle"}})", 4).run();
  for (const char* file : {"steps.csv", "replay.csv", "tyres.csv"})
    EXPECT_EQ(contents(folder / ("a/" + std::string(file))), contents(folder / ("b/" + std::string(file)))) << file;
  EXPECT_NE(contents(folder / "a/steps.csv"), contents(folder / "c/steps.csv"));
}

TEST(Simulation, TellsHowFarItIs) {
  const Folder folder;
  Race race(folder.path());
  std::vector<double> shares;
  race.run([&](double share) { shares.push_back(share); });
  ASSERT_EQ(shares.size(), 50u);
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_NEAR(shares.front(), 0.02, 1e-9);
  EXPECT_DOUBLE_EQ(shares.back(), 1.0);
}

TEST(Guard, AnExceptionIsOursWithNameAndTime) {
  const auto message = [](auto&& f) {
    try {
      guard("elm", 1.5, f);
    } catch (const PluginFailure& failure) {
      return std::string(failure.what());
    }
    return std::string("nothing");
  };
  EXPECT_EQ(message([] { throw std::out_of_range("row 7"); }), "elm at t = 1.500000 s: row 7");
  EXPECT_EQ(message([] { throw "text"; }), "elm at t = 1.500000 s: threw something that is not a std::exception");
  EXPECT_EQ(message([] { throw PluginFailure("already told"); }), "already told");
  EXPECT_EQ(message([] {}), "nothing");
  EXPECT_EQ(guard("elm", 0, [] { return 7; }), 7);
}

}  // namespace test_simulation
}  // namespace gripline
