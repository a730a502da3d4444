#include "world/world_spec.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/host_support.hpp"
#include "support/paths.hpp"

namespace gripline {
namespace test_world_spec {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using namespace testing_support;

std::string why(const char* patch) {
  return refusal([&] { world_of(patch); });
}

TEST(WorldSpec, IsReadWithDefaults) {
  const WorldSpec world = world_of();
  EXPECT_EQ(world.dt, 0.02);
  EXPECT_EQ(world.hold, Hold::zoh);
  EXPECT_EQ(world.vehicle.model.id(), "dynamic");
  EXPECT_EQ(world.vehicle.integration.tableau->name, "rk6");
  EXPECT_TRUE(world.plant.empty());
  for (const SensorSpec::Channel& channel : world.sensors.channels) {
    EXPECT_EQ(channel.sigma, 0.0);
    EXPECT_EQ(channel.bias, 0.0);
    EXPECT_EQ(channel.every, 1);
    EXPECT_EQ(channel.delay, 0);
  }
  EXPECT_TRUE(world.friction.points.empty());
  EXPECT_EQ(world.laps, 0);
  EXPECT_EQ(world.duration, 1.0);
  EXPECT_NEAR(world.timeout, 1.0, 1e-6);
  EXPECT_EQ(world.start.x, 0);
  EXPECT_EQ(world.start.yaw, 0);
  EXPECT_EQ(world.start_speed, 0.1);  // the published starts
  EXPECT_FALSE(world.time_optimal.at(1.0).has_value());
}

TEST(WorldSpec, EveryKeyIsRead) {
  const WorldSpec world = world_of(R"({
    "dt": "10 ms", "input_hold": "foh", "laps": 3, "timeout": "2 min", "duration": null,
    "start": {"x": "5 cm", "y": -0.1, "yaw": "10 deg", "speed": "3.6 km/h"},
    "plant": {"plugin": "dynamic", "integrator": "rkf5", "substeps": 2, "effects": [{"plugin": "aero_drag"}]},
    "friction": [{"t": 0, "factor": 1}, {"t": "1 s", "factor": 0.5}],
    "sensors": {"delay": {"x": "30 ms"}}})");
  EXPECT_EQ(world.dt, 0.01);
  EXPECT_EQ(world.hold, Hold::foh);
  EXPECT_EQ(world.laps, 3);
  EXPECT_EQ(world.timeout, 120);
  EXPECT_FALSE(world.duration.has_value());
  EXPECT_EQ(world.start.x, 0.05);
  EXPECT_NEAR(world.start.yaw, 0.17453292519943, 1e-12);
  EXPECT_EQ(world.start_speed, 1.0);
  EXPECT_EQ(world.vehicle.integration.tableau->name, "rkf5");
  EXPECT_EQ(world.vehicle.effects.size(), 1u);
  EXPECT_EQ(world.friction.points.size(), 2u);
  EXPECT_EQ(world.sensors.channels[0].delay, 3);  // in this world's own steps
}

TEST(WorldSpec, APlantMayBeABlackBox) {
  const Node tree = json(R"({"car": "cars/full_size.json", "track": "tracks/hill.json", "duration": 1,
    "plant": {"plugin": "double_track"}})");
  const auto read = [&](const char* patch) {
    Node world = merge(tree, json(patch));
    inline_world_files(world);
    Errors errors;
    WorldSpec spec = read_world(world, plugins(), errors);
    errors.throw_if_any();
    return spec;
  };
  EXPECT_EQ(read("{}").plant.id(), "double_track");
  EXPECT_TRUE(read("{}").vehicle.model.empty());
  EXPECT_THAT(refusal([&] { require_vehicle_model(read("{}"), "diagnose"); }),
              HasSubstr("/plant: \"double_track\" is a black box; diagnose needs a vehicle model (example: "
                        "worlds/diagnose_full.json)"));
  require_vehicle_model(world_of(), "diagnose");
  EXPECT_THAT(refusal([&] { read(R"({"input_hold": "foh"})"); }),
              HasSubstr("/plant: \"double_track\" moves by itself under held commands; expected input_hold \"zoh\""));
  EXPECT_THAT(refusal([&] { read(R"({"plant": {"effects": []}})"); }), HasSubstr("/plant/effects: unknown key"));
}

