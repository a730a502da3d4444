#include "race/recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/race_rig.hpp"

namespace gripline {
namespace test_recorder {

using testing::Each;
using testing::HasSubstr;
using namespace testing_support;

/// framework/doc/output.md: the columns of a measured log, then the run's own.
constexpr const char* steps_columns =
    "t_s,x_m,y_m,yaw_rad,vx_mps,vy_mps,yaw_rate_radps,d,delta_rad,"
    "x_true_m,y_true_m,yaw_true_rad,vx_true_mps,vy_true_mps,yaw_rate_true_radps,d_applied,delta_applied_rad,"
    "mu_belief_front,mu_belief_rear,mu_true,s_m,offset_m,lap,outside,v_ref_mps,iterations,solved";

TEST(Recorder, FilesHaveTheDefinedColumns) {
  const Folder folder;
  const Recorder recorder(folder.path());
  EXPECT_EQ(contents(folder / "steps.csv"), std::string(steps_columns) + "\n");
  EXPECT_EQ(lines(folder / "timing.csv").at(0), "t_s,update_ms,plan_ms,solve_ms,cpu_s");
  EXPECT_EQ(lines(folder / "tyres.csv").at(0), "t_s,axle,slip_rad,learned_n,sigma_n,true_n");
  EXPECT_THAT(lines(folder / "replay.csv").at(0), HasSubstr("t_s,mu_sigma_front,mu_sigma_rear,slip_front_rad"));
}

TEST(Recorder, WallClockFiguresAreInTimingOnly) {
  const Folder folder;
  Race race(folder.path());
  race.run();
  EXPECT_EQ(lines(folder / "timing.csv").size(), 52u);
  EXPECT_GT(lines(folder / "line.csv").size(), 100u);
  const CsvTable timing = read_csv(folder / "timing.csv");
  const std::vector<double> cpu = timing.column("cpu_s");
  EXPECT_TRUE(std::is_sorted(cpu.begin(), cpu.end()));
  double spent = 0;  // [s]
  for (const char* call : {"update_ms", "plan_ms", "solve_ms"})
    for (const double ms : timing.column(call)) spent += 1e-3 * ms;
  EXPECT_GT(spent, 0);
  EXPECT_LT(spent, cpu.back()) << "that of the process has its set-up too";
  for (const char* file : {"steps.csv", "replay.csv", "tyres.csv"})
    EXPECT_THAT(lines(folder / file).at(0), testing::Not(testing::AnyOf(HasSubstr("_ms"), HasSubstr("cpu"))));
}

/// A run's log is a measured log: from the true state of a row, the row's command held for a step gives the next row.
TEST(Recorder, ALogReplaysUnderHeldCommands) {
  const Folder folder;
  Race race(folder.path(), R"({"start": {"speed": 1}, "friction": [{"t": 0, "factor": 1}, {"t": 1, "factor": 0.5}],
    "sensors": {"sigma": {"x": 0.01, "vx": 0.05}}})");
  race.run();
  const CsvTable steps = race.steps();
  PluginContext context;
  context.car = race.world().car.car;
  const Vehicle vehicle(race.world().vehicle, context);
  CorrectedModel model(vehicle.car(), {0.02, Hold::zoh, {find_tableau("rk6"), 1}});
  const auto value = [&](std::size_t row, const char* name) {
    return steps.at(row, static_cast<std::size_t>(steps.find(name)));
  };
  ASSERT_GT(steps.rows(), 40u);
  for (std::size_t k = 0; k + 1 < steps.rows(); ++k) {
    State x;
    x.x = value(k, "x_true_m");
    x.y = value(k, "y_true_m");
    x.yaw = value(k, "yaw_true_rad");
    x.vx = value(k, "vx_true_mps");
    x.vy = value(k, "vy_true_mps");
    x.omega = value(k, "yaw_rate_true_radps");
    x.delta = value(k, "delta_rad");
    const double factor = 1 - 0.5 * value(k, "t_s");
    EXPECT_NEAR(value(k, "mu_true"), factor * 0.3657 / (0.041 * 9.81), 1e-9);
    for (std::size_t i = 0; i < race.world().vehicle.model.values.size(); ++i) {
      const std::string name = race.world().vehicle.model.entry->params()[i].name;
      if (name == "Df") model.set_parameter(i, 0.192 * factor);
      if (name == "Dr") model.set_parameter(i, 0.1737 * factor);
    }
    const State next = model.advance(x, {value(k, "d"), 0}, {});
    EXPECT_NEAR(next.x, value(k + 1, "x_true_m"), 1e-13) << k;
    EXPECT_NEAR(next.vy, value(k + 1, "vy_true_mps"), 1e-12) << k;
    EXPECT_NEAR(next.omega, value(k + 1, "yaw_rate_true_radps"), 1e-10) << k;
    EXPECT_EQ(value(k, "d_applied"), value(k, "d"));
    EXPECT_EQ(value(k, "delta_applied_rad"), value(k, "delta_rad"));
  }
}

/// Under a first-order hold the command of a row is the one reached then, and runs linearly to the next row's.
TEST(Recorder, ALogReplaysUnderAFirstOrderHold) {
  const Folder folder;
  Race race(folder.path(), R"({"start": {"speed": 1}, "input_hold": "foh"})");
  race.run();
  const CsvTable steps = race.steps();
  PluginContext context;
  context.car = race.world().car.car;
  const Vehicle vehicle(race.world().vehicle, context);
  const auto value = [&](std::size_t row, const char* name) {
    return steps.at(row, static_cast<std::size_t>(steps.find(name)));
  };
  ASSERT_GT(steps.rows(), 40u);
  for (std::size_t k = 0; k + 1 < steps.rows(); ++k) {
    CorrectedModel model(vehicle.car(), {0.02, Hold::foh, {find_tableau("rk6"), 1}});
    State x;
    x.yaw = value(k, "yaw_true_rad");
    x.vx = value(k, "vx_true_mps");
    x.vy = value(k, "vy_true_mps");
    x.omega = value(k, "yaw_rate_true_radps");
    x.delta = value(k, "delta_rad");
    model.reset(x, value(k, "d"), {});
    const State next = model.advance(x, {value(k + 1, "d"), (value(k + 1, "delta_rad") - x.delta) / 0.02}, {});
    EXPECT_NEAR(next.vx, value(k + 1, "vx_true_mps"), 1e-12) << k;
    EXPECT_NEAR(next.omega, value(k + 1, "yaw_rate_true_radps"), 1e-9) << k;
    EXPECT_NEAR(value(k, "d_applied"), value(k, "d"), 1e-15);
    EXPECT_NEAR(value(k, "delta_applied_rad"), value(k, "delta_rad"), 1e-15);
  }
}

TEST(Recorder, ActuatorsShowInTheAppliedColumns) {
  const Folder folder;
  Race race(folder.path(), R"({"start": {"speed": 1}, "plant": {"effects": [
    {"plugin": "input_delay", "params": {"T": "40 ms"}}, {"plugin": "steer_offset", "params": {"d0": 0.01}}]}})");
  race.run();
  const CsvTable steps = race.steps();
  const std::vector<double> d = steps.column("d"), d_applied = steps.column("d_applied"),
                            delta = steps.column("delta_rad"), delta_applied = steps.column("delta_applied_rad");
  ASSERT_GT(d.size(), 40u);
  for (std::size_t k = 2; k < d.size(); ++k) {
    EXPECT_NEAR(d_applied[k], d[k - 2], 1e-12);
    EXPECT_NEAR(delta_applied[k], delta[k - 2] + 0.01, 1e-12);
  }
}

