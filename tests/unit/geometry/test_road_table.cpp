#include "geometry/road_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "config/errors.hpp"
#include "geometry/lap_counter.hpp"
#include "geometry/racing_line.hpp"
#include "geometry/road_trace.hpp"
#include "geometry/track_file.hpp"
#include "support/figure_of_eight.hpp"
#include "support/host_support.hpp"
#include "util/csv_writer.hpp"

namespace gripline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr double pi = std::numbers::pi;

/// A line of text per point, as a file.
class RoadFiles : public ::testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& header, int count,
                 const std::function<std::vector<double>(int)>& row) {
    const fs::path file = scratch_ / name;
    CsvWriter csv(file, header);
    for (int i = 0; i < count; ++i) {
      for (const double value : row(i)) csv << value;
      csv.end_row();
    }
    csv.finish();
    return file;
  }
  RoadTable read(std::vector<fs::path> files, const RoadReading& reading = {}) {
    remarks_.clear();
    return read_road(files, reading, remarks_);
  }
  /// An ellipse of 200 m by 120 m, 8 m wide on the left and 4 m on the right.
  fs::path ellipse(double from = 0.0, double to = 1.0) {
    return write("ellipse.csv", "# x_m,y_m,w_tr_right_m,w_tr_left_m", 160, [=](int i) {
      const double a = 2 * pi * (from + (to - from) * i / 160.0);
      return std::vector{100 * std::cos(a), 60 * std::sin(a), 4.0, 8.0};
    });
  }
  std::string refusal(const std::function<void()>& call) {
    try {
      call();
    } catch (const InputError& error) {
      return error.what();
    } catch (const GeometryError& error) {
      return error.what();
    }
    return "not refused";
  }

  testing_support::Folder scratch_;
  std::vector<std::string> remarks_;
};

TEST_F(RoadFiles, ReverseSwapsTheSidesAndTurnsTheSlopes) {
  RoadTable road = read({ellipse()});
  road.grade.assign(road.size(), 0.01);
  road.bank.assign(road.size(), 0.02);
  const PlanePoint first = road.points[0], second = road.points[1];
  reverse(road);
  EXPECT_EQ(road.points[0].x, first.x);
  EXPECT_EQ(road.points.back().y, second.y);
  EXPECT_EQ(road.right[5], 8.0);
  EXPECT_EQ(road.left[5], 4.0);
  EXPECT_EQ(road.grade[3], -0.01);
  EXPECT_EQ(road.bank[3], -0.02);
  reverse(road);
  EXPECT_EQ(road.points[1].y, second.y);
}

TEST_F(RoadFiles, ScaleKeepsTheShape) {
  RoadTable road = read({ellipse()});
  const double before = to_track(road).length();
  scale(road, 1.0 / 43.0);
  const Track small = to_track(road);
  EXPECT_NEAR(small.length(), before / 43.0, 1e-9);
  EXPECT_NEAR(small.half_width_left(1.0), 8.0 / 43.0, 1e-12);
}

TEST_F(RoadFiles, AnOpenLineIsClosedOnlyWhenAsked) {
  const fs::path open = ellipse(0.0, 0.93);
  EXPECT_THAT(refusal([&] { read({open}); }), HasSubstr("--close METRES closes it"));
  EXPECT_THAT(refusal([&] { read({open}, {.largest_gap = 10.0}); }), HasSubstr("the line is open"));
  const RoadTable road = read({open}, {.largest_gap = 60.0});
  ASSERT_EQ(remarks_.size(), 1u);
  EXPECT_THAT(remarks_[0], HasSubstr("a gap of"));
  EXPECT_NEAR(to_track(road).length(), to_track(read({ellipse()})).length(), 1.0);
}