TEST(WorldSpec, TimeOptimalLapsAreLinearInTheFactor) {
  const WorldSpec world = world_of(
      R"({"time_optimal_laps": [{"factor": 0.5, "lap": 8}, {"factor": 0.8, "lap": 7.4}, {"factor": 1, "lap": "7 s"}]})");
  EXPECT_DOUBLE_EQ(world.time_optimal.at(0.8).value(), 7.4);
  EXPECT_DOUBLE_EQ(world.time_optimal.at(0.65).value(), 7.7);
  EXPECT_DOUBLE_EQ(world.time_optimal.at(0.9).value(), 7.2);
  EXPECT_DOUBLE_EQ(world.time_optimal.at(1).value(), 7);
  EXPECT_FALSE(world.time_optimal.at(1.1).has_value());
  EXPECT_FALSE(world.time_optimal.at(0.4).has_value());
  const WorldSpec one = world_of(R"({"time_optimal_laps": [{"factor": 1, "lap": 7}]})");
  EXPECT_EQ(one.time_optimal.at(1), 7);
  EXPECT_FALSE(one.time_optimal.at(0.3).has_value());
  EXPECT_THAT(why(R"({"time_optimal_laps": [{"factor": 1, "lap": 7}, {"factor": 1, "lap": 7}]})"),
              HasSubstr("/time_optimal_laps/1: factors must rise"));
}

/// The published tables of the two tracks, from a mesh of unknown error: those of gripline limit lie up to 1 % lower.
TEST(WorldSpec, ShippedWorldsStateLimitsNearThePublishedTables) {
  const auto lap = [](const char* file, double factor) {
    Node tree = load_json(source_dir() / "worlds" / file);
    inline_world_files(tree);
    Errors errors;
    const WorldSpec world = read_world(tree, plugins(), errors);
    errors.throw_if_any();
    return world.time_optimal.at(factor).value();
  };
  const double factors[] = {1.0, 0.9, 0.8, 0.7, 0.6579, 0.612};
  const double ethz[] = {7.00, 7.22, 7.46, 7.77, 7.91, 8.07}, mobil[] = {5.11, 5.25, 5.41, 5.59, 5.68, 5.79};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(lap("ethz.json", factors[i]), ethz[i], 0.01 * ethz[i]) << factors[i];
    EXPECT_NEAR(lap("mobil.json", factors[i]), mobil[i], 0.01 * mobil[i]) << factors[i];
  }
}

TEST(WorldSpec, ItsEndMustBeStated) {
  EXPECT_THAT(why(R"({"duration": null})"),
              HasSubstr("a world ends after \"laps\" or after a \"duration\"; neither is given"));
  EXPECT_THAT(why(R"({"duration": null, "laps": 2})"), HasSubstr("needs a \"timeout\""));
  EXPECT_EQ(why(R"({"duration": null, "laps": 2, "timeout": "20 s"})"), "nothing");
  EXPECT_EQ(why(R"({"laps": 2})"), "nothing");  // laps, or the duration
  EXPECT_THAT(why(R"({"duration": 0})"), HasSubstr("/duration: 0 is out of range"));
  EXPECT_THAT(why(R"({"laps": 2.5})"), HasSubstr("/laps: expected a whole number"));
}

TEST(WorldSpec, ForLogsAloneNoRoadAndNoEndAreNeeded) {
  Node tree = merge(small_world(), json(R"({"track": null, "start": null, "duration": null})"));
  inline_world_files(tree);
  Errors errors;
  const WorldSpec world = read_world(tree, plugins(), errors, RoadRule::optional);
  EXPECT_TRUE(errors.empty());
  EXPECT_EQ(world.track, nullptr);
  EXPECT_EQ(world.vehicle.model.id(), "dynamic");
  read_world(tree, plugins(), errors);
  EXPECT_EQ(errors.size(), 1u);
}

TEST(WorldSpec, ARoadsTableIsNoWorld) {
  EXPECT_THAT([] { load_world(testing_support::fixture_dir() / "tracks/oval.csv"); },
              ::testing::ThrowsMessage<InputError>(HasSubstr("oval.csv: is a table, expected a world")));
}

