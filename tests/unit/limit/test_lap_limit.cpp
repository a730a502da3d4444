#include "limit/lap_limit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <optional>
#include <stdexcept>
#include <vector>

#include "limit/lap_nlp.hpp"
#include "limit/limit_table.hpp"
#include "limit/starting_line.hpp"
#include "limit/true_plant.hpp"
#include "support/host_support.hpp"
#include "util/child_process.hpp"
#include "util/csv.hpp"
#include "world/world.hpp"

namespace gripline {
namespace test_lap_limit {

using testing::HasSubstr;
using namespace testing_support;

/// A corner of a car somewhere on the oval, by the formula and by the track.
TEST(LapLimit, OffsetOfACornerIsTheTracks) {
  const WorldSpec world = world_of();
  const Track& track = *world.track;
  for (const double s : {0.7, 3.1, 3.9, 5.5, 7.8}) {
    const CurvePoint p = track.at(s);
    for (const double n : {-0.2, 0.0, 0.25})
      for (const double xi : {-0.4, 0.0, 0.3}) {
        const double forward = 0.03, left = -0.015, yaw = p.yaw + xi;
        const double x = p.x - n * std::sin(p.yaw) + forward * std::cos(yaw) - left * std::sin(yaw);
        const double y = p.y + n * std::cos(p.yaw) + forward * std::sin(yaw) + left * std::cos(yaw);
        EXPECT_NEAR(offset_of_corner(n, xi, p.kappa, forward, left), track.locate(x, y).n, 1e-9) << s << " " << n;
      }
  }
}

TEST(LapLimit, ThePlantIsTheWorldsAtAFactor) {
  const WorldSpec spec = world_of(R"({"friction": [{"t": 0, "factor": 0.7}]})");
  const TruePlant fresh(spec, 1.0), worn(spec, 0.5);
  EXPECT_NEAR(fresh.mu(), (0.192 + 0.1737) / (0.041 * 9.81), 1e-6);
  EXPECT_NEAR(worn.mu(), 0.5 * fresh.mu(), 1e-9);
  EXPECT_GT(fresh.acceleration(1.0, 1.0), 4.0);  // Cm1 d - Cm2 v d - rolling over m
  EXPECT_LT(fresh.acceleration(2.0, -0.1), -1.0);
}

class OvalLimit : public testing::Test {
 protected:
  static LapLimit limit(double factor, bool body) {
    static const WorldSpec world = world_of();
    return find_lap_limit(world, {factor, body});
  }
};

TEST_F(OvalLimit, LessGripAndLessRoomAreSlower) {
  const LapLimit fresh = limit(1.0, false), worn = limit(0.7, false), body = limit(1.0, true);
  for (const LapLimit& one : {fresh, worn, body}) EXPECT_LE(one.error_s, lap_limit_tolerance * one.lap_s);
  EXPECT_GT(worn.lap_s, 1.05 * fresh.lap_s);
  EXPECT_GT(body.lap_s, fresh.lap_s + body.error_s);
  EXPECT_LT(body.lap_s, 1.1 * fresh.lap_s);
  // At best two straights at top speed and two half circles of the widest radius at the friction limit; at worst the
  // centre line at the friction limit of its turns.
  const double g = 9.81, mu = 0.909;
  EXPECT_GT(fresh.lap_s, 2 * 2 / 4.21 + 2 * 3.1416 * 0.5 / std::sqrt(mu * g * 1.1));
  EXPECT_LT(fresh.lap_s, 9.03 / std::sqrt(mu * g * 0.8));
}

/// Patches that cover the road are the road at their factor; one that covers half of it lies between.
TEST_F(OvalLimit, PatchesMultiplyTheFactorWhereTheyAre) {
  const auto with = [](const std::string& patches) {
    return world_of(R"({"friction": {"points": [{"t": 0, "factor": 0.9}], "patches": [)" + patches + "]}}");
  };
  const std::string length = number_text(world_of().track->length());
  const WorldSpec all =
      with(R"({"from_s": 0, "to_s": 4, "factor": 0.7}, {"from_s": 4, "to_s": )" + length + R"(, "factor": 0.7})");
  const WorldSpec half = with(R"({"from_s": 0, "to_s": 4, "factor": 0.7, "from_t": 15})");
  const LapLimit fresh = limit(1.0, false), worn = limit(0.7, false);
  const LapLimit covered = find_lap_limit(all, {1.0, false, true}), patched = find_lap_limit(half, {1.0, false, true});
  EXPECT_TRUE(patched.patches);
  EXPECT_NEAR(covered.lap_s, worn.lap_s, covered.error_s + worn.error_s);
  EXPECT_GT(patched.lap_s, fresh.lap_s + 0.2 * (worn.lap_s - fresh.lap_s));
  EXPECT_LT(patched.lap_s, fresh.lap_s + 0.8 * (worn.lap_s - fresh.lap_s));
  EXPECT_EQ(find_lap_limit(half, {1.0, false}).lap_s, fresh.lap_s);
  const TruePlant plant(half, 0.5, true);
  EXPECT_EQ(plant.factor_at(3.9), 0.5 * 0.7);
  EXPECT_EQ(plant.factor_at(4.1), 0.5);
}

/// The lap is one that the car can drive: the plant, integrated in time under the lap's commands, goes where it says.
TEST_F(OvalLimit, ItsCommandsDriveIt) {
  static const WorldSpec world = world_of();
  const FastestLap fastest = find_fastest_lap(world, {1.0, false});
  const Lap& lap = fastest.lap;
  const LapMesh& mesh = fastest.mesh;
  const TruePlant plant(world, 1.0);
  const Track& track = *world.track;
  const auto pose = [&](std::size_t k) {
    const CurvePoint p = track.at(mesh.s[k]);
    const auto& z = lap.z[k];
    return std::array<double, 6>{p.x - z[lap_n] * std::sin(p.yaw),
                                 p.y + z[lap_n] * std::cos(p.yaw),
                                 p.yaw + z[lap_xi],
                                 z[lap_vx],
                                 z[lap_vy],
                                 z[lap_omega]};
  };
  double largest = 0;
  const std::size_t pieces = 12, count = mesh.size();
  for (std::size_t piece = 0; piece < pieces; ++piece) {
    const std::size_t from = piece * count / pieces;
    std::array<double, 6> x = pose(from);
    for (std::size_t k = from; k < from + count / 24; ++k) {
      const auto &z = lap.z[k % count], &next = lap.z[(k + 1) % count];
      double middle[lap_variables];
      for (int j = 0; j < lap_states; ++j) middle[j] = 0.5 * (z[j] + next[j]);
      const double i = k % count,
                   along = middle[lap_vx] * std::cos(middle[lap_xi]) - middle[lap_vy] * std::sin(middle[lap_xi]);
      const auto at = static_cast<std::size_t>(i);
      const double time = mesh.ds[at] * (1 - mesh.kappa[at] * middle[lap_n]) / along;
      constexpr int substeps = 20;
      for (int step = 0; step < substeps; ++step) {
        const double delta = z[lap_delta] + (next[lap_delta] - z[lap_delta]) * (step + 0.5) / substeps;
        const ActingCommand<double> u{z[lap_d], delta, z[lap_rate]};
        const Place flat;
        std::array<double, 6> rate{}, half{}, half_rate{};
        plant.rates<double>(x, {&u, 1}, {&flat, 1}, rate);
        for (std::size_t j = 0; j < 6; ++j) half[j] = x[j] + 0.5 * time / substeps * rate[j];
        plant.rates<double>(half, {&u, 1}, {&flat, 1}, half_rate);
        for (std::size_t j = 0; j < 6; ++j) x[j] += time / substeps * half_rate[j];
      }
    }
    const std::array<double, 6> end = pose((from + count / 24) % count);
    largest = std::max(largest, std::hypot(end[0] - x[0], end[1] - x[1]));
  }
  EXPECT_LT(largest, 0.01);  // of 0.4 m driven each time
  for (std::size_t k = 0; k < count; ++k) EXPECT_LT(std::abs(lap.z[k][lap_n]), 0.3 + 1e-6);
}

TEST(LimitTable, IsKeptAndReadByAWorld) {
  const Folder folder;
  const WorldSpec world = world_of();
  LimitRequest request;
  request.factors = {1.0, 0.9};
  request.jobs = 2;
  request.cache = folder / "cache";
  request.key = "oval";
  std::size_t done = 0;
  const auto count = [&](std::size_t now, std::size_t) { done = std::max(done, now); };
  const std::vector<LapLimit> limits = compute_limits(world, request, count);
  ASSERT_EQ(limits.size(), 2u);
  EXPECT_EQ(limits[0].factor, 0.9);  // they rise
  EXPECT_EQ(done, 2u);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(request.cache), {}), 2);
  bool started = false;
  const std::vector<LapLimit> again = compute_limits(world, request, [&](std::size_t, std::size_t) { started = true; });
  EXPECT_FALSE(started);  // from the cache
  EXPECT_EQ(again[1].lap_s, limits[1].lap_s);
  write_limits(folder / "oval.csv", limits);
  EXPECT_EQ(lines(folder / "oval.csv").at(0), "factor,lap_s,error_s,body");
  const WorldSpec reads = world_of("{\"time_optimal_laps\": \"" + (folder / "oval.csv").string() + "\"}");
  EXPECT_NEAR(reads.time_optimal.at(0.95).value(), 0.5 * (limits[0].lap_s + limits[1].lap_s), 1e-9);
  EXPECT_NEAR(reads.time_optimal.error, std::max(limits[0].error_s, limits[1].error_s), 1e-12);
  EXPECT_TRUE(reads.time_optimal_body.laps.empty());
  std::vector<LapLimit> bodies = limits;
  bodies.insert(bodies.end(), limits.begin(), limits.end());
  for (std::size_t i = 2; i < 4; ++i) bodies[i].body = true, bodies[i].lap_s += 0.25, bodies[i].error_s = 0.125;
  write_limits(folder / "bodies.csv", bodies);
  const WorldSpec both = world_of("{\"time_optimal_laps\": \"" + (folder / "bodies.csv").string() + "\"}");
  EXPECT_NEAR(both.time_optimal.at(0.9).value(), limits[0].lap_s, 1e-9);
  EXPECT_NEAR(both.time_optimal_body.at(0.9).value(), limits[0].lap_s + 0.25, 1e-9);
  EXPECT_EQ(both.time_optimal_body.error, 0.125);
  EXPECT_LT(both.time_optimal.error, 0.125);
  std::vector<LapLimit> patched = limits;
  patched[0].patches = true;
  write_limits(folder / "patched.csv", patched);
  EXPECT_EQ(lines(folder / "patched.csv").at(0), "factor,lap_s,error_s,body,patches");
  EXPECT_THAT(refusal([&] { world_of("{\"time_optimal_laps\": \"" + (folder / "patched.csv").string() + "\"}"); }),
              HasSubstr("--patches"));
  write_text(folder / "bad.csv", "factor,lap\n1,2\n");
  EXPECT_THAT(refusal([&] { world_of("{\"time_optimal_laps\": \"" + (folder / "bad.csv").string() + "\"}"); }),
              HasSubstr("lap_s"));
}

