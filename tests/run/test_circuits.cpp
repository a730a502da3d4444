// The stacks as they are shipped on circuits that nobody tuned on, from poses that nobody would start in.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <string>

#include "config/json_file.hpp"
#include "config/merge_patch.hpp"
#include "experiment/experiment.hpp"
#include "race/assembly.hpp"
#include "support/paths.hpp"
#include "support/whole_world.hpp"

namespace gripline {
namespace test_circuits {

using testing_support::shipped_plugins;
using testing_support::world_from;

constexpr double degree = std::numbers::pi / 180.0;

/// A closed road about the origin whose radius varies by seeded waves, 9 to 13 m wide, as a CSV of TU Munich's format.
std::filesystem::path drawn_circuit(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> phase(0.0, 2.0 * std::numbers::pi);
  const double phases[] = {phase(random), phase(random), phase(random), phase(random)};
  std::string name = "circuit_";
  name.append(std::to_string(seed)).append(".csv");
  std::filesystem::path path = std::filesystem::path(testing::TempDir()) / name;
  std::ofstream out(path);
  out << "# x_m,y_m,w_tr_right_m,w_tr_left_m\n";
  constexpr int points = 240;
  for (int i = 0; i < points; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / points;
    const double waves = 0.16 * std::cos(2 * angle + phases[0]) + 0.08 * std::cos(3 * angle + phases[1]) +
                         0.03 * std::cos(5 * angle + phases[2]);
    const double radius = 180.0 * (1.0 + waves), width = 5.5 + std::cos(4 * angle + phases[3]);
    out << radius * std::cos(angle) << ',' << radius * std::sin(angle) << ',' << width << ',' << width << '\n';
  }
  return path;
}

WorldSpec full_size_on(const std::filesystem::path& track) {
  std::string text = R"({"car": "cars/full_size.json", "plant": {"plugin": "double_track"}, "duration": 10,
    "sensors": {"sigma": {"x": 0.02, "y": 0.02, "yaw": 0.0035, "vx": 0.05, "vy": 0.05, "yaw_rate": 0.0035}},
    "track": ")";
  text.append(track.string()).append("\"}");
  return world_from(parse_text(text, "circuit", testing_support::source_dir() / "worlds"));
}

StackSpec row(const char* file, const char* name, const CarFile& car) {
  const Node stacks = load_json(testing_support::source_dir() / "experiments" / file);
  Errors errors;
  StackSpec spec =
      read_stack(name, merge(*stacks.find("base"), *stacks.find("stacks")->find(name)), shipped_plugins(), car, errors);
  errors.throw_if_any();
  return spec;
}

/// A start beside the centre line at a station, `n` to the left, turned by an angle to the left.
struct Start {
  const char* row;
  double station, n, angle_deg, speed;
  friend std::ostream& operator<<(std::ostream& out, const Start& s) {
    return out << s.row << " at " << s.station << " m, " << s.n << " m to the left, " << s.angle_deg << " deg askew, "
               << s.speed << " m/s";
  }
};
void begin_at(const Start& start, double duration, WorldSpec& world) {
  const CurvePoint centre = world.track->at(start.station);
  world.start = {centre.x - start.n * std::sin(centre.yaw), centre.y + start.n * std::cos(centre.yaw),
                 centre.yaw + start.angle_deg * degree};
  world.start_speed = start.speed;
  world.laps = 0;
  world.duration = world.timeout = duration;
}

TEST(Circuits, EveryRowJoinsItsLineFromFarOff) {
  WorldSpec world = full_size_on(drawn_circuit(3));
  for (const Start& start : {Start{"none", 0, 4, 0, 0.1}, Start{"none", 600, 3, -30, 15}, Start{"elm", 300, -3, 30, 5},
                             Start{"best", 300, 3, 30, 5}, Start{"best", 0, -4, 0, 20}}) {
    begin_at(start, 5.0, world);
    const StackSpec stack = row("circuits.json", start.row, world.car);
    RaceAssembly race(world, stack);
    const RunSummary summary = race.run();
    EXPECT_EQ(summary.status, Status::finished) << start << ": " << summary.message;
    EXPECT_EQ(summary.violation_s, 0.0) << start;
    EXPECT_GT(race.world().covered(), 15.0) << start;
  }
}

/// Facing backwards, across, far beside the road, standing outside of it and facing outwards: the time it takes is
/// counted, and then it races on.
TEST(Circuits, ACarThatSpunOrLeftTheRoadDrivesBackAndGoesOn) {
  WorldSpec world = full_size_on(drawn_circuit(3));
  for (const Start& start : {Start{"best", 0, 0, 180, 0.1}, Start{"elm", 300, -30, -120, 8},
                             Start{"best", 300, 9, 20, 0.1}, Start{"best", 600, -9, -20, 0.1}}) {
    begin_at(start, 24.0, world);
    const StackSpec stack = row("circuits.json", start.row, world.car);
    RaceAssembly race(world, stack);
    const RunSummary summary = race.run();
    EXPECT_EQ(summary.status, Status::finished) << start << ": " << summary.message;
    EXPECT_LT(summary.violation_s, 20.0) << start;
    EXPECT_FALSE(race.world().outside()) << start;
    EXPECT_GT(race.world().covered(), 30.0) << start;
    EXPECT_GT(race.world().state().vx, 5.0) << start;
  }
}

// The car needs four metres to slow down for a hairpin. Where plans do not reach as far, they settle too late on the
// first lap with learned tyres.
TEST(Circuits, AFastSmallCarPlansAsFarAsItBrakes) {
  const auto path = std::filesystem::path(testing::TempDir()) / "straights.json";
  std::ofstream(path)
      << R"({"half_width": 0.15, "segments": [{"line": 16}, {"arc": {"radius": 0.25, "turn": "180 deg"}},
    {"line": 16}, {"arc": {"radius": 0.25, "turn": "180 deg"}}]})";
  std::string text =
      R"({"start": {"x": 0, "y": 0, "yaw": 0, "speed": 0.1}, "laps": 3, "time_optimal_laps": null, "track": ")";
  text.append(path.string()).append("\"}");
  const std::filesystem::path worlds = testing_support::source_dir() / "worlds";
  WorldSpec world = world_from(merge(load_json(worlds / "ethz.json"), parse_text(text, "straights", worlds)));
  const StackSpec stack = row("circuits_1_43.json", "best", world.car);
  RaceAssembly race(world, stack);
  const RunSummary summary = race.run();
  ASSERT_EQ(summary.status, Status::finished) << summary.message;
  EXPECT_NEAR(summary.laps[1], summary.laps[2], 0.005 * summary.laps[2]);
}