TEST(WorldSpec, RefusalsSayWhatAndWhere) {
  EXPECT_THAT(why(R"({"car": null})"), HasSubstr("/car: missing, expected a car file or an object"));
  EXPECT_THAT(why(R"({"track": null})"), HasSubstr("/track: missing, expected a track file or an object"));
  EXPECT_THAT(why(R"({"plant": null})"), HasSubstr("/plant: missing, expected a vehicle model or a plant"));
  EXPECT_THAT(why(R"({"dt": 0})"), HasSubstr("/dt: 0 is out of range"));
  EXPECT_THAT(why(R"({"dt": "20 m"})"), HasSubstr("\"20 m\" is a length, expected a time [s]"));
  EXPECT_THAT(why(R"({"input_hold": "soh"})"),
              HasSubstr("/input_hold: expected \"zoh\", \"foh\" or \"rate\", found \"soh\""));
  EXPECT_THAT(why(R"({"frictoin": []})"), HasSubstr("unknown key \"frictoin\"; did you mean \"friction\"?"));
  EXPECT_THAT(why(R"({"car": "cars/orca_1_44.json"})"), HasSubstr("did you mean \"orca_1_43.json\"?"));
  EXPECT_THAT(why(R"({"car": {"width": 0.7}})"), HasSubstr("/car: replaces the file"));
  EXPECT_THAT(why(R"({"friction": {"per_step": {"start_step": 10, "divide": 50}, "shift_per_seed": 0.03}})"),
              HasSubstr("/friction/shift_per_seed: friction shift_per_seed 0.03 s is not a multiple"));
  EXPECT_THAT(why(R"({"friction": {"patches": [{"from_s": 1, "to_s": 20, "factor": 0.5}]}})"),
              HasSubstr("/friction/patches/0/to_s: friction patch 1 names s = 20 m, expected 0 to"));
  EXPECT_THAT(why(R"({"friction": {"patches": [{"from_s": 1, "to_s": 2, "factor": 0.5},
                                               {"from_s": 20, "to_s": 2, "factor": 0.5}]}})"),
              HasSubstr("/friction/patches/1/from_s: friction patch 2"));
}

/// A change of a file of another ending would go unnoticed: runs are told apart by the files that endings tell.
TEST(WorldSpec, FilesOfOtherEndingsAreRefused) {
  const Folder folder;
  write_text(folder / "fr.txt", R"([{"t": 0, "factor": 0.5}])");
  write_text(folder / "laps.txt", "factor,lap_s,error_s,body\n1,7,0,0\n");
  write_text(folder / "road.txt", contents(source_dir() / "worlds/tracks/ethz.json"));
  const auto with = [&](const std::string& key, const std::string& name) {
    return why((R"({")" + key + R"(": ")" + (folder / name).string() + "\"}").c_str());
  };
  EXPECT_THAT(with("friction", "fr.txt"), AllOf(HasSubstr("/friction: \""), HasSubstr("ends in .json")));
  EXPECT_THAT(with("time_optimal_laps", "laps.txt"),
              AllOf(HasSubstr("/time_optimal_laps: \""), HasSubstr("ends in .csv")));
  EXPECT_THAT(with("track", "road.txt"), AllOf(HasSubstr("/track: \""), HasSubstr("ends in .json or .csv")));
}

/// The tree of a world is written into files of its own, where a removed key would be an unknown one.
TEST(WorldSpec, WhatAnExtendingFileRemovedIsNotInTheTree) {
  const Folder folder;
  write_text(folder / "base.json", R"({"plant": {"params": {"Df": 1, "Cr0": 2}}, "friction": [], "laps": 1})");
  write_text(folder / "world.json", R"({"extends": "base.json", "friction": null, "plant": {"params": {"Df": null}}})");
  Node tree = load_json(folder / "world.json");
  inline_world_files(tree);
  EXPECT_EQ(tree.find("friction"), nullptr);
  EXPECT_EQ(find_pointer(tree, "/plant/params/Df"), nullptr);
  EXPECT_EQ(find_pointer(tree, "/plant/params/Cr0")->number(), 2);
}

TEST(WorldSpec, TheStartMustBeOnTheRoadAndFaceAlong) {
  EXPECT_THAT(why(R"({"start": {"y": 0.5}})"),
              HasSubstr("/start: start (0, 0.5) is off the track: 0.5 m left of the centre line"));
  EXPECT_THAT(why(R"({"start": {"yaw": "180 deg"}})"), HasSubstr("/start: start faces backwards"));
  EXPECT_THAT(why(R"({"start": {"speed": -1}})"), HasSubstr("/start/speed: -1 is out of range"));
  EXPECT_THAT(why(R"({"start": {"X": 1}})"), HasSubstr("unknown key \"X\"; did you mean \"x\"?"));
}