TEST_F(RoadFiles, AFileWithoutRowsIsRefused) {
  const fs::path metres = scratch_ / "metres.csv", degrees = scratch_ / "degrees.csv", wide = scratch_ / "wide.csv";
  write_file(metres, "x_m,y_m\n");
  write_file(degrees, "lat,lon\n");
  write_file(wide, "x_m,y_m,w_tr_right_m,w_tr_left_m\n");
  const auto few = HasSubstr("has 0 points, a track needs at least 8");
  for (const fs::path& file : {metres, degrees, wide}) {
    EXPECT_THAT(refusal([&] { read({file}, {.width = 12}); }), few);
    EXPECT_THAT(refusal([&] { read({ellipse(), file}); }), few);
    EXPECT_THAT(refusal([&] { read({file, ellipse()}); }), few);
  }
}

TEST_F(RoadFiles, SmoothingStaysWithinItsToleranceAndKeepsTheEdges) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> noise(-0.3, 0.3);
  const fs::path noisy = write("noisy.csv", "x_m,y_m,w_tr_right_m,w_tr_left_m", 300, [&](int i) {
    const double a = 2 * pi * i / 300.0;
    return std::vector{100 * std::cos(a) + noise(random), 60 * std::sin(a) + noise(random), 5.0, 5.0};
  });
  RoadTable road = read({noisy});
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
  RoadTable clean = read({ellipse()});
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
    farthest = std::max(farthest, std::hypot(p.x - q.x, p.y - q.y));
  }
  return farthest;
}

