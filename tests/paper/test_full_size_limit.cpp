// The laps that a full-size world states as its limit are those of the plant's own quasi-steady states.
#include <gtest/gtest.h>

#include "config/json_file.hpp"
#include "limit/envelope_car.hpp"
#include "limit/lap_limit.hpp"
#include "support/full_size_limit.hpp"
#include "support/paths.hpp"
#include "support/whole_world.hpp"
#include "world/world_spec.hpp"

namespace gripline {
namespace test_full_size_limit {

TEST(FullSizeLimit, SteadyTurnsOfThePlantReachIt) {
  const double_track::Params p;
  const testing_support::FullSizeLimit limit(p, 1.0);
  double_track::DoubleTrackCar car(p);
  struct Plane final : Ground {
    Patch at(double, double, double) const override { return {}; }
  };
  const Plane plane;
  const double radius = 80.0;
  // speed rises slowly on the circle until it can no longer be held
  State start;
  start.vx = 20.0;
  car.reset(start, plane);
  double delta = 2.64 / radius;
  double d = 0.0;
  double best = 0.0;  // share of the limit
  for (int k = 0; k < 6000; ++k) {
    const double wanted = 20.0 + 0.1 * 0.02 * k;
    const auto& z = car.motion();
    d = std::clamp(d + 0.004 * (wanted - z.vx), -0.2, 1.0);
    delta = std::clamp(delta + 0.002 * (wanted / radius - z.omega), 0.0, 0.2);
    car.advance(std::clamp(d + 0.3 * (wanted - z.vx), -1.0, 1.0), delta, 0.02, plane);
    const double v = z.vx;
    const double most = testing_support::FullSizeLimit::largest(
        20.0, [&](double a) { return limit.holds(v, a, limit.resistance(v), {}); });
    best = std::max(best, v * z.omega / most);
  }
  EXPECT_LT(best, 1.02);  // steered drive forces push sideways too
  EXPECT_GT(best, 0.97);  // slip losses are left out of the limit
}

TEST(FullSizeLimit, WorldsStateTheirLimit) {
  const WorldSpec world =
      testing_support::world_from(load_json(testing_support::source_dir() / "worlds/full_size_wear.json"));
  ASSERT_GE(world.time_optimal.laps.size(), 4u);
  const auto line = testing_support::line_of_the_centre_of_gravity(*world.track, world.car.car);
  for (const auto& [factor, lap] : world.time_optimal.laps) {
    const double computed = testing_support::FullSizeLimit({}, factor).lap(line, *world.track);
    EXPECT_NEAR(computed, lap, 0.02) << factor;
  }
}

WorldSpec hill() {
  return testing_support::world_from(load_json(testing_support::source_dir() / "worlds/full_size.json"));
}

/// What is measured by driving the plant is what its own loads and tyres say, less what slip costs in turns.
TEST(FullSizeLimit, MeasuredEnvelopeIsThePlants) {
  const WorldSpec world = hill();
  for (const double factor : {1.0, 0.7}) {
    const PlantEnvelope e = EnvelopeCar(world, factor, false).envelope();
    const testing_support::FullSizeLimit limit({}, factor);
    for (const double v : {12.0, 25.0, 45.0, 60.0}) {
      const double side = limit.largest(40.0, [&](double a) { return limit.holds(v, a, 0.0, {}); });
      const double brake = limit.largest(3e4, [&](double Fx) { return limit.holds(v, 0.0, -Fx, {}); });
      EXPECT_NEAR(e.side.at(v, 1.0), side, 0.04 * side) << factor << " " << v;
      EXPECT_NEAR(e.brake.at(v, 1.0), brake / limit.effective_mass(), 0.08 * brake / limit.effective_mass())
          << factor << " " << v;
      const double brakes = double_track::Params().brake_torque / double_track::Params().radius;
      EXPECT_NEAR(e.brakes.at(v), std::min(brake, brakes) / limit.effective_mass(), 0.03 * e.brakes.at(v)) << v;
      EXPECT_NEAR(e.rolling.at(v), -limit.resistance(v) / limit.effective_mass(), 0.6) << v;  // the engine drags too
    }
  }
}

/// On the line of the limit's lap the plant's quasi-steady states are as fast: slip losses apart.
TEST(FullSizeLimit, TimeOptimalLapOfTheEnvelopeIsTheQuasiSteadyOneOfItsLine) {
  const WorldSpec world = hill();
  const Track& track = *world.track;
  const FastestLap fastest = find_fastest_lap(world, {1.0, false, false});
  const Lap& lap = fastest.lap;
  const LapMesh& mesh = fastest.mesh;
  // Curvature half-way through an interval: at nodes it alternates about that, which costs the program nothing.
  const auto bend = [&](std::size_t k) {
    const auto &a = lap.z[k % mesh.size()], &b = lap.z[(k + 1) % mesh.size()];
    return (a[lap_omega] + b[lap_omega]) / (a[lap_vx] + b[lap_vx]);
  };
  std::vector<LinePoint> line;
  double way = 0;
  for (std::size_t k = 0; k < mesh.size(); ++k) {
    const std::size_t next = (k + 1) % mesh.size();
    const auto &a = lap.z[k], &b = lap.z[next];
    const CurvePoint p = track.at(mesh.s[k]), q = track.at(mesh.s[next]);
    const auto x = [](const CurvePoint& c, double n) { return c.x - n * std::sin(c.yaw); };
    const auto y = [](const CurvePoint& c, double n) { return c.y + n * std::cos(c.yaw); };
    const double length = std::hypot(x(q, b[lap_n]) - x(p, a[lap_n]), y(q, b[lap_n]) - y(p, a[lap_n]));
    while (static_cast<double>(line.size()) < way + length) {
      const double share = (static_cast<double>(line.size()) - way) / length;
      const auto mix = [share](double from, double to) { return from + share * (to - from); };
      const double n = mix(a[lap_n], b[lap_n]), s = track.wrap(mesh.s[k] + share * mesh.ds[k]);
      const CurvePoint c = track.at(s);
      LinePoint point;
      point.s = static_cast<double>(line.size());
      point.x = x(c, n);
      point.y = y(c, n);
      point.kappa = share < 0.5 ? (0.5 - share) * bend(k + mesh.size() - 1) + (0.5 + share) * bend(k)
                                : (1.5 - share) * bend(k) + (share - 0.5) * bend(k + 1);
      point.grade = track.grade(s);
      point.bank = track.bank(s);
      line.push_back(point);
    }
    way += length;
  }
  const double quasi_steady = testing_support::FullSizeLimit({}, 1.0).lap(line, track);
  std::printf("time-optimal on the envelope %.2f s, quasi-steady on its line %.2f s\n", fastest.limit.lap_s,
              quasi_steady);
  EXPECT_NEAR(fastest.limit.lap_s, quasi_steady, 0.03 * quasi_steady);
}

}  // namespace test_full_size_limit
}  // namespace gripline
