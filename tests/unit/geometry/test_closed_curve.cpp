#include "geometry/closed_curve.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "geometry/track_file.hpp"
#include "support/paths.hpp"
#include "support/sample_curves.hpp"

namespace gripline {
namespace test_closed_curve {

using test::beside;
using test::ellipse;
using test::nearest_of;
using test::stadium;

constexpr double pi = std::numbers::pi;

Track shipped(const std::string& name) { return load_track(testing_support::source_dir() / "worlds/tracks" / name); }

void expect_round_trip(const ClosedCurve& curve, double widest, double tolerance) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> station(0.0, curve.length()), offset(-widest, widest), error(-0.1, 0.1);
  for (int i = 0; i < 2000; ++i) {
    const double s = station(random), n = offset(random);
    const CurvePoint at = curve.at(s);
    const PlanePoint p = beside(at, n);
    for (const CurveLocation& found : {curve.locate(p.x, p.y), curve.locate(p.x, p.y, s + error(random))}) {
      EXPECT_NEAR(wrap_difference(found.s - s, curve.length()), 0.0, tolerance);
      EXPECT_NEAR(found.n, n, tolerance);
      EXPECT_NEAR(wrap_angle(found.yaw - at.yaw), 0.0, 20.0 * tolerance);
    }
  }
}

TEST(ClosedCurve, LocateInvertsAt) {
  expect_round_trip(stadium(), 0.8, 1e-12);
  expect_round_trip(shipped("ethz.json").centre(), 0.18, 1e-9);
  expect_round_trip(shipped("ethz_mobil.json").centre(), 0.225, 1e-9);
  expect_round_trip(ellipse(3.0, 2.0, 61), 0.8, 1e-9);
}

TEST(ClosedCurve, AHintStaysOnItsStretch) {
  // Between the two straights of the stadium, nearer to the upper one: the hint decides.
  const ClosedCurve curve = stadium();
  EXPECT_NEAR(curve.locate(2.0, 1.2).s, 4.0 + pi + 2.0, 1e-12);
  EXPECT_NEAR(curve.locate(2.0, 1.2, 1.9).s, 2.0, 1e-12);
  EXPECT_NEAR(curve.locate(2.0, 1.2, 1.9).n, 1.2, 1e-12);
}

TEST(ClosedCurve, LocateFindsTheNearestPointFromAnywhere) {
  const ClosedCurve oval = ellipse(3.0, 2.0, 61);
  const Track ethz = shipped("ethz.json");
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> place(-4.0, 4.0);
  for (int i = 0; i < 300; ++i) {
    const double x = place(random), y = place(random);
    for (const ClosedCurve* curve : {&oval, &ethz.centre()}) {
      double nearest = INFINITY;
      for (int k = 0; k < 4000; ++k) {
        const CurvePoint at = curve->at(curve->length() * k / 4000.0);
        nearest = std::min(nearest, std::hypot(at.x - x, at.y - y));
      }
      const double found = std::abs(curve->locate(x, y).n);
      EXPECT_LE(found, nearest + 1e-12);
      EXPECT_GE(found, nearest - 2e-3);
    }
  }
}

/// What closed_curve.hpp promises of every place that is found, on the line's side or in the middle of nowhere.
TEST(ClosedCurve, ALocatedPlaceLeadsBack) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> place(-6.0, 8.0);
  for (const ClosedCurve& curve : {stadium(), ellipse(3.0, 2.0, 24), ellipse(3.0, 0.5, 12)})
    for (int i = 0; i < 300; ++i) {
      const double x = place(random), y = place(random);
      const CurveLocation found = curve.locate(x, y);
      ASSERT_GE(found.s, 0.0);
      ASSERT_LT(found.s, curve.length());
      const CurvePoint foot = curve.at(found.s);
      const PlanePoint p = beside(foot, found.n);
      EXPECT_NEAR(p.x, x, 1e-8);
      EXPECT_NEAR(p.y, y, 1e-8);
      EXPECT_NEAR(wrap_angle(foot.yaw - found.yaw), 0.0, 1e-8);
      EXPECT_LE(std::abs(found.n), nearest_of(curve, x, y, 1000) + 1e-12);
    }
}

TEST(ClosedCurve, OnlyASplineHasKnots) {
  EXPECT_EQ(stadium().spline(), nullptr);
  ASSERT_NE(ellipse(3.0, 2.0, 24).spline(), nullptr);
  EXPECT_EQ(ellipse(3.0, 2.0, 24).spline()->knot_stations().size(), 24u);
}

TEST(ClosedCurve, WrapsStations) {
  const ClosedCurve curve = stadium();
  EXPECT_NEAR(curve.wrap(-1.0), curve.length() - 1.0, 1e-14);
  EXPECT_EQ(curve.wrap(curve.length()), 0.0);
  EXPECT_EQ(curve.wrap(-1e-300), 0.0);
}

}  // namespace test_closed_curve
}  // namespace gripline