/// The force of a row is that of its slip: both are under the command that the row states.
TEST(Recorder, SlipsAndForcesOfARowAreOfOneInstant) {
  const Folder folder;
  Race race(folder.path(), R"({"start": {"speed": 1}})");
  race.run();
  const std::vector<std::string> rows = lines(folder / "replay.csv");
  ASSERT_GT(rows.size(), 5u);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    std::stringstream cells(rows[i]);
    std::vector<double> first;  // t, two sigmas, two slips, two forces
    for (std::string cell; first.size() < 7 && std::getline(cells, cell, ',');) first.push_back(std::stod(cell));
    EXPECT_NEAR(first[5], 0.192 * std::sin(1.2 * std::atan(2.579 * first[3])), 1e-9) << rows[i];
    EXPECT_NEAR(first[6], 0.1737 * std::sin(1.2691 * std::atan(3.3852 * first[4])), 1e-9) << rows[i];
  }
}

TEST(Recorder, RowsTellPlaceBeliefAndReference) {
  const Folder folder;
  Race race(folder.path(), R"({"start": {"speed": 1}, "duration": "2 s"})", R"({"mu_init": 0.77})");
  race.run();
  const CsvTable steps = race.steps();
  EXPECT_THAT(steps.column("mu_belief_front"), Each(0.77));
  EXPECT_THAT(steps.column("lap"), Each(0));
  EXPECT_THAT(steps.column("solved"), Each(1));
  const std::vector<double> s = steps.column("s_m"), x = steps.column("x_true_m"), offset = steps.column("offset_m"),
                            y = steps.column("y_true_m"), reference = steps.column("v_ref_mps");
  for (std::size_t k = 0; k < s.size() && x[k] < 1.9; ++k) {
    EXPECT_NEAR(s[k], x[k], 1e-12);
    EXPECT_NEAR(offset[k], y[k], 1e-12);
    EXPECT_GT(reference[k], 0.3);  // slowed where the car is led back to the line
  }
  const std::vector<double> t = steps.column("t_s");
  for (std::size_t k = 0; k < t.size(); ++k) EXPECT_DOUBLE_EQ(t[k], 0.02 * static_cast<double>(k));
}

