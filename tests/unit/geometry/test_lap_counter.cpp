#include "geometry/lap_counter.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "geometry/track_file.hpp"
#include "support/paths.hpp"

namespace gripline {
namespace test_lap_counter {

Track shipped(const std::string& name) { return load_track(testing_support::source_dir() / "worlds/tracks" / name); }

PlanePoint place(const Track& track, double s, double n) {
  const CurvePoint at = track.at(s);
  return {at.x - n * std::sin(at.yaw), at.y + n * std::cos(at.yaw)};
}

/// Drives along the centre line at offset n and speed v (by station) from the start; returns the ends of laps.
class Drive {
 public:
  Drive(const Track& track, double n) : track_(track), n_(n), counter_(track, track.start()), s_(counter_.place().s) {}

  void go(double way, double v) {
    const double end = s_ + way, step = (way < 0.0 ? -1.0 : 1.0) * v * 0.02;
    while ((end - s_) * step > 0.0) {
      s_ += step;
      t_ += 0.02;
      const PlanePoint p = place(track_, s_, n_);
      if (const auto ended = counter_.advance(t_, p.x, p.y)) ends.push_back(*ended);
    }
  }
  LapCounter& counter() { return counter_; }
  double t() const { return t_; }
  double s() const { return s_; }
  std::vector<double> ends;

 private:
  const Track& track_;
  double n_;
  LapCounter counter_;
  double s_, t_ = 0.0;
};

TEST(LapCounter, TimesAreInterpolatedWithinTheStep) {
  for (const char* name : {"ethz.json", "ethz_mobil.json"}) {
    const Track track = shipped(name);
    for (const double n : {0.0, 0.14, -0.14}) {
      Drive drive(track, n);
      const double v = 2.37;
      drive.go(3.2 * track.length(), v);
      ASSERT_EQ(drive.ends.size(), 3U);
      for (int lap = 0; lap < 3; ++lap) {
        // Off the centre line a step's path across the joint of line and arc is not quite even in station.
        EXPECT_NEAR(drive.ends[lap], (lap + 1) * track.length() / v, n == 0.0 ? 1e-4 : 4e-3) << name << " n " << n;
      }
      EXPECT_EQ(drive.counter().laps(), 3);
    }
  }
}

TEST(LapCounter, TheCrossingOfTheNormalIsExactForStraightSteps) {
  const Track track = shipped("ethz.json");
  LapCounter counter(track, track.start());
  const double s0 = counter.place().s;
  double t = 0.0;
  for (double s = s0; s < s0 + track.length() - 0.03; s += 0.02) {
    const PlanePoint p = place(track, s, 0.05);
    EXPECT_FALSE(counter.advance(t += 0.02, p.x, p.y));
  }
  const PlanePoint before = place(track, s0 - 0.02, -0.08), after = place(track, s0 + 0.06, 0.1);
  EXPECT_FALSE(counter.advance(10.0, before.x, before.y));
  const auto ended = counter.advance(11.0, after.x, after.y);
  ASSERT_TRUE(ended);
  EXPECT_NEAR(*ended, 10.25, 1e-9);
}

TEST(LapCounter, TheFirstStepOverTheStartLineIsNoLap) {
  const Track track = shipped("ethz.json");
  Drive drive(track, 0.0);
  drive.go(1.0, 1.0);
  EXPECT_TRUE(drive.ends.empty());
  EXPECT_NEAR(drive.counter().covered(), 1.0, 0.02);
}

TEST(LapCounter, RollingBackOverTheLineCountsOnce) {
  const Track track = shipped("ethz.json");
  Drive drive(track, 0.03);
  drive.go(-0.5, 1.0);
  drive.go(1.0, 1.0);
  EXPECT_TRUE(drive.ends.empty());
  drive.go(track.length() - 0.4, 2.0);
  EXPECT_EQ(drive.ends.size(), 1U);
  for (int i = 0; i < 3; ++i) {
    drive.go(-0.6, 1.0);
    drive.go(0.6, 1.0);
  }
  EXPECT_EQ(drive.ends.size(), 1U);
  drive.go(track.length(), 2.0);
  EXPECT_EQ(drive.ends.size(), 2U);
}

TEST(LapCounter, GoingRoundBackwardsIsNoLap) {
  const Track track = shipped("ethz_mobil.json");
  Drive drive(track, 0.0);
  drive.go(-2.5 * track.length(), 2.0);
  EXPECT_TRUE(drive.ends.empty());
  EXPECT_NEAR(drive.counter().covered(), -2.5 * track.length(), 0.05);
}

TEST(LapCounter, OffTheTrackTheStretchIsKept) {
  // Outside the edge, for -0.3 m even inside the edges of a neighbouring stretch: still the same lap.
  const Track track = shipped("ethz.json");
  for (const double n : {0.195, -0.3}) {
    Drive drive(track, n);
    drive.go(2.1 * track.length(), 1.5);
    EXPECT_EQ(drive.ends.size(), 2U) << n;
    EXPECT_NEAR(drive.counter().place().n, n, 1e-9);
  }
}

TEST(LapCounter, ACarPutBackElsewhereIsFoundAgain) {
  const Track track = shipped("ethz.json");
  Drive drive(track, 0.0);
  drive.go(2.0, 1.0);
  const PlanePoint p = place(track, drive.s() + 3.0, 0.0);
  EXPECT_FALSE(drive.counter().advance(drive.t() + 0.02, p.x, p.y));
  EXPECT_NEAR(drive.counter().place().s, track.wrap(drive.s() + 3.0), 1e-9);
  EXPECT_NEAR(drive.counter().covered(), 5.0, 0.05);
}

}  // namespace test_lap_counter
}  // namespace gripline
