// predict and diagnose as users call them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iomanip>
#include <sstream>

#include "support/race_program.hpp"
#include "tables/delimited_table.hpp"
#include "util/csv.hpp"

namespace gripline {
namespace test_cli_logs {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using namespace testing_support;
namespace fs = std::filesystem;

/// predict and diagnose on the log of a race of 12 s; they take worlds that name their parts in files, as races do.
class ModelsAndLogs : public RaceProgram {
 protected:
  void SetUp() override {
    ASSERT_EQ(
        compare({"--out", out(), "--only", "slow", "--set", "/seeds/count=1", "--set", "/world/duration=12 s"}).code,
        0);
  }
  std::string log() const { return out() + "/slow/1/steps.csv"; }
  static constexpr const char* world = "worlds/short.json";
};

TEST_F(ModelsAndLogs, PredictComparesAWorldWithModelsThatKnowNothing) {
  const Outcome predicted = gripline_with({"predict", world, log(), "--horizon", "0.1", "--out", folder_ / "p.csv"});
  EXPECT_EQ(predicted.code, 0) << predicted.err;
  EXPECT_EQ(read_delimited(folder_ / "p.csv").rows(), 4u);  // three that know nothing, and this world
}

TEST_F(ModelsAndLogs, AFitIsWrittenIntoTheCurrentFolder) {
  const Call there = {.folder = folder_.path(), .environment = {}};
  const Outcome fitted = gripline_with(
      {"fit", (fixture_dir() / world).string(), log(), "--fit", "observer", "--starts", "20", "--quiet"}, there);
  EXPECT_EQ(fitted.code, 0) << fitted.err;
  EXPECT_EQ(gripline_with({"validate", "fitted.json"}, there).code, 0);
}

/// Near 1.7e9 s neighbouring numbers are 2.4e-7 s apart: nothing may depend on when a clock began to count.
TEST_F(ModelsAndLogs, AClockThatCountsFrom1970ChangesNoError) {
  std::istringstream rows(contents(log()));
  std::ostringstream later;
  std::string line;
  std::getline(rows, line);
  ASSERT_TRUE(line.starts_with("t_s,"));
  later << line << '\n' << std::fixed << std::setprecision(6);
  while (std::getline(rows, line)) later << 1712345678.0 + std::stod(line) << line.substr(line.find(',')) << '\n';
  write_text(folder_ / "later.csv", later.str());
  const Outcome own = gripline_with({"predict", world, log(), "--horizon", "0.1,0.3"});
  const Outcome moved = gripline_with(
      {"predict", world, folder_ / "later.csv", "--horizon", "0.1,0.3", "--samples", folder_ / "samples.csv"});
  EXPECT_EQ(moved.code, 0) << moved.err;
  EXPECT_EQ(moved.out.substr(0, moved.out.find("samples:")), own.out);
  const auto samples = read_delimited(folder_ / "samples.csv");
  EXPECT_GE(samples.column[static_cast<std::size_t>(samples.find("start_s"))].front(), 1712345678.0);
}

/// The world holds commands until the next row: read as linear between rows the car is half a sample early.
TEST_F(ModelsAndLogs, CommandsAreHeldAsTheWorldHoldsThem) {
  ASSERT_EQ(gripline_with({"predict", world, log(), "--horizon", "0.1", "--out", folder_ / "p.csv"}).code, 0);
  write_text(folder_ / "linear.json",
             R"({"time": "t_s", "channels": {"x": "x_m", "y": "y_m", "yaw": "yaw_rad", "vx": "vx_mps", "vy": "vy_mps",
                "yaw_rate": "yaw_rate_radps", "d": "d", "delta": "delta_rad"}})");
  const Outcome linear = gripline_with(
      {"predict", world, log(), "--horizon", "0.1", "--map", folder_ / "linear.json", "--out", folder_ / "linear.csv"});
  EXPECT_EQ(linear.code, 0) << linear.err;
  const auto error_of = [&](const char* file) {
    const auto table = read_delimited(folder_ / file);
    return table.column[static_cast<std::size_t>(table.find("yaw_rate_radps"))].back();
  };
  EXPECT_LT(error_of("p.csv"), 0.7 * error_of("linear.csv"));
}

