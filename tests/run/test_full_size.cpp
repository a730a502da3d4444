// The full-size car in its worlds: the hill circuit, its walls, its sensors, and Town07 from CSV.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "config/json_file.hpp"
#include "config/merge_patch.hpp"
#include "experiment/experiment.hpp"
#include "geometry/track_file.hpp"
#include "geometry/track_import.hpp"
#include "race/assembly.hpp"
#include "support/paths.hpp"
#include "support/reference_data.hpp"
#include "support/whole_world.hpp"
#include "util/clock.hpp"

namespace gripline {
namespace test_full_size {

using testing_support::shipped_plugins;
using testing_support::world_from;

using testing::HasSubstr;

WorldSpec world_file(const std::string& name) {
  return world_from(load_json(testing_support::source_dir() / "worlds" / name));
}

/// A careful driver without anything learned.
StackSpec careful_driver(const CarFile& car, const char* mu) {
  const std::string text = R"({"model": {"plugin": "ekinematic"},
    "planner": {"plugin": "fixed_speed", "params": {"mu": )" +
                           std::string(mu) + R"(, "tyre_B": 10, "tyre_C": 1.5}},
    "controller": {"plugin": "pure_pursuit",
                   "params": {"horizon": 60, "lookahead_time": 0.3, "k_p": 1.5, "k_i": 0.1, "k_yaw": 0.02}}})";
  Errors errors;
  StackSpec spec = read_stack("careful", parse_text(text), shipped_plugins(), car, errors);
  errors.throw_if_any();
  return spec;
}

RunSummary drive(const WorldSpec& spec, const StackSpec& driver, std::uint64_t seed) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
  return RaceAssembly(spec, driver, {.seed = seed, .folder = folder}).run();
}
RunSummary race(const WorldSpec& spec, const char* mu, std::uint64_t seed = 1) {
  return drive(spec, careful_driver(spec.car, mu), seed);
}

TEST(FullSize, HillCircuitIsWhatItsNoteSays) {
  const Track hill = load_track(testing_support::source_dir() / "worlds/tracks/hill.json");
  EXPECT_NEAR(hill.length(), 1176.0, 0.5);
  EXPECT_DOUBLE_EQ(hill.narrowest(), 9.0);
  double steepest = 0.0;
  double bank = 0.0;
  double kappa = 0.0;
  double height = 0.0;
  double top = 0.0;
  const double step = 0.05;
  for (double s = 0.0; s < hill.length(); s += step) {
    steepest = std::max(steepest, std::abs(std::tan(hill.grade(s))));
    bank = std::max(bank, std::abs(hill.bank(s)));
    kappa = std::max(kappa, std::abs(hill.at(s).kappa));
    height += step * std::tan(hill.grade(s));
    top = std::max(top, height);
  }
  EXPECT_NEAR(steepest, 0.08, 1e-4);
  EXPECT_NEAR(bank, 5.0 * std::numbers::pi / 180.0, 1e-6);
  EXPECT_NEAR(1.0 / kappa, 22.0, 1e-9);
  EXPECT_NEAR(height, 0.0, 0.01);
  EXPECT_GT(top, 15.0);
}

TEST(FullSize, CarefulLapsOnTheHill) {
  WorldSpec spec = world_file("full_size.json");
  spec.duration = 120.0;
  const RunSummary summary = race(spec, "0.5");
  EXPECT_EQ(summary.status, Status::finished) << summary.message;
  ASSERT_EQ(summary.laps.size(), 2u);
  EXPECT_EQ(summary.violation_s, 0.0);
  EXPECT_LT(summary.mean_deviation_m.value(), 0.6);
  EXPECT_LT(summary.laps[1], summary.laps[0]);
  EXPECT_GT(summary.laps[1], 45.0);
}

TEST(FullSize, TooFastHitsTheWallAndSaysWhere) {
  const WorldSpec spec = world_file("full_size.json");
  const RunSummary summary = race(spec, "1.3");
  EXPECT_EQ(summary.status, Status::crashed);
  EXPECT_THAT(summary.message, HasSubstr("hit the wall at s = "));
  EXPECT_THAT(summary.message, HasSubstr("m/s"));
  EXPECT_GT(summary.violation_s, 0.0);
}

