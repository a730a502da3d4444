// The power fails at every call through which results are written: what is found afterwards is whole or not believed,
// and the same command comes to the same end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiment/out_folder.hpp"
#include "experiment/run_result.hpp"
#include "experiment/single_run.hpp"
#include "support/host_support.hpp"
#include "support/power_loss.hpp"
#include "util/whole_file.hpp"

namespace gripline {
namespace test_power_loss {

using testing::AnyOf;
using namespace testing_support;
namespace fs = std::filesystem;

constexpr Survives all_kinds[] = {Survives::everything, Survives::names, Survives::synced};

RaceSpec short_race() {
  Node world = small_world();
  world.set("duration", Node(0.2));
  inline_world_files(world);
  Node tree = json(
      R"({"stacks": {"one": {"model": {"plugin": "ekinematic"}, "controller": {"plugin": "pure_pursuit"},
      "planner": {"plugin": "fixed_speed", "params": {"mu": 0.3}}}}})");
  tree.set("world", world);
  return read_race("race.json", tree, plugins());
}

/// All that is the same each time.
void expect_same_results(const fs::path& is, const fs::path& should) {
  for (const char* name : {"steps.csv", "replay.csv", "tyres.csv", "line.csv", "config.json", "summary.json"})
    EXPECT_EQ(contents(is / name), contents(should / name)) << is / name;
}

/// Makes `folder` hold these files and no others.
void leave(const RecordingDisk::Files& files, const fs::path& folder) {
  fs::remove_all(folder);
  fs::create_directories(folder);
  for (const auto& [name, bytes] : files) write_text(folder / name, bytes);
}

TEST(PowerLoss, ARunIsWholeOrDrivenAgain) {
  const Folder folder;
  const RaceSpec race = short_race();
  RecordingDisk recording(folder / "out");
  {
    const ScopedDisk use(recording);
    run_here(race, {"one", 1}, "key", folder / "out", nullptr);
  }
  const fs::path whole = folder / "out/one/1", left = folder / "left";
  ASSERT_GT(recording.calls(), 50u);
  std::size_t believed = 0, tried = 0;
  for (const Survives survives : all_kinds)
    for (const RecordingDisk::Files& files : recording.all_left(0, survives)) {
      leave(files, left);
      const bool complete = read_result(left / "one/1", "key").has_value();
      if (complete) {
        ++believed;
        expect_same_results(left / "one/1", whole);
      }
      if (complete || ++tried % 10 != 0) continue;
      run_here(race, {"one", 1}, "key", left, nullptr);
      expect_same_results(left / "one/1", whole);
      EXPECT_TRUE(read_result(left / "one/1", "key").has_value());
    }
  EXPECT_GE(believed, 3u);  // at the end, by every kind of disk
  EXPECT_GT(tried, 60u);
}

/// A run that is driven again takes the place of the old one: at no moment do both count, or halves of each.
TEST(PowerLoss, ARunDrivenAgainIsTheOldOneOrTheNewOne) {
  const Folder folder;
  const RaceSpec race = short_race();
  RecordingDisk recording(folder / "out");
  const ScopedDisk use(recording);
  run_here(race, {"one", 1}, "old", folder / "out", nullptr);
  const std::size_t first = recording.calls();
  run_here(race, {"one", 1}, "new", folder / "out", nullptr);
  ASSERT_GT(recording.calls(), first);
  for (const Survives survives : all_kinds) {
    int neither = 0;
    for (const RecordingDisk::Files& files : recording.all_left(first, survives)) {
      leave(files, folder / "left");
      const bool old_one = read_result(folder / "left/one/1", "old").has_value();
      const bool new_one = read_result(folder / "left/one/1", "new").has_value();
      EXPECT_FALSE(old_one && new_one);
      if (!old_one && !new_one) ++neither;
    }
    EXPECT_LE(neither, 1);  // between the two calls that remove the old one and name the new one
  }
}

TEST(PowerLoss, AFileIsWholeOrAsBefore) {
  const Folder folder;
  RecordingDisk recording(folder / "out");
  fs::create_directories(folder / "out");
  {
    const ScopedDisk use(recording);
    write_file(folder / "out/t.json", "the first text");
    write_file(folder / "out/t.json", "the second text, which is longer");
  }
  for (const Survives survives : all_kinds) {
    bool found = false;
    for (const RecordingDisk::Files& files : recording.all_left(0, survives)) {
      const auto file = files.find("t.json");
      if (file == files.end()) continue;
      found = true;
      EXPECT_THAT(file->second, AnyOf("the first text", "the second text, which is longer"));
    }
    EXPECT_TRUE(found);
  }
}

/// What is left of a folder that was just claimed never locks out the one who claimed it.
TEST(PowerLoss, AFolderThatWasClaimedCanBeClaimedAgain) {
  const Folder folder;
  RecordingDisk recording(folder / "out");
  {
    const ScopedDisk use(recording);
    open_out_folder(folder / "out", "one");
  }
  for (const Survives survives : all_kinds)
    for (const RecordingDisk::Files& files : recording.all_left(0, survives)) {
      leave(files, folder / "left");
      EXPECT_EQ(refusal([&] { open_out_folder(folder / "left", "one"); }), "nothing");
    }
}

}  // namespace test_power_loss
}  // namespace gripline
