#include "experiment/out_folder.hpp"

#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/errors.hpp"
#include "config/hash.hpp"
#include "experiment/single_run.hpp"
#include "support/host_support.hpp"
#include "support/paths.hpp"
#include "util/csv.hpp"
#include "util/made_folders.hpp"

namespace gripline {
namespace test_out_folder {

using testing::HasSubstr;
using namespace testing_support;
namespace fs = std::filesystem;

TEST(OutFolder, IsMadeWithItsParents) {
  const Folder folder;
  open_out_folder(folder / "a/b", "one");
  EXPECT_TRUE(fs::exists(folder / "a/b/experiment.json"));
  fs::create_directory(folder / "empty");
  EXPECT_NO_THROW(open_out_folder(folder / "empty", "one"));
}

/// What fails before it wrote anything leaves no folder; one that was there, or that holds something, stays.
TEST(OutFolder, AFailureBeforeAnyResultLeavesNone) {
  const Folder folder;
  const auto fail = [&](const fs::path& out, bool written) {
    try {
      const OutLock lock = open_out_folder(out, "one");
      if (written) write_text(out / "runs.csv", "x");
      throw InputError("later");
    } catch (const InputError&) {
    }
    remove_empty_made_folders();
  };
  fail(folder / "a/b", false);
  EXPECT_FALSE(fs::exists(folder / "a"));
  fail(folder / "a/b", true);
  EXPECT_TRUE(fs::exists(folder / "a/b/experiment.json"));
  EXPECT_TRUE(fs::exists(folder / "a/b/runs.csv"));
  fs::create_directory(folder / "empty");
  fail(folder / "empty", false);
  EXPECT_TRUE(fs::exists(folder / "empty/experiment.json"));
  open_out_folder(folder / "fine", "one");
  remove_empty_made_folders();
  EXPECT_TRUE(fs::exists(folder / "fine/experiment.json"));
}

TEST(OutFolder, TheSameExperimentGoesOn) {
  const Folder folder;
  open_out_folder(folder / "out", "one");
  write_text(folder / "out/elm/1/summary.json", "{}");
  open_out_folder(folder / "out", "one");
  EXPECT_TRUE(fs::exists(folder / "out/elm/1/summary.json"));
}

TEST(OutFolder, AnotherExperimentIsRefusedUnlessForced) {
  const Folder folder;
  open_out_folder(folder / "out", "one");
  write_text(folder / "out/elm/1/summary.json", "{}");
  const std::string message = refusal([&] { open_out_folder(folder / "out", "two"); });
  EXPECT_THAT(message,
              HasSubstr("out already holds another experiment; choose another --out, or --force to replace it"));
  EXPECT_TRUE(fs::exists(folder / "out/elm/1/summary.json"));
  open_out_folder(folder / "out", "two", {.force = true});
  EXPECT_FALSE(fs::exists(folder / "out/elm"));
  EXPECT_NO_THROW(open_out_folder(folder / "out", "two"));
}

TEST(OutFolder, AnEditedExperimentGoesOnWhereAnyOfItsRunsStands) {
  const Folder folder;
  const Node one = json(R"({"stacks": {"elm": {"mu": 1}}})"), two = json(R"({"stacks": {"elm": {"mu": 1}, "gp": {}}})");
  EditedExperiment first{&one, [] { return false; }, {}};
  { open_out_folder(folder / "out", "one", {.edited = &first}); }
  EXPECT_TRUE(first.changes.empty());
  write_text(folder / "out/elm/1/summary.json", "{}");
  EditedExperiment other{&two, [] { return false; }, {}};
  EXPECT_THAT(refusal([&] { open_out_folder(folder / "out", "two", {.edited = &other}); }),
              HasSubstr("already holds another experiment (/stacks/gp: new); choose another --out"));
  const Node many = json(R"({"dt": 1, "laps": 2, "mu": 3, "seeds": {"count": 2}, "stacks": {"elm": {"mu": 2}}})");
  EditedExperiment unlike{&many, [] { return false; }, {}};
  EXPECT_THAT(refusal([&] { open_out_folder(folder / "out", "many", {.edited = &unlike}); }),
              HasSubstr(" (/dt: new, 1; /laps: new, 2; /mu: new, 3; and 1 more); choose"));
  EditedExperiment edited{&two, [] { return true; }, {}};
  { open_out_folder(folder / "out", "two", {.edited = &edited}); }
  EXPECT_THAT(edited.changes, testing::ElementsAre("/stacks/gp: new"));
  EXPECT_TRUE(fs::exists(folder / "out/elm/1/summary.json"));
  EditedExperiment again{&two, [] { return true; }, {}};
  { open_out_folder(folder / "out", "two", {.edited = &again}); }
  EXPECT_TRUE(again.changes.empty());
  EditedExperiment forced{&one, [] { return true; }, {}};
  { open_out_folder(folder / "out", "one", {.force = true, .edited = &forced}); }
  EXPECT_FALSE(fs::exists(folder / "out/elm"));
}

TEST(OutFolder, ForceOnTheSameExperimentBeginsAgain) {
  const Folder folder;
  open_out_folder(folder / "out", "one");
  write_text(folder / "out/elm/1/summary.json", "{}");
  open_out_folder(folder / "out", "one", {.force = true});
  EXPECT_FALSE(fs::exists(folder / "out/elm"));
}

TEST(OutFolder, ForceTakesOnlyWhatGriplineMakes) {
  const Folder folder;
  { open_out_folder(folder / "out", "one"); }
  const std::vector<std::string> made = {"runs.csv",
                                         "errors.csv",
                                         "ablation.csv",
                                         "parameters.csv",
                                         "samples.csv",
                                         "fitted.json",
                                         "measured.json",
                                         "report.html",
                                         "figures/speed.svg",
                                         "elm/1/steps.csv",
                                         "elm/.2.partial/steps.csv",
                                         "train/steps.csv",
                                         "train/tyres.csv",
                                         "case/diagnosis.json",
                                         "case/drive/steps.csv",
                                         "case/drive/tyres.csv",
                                         "case/round_trip/diagnosis.json"};
  const std::vector<std::string> foreign = {"notes.txt", "figures/mine.pdf", "elm/1/remark.md", "photos/1.jpg",
                                            "logs/steps.csv"};
  for (const auto* files : {&made, &foreign})
    for (const std::string& file : *files) write_text(folder / ("out/" + file), "x");
  fs::create_directory(folder / "out/empty");
  { open_out_folder(folder / "out", "two", {.force = true}); }
  for (const std::string& file : made) EXPECT_FALSE(fs::exists(folder / ("out/" + file))) << file;
  for (const std::string& file : foreign) EXPECT_TRUE(fs::exists(folder / ("out/" + file))) << file;
  EXPECT_FALSE(fs::exists(folder / "out/train"));
  EXPECT_FALSE(fs::exists(folder / "out/elm/.2.partial"));
  EXPECT_TRUE(fs::exists(folder / "out/empty"));
}

/// Whatever a race leaves: one whose start is drawn has a file more.
TEST(OutFolder, ForceTakesAllThatARaceLeaves) {
  const Folder folder;
  Node tree = json(R"({"perturb": {"speed": "0.05 m/s"}, "stacks": {"a": {"model": {"plugin": "ekinematic"},
    "planner": {"plugin": "fixed_speed", "params": {"mu": 0.3}}, "controller": {"plugin": "pure_pursuit"}}}})");
  Node world = small_world();
  inline_world_files(world);
  tree.set("world", world);
  const RaceSpec race = read_race("drawn.json", tree, plugins());
  const fs::path out = folder / "out";
  {
    const OutLock lock = open_out_folder(out, "one");
    ASSERT_EQ(run_here(race, {"a", 1}, "key", out, nullptr).status, Status::finished);
  }
  ASSERT_TRUE(fs::exists(out / "a/1/draw.json"));
  { open_out_folder(out, "two", {.force = true}); }
  EXPECT_FALSE(fs::exists(out / "a"));
}