struct FarOff {
  double y, yaw_deg, speed;  // of the start, from the centre line [m, deg, m/s]
};
/// From anywhere on a road that it knows nothing of, a stack joins its line without leaving the road.
TEST(FullSize, JoinsTheLineFromFarOffOnAnotherCircuit) {
  WorldSpec world = world_file("full_size_street.json");
  world.laps = 0;
  world.duration = 14.0;
  Errors errors;
  const Node stacks = load_json(testing_support::source_dir() / "experiments/shared/full_size_stacks.json");
  const Node best = merge(*stacks.find("base"), *stacks.find("stacks")->find("best"));
  const StackSpec stack = read_stack("best", best, shipped_plugins(), world.car, errors);
  errors.throw_if_any();
  for (const FarOff& start :
       {FarOff{4, 0, 0.1}, FarOff{4, 30, 5}, FarOff{-4, 0, 20}, FarOff{4, -30, 15}, FarOff{0, -30, 10}}) {
    world.start.y = start.y;
    world.start.yaw = start.yaw_deg * std::numbers::pi / 180.0;
    world.start_speed = start.speed;
    const RunSummary summary = drive(world, stack, 1);
    EXPECT_EQ(summary.status, Status::finished) << summary.message;
    EXPECT_EQ(summary.violation_s, 0.0) << start.y << " m, " << start.yaw_deg << " deg, " << start.speed << " m/s";
  }
}

TEST(FullSize, SensorsShowSlopeAndNoiseAsStated) {
  const WorldSpec spec = world_file("full_size.json");
  World world(spec, 3);
  World again(spec, 3);
  World other(spec, 4);
  double squares[6] = {};
  const int steps = 2000;
  bool differs = false;
  for (int k = 0; k < steps; ++k) {
    const Input u{0.05, 0.0};
    world.advance(u);
    again.advance(u);
    other.advance(u);
    const State& seen = world.observe().x;
    const State& real = world.state();
    const double error[6] = {seen.x - real.x,   seen.y - real.y,   seen.yaw - real.yaw,
                             seen.vx - real.vx, seen.vy - real.vy, seen.omega - real.omega};
    for (int i = 0; i < 6; ++i) squares[i] += error[i] * error[i];
    ASSERT_EQ(seen.vx, again.observe().x.vx);
    differs = differs || seen.vx != other.observe().x.vx;
    EXPECT_NEAR(world.observe().at.grade, world.track().grade(world.observe().at.s), 1e-12);
    EXPECT_NEAR(world.observe().at.bank, world.track().bank(world.observe().at.s), 1e-12);
    if (world.crashed()) break;
  }
  EXPECT_TRUE(differs);
  const double degree = std::numbers::pi / 180.0;
  const double stated[6] = {0.02, 0.02, 0.2 * degree, 0.05, 0.05, 0.2 * degree};
  for (int i = 0; i < 6; ++i)
    EXPECT_NEAR(std::sqrt(squares[i] / static_cast<double>(world.step())), stated[i], 0.1 * stated[i]) << i;
}

