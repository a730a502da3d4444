#include "geometry/spline.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "geometry/polyline.hpp"
#include "support/sample_curves.hpp"

namespace gripline {
namespace test_spline {

using test::beside;
using test::ellipse;
using test::ellipse_points;
using test::nearest_of;
using ::testing::HasSubstr;

constexpr double pi = std::numbers::pi;

TEST(SplinePath, MatchesAnEllipse) {
  const double a = 3.0, b = 2.0;
  const ClosedCurve curve = ellipse(a, b, 240);
  EXPECT_NEAR(curve.length(), 15.865439589290589, 1e-6);  // 4 a E(sqrt(1 - b^2/a^2))
  for (int i = 0; i < 100; ++i) {
    const CurvePoint at = curve.at(0.1586 * i);
    EXPECT_NEAR(at.x * at.x / (a * a) + at.y * at.y / (b * b), 1.0, 1e-7);
    const double c = at.x / a, s = at.y / b;
    const double kappa = a * b / std::pow(a * a * s * s + b * b * c * c, 1.5);
    EXPECT_NEAR(at.kappa, kappa, 2e-3);
    EXPECT_NEAR(wrap_angle(at.yaw - std::atan2(b * c, -a * s)), 0.0, 1e-5);
  }
}

TEST(SplinePath, StationsAreArcLengthAndCurvatureIsContinuous) {
  const ClosedCurve curve = ellipse(3.0, 2.0, 31);
  const double h = 1e-4;
  for (double s = 0.0; s < curve.length(); s += 0.0371) {
    const CurvePoint before = curve.at(s - h), at = curve.at(s), after = curve.at(s + h);
    EXPECT_NEAR(std::hypot(after.x - before.x, after.y - before.y), 2.0 * h, 1e-9);
    EXPECT_NEAR((after.kappa + before.kappa) / 2.0, at.kappa, 1e-3);
    EXPECT_NEAR(wrap_angle(after.yaw - before.yaw) / (2.0 * h), at.kappa, 1e-3);
  }
}

TEST(SplinePath, RefusesPointsThatMakeNoLine) {
  const std::vector<PlanePoint> few{{0, 0}, {1, 0}, {1, 1}};
  const std::vector<PlanePoint> same{{0, 0}, {1, 0}, {1, 0}, {1, 1}, {0, 1}};
  EXPECT_THROW(ClosedCurve::from_points(few), GeometryError);
  EXPECT_THROW(ClosedCurve::from_points(same), GeometryError);
}

std::string why_refused(const std::vector<PlanePoint>& points) {
  try {
    SplinePath path(points);
  } catch (const GeometryError& error) {
    return error.what();
  }
  return "not refused";
}

TEST(SplinePath, SaysWhichPointsMakeNoLine) {
  const std::vector<PlanePoint> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  EXPECT_EQ(why_refused(square), "not refused");
  EXPECT_THAT(why_refused({{0, 0}, {1, 0}, {1, 1}}), HasSubstr("at least 4 points, found 3"));
  EXPECT_THAT(why_refused({{0, 0}, {1, 0}, {1, 0}, {1, 1}, {0, 1}}), HasSubstr("points 2 and 3 are the same"));
  EXPECT_THAT(why_refused({{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}}), HasSubstr("points 5 and 1 are the same"));
  EXPECT_THAT(why_refused({{0, 0}, {1, 0}, {1, NAN}, {0, 1}}), HasSubstr("is not a finite number"));
}

/// Slopes of a periodic cubic spline make its second derivative meet at every knot, over the seam as well. There is
/// only one such cubic: this is all that can be asked of them.
TEST(PeriodicSplineSlopes, TheSecondDerivativeMeetsAtEveryKnot) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> value(-3.0, 3.0), power(-2.0, 2.0);
  for (const std::size_t n : {3u, 4u, 5u, 40u}) {
    std::vector<double> v(n), h(n);
    for (std::size_t i = 0; i < n; ++i) v[i] = value(random), h[i] = std::pow(10.0, power(random));
    const std::vector<double> m = periodic_spline_slopes(v, h);
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t j = (i + 1) % n, k = (i + 2) % n;
      const double from_left = (2 * m[i] + 4 * m[j]) / h[i] - 6 * (v[j] - v[i]) / (h[i] * h[i]);
      const double from_right = -(4 * m[j] + 2 * m[k]) / h[j] + 6 * (v[k] - v[j]) / (h[j] * h[j]);
      EXPECT_NEAR(from_left, from_right, 1e-11 * (std::abs(from_left) + 1 / (h[i] * h[i]) + 1 / (h[j] * h[j])));
    }
  }
}