/// The car starts in the middle of the road while the line of least curvature runs along the right edge: the pursuit
/// crosses that edge once.
TEST(Recorder, OutsideIsTheOffsetBeyondTheEdge) {
  const Folder folder;
  Race race(folder.path(), R"({"start": {"speed": 1}, "duration": "2 s"})");
  race.run();
  const CsvTable steps = race.steps();
  const std::vector<double> outside = steps.column("outside"), offset = steps.column("offset_m");
  EXPECT_THAT(outside, testing::Contains(1));
  EXPECT_THAT(outside, testing::Contains(0));
  for (std::size_t k = 0; k < outside.size(); ++k) EXPECT_EQ(outside[k], std::abs(offset[k]) > 0.3 ? 1 : 0) << k;
}

TEST(Recorder, TyresAreTheLearnedAndTheTrueCurve) {
  const Folder folder;
  Race race(folder.path(), R"({"friction": [{"t": 0, "factor": 0.8}]})", R"({"estimator": {"plugin": "oracle"}})");
  race.run();
  const std::vector<std::string> rows = lines(folder / "tyres.csv");
  ASSERT_EQ(rows.size(), 1u + 2 * 2 * 41);  // at 0 s and 1 s, two axles
  EXPECT_EQ(rows[1].substr(0, 13), "0,front,-0.6,");
  EXPECT_EQ(rows.back().substr(0, 11), "1,rear,0.6,");
  const std::string& row = rows[1];
  const double learned = std::stod(row.substr(13)), truth = std::stod(row.substr(row.rfind(',') + 1));
  EXPECT_DOUBLE_EQ(learned, truth);
  EXPECT_NEAR(truth, 0.8 * 0.192 * std::sin(1.2 * std::atan(2.579 * -0.6)), 1e-12);
}

TEST(Recorder, AFullDiskIsToldWithItsReason) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no such device here";
  const Folder folder;
  std::filesystem::create_symlink("/dev/full", folder / "steps.csv");
  try {
    const Recorder recorder(folder.path());
    FAIL() << "written";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("steps.csv: No space left on device"));
  }
}

}  // namespace test_recorder
}  // namespace gripline