/// Displacements from a log: mean over the horizons and at the last one, and how many starts they are of.
struct Displacement {
  double mean = 0, last = 0;
  std::size_t starts = 0;
};

/// From the samples that predict wrote, three of each start, and the log (a row every 0.02 s).
Displacement displacement_of(const fs::path& samples_file, const std::string& log, double slowest) {
  const auto samples = read_delimited(samples_file);
  const CsvTable rows = read_csv(log);
  const auto x = rows.column("x_m"), y = rows.column("y_m"), vx = rows.column("vx_mps"), t = rows.column("t_s");
  const auto row_at = [&](double time) { return static_cast<std::size_t>(std::lround((time - t[0]) / 0.02)); };
  const auto of = [&](const char* name, std::size_t i) {
    return samples.column[static_cast<std::size_t>(samples.find(name))][i];
  };
  Displacement found;
  for (std::size_t i = 0; i + 2 < samples.rows(); i += 3) {
    if (vx.at(row_at(of("start_s", i))) < slowest) continue;
    ++found.starts;
    for (std::size_t j = i; j < i + 3; ++j) {
      const std::size_t row = row_at(of("t_s", j));
      const double distance = std::hypot(of("x_m", j) - x.at(row), of("y_m", j) - y.at(row));
      found.mean += distance / 3;
      if (j == i + 2) found.last += distance;
    }
  }
  found.mean /= static_cast<double>(found.starts);
  found.last /= static_cast<double>(found.starts);
  return found;
}

TEST_F(ModelsAndLogs, DisplacementsAreThoseOfTheSamples) {
  const Outcome paths = gripline_with({"predict", world, log(), "--horizon", "0.1,0.2,0.3", "--every", "0.1",
                                       "--slowest", "1.2", "--samples", folder_ / "paths.csv"});
  EXPECT_EQ(paths.code, 0) << paths.err;
  const Displacement found = displacement_of(folder_ / "paths.csv", log(), 1.2);
  ASSERT_GT(found.starts, 20u);
  const std::string table = paths.out.substr(paths.out.find("displacement [m] over 3 horizons up to 0.3 s"));
  std::istringstream line(table.substr(table.find("this world") + 10));
  Displacement shown;
  line >> shown.mean >> shown.last >> shown.starts;
  EXPECT_EQ(shown.starts, found.starts);
  EXPECT_NEAR(shown.mean, found.mean, 0.01 * shown.mean);
  EXPECT_NEAR(shown.last, found.last, 0.01 * shown.last);
}

/// A table without the column of that index.
std::string without_column(const std::string& file, int column) {
  std::string out;
  for (std::string line : lines(file)) {
    for (int comma = 0; comma < column; ++comma)
      out += line.substr(0, line.find(',') + 1), line.erase(0, line.find(',') + 1);
    out += line.substr(line.find(',') + 1) + "\n";
  }
  return out;
}

/// Without a sideways speed there is nothing to compare it with.
TEST_F(ModelsAndLogs, AChannelThatTheLogLacksIsADash) {
  write_text(folder_ / "without_vy.csv", without_column(log(), 5));
  const Outcome dashed = gripline_with({"predict", world, folder_ / "without_vy.csv", "--horizon", "0.1"});
  EXPECT_EQ(dashed.code, 0) << dashed.err;
  EXPECT_THAT(dashed.out, testing::AllOf(HasSubstr("  -   "), testing::Not(HasSubstr("nan"))));
}