/// The road of experiments/ethz_wet_patch.json: its limit, with the stretch slippery, is 7.1125 s.
TEST(Circuits, ASlipperyStretchMetOnceIsDrivenAtItsLimit) {
  const std::filesystem::path worlds = testing_support::source_dir() / "worlds";
  const Node patch = parse_text(R"({"laps": 5, "friction": {"points": [{"t": 0, "factor": 1}],
      "patches": [{"from_s": 9.0, "to_s": 12.57, "factor": 0.7, "from_t": 15}]}})",
                                "wet", worlds);
  WorldSpec world = world_from(merge(load_json(worlds / "ethz.json"), patch));
  const StackSpec stack = row("shared/limit_stacks.json", "best", world.car);
  RaceAssembly race(world, stack);
  const RunSummary summary = race.run();
  ASSERT_EQ(summary.status, Status::finished) << summary.message;
  EXPECT_EQ(summary.violation_s, 0.0);
  for (const std::size_t lap : {3, 4}) EXPECT_LT(summary.laps[lap], 1.015 * 7.1125) << lap;
}

TEST(Circuits, SoDoesASmallOne) {
  WorldSpec world = world_from(load_json(testing_support::source_dir() / "worlds/ethz.json"));
  begin_at({"elm", 0.8, 0, 170, 0.1}, 6.0, world);
  const StackSpec stack = row("circuits_1_43.json", "elm", world.car);
  RaceAssembly race(world, stack);
  const RunSummary summary = race.run();
  EXPECT_EQ(summary.status, Status::finished) << summary.message;
  EXPECT_FALSE(race.world().outside());
  EXPECT_GT(race.world().covered(), 2.0);
}

}  // namespace test_circuits
}  // namespace gripline