TEST(OutFolder, OneAtATime) {
  const Folder folder;
  {
    const OutLock first = open_out_folder(folder / "out", "one");
    for (const bool force : {false, true})
      EXPECT_EQ(refusal([&] { open_out_folder(folder / "out", "one", {.force = force}); }),
                (folder / "out").string() +
                    ": another gripline is writing there now; wait for its end or choose another --out");
  }
  EXPECT_FALSE(fs::exists(folder / "out/.lock"));
  EXPECT_NO_THROW(open_out_folder(folder / "out", "one"));
}

/// A lock left by a process that was killed holds nobody up.
TEST(OutFolder, ALockFileAloneIsNoLock) {
  const Folder folder;
  write_text(folder / "out/.lock", "");
  EXPECT_NO_THROW(open_out_folder(folder / "out", "one"));
}

/// A process is named by its machine, its number and its start: numbers are given again.
TEST(OutFolder, TheLockNamesTheProcessThatHoldsIt) {
  const Folder folder;
  const fs::path file = folder / "out/.lock";
  write_text(file, "left by a process that was killed, and longer than what follows it in this file\n");
  EXPECT_FALSE(OutLock::holder_here(folder / "out"));
  {
    const OutLock lock(folder / "out");
    EXPECT_EQ(OutLock::holder_here(folder / "out"), getpid());
    const std::string line = contents(file), number = std::to_string(getpid());
    ASSERT_TRUE(line.starts_with(number + " ")) << line;
    write_text(file, number + " 1" + line.substr(number.size() + 1));
    EXPECT_FALSE(OutLock::holder_here(folder / "out")) << "of another process that had this number";
    write_text(file, line.substr(0, line.size() - 1) + "x\n");
    EXPECT_FALSE(OutLock::holder_here(folder / "out")) << "of another machine";
  }
  EXPECT_FALSE(OutLock::holder_here(folder / "out"));
}