/// The nominal model's straight-line acceleration against the plant's own.
TEST(FullSize, KnownThrottleAndBrakeMapIsTheCarsOwn) {
  const WorldSpec spec = world_file("full_size.json");
  struct Plane final : Ground {
    Patch at(double, double, double) const override { return {}; }
  };
  const Plane plane;
  const PluginEntry& entry = shipped_plugins().find(abi::Kind::plant, "double_track");
  const auto plant = create<Plant>(entry, PluginContext{}, spec.plant.values);
  /// Acceleration at a speed with everything settled and no change of gear near, and that speed.
  const auto plant_rate = [&](double v, double d) {
    State x;
    x.vx = v;
    plant->reset(x, plane);
    for (int k = 0; k < 20; ++k) x = plant->advance(d, 0.0, 0.02, plane);
    const double before = x.vx;
    for (int k = 0; k < 5; ++k) x = plant->advance(d, 0.0, 0.02, plane);
    return std::pair{(x.vx - before) / 0.1, 0.5 * (before + x.vx)};
  };
  Errors errors;
  const StackSpec stack = read_stack("known", parse_text(R"({"model": {"plugin": "ekinematic"},
    "planner": {"plugin": "fixed_speed"}, "controller": {"plugin": "pure_pursuit"}})"),
                                     shipped_plugins(), spec.car, errors);
  errors.throw_if_any();
  PluginContext context;
  context.car = spec.car.car;
  context.dt = spec.dt;
  const Vehicle vehicle(stack.model, context);
  CorrectedModel model(vehicle.car(), {spec.dt, spec.hold, stack.model.integration});
  for (const double d : {1.0, 0.5, 0.0, -0.3, -0.7})
    for (const double v : {18.0, 21.0, 24.0, 33.0, 36.0, 40.0}) {
      const auto [rate, speed] = plant_rate(v, d);
      State x;
      x.vx = speed;
      EXPECT_NEAR(model.rates(x, {d, 0.0}, Place{}).vx, rate, 0.06 + 0.06 * std::abs(rate)) << v << " m/s, d = " << d;
    }
}

/// A row of experiments/full_size_wear.json for as long as the test wants.
RunSummary row_of_wear(const std::string& row, double duration) {
  const std::filesystem::path file = testing_support::source_dir() / "experiments/full_size_wear.json";
  RaceSpec race = read_race(file, load_experiment(file, {}), shipped_plugins());
  race.world.duration = duration;
  for (const StackSpec& stack : race.stacks)
    if (stack.name == row) return drive(race.world, stack, race.seeds.front());
  throw std::invalid_argument("no row " + row);
}

TEST(FullSize, TheLearnedStackStaysOnTheRoadAndKnowsItsGrip) {
  const RunSummary best = row_of_wear("best", 75.0);
  EXPECT_EQ(best.status, Status::finished) << best.message;
  ASSERT_EQ(best.laps.size(), 1u);
  EXPECT_EQ(best.violation_s, 0.0);
  EXPECT_LT(best.mean_deviation_m.value(), 0.1);
  EXPECT_LT(best.mu_rmse.value(), 0.08);
  EXPECT_LT(best.hilly_deviation_m.value(), best.mean_deviation_m.value());
  const RunSummary again = row_of_wear("best", 75.0);
  EXPECT_EQ(again.mean_deviation_m, best.mean_deviation_m);
}

TEST(FullSize, WithoutLearningTheCarIsLostOncePlansAreMadeForFreshTyres) {
  const RunSummary none = row_of_wear("none", 75.0);
  EXPECT_GT(none.violation_s, 0.0);
}

TEST(FullSize, WorldStepIsFastWithTheRoadAskedAtEveryWheel) {
#if defined(__SANITIZE_ADDRESS__)
  GTEST_SKIP() << "built with sanitizers";
#endif
  const WorldSpec spec = world_file("full_size_wet.json");
  World world(spec, 1);
  const double begin = thread_cpu_s();
  for (int k = 0; k < 300; ++k) world.advance({0.2, 0.0});
  EXPECT_LT(thread_cpu_s() - begin, 300 * 0.02 / 100.0);
}

class FullSizeTown : public testing_support::WithReference {};

