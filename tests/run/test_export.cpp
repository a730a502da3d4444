// gripline export: files as a user's tools read them. The reader of MCAP's makers is an npm package of tools/report, as
// the browser's driver is; without Node or `npm ci` there that test is skipped, unless GRIPLINE_REQUIRE_BROWSER=1.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "report/columns.hpp"
#include "support/mcap_reading.hpp"
#include "support/paths.hpp"
#include "support/program.hpp"
#include "support/report_sample.hpp"

namespace gripline {
namespace test_export {

namespace fs = std::filesystem;
using namespace testing_support;
using testing::HasSubstr;

class Export : public testing::Test {
 protected:
  Export() {
    sample::SampleOptions options;
    options.laps = 1;
    options.stacks = {{"elm", false, 1, 0.9, 0.8}, {"oracle", true, 1, 0.96, 0.7}};
    sample::write_sample(out_, options);
  }
  /// A program of that name on a PATH of its own.
  std::string path_with(const std::string& name, const std::string& script) const {
    const fs::path bin = folder_ / "bin";
    fs::create_directories(bin);
    std::ofstream(bin / name) << "#!/bin/sh\n" << script;
    fs::permissions(bin / name, fs::perms::owner_all);
    return bin.string();
  }
  Folder folder_;
  fs::path out_ = folder_ / "out";
};

TEST_F(Export, McapAndCsvHoldTheLogs) {
  const fs::path mcap = folder_ / "race.mcap", csv = folder_ / "race.csv";
  const Outcome outcome = gripline_with({"export", out_, "--mcap", mcap, "--csv", csv});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("mcap: " + mcap.string()));
  const report::Columns steps = report::Columns::read(out_ / "elm" / "1" / "steps.csv");
  std::size_t count = 0;
  for (const McapMessage& message : read_mcap(contents(mcap)).messages)
    if (message.topic == "/elm/step") {
      EXPECT_EQ(message.data["vx_mps"], steps.number("vx_mps", count++));
    }
  EXPECT_EQ(count, steps.rows());
  const report::Columns wide = report::Columns::read(csv);
  for (std::size_t row = 0; row < steps.rows(); row += 50)
    EXPECT_EQ(wide.number("elm/vx_mps", row), steps.number("vx_mps", row));
  EXPECT_TRUE(wide.has("oracle/mu_true"));
}

TEST_F(Export, TheReaderOfMcapsMakersReadsIt) {
  const fs::path reader = source_dir() / "tools" / "report" / "test" / "mcap.mjs";
  const bool there = fs::exists(source_dir() / "tools" / "report" / "node_modules" / "@mcap" / "core");
  const char* const required = std::getenv("GRIPLINE_REQUIRE_BROWSER");
  if (!there && required != nullptr && std::string(required) == "1") FAIL() << "npm ci in tools/report";
  if (!there) GTEST_SKIP() << "tools/report/node_modules/@mcap/core is not there (npm ci)";
  const fs::path mcap = folder_ / "race.mcap";
  ASSERT_EQ(gripline_with({"export", out_, "--mcap", mcap}).code, 0);
  const Outcome outcome = run_program({"node", reader, mcap});
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  const std::string rows = std::to_string(report::Columns::read(out_ / "elm" / "1" / "steps.csv").rows());
  EXPECT_THAT(outcome.out, HasSubstr("/elm/pose foxglove.PoseInFrame " + rows + "\n"));
  EXPECT_THAT(outcome.out, HasSubstr("/elm/step gripline.Step " + rows + "\n"));
  EXPECT_THAT(outcome.out, HasSubstr("/track foxglove.SceneUpdate 1\n"));
}

TEST_F(Export, WrongRequestsAreRefused) {
  const auto refusal = [&](std::vector<std::string> words) {
    words.insert(words.begin(), {"export", out_});
    const Outcome outcome = gripline_with(words);
    EXPECT_EQ(outcome.code, 2);
    return outcome.err;
  };
  EXPECT_THAT(refusal({}), HasSubstr("--mcap FILE, --csv FILE, --hdf5 FILE or --video FILE"));
  EXPECT_THAT(refusal({"--csv", folder_ / "x.csv", "--only", "elmo"}), HasSubstr("did you mean \"elm\"?"));
  EXPECT_THAT(refusal({"--csv", out_ / "elm" / "1" / "steps.csv" / "x.csv"}), HasSubstr("--csv"));  // below a file
  EXPECT_THAT(refusal({"--video", folder_ / "x.mp4", "--size", "wide"}), HasSubstr("--size: expected WIDTHxHEIGHT"));
  EXPECT_THAT(refusal({"--video", folder_ / "x.mp4", "--fps", "many"}),
              HasSubstr("--fps many: expected a whole number"));
  EXPECT_THAT(refusal({"--video", folder_ / "x.mp4", "--fps", "25.7"}),
              HasSubstr("--fps 25.7: expected a whole number"));
  EXPECT_THAT(refusal({"--video", folder_ / "x.mp4", "--fps", "121"}), HasSubstr("--fps 121: expected 1 to 120"));
}

TEST_F(Export, AVideoSaysWhichProgramIsMissing) {
  const auto refusal = [&](const std::string& path) {
    const Outcome outcome = gripline_with({"export", out_, "--video", folder_ / "race.mp4"},
                                          {.folder = folder_.path(), .environment = {{"PATH", path}}});
    EXPECT_EQ(outcome.code, 2);
    EXPECT_FALSE(fs::exists(folder_ / "race.mp4"));
    return outcome.err;
  };
  EXPECT_THAT(refusal("/nowhere"), HasSubstr("needs Chromium, which is not on the PATH"));
  EXPECT_THAT(refusal(path_with("chromium", "exit 0\n")), HasSubstr("needs ffmpeg, which is not on the PATH"));
}

/// A browser that ends at once and one that never answers would be waited for: the first is told at once.
TEST_F(Export, ABrowserThatEndsIsNamed) {
  (void)path_with("chromium", "exit 3\n");
  const Outcome outcome =
      gripline_with({"export", out_, "--video", folder_ / "race.mp4"},
                    {.folder = folder_.path(), .environment = {{"PATH", path_with("ffmpeg", "cat >/dev/null\n")}}});
  EXPECT_NE(outcome.code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("the browser ended before its time"));
  EXPECT_FALSE(fs::exists(folder_ / "race.mp4"));
  EXPECT_FALSE(fs::exists(folder_ / "race.mp4.html"));
}

/// The real browser draws; in place of ffmpeg stands a program that keeps the pictures.
TEST_F(Export, AVideoHasAPictureForEveryInstant) {
  const Outcome found = run_program({"sh", "-c", "command -v chromium || command -v google-chrome"});
  const char* const required = std::getenv("GRIPLINE_REQUIRE_BROWSER");
  if (found.code != 0 && required != nullptr && std::string(required) == "1") FAIL() << "Chromium is not installed";
  if (found.code != 0) GTEST_SKIP() << "Chromium is not installed";
  std::string path = path_with("ffmpeg", "for last; do :; done\ncat > \"$last\"\n");
  path.append(":").append(std::getenv("PATH"));
  const fs::path video = folder_ / "race.mp4";
  const Outcome outcome = gripline_with(
      {"export", out_, "--video", video, "--from", "1", "--to", "2", "--fps", "5", "--size", "640x360", "--follow"},
      {.folder = folder_.path(), .environment = {{"PATH", path}}});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::string bytes = contents(video);
  const std::string begin("\xff\xd8\xff", 3);
  std::vector<std::string> pictures;
  for (std::size_t at = bytes.find(begin); at != bytes.npos;) {
    const std::size_t next = bytes.find(begin, at + 3);
    pictures.push_back(bytes.substr(at, next == bytes.npos ? next : next - at));
    at = next;
  }
  EXPECT_EQ(pictures.size(), 6U);  // both ends
  for (std::size_t i = 1; i < pictures.size(); ++i) EXPECT_NE(pictures[i - 1], pictures[i]) << "nothing moved";
  EXPECT_FALSE(fs::exists(folder_ / "race.mp4.html"));
}

}  // namespace test_export
}  // namespace gripline