/// Not where the start of the extended file stands, which is good.
TEST(WorldSpec, AStartIsToldAtTheMemberThatMovedIt) {
  const Folder folder;
  write_text(folder / "base.json", R"({"start": {"x": 0, "y": 0, "yaw": 0, "speed": "1 m/s"}})");
  write_text(folder / "world.json", R"({"extends": "base.json", "start": {"speed": "2 m/s", "y": 0.5}})");
  Node tree = merge(small_world(), load_json(folder / "world.json"));
  inline_world_files(tree);
  Errors errors;
  read_world(tree, plugins(), errors);
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_THAT(errors.sorted().front().text(), HasSubstr("world.json:1:59: /start/y: start (0, 0.5) is off the track"));
}

TEST(WorldSpec, TheCarMustFit) {
  EXPECT_THAT(why(R"({"track": {"half_width": 0.014}})"),
              HasSubstr("/track: the car is 0.03 m wide, the track only 0.028 m at its narrowest"));
}

/// One mistake is told once: a road that cannot be read says nothing of what stands on it.
TEST(WorldSpec, AWrongTrackIsTheOnlyError) {
  const std::string message = why(R"({"track": {"segments": [{"line": 1}]}, "start": {"x": 1}})");
  EXPECT_THAT(message, AllOf(HasSubstr("/track/segments"), Not(HasSubstr("/start")), Not(HasSubstr("\n"))));
}

TEST(WorldSpec, EverythingWrongIsToldAtOnce) {
  const std::string message = why(R"({"dt": -1, "input_hold": 3, "sensors": {"sigma": {"x": -1}}})");
  EXPECT_THAT(message, AllOf(HasSubstr("/dt"), HasSubstr("/input_hold"), HasSubstr("/sensors/sigma/x")));
}

TEST(WorldSpec, FilesAreInlinedSoThatTheTreeSaysEverything) {
  Node tree = load_json(source_dir() / "worlds/ethz_wear.json");
  inline_world_files(tree);
  EXPECT_TRUE(tree.find("car")->is_object());
  EXPECT_TRUE(tree.find("track")->find("segments")->is_array());
  EXPECT_TRUE(tree.find("friction")->find("per_step")->is_object());
  EXPECT_EQ(find_pointer(tree, "/plant/params/Bf")->number(), 2.579);
  EXPECT_EQ(tree.find("car")->find("m")->origin.source->name.substr(
                tree.find("car")->find("m")->origin.source->name.rfind('/')),
            "/orca_1_43.json");
}

/// One mistake is one message: what would follow from it is not told.
TEST(WorldSpec, AMistakeIsToldOnce) {
  EXPECT_EQ(why(R"({"car": {"width": "3 s"}})").find("the car is"), std::string::npos);
  EXPECT_THAT(why(R"({"car": 3})"), HasSubstr("/car: expected an object, found 3"));
  EXPECT_EQ(why(R"({"car": 3})").find("narrowest"), std::string::npos);
  EXPECT_EQ(why(R"({"start": {"x": "1e400 m"}})").find("off the track"), std::string::npos);
  for (const char* end :
       {R"({"duration": null, "laps": 2, "timeot": "20 s"})", R"({"duration": null, "lpas": 2})",
        R"({"duration": null, "laps": "two"})", R"({"duration": null, "laps": 2, "timeout": "20 m"})"})
    EXPECT_EQ(why(end).find('\n'), std::string::npos) << why(end);
}

TEST(WorldSpec, NumbersBeyondReasonAreRefused) {
  EXPECT_THAT(why(R"({"start": {"speed": "900 km/h"}})"), HasSubstr("/start/speed: \"900 km/h\" is out of range"));
  EXPECT_THAT(why(R"({"start": {"x": "1e307 km"}})"), HasSubstr("/start/x: "));
}

TEST(WorldSpec, AWorldFileIsReadWithEverythingItNames) {
  const std::filesystem::path worlds = source_dir() / "worlds";
  const Node whole = load_world(worlds / "ethz.json");
  EXPECT_TRUE(whole.find("car")->is_object());
  EXPECT_TRUE(whole.find("track")->is_object());
  const Node elsewhere = load_world(worlds / "ethz.json", worlds / "tracks/ring.json");
  EXPECT_EQ(content_text(*elsewhere.find("track")), content_text(load_json(worlds / "tracks/ring.json")));
  EXPECT_THAT(refusal([&] { (void)load_world(worlds / "cars/orca_1_43.json"); }),
              HasSubstr("is a car, expected a world"));
}

}  // namespace test_world_spec
}  // namespace gripline
