#include "exports/runs.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "config/errors.hpp"
#include "support/report_files.hpp"
#include "support/report_sample.hpp"

namespace gripline::exports {
namespace test_exported_runs {

using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> names(const Results& results) {
  std::vector<std::string> all;
  for (const NamedRun& run : results.runs) all.push_back(run.name);
  return all;
}

std::string refusal(const std::filesystem::path& folder, const RunFilter& filter) {
  try {
    (void)read_results(folder, filter);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ExportedRuns, AreChosenByRowAndSeed) {
  const report::Folder folder;
  sample::SampleOptions options;
  options.laps = 1;
  options.seeds = 2;
  options.stacks = {{"elm", false, 1, 0.9, 0.8}, {"oracle", true, 1, 0.96, 0.7}};
  sample::write_sample(folder.path(), options);
  EXPECT_THAT(names(read_results(folder.path(), {})), ElementsAre("elm", "oracle"));
  EXPECT_THAT(names(read_results(folder.path(), {{"oracle"}, {}})), ElementsAre("oracle"));
  EXPECT_THAT(names(read_results(folder.path(), {{}, {"2"}})), ElementsAre("elm", "oracle"));
  EXPECT_THAT(names(read_results(folder.path(), {{"elm"}, {"1", "2"}})), ElementsAre("elm/1", "elm/2"));
  EXPECT_GT(read_results(folder.path(), {}).runs[0].steps.rows(), 100U);
  EXPECT_FALSE(read_results(folder.path(), {}).track.empty());
  EXPECT_THAT(refusal(folder.path(), {{"oracel"}, {}}), HasSubstr("no row \"oracel\"; did you mean \"oracle\"?"));
  EXPECT_THAT(refusal(folder.path(), {{}, {"3"}}), HasSubstr("no seed \"3\""));
  EXPECT_THAT(refusal(folder.path() / "absent", {}), HasSubstr("no such folder"));
}

}  // namespace test_exported_runs
}  // namespace gripline::exports
