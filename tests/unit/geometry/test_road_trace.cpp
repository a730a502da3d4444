#include "geometry/road_trace.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "support/road_files.hpp"

namespace gripline {
namespace test_road_trace {

using ::testing::HasSubstr;
using testing_support::gpx_circle;
using testing_support::RoadFiles;
namespace fs = std::filesystem;

constexpr double pi = std::numbers::pi;

TEST_F(RoadFiles, SlipsInNamesOfSlopesAreRefusedInARoadAndOtherColumnsTold) {
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

TEST_F(RoadFiles, AHeightThatCannotBeReadIsNotAMissingOne) {
  for (const auto& [height, why] :
       {std::pair{"400,06", "\"400,06\""}, {"400.06 m", "\"400.06 m\""}, {"high", "\"high\""}}) {
    std::string text = gpx_circle();
    const std::size_t at = text.find("<ele>", text.find("</ele>")) + 5;
    text.replace(at, text.find("</ele>", at) - at, height);
    write_file(scratch_ / "height.gpx", text);
    EXPECT_THAT(refusal([&] { read({scratch_ / "height.gpx"}, {.width = 10.0}); }),
                HasSubstr(std::string("height.gpx:4:1: point 2 has the height ") + why +
                          "; expected a number of metres without its unit, with '.' as the decimal sign"));
  }
  for (const char* missing : {"", " \n", "nan"}) {
    std::string text = gpx_circle();
    const std::size_t at = text.find("<ele>") + 5;
    text.replace(at, text.find("</ele>") - at, missing);
    write_file(scratch_ / "height.gpx", text);
    read({scratch_ / "height.gpx"}, {.width = 10.0});
    EXPECT_THAT(remarks_, ::testing::Contains("1 of 250 points have no height: interpolated")) << missing;
  }
}

TEST_F(RoadFiles, PlacesThatAreThereTwiceAreTold) {
  const fs::path file = write("both.csv", "x_m,y_m,z_m,lon,lat,ele", 100, [](int i) {
    return std::vector{100 * std::cos(2 * pi * i / 100), 60 * std::sin(2 * pi * i / 100), 0.0, 11.0, 48.0, 0.0};
  });
  read({file}, {.width = 8.0});
  EXPECT_THAT(remarks_, ::testing::ElementsAre("columns that are left out: lon,lat,ele"));
}

TEST_F(RoadFiles, WhatIsNoGpxIsRefused) {
  const fs::path file = scratch_ / "bad.gpx";
  write_file(file, "<gpx><trk>");
  EXPECT_THAT(refusal([&] { read({file}, {.width = 5}); }), HasSubstr("is not XML"));
  write_file(file, "<kml></kml>");
  EXPECT_THAT(refusal([&] { read({file}, {.width = 5}); }), HasSubstr("is not a GPX file"));
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
  EXPECT_THAT(refusal([&] { read({bad}, {.width = 5}); }), HasSubstr("is not XML"));
  write_file(bad, std::string("\xff\xfe<\0g\0", 6));
  EXPECT_THAT(refusal([&] { read({bad}, {.width = 5}); }), HasSubstr("is UTF-16; expected UTF-8"));
  // Elements that only look closed are counted.
  std::string deep = "<gpx>";
  for (int i = 0; i < 100000; ++i) deep += "<a b='/>'>";
  write_file(bad, deep);
  EXPECT_THAT(refusal([&] { read({bad}, {.width = 5}); }), HasSubstr("within each other"));
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

}  // namespace test_road_trace
}  // namespace gripline
