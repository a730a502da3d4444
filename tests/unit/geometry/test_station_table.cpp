#include "geometry/station_table.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "geometry/plane.hpp"

namespace gripline {
namespace test_station_table {

using ::testing::HasSubstr;

TEST(StationTable, IsLinearAndPeriodic) {
  const StationTable table(10.0, {1.0, 4.0, 9.0}, {1.0, 4.0, -1.0});
  EXPECT_DOUBLE_EQ(table.at(2.5), 2.5);
  EXPECT_DOUBLE_EQ(table.at(9.5), -0.5);
  EXPECT_DOUBLE_EQ(table.at(0.5), 0.5);
  EXPECT_DOUBLE_EQ(table.at(-0.5), -0.5);
  EXPECT_DOUBLE_EQ(table.at(14.0), 4.0);
  EXPECT_EQ(StationTable(3.0).at(1e9), 3.0);
  EXPECT_THROW(StationTable(10.0, {1.0, 1.0}, {0.0, 0.0}), GeometryError);
  EXPECT_THROW(StationTable(10.0, {1.0, 10.0}, {0.0, 0.0}), GeometryError);
  EXPECT_THROW(StationTable(10.0, {1.0, 2.0}, {0.0, NAN}), GeometryError);
}

std::string why_refused(double period, const std::vector<double>& stations, const std::vector<double>& values) {
  try {
    StationTable(period, stations, values);
  } catch (const GeometryError& error) {
    return error.what();
  }
  return "not refused";
}

TEST(StationTable, SaysWhichRowIsWrong) {
  EXPECT_THAT(why_refused(10, {}, {}), HasSubstr("at least one row"));
  EXPECT_THAT(why_refused(10, {0, 1}, {5}), HasSubstr("at least one row"));
  EXPECT_THAT(why_refused(10, {0, 3, 3}, {1, 1, 1}), HasSubstr("row 3 of a table by station has station 3"));
  EXPECT_THAT(why_refused(10, {0, 3, 12}, {1, 1, 1}), HasSubstr("row 3 of a table by station has station 12"));
  EXPECT_THAT(why_refused(10, {-1, 3}, {1, 1}), HasSubstr("row 1 of a table by station has station -1"));
  EXPECT_THAT(why_refused(10, {0, NAN}, {1, 1}), HasSubstr("row 2"));
  EXPECT_THAT(why_refused(10, {0, 3}, {1, NAN}), HasSubstr("row 2 of a table by station is not a number"));
  EXPECT_THAT(why_refused(NAN, {0, 3}, {1, 1}), HasSubstr("row 1"));
}

/// The row is looked up by shares of the length: rows that crowd in one share must not be missed.
TEST(StationTable, FindsTheRowAsAPlainSearchDoes) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  for (const int rows : {2, 3, 17, 300}) {
    const double period = 50.0;
    std::vector<double> s, v;
    double sum = 0.0;
    for (int i = 0; i < rows; ++i) {
      sum += std::pow(10.0, -6.0 * share(random));
      s.push_back(sum);
      v.push_back(share(random));
    }
    for (double& station : s) station *= 0.9 * period / sum;
    const StationTable table(period, s, v);
    const auto plain = [&](double at) {
      std::size_t i = s.size() - 1;
      for (std::size_t k = 0; k < s.size(); ++k)
        if (s[k] <= at) i = k;
      if (at < s[0]) at += period, i = s.size() - 1;
      const std::size_t j = (i + 1) % s.size();
      const double next = j == 0 ? s[0] + period : s[j];
      return v[i] + (at - s[i]) / (next - s[i]) * (v[j] - v[i]);
    };
    for (int k = 0; k < 2000; ++k) {
      const double at = period * share(random);
      EXPECT_NEAR(table.at(at), plain(at), 1e-12) << rows << ' ' << at;
    }
    for (std::size_t i = 0; i < s.size(); ++i) EXPECT_EQ(table.at(s[i]), v[i]);
  }
}

TEST(StationTable, IsContinuousOverTheSeam) {
  const StationTable table(10.0, {2.0, 7.0}, {1.0, 3.0});
  EXPECT_NEAR(table.at(std::nextafter(10.0, 0.0)), 1.8, 1e-12);
  EXPECT_NEAR(table.at(0.0), 1.8, 1e-12);
  EXPECT_NEAR(table.at(-1e-13), 1.8, 1e-12);
  EXPECT_NEAR(table.at(std::nextafter(2.0, 0.0)), 1.0, 1e-12);
  EXPECT_EQ(table.at(NAN), table.at(0.0));  // a station that is no number is the first
}

TEST(StationTable, NothingIsInterpolatedToOrFromAnInfiniteValue) {
  const StationTable walls(10.0, {1.0, 2.0, 4.0}, {INFINITY, 0.5, 0.7});
  EXPECT_EQ(walls.at(1.0), INFINITY);
  EXPECT_EQ(walls.at(1.999), INFINITY);
  EXPECT_EQ(walls.at(2.0), 0.5);
  EXPECT_DOUBLE_EQ(walls.at(3.0), 0.6);
  EXPECT_EQ(walls.at(9.0), 0.7);
  EXPECT_EQ(walls.at(0.5), 0.7);
  EXPECT_EQ(walls.minimum(), 0.5);
  EXPECT_EQ(walls.maximum(), INFINITY);
}

TEST(StationTable, OneRowIsTheSameEverywhere) {
  const StationTable row(10.0, {4.0}, {2.5});
  EXPECT_TRUE(row.constant());
  EXPECT_EQ(row.at(3.9), 2.5);
  EXPECT_EQ(row.at(-7.0), 2.5);
  EXPECT_FALSE(StationTable(10.0, {1.0, 2.0}, {2.5, 2.5}).constant());
}

}  // namespace test_station_table
}  // namespace gripline