TEST(OutFolder, SeedsAndClaimsDoNotMakeAnotherExperiment) {
  const auto identity = [](const char* text) { return experiment_identity(json(text)); };
  const std::string one = identity(R"({"stacks": {"a": {}}, "seeds": {"count": 2}, "claims": ["a.runs > 1"]})");
  EXPECT_EQ(one, identity(R"({"stacks": {"a": {}}, "seeds": {"count": 3}, "claim_share": 0.5})"));
  EXPECT_NE(one, identity(R"({"stacks": {"a": {}, "b": {}}})"));
}

TEST(OutFolder, WhatGriplineDidNotMakeIsNeverEmptied) {
  const Folder folder;
  write_text(folder / "home/thesis.tex", "years of work");
  EXPECT_THAT(refusal([&] { open_out_folder(folder / "home", "one"); }), HasSubstr("already holds something else"));
  EXPECT_THAT(refusal([&] { open_out_folder(folder / "home", "one", {.force = true}); }),
              HasSubstr("was not made by gripline; --force does not empty it, choose another --out"));
  write_text(folder / "home/experiment.json", "{\"identity\": ");  // somebody else's file of that name
  EXPECT_THAT(refusal([&] { open_out_folder(folder / "home", "one", {.force = true}); }),
              HasSubstr("was not made by gripline"));
  EXPECT_EQ(contents(folder / "home/thesis.tex"), "years of work");
}

/// What a process or a machine that died left of the marker locks nobody out.
TEST(OutFolder, HalfAMarkerIsNoObstacle) {
  const Folder folder;
  write_text(folder / "out/experiment.json.partial", "{\"ident");
  EXPECT_NO_THROW(open_out_folder(folder / "out", "one"));
  write_text(folder / "out/runs.csv", "stack\n");
  write_text(folder / "out/experiment.json", "");
  EXPECT_EQ(refusal([&] { open_out_folder(folder / "out", "one"); }),
            (folder / "out").string() +
                ": its experiment.json cannot be read; choose another --out, or --force to "
                "replace what gripline made there");
  EXPECT_NO_THROW(open_out_folder(folder / "out", "one", {.force = true}));
  EXPECT_FALSE(fs::exists(folder / "out/runs.csv"));
}

TEST(OutFolder, AFileIsNoFolder) {
  const Folder folder;
  write_text(folder / "file", "x");
  EXPECT_THAT(refusal([&] { open_out_folder(folder / "file", "one", {.force = true}); }),
              HasSubstr("file is a file; --out names a folder"));
  EXPECT_THAT(refusal([&] { open_out_folder(folder / "file/out", "one"); }), HasSubstr("cannot make"));
}

TEST(OutFolder, TheSceneTellsTheReportWhatItNeeds) {
  const Folder folder;
  Node world = small_world();
  inline_world_files(world);
  Node tree = json(R"({"note": "a note", "stacks": {"a": {"model": {"plugin": "ekinematic"},
    "planner": {"plugin": "fixed_speed"}, "controller": {"plugin": "pure_pursuit"}}}})");
  tree.set("world", world);
  const RaceSpec race = read_race("scene.json", tree, plugins());
  write_scene(folder.path(), race, plugins());
  const Node scene = parse_file(folder / "scene.json");
  EXPECT_EQ(scene.find("name")->text(), "scene");
  EXPECT_EQ(scene.find("kind")->text(), "race");
  EXPECT_EQ(scene.find("note")->text(), "a note");
  EXPECT_EQ(find_pointer(scene, "/car/width")->number(), 0.03);
  const CsvTable track = read_csv(folder / "track.csv");
  EXPECT_GE(track.rows(), 200u);
  EXPECT_NEAR(track.column("left_y_m").at(0), 0.3, 1e-12);
  EXPECT_NEAR(track.column("right_y_m").at(0), -0.3, 1e-12);
  const Node origin = parse_file(folder / "provenance.json");
  EXPECT_EQ(origin.find("plugin_abi")->number(), abi::number);
  const Node::Array& libraries = origin.find("libraries")->array();
  ASSERT_EQ(libraries.size(), 4u);
  EXPECT_EQ(libraries[0].find("file")->text(), "dynamic.so");
  EXPECT_EQ(libraries[0].find("sha256")->text(), sha256_of_file(plugin_dir() / "dynamic.so"));
  EXPECT_EQ(libraries[0].find("plugins")->array().at(0).text(), "dynamic 1.0");
}

}  // namespace test_out_folder
}  // namespace gripline