/// What is such a spline comes out as it is: a constant, and the bump of the uniform cubic B-spline.
TEST(PeriodicSplineSlopes, ReproduceSplines) {
  for (const double m : periodic_spline_slopes(std::vector(6, 4.2), std::vector{1.0, 0.1, 3.0, 1.0, 9.0, 2.0}))
    EXPECT_NEAR(m, 0.0, 1e-14);
  for (std::size_t middle = 0; middle < 7; ++middle) {
    std::vector<double> v(7, 0.0), slope(7, 0.0);
    const std::size_t before = (middle + 6) % 7, after = (middle + 1) % 7;
    v[middle] = 4.0 / 6, v[before] = v[after] = 1.0 / 6;
    slope[before] = 0.5 / 0.25, slope[after] = -0.5 / 0.25;
    const std::vector<double> found = periodic_spline_slopes(v, std::vector(7, 0.25));
    for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(found[i], slope[i], 1e-14) << middle << ' ' << i;
  }
}

TEST(PeriodicSplineSlopes, AreOfFourthOrder) {
  const auto error = [](int n) {
    std::vector<double> v(static_cast<std::size_t>(n));
    for (int i = 0; i < n; ++i) v[i] = std::sin(2 * pi * i / n + 0.3);
    const std::vector<double> m = periodic_spline_slopes(v, std::vector<double>(v.size(), 2 * pi / n));
    double largest = 0.0;
    for (int i = 0; i < n; ++i) largest = std::max(largest, std::abs(m[i] - std::cos(2 * pi * i / n + 0.3)));
    return largest;
  };
  EXPECT_NEAR(error(20) / error(40), 16.0, 0.5);
}

TEST(PeriodicSplineSlopes, RefuseTooFewKnots) {
  EXPECT_THROW(periodic_spline_slopes(std::vector{1.0, 2.0}, std::vector{1.0, 1.0}), GeometryError);
  EXPECT_THROW(periodic_spline_slopes(std::vector{1.0, 2.0, 3.0}, std::vector{1.0, 1.0}), GeometryError);
}

/// Circles from the size of a model road to 20 km round, far away from the origin, of both directions.
TEST(SplinePath, PointsOfACircleGiveACircle) {
  for (const double radius : {0.02, 30.0, 3200.0})
    for (const double sign : {1.0, -1.0}) {
      std::vector<PlanePoint> points;
      for (int i = 0; i < 64; ++i)
        points.push_back({1000 + radius * std::cos(2 * pi * i / 64), sign * radius * std::sin(2 * pi * i / 64) - 500});
      const SplinePath path(points);
      // Between points a spline runs inside a circle: its length lacks the share step^4 / 720.
      EXPECT_NEAR(1.0 - path.length() / (2 * pi * radius), std::pow(2 * pi / 64, 4) / 720, 1e-9);
      for (double share = 0.01; share < 1.0; share += 0.0173) {
        const CurvePoint at = path.at(share * path.length());
        EXPECT_NEAR(at.kappa * radius, sign, 1e-3);
        EXPECT_NEAR(std::hypot(at.x - 1000, at.y + 500) / radius, 1.0, 1e-6);
        EXPECT_NEAR(wrap_angle(at.yaw - sign * (2 * pi * share + 0.5 * pi)), 0.0, 1e-5);
        const PlanePoint p = beside(at, 0.3 * radius);
        EXPECT_NEAR(path.locate(p.x, p.y).s / path.length(), share, 1e-9);
      }
    }
}

/// A closed line of clothoids: its heading is s + a tri(3 s), where the curvature 1 + a tri'(3 s) rises and falls at a
/// steady rate, and three equal parts close it. Its length is 2 pi.
struct Clothoids {
  static constexpr double rate = 0.9, part = 2 * pi / 3;
  /// Curvature between 1 - rate and 1 + rate, linear between.
  static double kappa(double s) {
    const double u = s / part - std::floor(s / part);  // a triangle from -1 to 1 and back
    return 1.0 + rate * (u < 0.5 ? 4 * u - 1 : 3 - 4 * u);
  }
  static double yaw(double s) {
    const double whole = std::floor(s / part), u = s / part - whole;
    const double triangle = u < 0.5 ? 2 * u * u - u : 3 * u - 2 * u * u - 1;
    return whole * part + part * (u + rate * triangle);
  }
  /// By Simpson's rule on steps that end where the rate changes.
  static std::vector<PlanePoint> points(int count) {
    std::vector<PlanePoint> p{{0.0, 0.0}};
    constexpr int fine = 40;
    const double step = 2 * pi / count / fine;
    for (int i = 1; i < count; ++i) {
      PlanePoint at = p.back();
      for (int k = 0; k < fine; ++k) {
        const double s = (static_cast<double>((i - 1) * fine + k)) * step;
        const double a = yaw(s), b = yaw(s + 0.5 * step), c = yaw(s + step);
        at.x += step / 6 * (std::cos(a) + 4 * std::cos(b) + std::cos(c));
        at.y += step / 6 * (std::sin(a) + 4 * std::sin(b) + std::sin(c));
      }
      p.push_back(at);
    }
    return p;
  }
};

