// framework/doc/tutorial.md: its commands, in their order, in an empty folder.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "support/paths.hpp"
#include "support/program.hpp"

namespace gripline {
namespace test_tutorial {

using namespace testing_support;
using testing::HasSubstr;

/// The blocks of a page in one language, one after the other.
std::string blocks(const std::string& page, const std::string& language) {
  const std::string fence = "```" + language + "\n";
  std::string all;
  for (std::size_t at = page.find(fence); at != std::string::npos; at = page.find(fence, at + 1)) {
    const std::size_t begin = at + fence.size();
    all.append(page, begin, page.find("```", begin) - begin);
  }
  return all;
}

TEST(Tutorial, ItsCommandsRun) {
  const Folder folder;
  const std::string commands = blocks(contents(source_dir() / "framework/doc/tutorial.md"), "sh");
  EXPECT_THAT(commands, HasSubstr("plugins new estimator my_drag"));
  const char* const before = std::getenv("PATH");
  std::string path = gripline_program().parent_path().string();
  path.append(":").append(before != nullptr ? before : "");
  const Outcome outcome =
      run_program({"bash", "-e", "-c", commands}, {.folder = folder.path(), .environment = {{"PATH", path}}});
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("    e_vx = phi c"));
  EXPECT_THAT(outcome.out, HasSubstr("  95 %"));
  EXPECT_THAT(outcome.out, HasSubstr("12 of 12 runs were already there."));
  EXPECT_THAT(outcome.out, HasSubstr("claims: 1 of 1 hold"));
  EXPECT_TRUE(std::filesystem::exists(folder / "out/spread/figures/laps.svg"));
  EXPECT_EQ(lines(folder / "out/spread/runs.csv").size(), 13U);
}

}  // namespace test_tutorial
}  // namespace gripline
