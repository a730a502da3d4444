#include "geometry/road_smoothing.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "geometry/track_checks.hpp"
#include "support/sample_roads.hpp"

namespace gripline {
namespace test_road_smoothing {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr double pi = std::numbers::pi;

TEST(RoadSmoothing, SmoothingStaysWithinItsToleranceAndKeepsTheEdges) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> noise(-0.3, 0.3);
  RoadTable road;
  for (int i = 0; i < 300; ++i) {
    const double a = 2 * pi * i / 300.0;
    road.points.push_back({100 * std::cos(a) + noise(random), 60 * std::sin(a) + noise(random)});
  }
  road.right = road.left = std::vector<double>(road.size(), 5.0);
  const auto bends = [](const RoadTable& table) {
    const ClosedCurve curve = ClosedCurve::from_points(table.points);
    double sum = 0;
    for (int i = 0; i < 2000; ++i) sum += std::pow(curve.at(curve.length() * i / 2000).kappa, 2) / 2000;
    return std::sqrt(sum);
  };
  const double before = bends(road);
  const Smoothed done = smooth(road, 0.6);
  EXPECT_GT(done.moved, 0.05);
  EXPECT_LE(done.moved, 0.6);
  EXPECT_LT(bends(road), 0.1 * before);
  EXPECT_EQ(check_start(to_track(road), to_track(road).start()), "");
  // On a clean road little is to be smoothed: what is longer than three widths stays.
  RoadTable clean = test::ellipse();
  EXPECT_LT(smooth(clean, 0.6).moved, 0.1);
}

/// A trace of an ellipse with white noise in both directions [m], so many metres from point to point.
RoadTable noisy_trace(double step, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> error(0.0, noise);
  RoadTable road;
  const int count = static_cast<int>(std::lround(1022.0 / step));  // the ellipse's length
  for (int i = 0; i < count; ++i) {
    const double a = 2 * pi * i / count;
    road.points.push_back({200 * std::cos(a) + error(random), 120 * std::sin(a) + error(random)});
  }
  road.right = road.left = std::vector<double>(road.size(), 6.0);
  road.edges_known = false;
  return road;
}

double farthest_point(const std::vector<PlanePoint>& points, const std::vector<PlanePoint>& line) {
  const ClosedPolyline curve(line);
  double farthest = 0.0;
  for (const PlanePoint& p : points) {
    const PlanePoint q = curve.at(curve.nearest_station(p.x, p.y));
    farthest = std::max(farthest, distance(p, q));
  }
  return farthest;
}

TEST(RoadSmoothing, NoisyTracesBecomeSmoothRoadsOfTheirWidth) {
  for (const double step : {1.0, 3.0, 10.0}) {
    for (unsigned seed = 1; seed <= 3; ++seed) {
      RoadTable road = noisy_trace(step, 1.0, seed);
      RoadTable tight = road;
      EXPECT_GT(smooth(tight, 0.3).wanted, 0.3);
      const Smoothed done = smooth(road, 6.0);
      EXPECT_LE(done.wanted, 6.0);
      const Track track = to_track(road);
      EXPECT_EQ(track.narrowest(), 12.0);
      EXPECT_NEAR(track.length(), 1022.0, 20.0) << step;
    }
  }
}

TEST(RoadSmoothing, ATooSmallToleranceIsRefusedAndALargerOneNamed) {
  const RoadTable noisy = noisy_trace(1.0, 1.0, 2);
  EXPECT_THAT([&] { to_track(noisy); }, ThrowsMessage<GeometryError>(HasSubstr("bends more sharply")));
  const double tolerance = helpful_tolerance(noisy);
  EXPECT_GT(tolerance, 3.0);
  EXPECT_LT(tolerance, 6.0);
  RoadTable road = noisy;
  smooth(road, tolerance);
  EXPECT_NO_THROW(to_track(road));
  // No tolerance helps a road that runs over itself.
  RoadTable twice = test::ellipse();
  twice.points.insert(twice.points.end(), twice.points.begin(), twice.points.end());
  twice.right.resize(twice.size(), 4.0), twice.left.resize(twice.size(), 8.0);
  EXPECT_EQ(helpful_tolerance(twice), 0.0);
}

TEST(RoadSmoothing, TheToleranceHoldsForThePointsThatWereGiven) {
  for (const double step : {1.0, 3.0, 10.0, 30.0}) {
    for (const double tolerance : {0.2, 1.0, 3.0}) {
      RoadTable road = noisy_trace(step, 1.0, 5);
      const std::vector<PlanePoint> given = road.points;
      const Smoothed done = smooth(road, tolerance);
      EXPECT_LE(done.moved, tolerance + 0.12) << step;  // points within 1 % of the width count as one
      EXPECT_LE(farthest_point(given, road.points), done.moved + 1e-9) << step;
    }
  }
}

TEST(RoadSmoothing, StepsOfWidthAreEvenedOutInwards) {
  RoadTable road = test::ellipse();
  for (std::size_t i = 40; i < 80; ++i) road.left[i] = 3.0;
  ASSERT_FALSE(width_steps(road).empty());
  smooth(road, 0.1);
  EXPECT_TRUE(width_steps(road).empty());
  for (const double left : road.left) EXPECT_LT(left, 8.1);
}

}  // namespace test_road_smoothing
}  // namespace gripline
