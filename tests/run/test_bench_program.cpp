// `gripline bench` hands over to a program of its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/program.hpp"
#include "util/csv.hpp"

namespace gripline {
namespace test_bench_program {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;
using namespace testing_support;
namespace fs = std::filesystem;

const fs::path built = gripline_program().parent_path();

TEST(BenchProgram, SpeaksAsTheCommandOfGripline) {
  const Outcome help = gripline_with({"bench", "--help"});
  EXPECT_EQ(help.code, 0);
  EXPECT_THAT(help.out, AllOf(StartsWith("usage: gripline bench [--out F.csv] [options]\n"), HasSubstr("--instances")));
  const Outcome wrong = gripline_with({"bench", "--instnaces", "20"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, EndsWith("; see gripline bench --help\n"));
}

TEST(BenchProgram, IsFoundWhereItIsInstalled) {
  const Folder folder;
  fs::create_directories(folder / "bin");
  fs::create_directories(folder / "libexec");
  fs::copy_file(gripline_program(), folder / "bin/gripline");
  const std::string program = folder / "bin/gripline";
  const Outcome absent = run_program({program, "bench", "--help"});
  EXPECT_EQ(absent.code, 4);
  EXPECT_EQ(absent.err, "gripline: bench needs the program gripline-bench, which is not installed; searched " +
                            std::string(folder / "bin/gripline-bench") + " " +
                            std::string(folder / "libexec/gripline-bench") + "\n");
  fs::copy_file(built / "gripline-bench", folder / "libexec/gripline-bench");
  EXPECT_EQ(run_program({program, "bench", "--help"}).code, 0);
}

/// Six rows: both controllers at two horizons, the Gaussian process, the update alone. Steps of the own solver and of
/// the estimator allocate nothing.
TEST(BenchProgram, MeasuresEveryCase) {
  const Folder folder;
  const std::string world = (source_dir() / "worlds/ethz.json").string();
  const Outcome outcome =
      gripline_with({"bench", "--world", world, "--instances", "20", "--out", folder / "bench.csv"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::vector<std::string> rows = lines(folder / "bench.csv");
  ASSERT_EQ(rows.size(), 7u);
  EXPECT_EQ(rows[0],
            "case,median_us,p95_us,p99_us,max_us,allocations_per_step,iterations_median,first_input_error_p95,"
            "first_input_error_max,failures,ratio_to_mpc_ipopt");
  const char* const cases[] = {
      "mpc_ipopt_n50_elm40", "mpc_sqp_n50_elm40", "mpc_ipopt_n20_elm40", "mpc_sqp_n20_elm40", "gp_410", "elm_update"};
  for (std::size_t i = 0; i < std::size(cases); ++i) EXPECT_THAT(rows[i + 1], StartsWith(std::string(cases[i]) + ","));
  for (const std::size_t row : {2u, 4u, 6u}) {
    std::vector<std::string> cells;
    std::istringstream rest(rows[row]);
    for (std::string cell; std::getline(rest, cell, ',');) cells.push_back(cell);
    EXPECT_GT(std::stod(cells[1]), 0.0) << rows[row];
    EXPECT_GE(std::stod(cells[4]), std::stod(cells[1])) << rows[row];
    EXPECT_EQ(cells[5], "0") << rows[row];
  }
}

/// A plugin under test is named instead of the two that are there.
TEST(BenchProgram, ComparesTheControllersThatAreNamed) {
  const Folder folder;
  const std::string world = (source_dir() / "worlds/ethz.json").string();
  const Outcome outcome = gripline_with(
      {"bench", "--world", world, "--instances", "20", "--controller", "mpc_sqp", "--out", folder / "bench.csv"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::vector<std::string> rows = lines(folder / "bench.csv");
  ASSERT_EQ(rows.size(), 5u);
  EXPECT_THAT(rows[1], StartsWith("mpc_sqp_n50_elm40,"));
  EXPECT_THAT(rows[1], EndsWith(",0,"));
  const Outcome unknown = gripline_with({"bench", "--world", world, "--controller", "mpc_spq"});
  EXPECT_EQ(unknown.code, 3);
  EXPECT_THAT(unknown.err, HasSubstr("mpc_sqp"));
}

}  // namespace test_bench_program
}  // namespace gripline
