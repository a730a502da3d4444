#include "sweep/task.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/hash.hpp"
#include "support/sweep_rig.hpp"

namespace gripline::sweep {
namespace test_task {

using namespace testing_support;
using testing::HasSubstr;

class Tasks : public SweepRig {};

TEST_F(Tasks, InputsThatChangedSinceThePlanAreRefused) {
  factors({"/base/planner/params/mu=0.3,0.4"});
  const Sweep sweep = planned();
  std::string text = contents(file());
  write_text(file(), text.replace(text.find("0.9}"), 3, "0.8"));
  testing::internal::CaptureStderr();
  EXPECT_EQ(body(sweep)(*missing("out", 100), 0, [] {}), task_refused);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("no longer those that the sweep was planned with"));
  Sweep other = sweep;
  other.program[0] = other.program[0] == 'a' ? 'b' : 'a';
  EXPECT_THAT(refusal([&] { require_same_versions(other, plugins()); }), HasSubstr("is another build than the one"));
  other = sweep;
  ASSERT_FALSE(other.libraries.empty());
  other.libraries.begin()->second = {std::string(64, '0')};
  EXPECT_THAT(refusal([&] { require_same_versions(other, plugins()); }), HasSubstr("results of both are not mixed"));
}

/// Two folders may each hold a library of one name: what counts is that each is there.
TEST_F(Tasks, LibrariesOfOneNameAreToldApartByTheirBytes) {
  namespace fs = std::filesystem;
  for (const char* folder : {"a", "b"}) fs::create_directories(folder_ / folder);
  const fs::path first = folder_ / "a/zz.so", second = folder_ / "b/zz.so";
  fs::copy_file(fixture_plugins("stranger") / "stranger.so", first);
  fs::copy_file(fixture_plugins("namesake") / "namesake.so", second);
  Sweep sweep = planned();
  sweep.libraries = {{"zz.so", {sha256_of_file(first), sha256_of_file(second)}}};
  const Registry both({folder_ / "a", folder_ / "b"}), turned({folder_ / "b", folder_ / "a"}), one({folder_ / "a"});
  EXPECT_EQ(refusal([&] { require_same_versions(sweep, both); }), "nothing");
  EXPECT_EQ(refusal([&] { require_same_versions(sweep, turned); }), "nothing");
  EXPECT_THAT(refusal([&] { require_same_versions(sweep, one); }), HasSubstr("results of both are not mixed"));
  EXPECT_THAT(refusal([&] { require_same_versions(sweep, plugins()); }), HasSubstr("is not found here"));
}

/// A file that a run may have read after it was hashed: its record would stand under the key of another file.
TEST_F(Tasks, ARunWhoseFilesAreEditedMeanwhileIsRefused) {
  namespace fs = std::filesystem;
  fs::create_directories(folder_ / "tracks");
  const fs::path road = folder_ / "tracks/road.csv";
  fs::copy_file(fixture_dir() / "tracks/oval.csv", road);
  factors({"/base/planner/params/mu=0.3,0.4"});
  request_.assignments = {"/world/track=" + road.string()};
  const Sweep sweep = planned();
  Worker worker(sweep, plugins(), out(), out() / "work");
  worker.run_with([&](const RunAt& run) {
    if (run.index == 1) write_text(road, contents(road) + "\n");
    return drawn(sweep, run);
  });
  testing::internal::CaptureStderr();
  EXPECT_EQ(worker.run(*missing("out", 100), 0, [] {}), task_refused);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("run 1: experiment, files or plugins are no longer"));
  Table table;
  EXPECT_EQ(merge_records(out(), sweep, table).finished, 1u);
}

TEST_F(Tasks, OfRunsThatWereCutOffOnlyTheReasonIsKept) {
  factors({"/base/planner/params/mu=0.3,0.4"});
  request_.keep_files = true;
  const Sweep sweep = planned();
  Worker worker(sweep, plugins(), out(), out() / "work");
  worker.run_with([&](const RunAt&) {
    Attempt attempt;
    attempt.files = out() / "work/half";
    std::filesystem::create_directories(attempt.files);
    write_text(attempt.files / "log.csv", "t_s\n");
    attempt.record.status = "error";
    attempt.record.message = "its process was ended by signal 9 (Killed)";
    attempt.cut_off = true;
    return attempt;
  });
  testing::internal::CaptureStderr();
  EXPECT_EQ(worker.run(*missing("out", 100), 0, [] {}), task_again);
  testing::internal::GetCapturedStderr();
  EXPECT_FALSE(std::filesystem::exists(out() / "work/half"));
  EXPECT_FALSE(std::filesystem::exists(out() / "files"));
  Table table;
  EXPECT_EQ(merge_records(out(), sweep, table).missing, 4u);
  EXPECT_THAT(lines(out() / "missing.csv").back(), HasSubstr("missing,its process was ended by signal 9 (Killed)"));
  body(sweep)(*missing("out", 100), 0, [] {});
  Table whole;
  EXPECT_TRUE(merge_records(out(), sweep, whole).complete());
  EXPECT_EQ(lines(out() / "missing.csv").size(), 1u);
}

/// What a plugin says decides nothing.
TEST_F(Tasks, RunsThatSpeakOfAKillOrTheDiskAreRecorded) {
  for (const char* words : {"was ended by signal 9 (Killed)", "cannot write plan.csv: No space left on device"}) {
    const Sweep sweep = planned();
    Worker worker(sweep, plugins(), out(), out() / "work");
    worker.run_with([&](const RunAt&) {
      Attempt attempt;
      attempt.record.status = "plugin_error";
      attempt.record.message = words;
      return attempt;
    });
    EXPECT_EQ(worker.run(*missing("out", 100), 0, [] {}), task_broke) << words;
    Table table;
    EXPECT_EQ(merge_records(out(), sweep, table).broken, 2u);
    std::filesystem::remove_all(out());
  }
}

}  // namespace test_task
}  // namespace gripline::sweep