/// What stands in the place of a channel is told: errors of it are not errors of a reading.
TEST_F(ModelsAndLogs, AChannelThatIsReplacedIsTold) {
  EXPECT_EQ(gripline_with({"predict", world, log(), "--horizon", "0.1"}).err, "");
  const std::string without_yaw = folder_ / "without_yaw.csv", without_vx = folder_ / "without_vx.csv";
  write_text(without_yaw, without_column(log(), 3));
  write_text(without_vx, without_column(log(), 4));
  const Outcome course = gripline_with({"predict", world, without_yaw, "--horizon", "0.1"});
  EXPECT_EQ(course.code, 0);
  EXPECT_EQ(course.err, "warning: " + without_yaw +
                            ": yaw absent: the course over ground is taken, half a step late; sideslip is not seen\n");
  const Outcome differences = gripline_with({"predict", world, without_vx, "--horizon", "0.1"});
  EXPECT_EQ(differences.code, 0);
  EXPECT_EQ(differences.err,
            "warning: " + without_vx + ": velocity absent: from differences of the place, half a step late\n");
}

/// What import's table says of lost rows and unknown units is told here too; the form of a file is not.
TEST_F(ModelsAndLogs, WhatIsLeftOutOfALogIsTold) {
  const std::string lossy = folder_ / "lossy.csv";
  std::string text = contents(log());
  const std::size_t end = text.find_last_of('\n', text.size() - 2) + 1;
  text += text.substr(end);  // its time stamp once more
  text += "1,2\n";
  write_text(lossy, text);
  const Outcome told = gripline_with({"predict", world, lossy, "--horizon", "0.1"});
  EXPECT_EQ(told.code, 0) << told.err;
  EXPECT_EQ(told.err, "warning: " + lossy + ": 1 rows of another length, left out\nwarning: " + lossy +
                          ": rows 1 repeat a time stamp: they fill the empty cells of the first row of it\n");
}

TEST_F(ModelsAndLogs, PredictNeverWritesOverWhatItReads) {
  const Outcome over = gripline_with({"predict", world, log(), "--out", log()});
  EXPECT_EQ(over.code, 2);
  EXPECT_EQ(over.err,
            "--out " + log() + ": is an input of this command and would be overwritten; choose another file\n");
}

TEST_F(ModelsAndLogs, AnExperimentIsNoWorld) {
  const Outcome wrong = gripline_with({"predict", "experiments/good.json", log()});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_EQ(wrong.err, "experiments/good.json: is an experiment, expected a world\n");
}

/// Somebody's folder is not a diagnosis' own; a diagnosis' own is.
TEST_F(ModelsAndLogs, DiagnoseWritesIntoFoldersOfItsOwn) {
  write_text(folder_ / "mine/notes.txt", "mine");
  const Outcome refused = gripline_with({"diagnose", world, log(), "--out", folder_ / "mine"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("mine already holds something else"));
  EXPECT_FALSE(fs::exists(folder_ / "mine/diagnosis.json"));
  for (int i = 0; i < 2; ++i) {
    const Outcome diagnosed = gripline_with({"diagnose", world, log(), "--out", folder_ / "d"});
    EXPECT_THAT(diagnosed.code, testing::AnyOf(0, 1)) << diagnosed.err;
    EXPECT_TRUE(fs::exists(folder_ / "d/diagnosis.json"));
  }
}

/// By a map a log is taken for a real car's, and the verdict is always unknown; a world with a road of its own may be
/// meant for a simulated one. Refused by its folder, so that nothing is searched.
TEST_F(ModelsAndLogs, DiagnoseByAMapTellsWhatIsBetterForASimulatedLog) {
  write_text(folder_ / "mine/notes.txt", "mine");
  write_text(folder_ / "own.json",
             R"({"time": "t_s", "channels": {"x": "x_m", "y": "y_m", "yaw": "yaw_rad", "vx": "vx_mps", "vy": "vy_mps",
                "yaw_rate": "yaw_rate_radps", "d": "d", "delta": "delta_rad"}})");
  const Outcome mapped =
      gripline_with({"diagnose", world, log(), "--map", folder_ / "own.json", "--out", folder_ / "mine"});
  EXPECT_EQ(mapped.code, 2);
  EXPECT_THAT(mapped.err, HasSubstr("of a simulated one, gripline import it and diagnose what that writes"));
  const Outcome own = gripline_with({"diagnose", world, log(), "--out", folder_ / "mine"});
  EXPECT_THAT(own.err, Not(HasSubstr("simulated")));
}

}  // namespace test_cli_logs
}  // namespace gripline