/// Town07's centre line, edges and slope profile as one CSV in the TUM convention, driven with its slope.
TEST_F(FullSizeTown, DrivesTown07FromCsvWithItsSlope) {
  TrackShape shape = shape_from_table(read_csv(reference("track_carla.csv")), {.left_handed = true});
  const CsvTable line = read_csv(reference("raceline_carla_tum.csv"));
  const CsvTable slope = read_csv(reference("carla_slope_profile.csv"));
  const std::vector<double> x = line.column("x_m");
  const std::vector<double> y = line.column("y_m");
  std::vector<PlanePoint> points;
  for (std::size_t i = 0; i < x.size(); ++i) points.push_back({x[i], -y[i]});
  drop_closing_point_and_check_closed(points);
  shape.grade =
      grade_from_heights(shape.centre, ClosedCurve::from_points(points), slope.column("s_m"), slope.column("z_m"));
  const std::filesystem::path csv = std::filesystem::path(testing::TempDir()) / "town07.csv";
  {
    std::ofstream out(csv);
    write_track_csv(out, Track(std::move(shape)), 2.0);
  }
  const std::string world = R"({"car": "cars/full_size.json", "track": ")" + csv.string() +
                            R"(", "plant": {"plugin": "double_track"}, "laps": 1, "timeout": 120})";
  const WorldSpec spec = world_from(parse_text(world, "town07", testing_support::source_dir() / "worlds"));
  EXPECT_NEAR(spec.track->length(), 1232.0, 1.0);
  double steepest = 0.0;
  for (double s = 0.0; s < spec.track->length(); s += 1.0)
    steepest = std::max(steepest, std::abs(spec.track->grade(s)));
  EXPECT_GT(steepest, 0.07);
  const RunSummary summary = race(spec, "0.35");
  EXPECT_EQ(summary.status, Status::finished) << summary.message;
  EXPECT_EQ(summary.violation_s, 0.0);
  ASSERT_EQ(summary.laps.size(), 1u);
  EXPECT_GT(summary.laps[0], 45.0);  // the published lap at twice the grip
  EXPECT_LT(summary.laps[0], 110.0);
}

std::string refusal(const std::string& world) {
  try {
    world_from(parse_text(world, "world", testing_support::source_dir() / "worlds"));
  } catch (const std::exception& error) {
    return error.what();
  }
  return "nothing";
}

TEST(FullSizeBadInput, RoadCarAndSensors) {
  const std::string car = R"("car": "cars/full_size.json", "plant": {"plugin": "double_track"}, "duration": 10)";
  const std::string road = R"("segments": [{"line": 100}, {"arc": {"radius": 30, "turn": "180 deg"}}, {"line": 100},
                               {"arc": {"radius": 30, "turn": "180 deg"}}])";
  EXPECT_EQ(refusal("{" + car + R"(, "track": {"half_width": 4, )" + road + "}}"), "nothing");
  EXPECT_THAT(refusal("{" + car +
                      R"(, "track": {"half_width": 4, "grade": [{"s": 0, "grade": 0.05}, {"s": 150, "grade": 0}], )" +
                      road + "}}"),
              HasSubstr("the grade does not close"));
  EXPECT_THAT(refusal("{" + car + R"(, "track": {"half_width": 0.8, )" + road + "}}"),
              HasSubstr("the car is 1.84 m wide, the track only 1.6 m"));
  EXPECT_THAT(
      refusal("{" + car + R"(, "sensors": {"rate": {"x": "30 Hz"}}, "track": {"half_width": 4, )" + road + "}}"),
      HasSubstr("is not a multiple of the control step"));
}

TEST(FullSizeBadInput, TablesOfThePlant) {
  const auto with = [](const std::string& params) {
    const std::string text = R"({"car": "cars/full_size.json", "track": "tracks/hill.json", "duration": 10,
      "plant": {"plugin": "double_track", "params": {)" +
                             params + "}}}";
    try {
      const WorldSpec spec = world_from(parse_text(text, "world", testing_support::source_dir() / "worlds"));
      const World world(spec, 1);
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  EXPECT_EQ(with(R"("gears": [[1, 2, 0, 20], [2, 1, 15, 90]])"), "nothing");
  EXPECT_THAT(with(R"("gears": [[1, 2, 0, 20], [2, 1, 25, 90]])"),
              HasSubstr("/plant/params: double_track: gears has a gap"));
  EXPECT_THAT(with(R"("engine_torque": [[100, 300, 20], [400, 350, 20], [300, 340, 20]])"), HasSubstr("300"));
  EXPECT_THAT(with(R"("engine_torque": [[100, 300, 20], [400, 350, 20], [300, 340, 20]])"), HasSubstr("400"));
  EXPECT_THAT(with(R"("brake_byas": 0.6)"), HasSubstr("brake_bias"));
}

}  // namespace test_full_size
}  // namespace gripline