/// As `env --ignore-signal=CHLD` leaves it: there is no status to collect, and no process stays.
TEST(LimitTable, IsMadeWhereTheEndOfChildrenIsIgnored) {
  LimitRequest request;
  request.factors = {1.0};
  const auto before = std::signal(SIGCHLD, SIG_IGN);
  std::vector<LapLimit> limits;
  EXPECT_NO_THROW(limits = compute_limits(world_of(), request, [](std::size_t, std::size_t) {}));
  EXPECT_EQ(std::signal(SIGCHLD, before), SIG_IGN);
  EXPECT_EQ(limits.size(), 1u);
}

/// A process that somebody else started, and that ended meanwhile, is left to who waits for it.
TEST(LimitTable, CollectsNoOtherProcess) {
  const pid_t other = fork_process();
  if (other == 0) _exit(7);
  LimitRequest request;
  request.factors = {1.0};
  EXPECT_EQ(compute_limits(world_of(), request, [](std::size_t, std::size_t) {}).size(), 1u);
  const std::optional<int> status = wait_for_end(other);
  ASSERT_TRUE(status.has_value());
  EXPECT_EQ(describe_end(*status), "ended with exit code 7");
}

/// What fails while processes run, as the start of another one may, leaves none behind.
TEST(LimitTable, AnErrorEndsTheProcessesThatRun) {
  LimitRequest request;
  request.factors = {0.8, 0.9, 1.0};
  request.jobs = 2;
  const auto fails = [](std::size_t, std::size_t) { throw std::runtime_error("no more"); };
  EXPECT_THROW(compute_limits(world_of(), request, fails), std::runtime_error);
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1) << "a process was left";
  EXPECT_EQ(errno, ECHILD);
}

}  // namespace test_lap_limit
}  // namespace gripline
