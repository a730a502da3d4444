#include "geometry/arc_path.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "support/sample_curves.hpp"

namespace gripline {
namespace test_arc_path {

using test::beside;
using test::stadium;
using ::testing::HasSubstr;

constexpr double pi = std::numbers::pi;

TEST(ArcPath, IsExact) {
  const ClosedCurve curve = stadium();
  EXPECT_DOUBLE_EQ(curve.length(), 8.0 + 2.0 * pi);
  const CurvePoint top = curve.at(4.0 + 0.5 * pi);
  EXPECT_NEAR(top.x, 5.0, 1e-15);
  EXPECT_NEAR(top.y, 1.0, 1e-15);
  EXPECT_NEAR(top.yaw, 0.5 * pi, 1e-15);
  EXPECT_EQ(top.kappa, 1.0);
  EXPECT_EQ(curve.at(2.0).kappa, 0.0);
  const CurvePoint back = curve.at(4.0 + pi + 1.0);
  EXPECT_NEAR(std::abs(back.yaw), pi, 1e-15);
  EXPECT_NEAR(back.x, 3.0, 1e-14);
  EXPECT_NEAR(back.y, 2.0, 1e-14);
}

TEST(ArcPath, RepeatsItself) {
  const ClosedCurve curve = stadium();
  for (const double s : {0.3, 5.0, 9.9, 13.0}) {
    const CurvePoint a = curve.at(s), b = curve.at(s - 3.0 * curve.length()), c = curve.at(s + 2.0 * curve.length());
    EXPECT_NEAR(a.x, b.x, 1e-12);
    EXPECT_NEAR(a.y, c.y, 1e-12);
    EXPECT_NEAR(b.s, s, 1e-12);
  }
}

TEST(ArcPath, LeftIsPositive) {
  const ClosedCurve curve = stadium();
  EXPECT_NEAR(curve.locate(2.0, 0.3).n, 0.3, 1e-15);
  EXPECT_NEAR(curve.locate(2.0, -0.3).n, -0.3, 1e-15);
  const CurveLocation outside = curve.locate(5.5, 1.0);
  EXPECT_NEAR(outside.n, -0.5, 1e-15);
  EXPECT_NEAR(outside.s, 4.0 + 0.5 * pi, 1e-15);
}

TEST(ArcPath, RefusesWhatDoesNotClose) {
  const std::vector<Segment> gap{Segment::line(4.0), Segment::arc(1.0, pi), Segment::line(3.9), Segment::arc(1.0, pi)};
  const std::vector<Segment> kink{Segment::line(4.0), Segment::arc(1.0, pi), Segment::line(4.0),
                                  Segment::arc(1.0, 0.9 * pi)};
  const std::vector<Segment> empty{Segment::line(0.0)};
  EXPECT_THROW(ClosedCurve::from_segments({}, gap), GeometryError);
  EXPECT_THROW(ClosedCurve::from_segments({}, kink), GeometryError);
  EXPECT_THROW(ClosedCurve::from_segments({}, empty), GeometryError);
  EXPECT_THROW(ClosedCurve::from_segments({}, {}), GeometryError);
}

std::string why_refused(const std::vector<Segment>& segments, double closure = 1e-5) {
  try {
    ArcPath({}, segments, closure);
  } catch (const GeometryError& error) {
    return error.what();
  }
  return "not refused";
}

TEST(ArcPath, SaysByHowMuchItDoesNotClose) {
  EXPECT_THAT(why_refused({Segment::arc(2.0, pi), Segment::line(0.5), Segment::arc(2.0, pi)}),
              HasSubstr("the last ends 0.5 m from the start (1e-05 m is accepted)"));
  EXPECT_THAT(why_refused({Segment::arc(2.0, 1.5 * pi)}),
              HasSubstr("ends with heading -90 deg, the first begins with 0"));
  EXPECT_THAT(why_refused({Segment::line(1.0), {NAN, 0.0}}), HasSubstr("segment 2"));
  EXPECT_THAT(why_refused({Segment::line(1.0), {1.0, INFINITY}}), HasSubstr("segment 2"));
  EXPECT_EQ(why_refused({Segment::arc(2.0, pi), Segment::line(0.5), Segment::arc(2.0, pi)}, 0.51), "not refused");
}

/// A circle of either direction from 1 mm to 10 km: everything about it is known.
TEST(ArcPath, OneArcIsACircle) {
  for (const double radius : {1e-3, 0.3, 25.0, 1e4})
    for (const double sign : {1.0, -1.0}) {
      const std::vector<Segment> whole{Segment::arc(radius, sign * 2 * pi)};
      const ArcPath circle({radius, 0.0, sign * 0.5 * pi}, whole, 1e-9 * radius);
      const double exact = 4e-15 * radius;
      EXPECT_NEAR(circle.length(), 2 * pi * radius, exact);
      for (double angle = 0.05; angle < 2 * pi; angle += 0.37) {
        const CurvePoint at = circle.at(angle * radius);
        EXPECT_NEAR(at.x, radius * std::cos(sign * angle), exact);
        EXPECT_NEAR(at.y, radius * std::sin(sign * angle), exact);
        EXPECT_NEAR(wrap_angle(at.yaw - sign * (angle + 0.5 * pi)), 0.0, 1e-14);
        EXPECT_DOUBLE_EQ(at.kappa, sign / radius);
        for (const double grow : {0.1, 0.9, 1.0, 1.5, 20.0}) {  // to the left of a left turn is inside
          const CurveLocation place = circle.locate(grow * at.x, grow * at.y);
          EXPECT_NEAR(place.s, angle * radius, 8 * exact);
          EXPECT_NEAR(place.n, sign * (1.0 - grow) * radius, 20 * exact);
        }
      }
      EXPECT_NEAR(std::abs(circle.locate(0.0, 0.0).n), radius, exact);  // every place of it is nearest to its centre
    }
}

/// Where x and y are after s metres on an arc that begins at the origin along x: the series of sine and cosine, whose
/// next terms are below the last digit for the radii below.
PlanePoint on_wide_arc(double s, double kappa) {
  const double u = s * kappa;
  return {s * (1 - u * u / 6 + u * u * u * u / 120), s * (u / 2 - u * u * u / 24)};
}

/// The centre of a wide arc is far away: places must not be differences of numbers of that size. 1e12 m once cost
/// 0.1 mm, and then the segments did not close.
TEST(ArcPath, ArcsOfAnyRadiusAreExact) {
  for (const double radius : {2e4, 9.9e4, 1.01e5, 1e6, 1e9, 1e12, 1e15, 1e300})
    for (const double sign : {1.0, -1.0}) {
      // A stadium whose straights bend one way and back.
      const Segment bend = Segment::arc(radius, sign * 100.0 / radius),
                    back = Segment::arc(radius, -sign * 100.0 / radius);
      const std::vector<Segment> segments{bend, back, Segment::arc(20.0, pi), bend, back, Segment::arc(20.0, pi)};
      const ArcPath path({}, segments, 1e-9);
      for (double s = 1.0; s < 100.0; s += 7.0) {
        const PlanePoint truth = on_wide_arc(s, sign / radius);
        const CurvePoint at = path.at(s);
        EXPECT_NEAR(at.x, truth.x, 1e-10) << radius;
        EXPECT_NEAR(at.y, truth.y, 1e-10) << radius;
        EXPECT_NEAR(at.yaw, sign * s / radius, 1e-15);
        EXPECT_DOUBLE_EQ(at.kappa, sign / radius);
        for (const double n : {3.0, -3.0}) {
          const PlanePoint p = beside(at, n);
          for (const CurveLocation& place : {path.locate(p.x, p.y), path.locate(p.x, p.y, s + 20.0)}) {
            EXPECT_NEAR(place.s, s, 1e-9) << radius;
            EXPECT_NEAR(place.n, n, 1e-10) << radius;
          }
        }
      }
    }
}

TEST(ArcPath, AFigureOfEightClosesWithoutATurn) {
  const std::vector<Segment> eight{Segment::arc(3.0, 2 * pi), Segment::arc(5.0, -2 * pi)};
  const ArcPath path({}, eight, 1e-12);
  EXPECT_DOUBLE_EQ(path.length(), 16 * pi);
  EXPECT_DOUBLE_EQ(path.at(1.0).kappa, 1 / 3.0);
  EXPECT_DOUBLE_EQ(path.at(6 * pi + 1.0).kappa, -1 / 5.0);
  // Both circles touch at the origin: a hint says on which one the car is.
  const double half = 3 * pi;
  EXPECT_NEAR(path.locate(0.0, 6.5, half + 0.2).n, -0.5, 1e-14);
  EXPECT_NEAR(path.locate(0.0, -10.5, 11 * pi).n, 0.5, 1e-13);
  EXPECT_NEAR(path.locate(0.3, 0.01, 0.2).s, 0.3, 0.01);
  EXPECT_NEAR(path.locate(0.3, -0.01, 6 * pi + 0.2).s, 6 * pi + 0.3, 0.01);
}

/// A road may be described from the middle of a corner: it is the same one, with other stations.
TEST(ArcPath, ItMayBeginWithinACorner) {
  const ClosedCurve whole = stadium();
  const double later = 4.0 + 0.3 * pi;
  const CurvePoint first = whole.at(later);
  const std::vector<Segment> segments{Segment::arc(1.0, 0.7 * pi), Segment::line(4.0), Segment::arc(1.0, pi),
                                      Segment::line(4.0), Segment::arc(1.0, 0.3 * pi)};
  const ArcPath path({first.x, first.y, first.yaw}, segments, 1e-12);
  EXPECT_NEAR(path.length(), whole.length(), 1e-14);
  for (double s = -2.0; s < 20.0; s += 0.173) {
    const CurvePoint at = path.at(s), truth = whole.at(s + later);
    EXPECT_NEAR(at.x, truth.x, 1e-13);
    EXPECT_NEAR(at.y, truth.y, 1e-13);
    EXPECT_NEAR(wrap_angle(at.yaw - truth.yaw), 0.0, 1e-13);
    const PlanePoint p = beside(truth, -0.4);
    EXPECT_NEAR(wrap_difference(path.locate(p.x, p.y, s).s - s, path.length()), 0.0, 1e-12);
  }
}

TEST(ArcPath, AHintFollowsTheLineOverJoinsAndTheSeam) {
  const ClosedCurve curve = stadium();
  for (double s = 0.0; s < curve.length(); s += 0.31)
    for (const double behind : {-1.2, 1.2}) {  // further than a corner's radius, over up to one join
      const PlanePoint p = beside(curve.at(s), -0.2);
      EXPECT_NEAR(wrap_difference(curve.locate(p.x, p.y, s + behind).s - s, curve.length()), 0.0, 1e-12) << s;
    }
}

TEST(ArcPath, WhatIsNoStationIsTheFirst) {
  const ArcPath circle({}, std::vector{Segment::arc(2.0, 2 * pi)}, 1e-9);
  EXPECT_EQ(circle.at(NAN).s, 0.0);
  EXPECT_EQ(circle.at(-1e-300).s, 0.0);
  EXPECT_LT(circle.at(std::nextafter(circle.length(), 0.0)).s, circle.length());
}

}  // namespace test_arc_path
}  // namespace gripline