TEST_F(RoadFiles, NoisyTracesBecomeSmoothRoadsOfTheirWidth) {
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

TEST_F(RoadFiles, ATooSmallToleranceIsRefusedAndALargerOneNamed) {
  const RoadTable noisy = noisy_trace(1.0, 1.0, 2);
  EXPECT_THAT(refusal([&] { to_track(noisy); }), HasSubstr("bends more sharply"));
  const double tolerance = helpful_tolerance(noisy);
  EXPECT_GT(tolerance, 3.0);
  EXPECT_LT(tolerance, 6.0);
  RoadTable road = noisy;
  smooth(road, tolerance);
  EXPECT_NO_THROW(to_track(road));
  // No tolerance helps a road that runs over itself.
  RoadTable twice = read({ellipse()});
  twice.points.insert(twice.points.end(), twice.points.begin(), twice.points.end());
  twice.right.resize(twice.size(), 4.0), twice.left.resize(twice.size(), 8.0);
  EXPECT_EQ(helpful_tolerance(twice), 0.0);
}

TEST_F(RoadFiles, TheToleranceHoldsForThePointsThatWereGiven) {
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

TEST_F(RoadFiles, StepsOfWidthAreFoundAndEvenedOutInwards) {
  RoadTable road = read({ellipse()});
  for (std::size_t i = 40; i < 80; ++i) road.left[i] = 3.0;
  const std::vector<WidthStep> steps = width_steps(road);
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_FALSE(steps[0].right);
  EXPECT_EQ(steps[0].from, 8.0);
  EXPECT_EQ(steps[0].to, 3.0);
  smooth(road, 0.1);
  EXPECT_TRUE(width_steps(road).empty());
  for (const double left : road.left) EXPECT_LT(left, 8.1);
}

TEST_F(RoadFiles, EdgesMakeARoadWhosePointsNeedNotCorrespond) {
  const auto edge = [&](const char* name, double grow, int count) {
    return write(name, "x_m,y_m", count, [=](int i) {
      const double a = 2 * pi * i / count;
      return std::vector{(100 + grow) * std::cos(a), (100 + grow) * std::sin(a)};
    });
  };
  const Track track = to_track(read({edge("left.csv", -4, 150), edge("right.csv", 4, 210)}));
  EXPECT_NEAR(track.length(), 2 * pi * 100, 0.5);
  EXPECT_NEAR(track.half_width_left(50), 4.0, 0.05);
  EXPECT_NEAR(track.half_width_right(50), 4.0, 0.05);
}

/// A circle of 300 m radius around 48 degrees north, one lap and a quarter.
std::string gpx_circle() {
  std::string text = "<?xml version=\"1.0\"?>\n<gpx><trk><trkseg>\n";
  for (int i = 0; i < 250; ++i) {
    const double a = 2 * pi * i / 200.0;
    const double north = 300 * std::sin(a), east = 300 * std::cos(a);
    char line[160];
    std::snprintf(line, sizeof line, "<trkpt lat=\"%.9f\" lon=\"%.9f\"><ele>%.3f</ele></trkpt>\n",
                  48.0 + north / 111194.0, 11.0 + east / 74555.0, 400.0 + 5 * std::sin(a));
    text += line;
  }
  return text + "</trkseg></trk></gpx>\n";
}

TEST_F(RoadFiles, AGpxTraceIsCutAfterALap) {
  const fs::path file = scratch_ / "lap.gpx";
  write_file(file, gpx_circle());
  EXPECT_THAT(refusal([&] { read({file}); }), HasSubstr("--width METRES"));
  const RoadTable road = read({file}, {.width = 10.0});
  EXPECT_EQ(road.size(), 200u);
  const Track track = to_track(road);
  EXPECT_NEAR(track.length(), 2 * pi * 300, 6.0);
  EXPECT_NEAR(track.half_width_left(3), 5.0, 1e-12);
  // dz/ds is largest at the start: 5 m of height over a radius of 300 m.
  EXPECT_NEAR(track.grade(0.0), std::atan(5.0 / 300.0), 5e-4);
}

TEST_F(RoadFiles, ARoadWithWidthsIsCutAfterALapAsWell) {
  const RoadTable lap = read({ellipse()});
  EXPECT_TRUE(remarks_.empty());
  EXPECT_EQ(lap.size(), 160u);
  const RoadTable road = read({ellipse(0.0, 1.05)});  // 160 points on 1.05 laps
  EXPECT_THAT(remarks_, ::testing::ElementsAre(HasSubstr("points after a lap: left out")));
  EXPECT_LT(road.size(), 154u);
  EXPECT_EQ(road.right.size(), road.size());
  const Track track = to_track(road);
  EXPECT_NEAR(track.length(), lap.length(), 1.0);
  for (int i = 0; i < 400; ++i)  // the ellipse's sharpest bend has a radius of 36 m
    EXPECT_LT(std::abs(track.at(track.length() * i / 400).kappa), 1 / 30.0);
}

TEST_F(RoadFiles, APointThatTwoLapsShareIsKeptOnce) {
  const fs::path file = write("twice.csv", "# x_m,y_m,w_tr_right_m,w_tr_left_m", 163, [](int i) {
    return std::vector{100 * std::cos(2 * pi * i / 160), 60 * std::sin(2 * pi * i / 160), 4.0, 8.0};
  });
  EXPECT_EQ(read({file}).size(), 160u);
  EXPECT_THAT(remarks_, ::testing::ElementsAre(HasSubstr("3 points after a lap: left out")));
}

TEST_F(RoadFiles, ALoggerThatStandsBeforeItsLapsIsNoCourse) {
  for (const double jitter : {0.05, 0.3}) {
    std::mt19937 random(3);
    std::normal_distribution<double> error(0.0, jitter);
    const fs::path file = write("stands.csv", "x_m,y_m", 100 + 800, [&](int i) {
      const double a = 2 * pi * std::max(0, i - 100) / 340.0;  // 340 points a lap, 3 m apart
      const double noise = i < 100 ? 1.0 : 0.0;
      return std::vector{200 * std::cos(a) + noise * error(random), 120 * std::sin(a) + noise * error(random)};
    });
    const RoadTable road = read({file}, {.width = 12.0});
    EXPECT_THAT(remarks_, ::testing::ElementsAre(HasSubstr("where the trace stands"), HasSubstr("after a lap")));
    EXPECT_NEAR(static_cast<double>(road.size()), 340.0, 4.0) << jitter;
    EXPECT_NEAR(to_track(road).length(), 1022.0, 3.0);
  }
}

TEST_F(RoadFiles, ADriveThatTurnsRoundAfterItsLapIsCut) {
  const fs::path file = write("back.csv", "x_m,y_m", 400, [](int i) {
    const double a = 2 * pi * (i < 200 ? i : 399 - i) / 200;
    return std::vector{200 * std::cos(a), 120 * std::sin(a)};
  });
  EXPECT_NEAR(static_cast<double>(read({file}, {.width = 12.0}).size()), 200.0, 1.0);
}

TEST_F(RoadFiles, ARoadDrivenTwiceIsCut) {
  const fs::path file = write("exactly.csv", "# x_m,y_m,w_tr_right_m,w_tr_left_m", 320, [](int i) {
    return std::vector{100 * std::cos(2 * pi * i / 160), 60 * std::sin(2 * pi * i / 160), 4.0, 8.0};
  });
  EXPECT_EQ(read({file}).size(), 160u);
}

TEST_F(RoadFiles, EdgesAreCutAfterALapAsWell) {
  const auto edge = [&](const char* name, double grow, int rows) {
    return write(name, "x_m,y_m", rows, [=](int i) {
      const double a = 2 * pi * i / 200;
      return std::vector{(100 + grow) * std::cos(a), (100 + grow) * std::sin(a)};
    });
  };
  const Track track = to_track(read({edge("left.csv", -4, 215), edge("right.csv", 4, 200)}));
  EXPECT_THAT(remarks_, ::testing::Contains(HasSubstr("15 points after a lap")));
  EXPECT_NEAR(track.length(), 2 * pi * 100, 0.5);
}

TEST_F(RoadFiles, EdgesThatCrossAreRefusedWithThePlace) {
  const auto edge = [&](const char* name, double grow, double bump) {
    return write(name, "x_m,y_m", 300, [=](int i) {
      const double a = 2 * pi * i / 300, r = 100 + grow + (i >= 100 && i < 120 ? bump : 0.0);
      return std::vector{r * std::cos(a), r * std::sin(a)};
    });
  };
  const fs::path left = edge("left.csv", -4, 0);
  EXPECT_THAT(refusal([&] { read({left, edge("right.csv", 4, -12)}); }), HasSubstr("cross each other: near (-"));
  EXPECT_THAT(refusal([&] { read({left, left}); }), HasSubstr("are the same line"));
  EXPECT_EQ(refusal([&] { read({left, edge("right.csv", 4, -3)}); }), "not refused");
}

TEST_F(RoadFiles, UnknownColumnsAreRefusedInARoadAndToldOfATrace) {
  const auto file = [&](const std::string& header, std::size_t columns) {
    return write("columns.csv", header, 100, [=](int i) {
      std::vector<double> row{100 * std::cos(2 * pi * i / 100), 60 * std::sin(2 * pi * i / 100), 4.0, 4.0, 0.0};
      row.resize(columns);
      return row;
    });
  };
  const fs::path typo = file("x_m,y_m,w_tr_right_m,w_tr_left_m,grade", 5);
  EXPECT_THAT(refusal([&] { read({typo}); }), HasSubstr(":1:1: unknown column \"grade\"; did you mean \"grade_rad\"?"));
  read({file("x_m,y_m,speed,time", 4)}, {.width = 8.0});
  EXPECT_THAT(remarks_, ::testing::ElementsAre("columns that are left out: speed,time"));
}

TEST_F(RoadFiles, MissingHeightsAreFilledOrTold) {
  std::string text = gpx_circle();
  const auto without_height = [&](std::size_t from) {
    const std::size_t at = text.find("<ele>", from), end = text.find("</ele>", at) + 6;
    text.erase(at, end - at);
    return at;
  };
  without_height(text.size() / 4);
  write_file(scratch_ / "one.gpx", text);
  const Track filled = to_track(read({scratch_ / "one.gpx"}, {.width = 10.0}));
  EXPECT_THAT(remarks_, ::testing::Contains("1 of 250 points have no height: interpolated"));
  EXPECT_NEAR(filled.grade(0.0), std::atan(5.0 / 300.0), 5e-4);
  for (std::size_t i = 0, at = 0; i < 100; ++i) at = without_height(at);
  write_file(scratch_ / "many.gpx", text);
  EXPECT_TRUE(read({scratch_ / "many.gpx"}, {.width = 10.0}).height.empty());
  EXPECT_THAT(remarks_, ::testing::Contains("101 of 250 points have no height: heights are left out"));
}

TEST_F(RoadFiles, HeightsOfOneEdgeAreToldToBeLeftOut) {
  const auto edge = [&](const char* name, double r, bool heights) {
    return write(name, heights ? "x_m,y_m,z_m" : "x_m,y_m", 200, [=](int i) {
      std::vector<double> row{r * std::cos(2 * pi * i / 200), r * std::sin(2 * pi * i / 200)};
      if (heights) row.push_back(1.0);
      return row;
    });
  };
  read({edge("left.csv", 96, true), edge("right.csv", 104, false)});
  EXPECT_THAT(remarks_,
              ::testing::Contains(::testing::AllOf(HasSubstr("heights are left out"), HasSubstr("left.csv"))));
}

TEST_F(RoadFiles, HeightsThatDriftAreEvenedOutOrRefused) {
  const auto trace = [&](double drift) {
    return write("drift.csv", "x_m,y_m,z_m", 200, [=](int i) {
      const double a = 2 * pi * i / 200;
      return std::vector{100 * std::cos(a), 100 * std::sin(a), 5 * std::sin(a) + drift * i / 200};
    });
  };
  const Track clean = to_track(read({trace(0.0)}, {.width = 8.0}));
  EXPECT_TRUE(remarks_.empty());
  const Track even = to_track(read({trace(2.0)}, {.width = 8.0}));
  EXPECT_THAT(remarks_, ::testing::ElementsAre(HasSubstr("m higher than where it began: evened out")));
  for (int i = 0; i < 100; ++i) EXPECT_NEAR(even.grade(6.28 * i), clean.grade(6.28 * i), 1e-3) << i;
  EXPECT_THAT(refusal([&] { read({trace(-20.0)}, {.width = 8.0}); }), HasSubstr("20 m lower than where it began"));
}

TEST_F(RoadFiles, WallsAndStartOfAJsonRoadAreToldToBeLeftOut) {
  write_file(scratch_ / "walls.json",
             R"({"segments": [{"arc": {"radius": 40, "turn": "360 deg"}}], "half_width": 3,
                 "walls": {"left": 2}, "start": {"x": 5, "y": 1, "yaw": 0}})");
  read({scratch_ / "walls.json"});
  EXPECT_THAT(remarks_, ::testing::ElementsAre(HasSubstr("walls are left out"), HasSubstr("the start is left out")));
  write_file(scratch_ / "plain.json", R"({"segments": [{"arc": {"radius": 40, "turn": "360 deg"}}], "half_width": 3})");
  read({scratch_ / "plain.json"});
  EXPECT_TRUE(remarks_.empty());
}

TEST_F(RoadFiles, AClosingPointNearTheFirstIsDropped) {
  for (const double gap : {0.0, 1e-6, 0.01, 0.25}) {
    const fs::path file = write("near.csv", "# x_m,y_m,w_tr_right_m,w_tr_left_m", 161, [=](int i) {
      const double a = 2 * pi * i / 160;
      return std::vector{100 * std::cos(a), 60 * std::sin(a) - (i == 160 ? gap : 0.0), 4.0, 8.0};
    });
    EXPECT_EQ(read({file}).size(), 160u) << gap;
    EXPECT_EQ(remarks_.size(), gap > 0.0 ? 1u : 0u) << gap;
    EXPECT_NEAR(load_track(file).length(), to_track(read({file})).length(), 1e-9);
  }
}

TEST_F(RoadFiles, WhatIsNoGpxIsRefused) {
  const fs::path file = scratch_ / "bad.gpx";
  write_file(file, "<gpx><trk>");
  EXPECT_THAT(refusal([&] { read({file}, {.width = 5}); }), HasSubstr("is no XML"));
  write_file(file, "<kml></kml>");
  EXPECT_THAT(refusal([&] { read({file}, {.width = 5}); }), HasSubstr("is no GPX file"));
  write_file(file, "<gpx></gpx>");
  EXPECT_THAT(refusal([&] { read({file}, {.width = 5}); }), HasSubstr("no track points"));
  write_file(file, "<gpx><trk><trkseg><trkpt lat=\"91\" lon=\"3\"/></trkseg></trk></gpx>");
  EXPECT_THAT(refusal([&] { read({file}, {.width = 5}); }), HasSubstr("expected degrees"));
  std::string deep = "<gpx>";
  for (int i = 0; i < 100000; ++i) deep += "<a>";
  write_file(file, deep);
  EXPECT_THAT(refusal([&] { read({file}, {.width = 5}); }), HasSubstr("within each other"));
}

TEST_F(RoadFiles, WhatAGpxFileMayHave) {
  std::string text = gpx_circle();
  std::string comment = "<!-- ";
  for (int i = 0; i < 60; ++i) comment += "<trkpt>";
  text.insert(text.find("<trkpt"), comment + " -->\n<desc note='a > b'/>");
  write_file(scratch_ / "capital.GPX", text);
  EXPECT_EQ(read({scratch_ / "capital.GPX"}, {.width = 10.0}).size(), 200u);
  const fs::path bad = scratch_ / "bad.gpx";
  write_file(bad,
             "<gpx><trk><trkseg>\n<trkpt lat=\"1\" lon=\"2\"/>\n<trkpt lat=\"1,5\" lon=\"2\"/>\n</trkseg></trk></gpx>");
  EXPECT_THAT(refusal([&] { read({bad}, {.width = 5}); }),
              HasSubstr(":3:1: point 2 has lat=\"1,5\" lon=\"2\"; expected"));
  write_file(bad, "<gpx><!-- ");
  EXPECT_THAT(refusal([&] { read({bad}, {.width = 5}); }), HasSubstr("is no XML"));
  write_file(bad, std::string("\xff\xfe<\0g\0", 6));
  EXPECT_THAT(refusal([&] { read({bad}, {.width = 5}); }), HasSubstr("is UTF-16; expected UTF-8"));
  // Elements that only look closed are counted.
  std::string deep = "<gpx>";
  for (int i = 0; i < 100000; ++i) deep += "<a b='/>'>";
  write_file(bad, deep);
  EXPECT_THAT(refusal([&] { read({bad}, {.width = 5}); }), HasSubstr("within each other"));
}

TEST_F(RoadFiles, WidthsAreCheckedLineByLineAndStatedOnce) {
  const fs::path none = write("none.csv", "x_m,y_m,w_tr_right_m,w_tr_left_m", 100, [](int i) {
    return std::vector{50 * std::cos(2 * pi * i / 100), 50 * std::sin(2 * pi * i / 100), 4.0, i == 30 ? 0.0 : 4.0};
  });
  EXPECT_THAT(refusal([&] { read({none}); }), HasSubstr("none.csv:32:1: half widths of 4 m (right) and 0 m (left)"));
  EXPECT_THAT(refusal([&] { load_track(none); }), HasSubstr("none.csv:32:1: the left half width is 0 m"));
  EXPECT_THAT(refusal([&] { read({ellipse()}, {.width = 5}); }), HasSubstr("has widths of its own"));
  EXPECT_THAT(refusal([&] { read({none, none}, {.width = 5}); }), HasSubstr("two edges have their width between them"));
  write_file(scratch_ / "road.xodr", "<OpenDRIVE/>");
  EXPECT_THAT(refusal([&] { read({scratch_ / "road.xodr"}); }), HasSubstr("is OpenDRIVE, which is not read"));
}

TEST_F(RoadFiles, ACentreLineBetweenItsEdgesIsRead) {
  const fs::path file =
      write("three.csv", "x_center_m,y_center_m,x_inner_m,y_inner_m,x_outer_m,y_outer_m", 200, [](int i) {
        const double c = std::cos(2 * pi * i / 200), s = std::sin(2 * pi * i / 200);
        return std::vector{100 * c, 100 * s, 97 * c, 97 * s, 105 * c, 105 * s};
      });
  const Track track = to_track(read({file}));
  EXPECT_NEAR(track.half_width_left(10), 3.0, 1e-6);
  EXPECT_NEAR(track.half_width_right(10), 5.0, 1e-6);
}

TEST_F(RoadFiles, ALapOver180DegreesIsAsLongAsElsewhere) {
  const auto lap = [&](double longitude) {
    return to_track(read({write("lap.csv", "lat,lon", 200,
                                [=](int i) {
                                  const double a = 2 * pi * i / 200;
                                  const double lon = longitude + 0.004 * std::cos(a);
                                  return std::vector{-17 + 0.004 * std::sin(a), lon > 180 ? lon - 360 : lon};
                                })},
                         {.width = 10}))
        .length();
  };
  EXPECT_NEAR(lap(180.0), lap(8.0), 1e-3);
}

TEST_F(RoadFiles, TheTangentPlaneIsMetric) {
  const double degree = pi / 180.0;
  const PlanePoint origin{11 * degree, 48 * degree};
  // A minute of latitude on the WGS 84 ellipsoid at 48 degrees: 1853.3 m.
  const PlanePoint north = on_tangent_plane({11 * degree, (48 + 1.0 / 60) * degree}, origin);
  EXPECT_NEAR(north.x, 0.0, 1e-6);
  EXPECT_NEAR(north.y, 1853.3, 0.2);
  const PlanePoint east = on_tangent_plane({(11 + 1.0 / 60) * degree, 48 * degree}, origin);
  EXPECT_NEAR(east.x, 1243.8, 0.2);
}

TEST_F(RoadFiles, ACrossingIsABridgeWhereHeightsDifferOrTheRoadSaysSo) {
  RoadTable road = test::figure_of_eight(5.0, 0.0);
  EXPECT_THAT(refusal([&] { to_track(road); }), HasSubstr("\"bridges\": true says so"));
  road.bridges = true;
  const Track told = to_track(road);
  ASSERT_EQ(told.crossings().size(), 1u);
  EXPECT_NEAR(told.crossings()[0].x, 0.0, 0.1);
  EXPECT_NEAR(told.crossings()[0].angle, pi / 2, 0.02);
  const Track high = to_track(test::figure_of_eight(5.0, 4.0));
  ASSERT_EQ(high.crossings().size(), 1u);
  EXPECT_NEAR(std::abs(high.crossings()[0].height), 8.0, 0.2);
  EXPECT_THAT(refusal([&] { to_track(test::figure_of_eight(5.0, 0.5)); }), HasSubstr("crosses or overlaps itself"));
}

TEST_F(RoadFiles, ABridgeAtTheFirstPointIsFoundOnce) {
  for (const double degrees : {35.0, 60.0, 75.0, 90.0, 105.0, 120.0}) {
    for (const int count : {200, 238, 240, 301}) {
      RoadTable road;
      for (int i = 0; i < count; ++i) {
        const double a = 2 * pi * i / count;
        road.points.push_back({150 * std::sin(a), 75 * std::tan(degrees * pi / 360.0) * std::sin(2 * a)});
      }
      road.right = road.left = std::vector<double>(road.size(), 4.0);
      road.bridges = true;
      const Track track = to_track(road);
      ASSERT_EQ(track.crossings().size(), 1u) << degrees << " " << count;
      EXPECT_NEAR(wrap_difference(track.crossings()[0].first, track.length()), 0.0, 0.1);
    }
  }
}

TEST_F(RoadFiles, OnABridgeTheCarsPlaceFollowsItsHeading) {
  const Track track = to_track(test::figure_of_eight(5.0, 4.0));
  const Crossing c = track.crossings().front();
  for (const double s : {c.first, c.second}) {
    const CurvePoint at = track.at(s);
    EXPECT_NEAR(wrap_difference(track.locate(Pose{at.x, at.y, at.yaw}).s - at.s, track.length()), 0.0, 1e-6);
    EXPECT_EQ(check_start(track, {at.x, at.y, at.yaw}), "");
    // Two metres beside its own pass, the car is nearer to the other one.
    const Pose beside{at.x - 2.0 * std::sin(at.yaw), at.y + 2.0 * std::cos(at.yaw), at.yaw};
    EXPECT_NEAR(wrap_difference(LapCounter(track, beside).place().s - at.s, track.length()), 0.0, 0.1);
  }
}

TEST_F(RoadFiles, TwoWaysBesideEachOtherAreNoBridge) {
  // A flat figure of eight: it crosses itself at 11 degrees.
  RoadTable road = test::figure_of_eight(5.0, 0.0);
  for (PlanePoint& p : road.points) p.y *= 0.1;
  road.bridges = true;
  EXPECT_THAT(refusal([&] { to_track(road); }), HasSubstr("overlaps itself"));
  EXPECT_THAT(refusal([&] { to_track(road); }), HasSubstr("a crossing at 11.4 degrees"));
}

TEST_F(RoadFiles, ABridgeSurvivesBeingWritten) {
  RoadTable road = test::figure_of_eight(5.0, 0.0);
  road.name = "eight";
  road.bridges = true;
  const Track track = to_track(road);
  EXPECT_THAT(refusal([&] { write_road(scratch_ / "eight.csv", track, road); }), HasSubstr("FILE.json"));
  write_road(scratch_ / "eight.json", track, road);
  const Track again = load_track(scratch_ / "eight.json");
  EXPECT_EQ(again.name(), "eight");
  EXPECT_EQ(again.crossings().size(), 1u);
  EXPECT_NEAR(again.length(), track.length(), 1e-3);
}

/// Two straights joined by half circles of this radius [m].
Track hairpins(double radius, double half_width) {
  RoadTable road;
  const int per_arc = 60, per_line = 40;
  for (const double side : {1.0, -1.0}) {
    for (int i = 0; i < per_line; ++i) road.points.push_back({side * (-60 + 120.0 * i / per_line), -side * radius});
    for (int i = 0; i < per_arc; ++i) {
      const double a = -pi / 2 + pi * i / per_arc;
      road.points.push_back({side * (60 + radius * std::cos(a)), side * radius * std::sin(a)});
    }
  }
  road.right.assign(road.size(), half_width);
  road.left = road.right;
  return to_track(road);
}

TEST_F(RoadFiles, AHairpinThatTheCarCannotSteerIsNamedWithItsRadius) {
  const Track track = hairpins(6.0, 3.0);
  EXPECT_EQ(check_car_turns(track, 1.8, 5.0), "");
  // The outer edge lets the widest line be wider than the centre line.
  EXPECT_EQ(check_car_turns(track, 1.8, 6.5), "");
  EXPECT_THAT(check_car_turns(track, 1.8, 12.0), HasSubstr("a turn is tighter than the car can steer: at s = "));
  EXPECT_THAT(check_car_turns(track, 1.8, 12.0), HasSubstr("the car's least is 12 m"));
}

TEST_F(RoadFiles, TwentyKilometresAreARoad) {
  const fs::path file = write("long.csv", "x_m,y_m,w_tr_right_m,w_tr_left_m", 4000, [](int i) {
    const double a = 2 * pi * i / 4000.0, r = 2600 + 500 * std::cos(5 * a) + 60 * std::sin(31 * a);
    return std::vector{r * std::cos(a), r * std::sin(a), 4.0, 4.0};
  });
  const Track track = to_track(read({file}));
  EXPECT_GT(track.length(), 19000);
  EXPECT_EQ(check_car_turns(track, 1.8, 6.0), "");
}

}  // namespace
}  // namespace gripline
