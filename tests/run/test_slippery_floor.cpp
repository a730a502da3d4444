// The 1:10 car of worlds/dart.json on a floor that got slippery: its tyres alone are fitted, from the model of a dry
// floor. Logs are simulated with tyres, drive and delays that no file here names, and written as its motion capture and
// its logger write them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <random>
#include <sstream>

#include "calibrate/fit/unknowns.hpp"
#include "config/json_file.hpp"
#include "support/calibrate_rig.hpp"
#include "support/paths.hpp"
#include "support/program.hpp"

namespace gripline {
namespace test_slippery_floor {

using namespace testing_support;

/// The car with a friction of its own.
Node true_car(double friction) {
  Node world = parse_file(source_dir() / "worlds/dart.json");
  inline_world_files(world);
  const double grip = friction * 1.58 * gravity / 2.0;
  for (const auto& [pointer, value] : {std::pair("/plant/params/Df", 1.04 * grip),
                                       {"/plant/params/Dr", 0.96 * grip},
                                       {"/plant/params/Bf", 4.1},
                                       {"/plant/params/Br", 6.9},
                                       {"/plant/params/Cm1", 15.0},
                                       {"/plant/params/Cr0", 1.5},
                                       {"/plant/effects/throttle_dead_zone/params/z", 0.13},
                                       {"/plant/effects/steer_map/params/g", 0.9},
                                       {"/plant/effects/steer_offset/params/d0", 0.015}})
    calibrate::set_value(world, pointer, value);
  return world;
}

/// A driver's commands: throttle and steering as the logger's columns have them.
CommandSample<double> driver(double t, double throttle) {
  return {throttle + 0.1 * std::sin(0.7 * t) + 0.06 * std::sin(1.9 * t),
          0.55 * std::sin(0.9 * t) + 0.3 * std::sin(2.3 * t + 1.0)};
}

/// 100 Hz: the pose of a marker with 0.3 mm and 1 mrad of noise, 25 ms late; velocities by its differences over 40 ms;
/// commands read ten times a second.
void write_log(const std::filesystem::path& file, double friction, double throttle, double seconds, unsigned seed) {
  const test::CalibrateRig car(true_car(friction));
  const measured::Session s = test::drive(car.vehicle.car(), {.seconds = seconds, .dt = 0.01, .command = [&](double t) {
                                                                const auto now = driver(t, throttle);
                                                                return CommandSample<double>{now.d, 0.45 * now.delta};
                                                              }});
  constexpr double late = 0.025, ahead = 0.022;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<std::array<double, 3>> pose;
  for (std::size_t i = 0; i < s.rows(); ++i) {
    std::array<double, 3> p{};
    const double t = std::max(s.t[i] - late, s.t.front());
    for (std::size_t c = 0; c < 3; ++c) p[c] = s.interpolate(c, t);
    p[0] += ahead * std::cos(p[2]) + 3e-4 * normal(random);
    p[1] += ahead * std::sin(p[2]) + 3e-4 * normal(random);
    p[2] += 1e-3 * normal(random);
    pose.push_back(p);
  }
  std::ofstream out(file);
  out.precision(9);
  out << "t_s,x_m,y_m,yaw_rad,vx_mps,vy_mps,yaw_rate_radps,throttle_norm,steer_cmd_norm,drive_enabled,pose_valid\n";
  CommandSample<double> shown{};
  for (std::size_t i = 2; i + 2 < pose.size(); ++i) {
    if (i % 10 == 2) shown = driver(s.t[i], throttle);
    const auto rate = [&](std::size_t c) { return (pose[i + 2][c] - pose[i - 2][c]) / 0.04; };
    const double c = std::cos(pose[i][2]), q = std::sin(pose[i][2]);
    out << s.t[i] << ',' << pose[i][0] << ',' << pose[i][1] << ',' << std::remainder(pose[i][2], 2 * std::numbers::pi)
        << ',' << c * rate(0) + q * rate(1) << ',' << c * rate(1) - q * rate(0) << ',' << rate(2) << ',' << shown.d
        << ',' << shown.delta << ",1,1\n";
  }
}

TEST(SlipperyFloor, FrictionIsReadFromTheModelOfADryFloor) {
  const Folder folder;
  const std::string world = source_dir() / "worlds/dart.json", map = source_dir() / "experiments/real/maps/dart.json";
  const auto in = [&](const char* name) { return (folder / name).string(); };
  write_log(in("dry.csv"), 0.78, 0.45, 60.0, 1);
  const Outcome dry =
      gripline_with({"fit", world, in("dry.csv"), "--map", map, "--out", in("dry.json"), "--starts", "100", "--quiet"});
  ASSERT_EQ(dry.code, 0) << dry.err;
  for (const double friction : {0.35, 0.44}) {
    write_log(in("wet.csv"), friction, 0.36, 60.0, 2);
    const Outcome wet = gripline_with(
        {"fit", in("dry.json"), in("wet.csv"), "--map", map, "--out", in("wet.json"), "--fit", "tyres", "--quiet"});
    ASSERT_EQ(wet.code, 0) << wet.err;
    const Node fitted = parse_file(in("wet.json"));
    EXPECT_NEAR(find_pointer(fitted, "/calibration/friction/total")->number(), friction, 0.05) << wet.out;
  }
}

}  // namespace test_slippery_floor
}  // namespace gripline
