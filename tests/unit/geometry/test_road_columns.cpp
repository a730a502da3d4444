#include "geometry/road_columns.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "config/errors.hpp"
#include "support/scratch.hpp"

namespace gripline {
namespace test_road_columns {

using testing::AllOf;
using testing::Each;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing_support::scratch;

constexpr double degree = std::numbers::pi / 180.0;

/// A header and ten rows alike.
RoadColumns read(const std::string& header, const std::string& row) {
  const auto file = scratch("road.csv");
  std::string text = header + "\n";
  for (int i = 0; i < 10; ++i) text += row + "\n";
  std::ofstream(file, std::ios::binary) << text;
  return read_road_columns(file);
}

std::string why(const std::string& header, const std::string& row) {
  try {
    read(header, row);
  } catch (const InputError& error) {
    return error.what();
  }
  return "read";
}

TEST(RoadColumns, GriplinesOwnNamesAreReadWithoutAWord) {
  const RoadColumns road = read("# x_m,y_m,w_tr_right_m,w_tr_left_m,grade_rad,bank_rad", "100.5,200,4,5,0.01,-0.02");
  EXPECT_FALSE(road.on_earth);
  EXPECT_THAT(road.x, Each(100.5));
  EXPECT_THAT(road.y, Each(200.0));
  EXPECT_THAT(road.right, Each(4.0));
  EXPECT_THAT(road.left, Each(5.0));
  EXPECT_THAT(road.grade, Each(0.01));
  EXPECT_THAT(road.bank, Each(-0.02));
  EXPECT_THAT(road.height, IsEmpty());
  EXPECT_THAT(road.remarks, IsEmpty());
  EXPECT_EQ(road.x.size(), 10u);
  EXPECT_EQ(road.line.front(), 2);
}

TEST(RoadColumns, NamesOfOthersAreReadInAnyCase) {
  for (const char* places :
       {"easting,northing", "East,North", "X_M,Y_M", "pose.position.x,pose.position.y", "\"x\",\"y\""})
    for (const char* widths : {"right,left", "w_right,w_left", "Width_Right,Width_Left", "W_TR_RIGHT_M,W_TR_LEFT_M"}) {
      const std::string header = std::string(places) + "," + widths;
      SCOPED_TRACE(header);
      const RoadColumns road = read(header, "100.5,200,4,5");
      EXPECT_THAT(road.x, Each(100.5));
      EXPECT_THAT(road.y, Each(200.0));
      EXPECT_THAT(road.right, Each(4.0));
      EXPECT_THAT(road.left, Each(5.0));
    }
  EXPECT_THAT(read("easting,northing,right,left", "1,2,3,4").remarks,
              ElementsAre("read: x from easting (m), y from northing (m), right from right (m), left from left (m)"));
}

TEST(RoadColumns, UnitsStandAtEndsInBracketsOrInARow) {
  for (const char* header :
       {"x_mm,y_mm,w_right_mm,w_left_mm", "x (mm),y (mm),right [mm],left [mm]", "x,y,right,left\nmm,mm,mm,mm"}) {
    SCOPED_TRACE(header);
    const RoadColumns road = read(header, "100500,200000,4000,5000");
    EXPECT_NEAR(road.x[0], 100.5, 1e-9);
    EXPECT_NEAR(road.y[0], 200.0, 1e-9);
    EXPECT_NEAR(road.right[0], 4.0, 1e-9);
    EXPECT_NEAR(road.left[0], 5.0, 1e-9);
  }
  EXPECT_NEAR(read("x_km,y_km", "1.5,2").x[0], 1500.0, 1e-9);
  for (const auto& [unit, metres] : {std::pair("mm", 1e-3), {"cm", 1e-2}, {"m", 1.0}, {"km", 1e3}, {"ft", 0.3048}})
    for (const std::string path : {"odom.", "pose.position.", "/odom/pose/pose/position/"}) {
      SCOPED_TRACE(path + unit);
      const RoadColumns road = read(path + "x_" + unit + "," + path + "y_" + unit, "1000,2000");
      EXPECT_NEAR(road.x[0], 1000.0 * metres, 1e-6);
      EXPECT_NEAR(road.y[0], 2000.0 * metres, 1e-6);
    }
  const RoadColumns slopes = read("x_m,y_m,w_right_m,w_left_m,grade_deg,bank [deg]", "1,2,3,4,2,-1");
  EXPECT_NEAR(slopes.grade[0], 2 * degree, 1e-12);
  EXPECT_NEAR(slopes.bank[0], -degree, 1e-12);
}

TEST(RoadColumns, SemicolonsTabsAndDecimalCommasAreRead) {
  const RoadColumns road = read("East (ft);North (ft);Width right [cm];Width left [cm]", "1000,5;2000,25;400,5;500,25");
  EXPECT_NEAR(road.x[0], 0.3048 * 1000.5, 1e-9);
  EXPECT_NEAR(road.right[0], 4.005, 1e-9);
  EXPECT_THAT(
      road.remarks,
      ElementsAre("columns separated by semicolons, decimal commas",
                  "read: x from East (ft), y from North (ft), right from Width right (cm), left from Width left "
                  "(cm)"));
  EXPECT_THAT(read("x_m\ty_m", "1.5\t2.5").remarks, ElementsAre("columns separated by tabs"));
}

TEST(RoadColumns, OneWidthIsHalvedToBothSides) {
  const RoadColumns road = read("x_m,y_m,width", "1,2,9");
  EXPECT_THAT(road.right, Each(4.5));
  EXPECT_THAT(road.left, Each(4.5));
  EXPECT_THAT(road.remarks,
              ElementsAre("read: x from x_m (m), y from y_m (m), right and left, half each, from width (m)"));
  // Both sides go before it.
  EXPECT_THAT(read("x_m,y_m,width,right,left", "1,2,9,3,4").right, Each(3.0));
}

TEST(RoadColumns, PlacesOnTheEarthAreDegrees) {
  const RoadColumns road = read("Latitude,Longitude", "48.5,11.25");
  EXPECT_TRUE(road.on_earth);
  EXPECT_THAT(road.x, Each(11.25));
  EXPECT_THAT(road.y, Each(48.5));
  const RoadColumns radians = read("lat_rad,lon_rad", "0.5,0.25");
  EXPECT_NEAR(radians.x[0], 0.25 / degree, 1e-9);
  EXPECT_NEAR(radians.y[0], 0.5 / degree, 1e-9);
}

TEST(RoadColumns, ColumnsOfLogsThatOnlySoundAlikeAreLeftOut) {
  const RoadColumns log =
      read("pose.position.x,pose.position.y,pose.orientation.x,goal.position.y,brake.right", "1,2,3,4,5");
  EXPECT_THAT(log.x, Each(1.0));
  EXPECT_THAT(log.y, Each(2.0));
  EXPECT_THAT(log.right, IsEmpty());
  EXPECT_THAT(log.remarks.back(), "columns that are left out: pose.orientation.x,goal.position.y,brake.right");
}

TEST(RoadColumns, TextInColumnsThatAreNotReadIsNoFault) {
  EXPECT_THAT(read("x_m,y_m,speed,note", "1,2,3,dry").x, Each(1.0));
}

TEST(RoadColumns, MissingPlacesAreToldWithWhatIsFound) {
  EXPECT_THAT(
      why("eastng,nrthing,right,left", "1,2,3,4"),
      AllOf(HasSubstr("road.csv:1:1: expected columns x_m,y_m or lat,lon (and w_tr_right_m,w_tr_left_m where it "
                      "has widths); found eastng,nrthing,right,left"),
            EndsWith("; did you mean \"easting\" by \"eastng\" and \"northing\" by \"nrthing\"?")));
}

TEST(RoadColumns, AMissingHeaderIsTold) {
  EXPECT_THAT(why("1,2,3,4", "1,2,3,4"),
              HasSubstr("no header line of 4 names above the first row of numbers; expected the names of the columns, "
                        "as x_m,y_m,w_tr_right_m,w_tr_left_m"));
}

TEST(RoadColumns, AMisspeltWidthIsNamed) {
  EXPECT_THAT(why("x_m,y_m,w_tr_rigth_m,w_tr_left_m", "1,2,3,4"),
              EndsWith("w_tr_right_m and w_tr_left_m go together; no column for the right half width; did you mean "
                       "\"w_tr_right_m\" by \"w_tr_rigth_m\"?"));
}

TEST(RoadColumns, UnitsOfAnotherKindAndSlipsInNamesOfSlopesAreRefused) {
  EXPECT_THAT(why("x [m/s],y [m/s]", "1,2"), HasSubstr("column \"x\" has the unit \"m/s\"; expected a length"));
  EXPECT_THAT(why("x_m,y_m,w_right,w_left,grade", "1,2,3,4,0"),
              HasSubstr("unknown column \"grade\"; did you mean \"grade_rad\"?"));
  EXPECT_THAT(why("x_m,y_m,w_right,w_left,bnak_rad", "1,2,3,4,0"), HasSubstr("did you mean \"bank_rad\"?"));
  EXPECT_THAT(why("x_m,y_m,w_right,w_left,grade (?)", "1,2,3,4,0"), HasSubstr("has the unit \"?\"; expected an angle"));
}

TEST(RoadColumns, SlopesInPercentAreRiseOverWay) {
  for (const char* header : {"x_m,y_m,w_right,w_left,grade (%)", "x_m,y_m,w_right,w_left,grade_pct"})
    EXPECT_NEAR(read(header, "1,2,3,4,5").grade[0], std::atan(0.05), 1e-12);
}

TEST(RoadColumns, OtherColumnsBesideWidthsAreLeftOutByName) {
  EXPECT_THAT(read("id,s_m,x_m,y_m,w_tr_right_m,w_tr_left_m", "1,2,3,4,5,6").remarks,
              ElementsAre("columns that are left out: id,s_m"));
}

TEST(RoadColumns, ATraceGoesWithoutWhatHasAnotherUnit) {
  const RoadColumns log = read("time,lat,lon,ele,grade (%),bank (?),left (km/h)", "1,2,3,4,5,6,7");
  EXPECT_THAT(log.height, Each(4.0));
  EXPECT_THAT(log.grade, IsEmpty());
  EXPECT_THAT(log.remarks, ElementsAre("columns that are left out for their units: grade (%), bank (?), left (km/h)",
                                       "columns that are left out: time"));
  // Accelerations beside places on the earth.
  EXPECT_TRUE(read("lat,lon,x (g),y (g),z (g)", "1,2,3,4,5").on_earth);
  EXPECT_THAT(read("x_m,y_m,grade_deg", "1,2,3").grade, IsEmpty());
  EXPECT_THAT(read("x_m,y_m,grade_rad", "1,2,3").grade, Each(3.0));
}

TEST(RoadColumns, APairHasOneUnit) {
  EXPECT_THAT(why("x_ft,y,width_ft", "1,2,3"),
              HasSubstr("road.csv:1:1: \"x_ft\" in ft and \"y\" without a unit: expected one unit for both"));
  EXPECT_THAT(why("Easting (ft),Northing,width_ft", "1,2,3"), HasSubstr("\"Northing\" without a unit: expected one"));
  EXPECT_THAT(why("x_ft,y_mm", "1,2"), HasSubstr("\"x_ft\" in ft and \"y_mm\" in mm: expected one"));
  EXPECT_THAT(why("x,y,w_right_ft,w_left", "1,2,3,4"), HasSubstr("\"w_left\" without a unit: expected one"));
  EXPECT_THAT(why("x,y,right,left\nm,m,ft,", "1,2,3,4"), HasSubstr("\"left\" without a unit: expected one"));
  EXPECT_THAT(why("lat_rad,lon", "1,2"), HasSubstr("\"lon\" without a unit and \"lat_rad\" in rad: expected one"));
  EXPECT_THAT(read("x_m,y", "1,2").y, Each(2.0)) << "without a unit it is in m";
}

TEST(RoadColumns, LengthsWithoutAUnitBesidePlacesInFeetAreRefused) {
  EXPECT_THAT(why("East (ft),North (ft),Elevation,w_right,w_left", "1,2,3,4,5"),
              EndsWith("columns without a unit beside \"East\" in ft: Elevation,w_right,w_left; expected theirs in the "
                       "header, as \"Elevation (ft)\" or \"Elevation (m)\""));
  EXPECT_THAT(why("x_km,y_km,width", "1,2,3"), HasSubstr("beside \"x_km\" in km: width;"));
  EXPECT_THAT(why("x,y,z,width\nm,m,ft,", "1,2,3,4"), HasSubstr("beside \"z\" in ft: width;"));
  EXPECT_THAT(read("x_ft,y_ft,w_right_m,w_left_m", "1,2,3,4").right, Each(3.0));
  EXPECT_THAT(read("x,y,right,left\nm,m,,", "1,2,3,4").right, Each(3.0));
  EXPECT_NEAR(read("x_m,y_m,z,width_ft", "1,2,3,4").right[0], 2 * 0.3048, 1e-9) << "it states its own";
}

TEST(RoadColumns, PlacesAreAPairOfNames) {
  EXPECT_THAT(read("px,easting,northing", "1,2,3").x, Each(2.0));
  EXPECT_THAT(why("px,northing", "1,2"), HasSubstr("\"px\" and \"northing\" are no pair of names"));
  EXPECT_THAT(why("x,y,w_right,left", "1,2,3,4"), HasSubstr("\"w_right\" and \"left\" are no pair of names"));
  EXPECT_THAT(read("x,y,w_tr_right_m,right,left", "1,2,3,4,5").right, Each(4.0));
  EXPECT_THAT(read("odom.position.x,gps.position.x,gps.position.y", "1,2,3").x, Each(2.0));
  EXPECT_TRUE(read("lat,x,lon", "1,2,3").on_earth);
  const RoadColumns two = read("easting,northing,px,py", "1,2,3,4");
  EXPECT_THAT(two.x, Each(3.0));
  EXPECT_THAT(two.y, Each(4.0));
  EXPECT_THAT(two.remarks, testing::Contains("several pairs of places: px,py are read, not easting,northing"));
}

TEST(RoadColumns, WhatIsThereTwiceIsRefused) {
  EXPECT_THAT(why("x_m,x_m,y_m", "1,2,3"), HasSubstr("column \"x_m\" is there twice"));
}

TEST(RoadColumns, CellsAndRowsThatLackNumbersAreRefusedWithTheirLines) {
  const auto refusal = [](const std::string& line) { return why("x_m,y_m,speed\n1,2,3\n" + line, "1,2,3"); };
  EXPECT_THAT(refusal("1,2 m,3"), HasSubstr("road.csv:3:1: column \"y_m\": expected a finite number, found \"2 m\""));
  EXPECT_THAT(refusal("1,,3"), HasSubstr("road.csv:3:1: column \"y_m\": expected a finite number, found \"\""));
  EXPECT_THAT(refusal("1,2,3,4"), HasSubstr("road.csv:3:1: expected 3 columns as in the header, found another number"));
}

}  // namespace test_road_columns
}  // namespace gripline