TEST(SplinePath, FollowsClothoids) {
  const int count = 240;
  const SplinePath path(Clothoids::points(count));
  EXPECT_NEAR(path.length(), 2 * pi, 1e-6);
  const std::vector<double> knots = path.knot_stations();
  ASSERT_EQ(knots.size(), 240u);
  for (int i = 0; i < count; ++i) EXPECT_NEAR(knots[i], 2 * pi * i / count, 1e-6);
  for (double s = 0.01; s < 2 * pi; s += 0.0197) {
    const CurvePoint at = path.at(s);
    EXPECT_NEAR(at.kappa, Clothoids::kappa(s), 0.02) << s;  // its rate jumps within a step
    EXPECT_NEAR(wrap_angle(at.yaw - Clothoids::yaw(s)), 0.0, 2e-4) << s;
    const PlanePoint p = beside(at, -0.2);
    EXPECT_NEAR(path.locate(p.x, p.y, s + 0.1).s, s, 1e-9);
  }
}

/// The first point is a point as any other: place, heading and curvature are the same from both sides of it.
TEST(SplinePath, TheSeamIsSmooth) {
  std::vector<PlanePoint> points = ellipse_points(3.0, 2.0, 24);
  points.erase(points.begin() + 1, points.begin() + 4);  // uneven around the seam
  const SplinePath path(points);
  for (const double knot : path.knot_stations()) {
    const double h = 1e-7;
    const CurvePoint before = path.at(knot - h), after = path.at(knot + h);
    EXPECT_NEAR(std::hypot(after.x - before.x, after.y - before.y), 2 * h, 1e-12);
    EXPECT_NEAR(wrap_angle(after.yaw - before.yaw), 2 * h * path.at(knot).kappa, 1e-10);
    EXPECT_NEAR(after.kappa, before.kappa, 1e-5);
  }
  std::rotate(points.begin(), points.begin() + 9, points.end());
  const SplinePath rotated(points);
  const double later = path.knot_stations()[9];
  EXPECT_NEAR(rotated.length(), path.length(), 1e-13);
  for (double s = 0.0; s < path.length(); s += 0.173) {
    EXPECT_NEAR(rotated.at(s).kappa, path.at(s + later).kappa, 1e-11);
    EXPECT_NEAR(rotated.at(s).x, path.at(s + later).x, 1e-12);
  }
}

TEST(SplinePath, PassesItsPointsAtTheirStations) {
  const std::vector<PlanePoint> points = ellipse_points(3.0, 2.0, 17);
  const SplinePath path(points);
  const std::vector<double> knots = path.knot_stations();
  EXPECT_EQ(knots.front(), 0.0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(path.at(knots[i]).x, points[i].x, 1e-14);
    EXPECT_NEAR(path.at(knots[i]).y, points[i].y, 1e-14);
    EXPECT_EQ(path.knot_before(knots[i]), i);
    EXPECT_EQ(path.knot_before(std::nextafter(i + 1 == knots.size() ? path.length() : knots[i + 1], 0.0)), i);
  }
}

/// A road of 80 m by 60 m whose first side has no points between its ends. Beside its middle the knots of the other
/// sides are nearer than those ends: the nearest knot says nothing of the nearest place.
std::vector<PlanePoint> box_with_a_bare_side() {
  std::vector<PlanePoint> points{{0, 0}, {80, 0}};
  for (int i = 1; i <= 30; ++i) points.push_back({80, 2.0 * i});
  for (int i = 1; i < 40; ++i) points.push_back({80 - 2.0 * i, 60});
  for (int i = 30; i > 0; --i) points.push_back({0, 2.0 * i});
  return points;
}

TEST(SplinePath, FindsTheNearestPlaceOnALongBarePiece) {
  const ClosedCurve curve = ClosedCurve::from_points(box_with_a_bare_side());
  for (double x = 5.0; x < 80.0; x += 10.0)
    for (double y = -45.0; y < 58.0; y += 9.0)
      EXPECT_NEAR(std::abs(curve.locate(x, y).n), nearest_of(curve, x, y, 4000), 0.02) << x << ' ' << y;
  // A car on that side stays there.
  for (const double n : {5.0, 15.0, -15.0}) {
    const PlanePoint p = beside(curve.at(40.0), n);
    EXPECT_NEAR(curve.locate(p.x, p.y, 39.0).s, 40.0, 1e-6) << n;
  }
}

/// Noise as large as the steps folds a line so that the speed of its parameter is almost 0 in places. The line stays
/// near its points, and its stations stay its arc length; Newton's method alone once ended kilometres away.
TEST(SplinePath, NoisyPointsGiveALineThatStaysAtThem) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, 0.6);
    std::vector<PlanePoint> points = ellipse_points(64.0, 64.0, 400);
    for (PlanePoint& p : points) p.x += noise(random), p.y += noise(random);
    const SplinePath path(points);
    const ClosedPolyline chords(points);
    CurvePoint last = path.at(0.0);
    const double step = path.length() / 30000;
    for (int i = 1; i <= 30000; ++i) {
      const CurvePoint at = path.at(i * step);
      EXPECT_LT(std::hypot(at.x - last.x, at.y - last.y), 1.2 * step) << seed << ' ' << i;
      const double s = chords.nearest_station(at.x, at.y, path.knot_before(at.s));
      EXPECT_LT(distance(chords.at(s), {at.x, at.y}), 3.0) << seed << ' ' << i;
      last = at;
    }
  }
}

}  // namespace test_spline
}  // namespace gripline
