// Files of roads that tests write and read.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "config/errors.hpp"
#include "geometry/road_reading.hpp"
#include "support/host_support.hpp"
#include "util/csv_writer.hpp"

namespace gripline::testing_support {

class RoadFiles : public ::testing::Test {
 protected:
  /// A line of text per point, as a file.
  std::filesystem::path write(const std::string& name, const std::string& header, int count,
                              const std::function<std::vector<double>(int)>& row) {
    const std::filesystem::path file = scratch_ / name;
    CsvWriter csv(file, header);
    for (int i = 0; i < count; ++i) {
      for (const double value : row(i)) csv << value;
      csv.end_row();
    }
    csv.finish();
    return file;
  }
  /// 160 points from a share of a lap to another on an ellipse of 200 m by 120 m, 8 m wide on the left and 4 m on the
  /// right.
  std::filesystem::path ellipse(double from = 0.0, double to = 1.0) {
    return write("ellipse.csv", "# x_m,y_m,w_tr_right_m,w_tr_left_m", 160, [=](int i) {
      const double a = 2 * std::numbers::pi * (from + (to - from) * i / 160.0);
      return std::vector{100 * std::cos(a), 60 * std::sin(a), 4.0, 8.0};
    });
  }
  RoadTable read(const std::vector<std::filesystem::path>& files, const RoadReading& reading = {}) {
    remarks_.clear();
    return read_road(files, reading, remarks_);
  }
  static std::string refusal(const std::function<void()>& call) {
    try {
      call();
    } catch (const InputError& error) {
      return error.what();
    } catch (const GeometryError& error) {
      return error.what();
    }
    return "not refused";
  }

  Folder scratch_;
  std::vector<std::string> remarks_;
};

/// A circle of 300 m radius around 48 degrees north, one lap and a quarter with heights, as a GPX file.
inline std::string gpx_circle() {
  std::string text = "<?xml version=\"1.0\"?>\n<gpx><trk><trkseg>\n";
  for (int i = 0; i < 250; ++i) {
    const double a = 2 * std::numbers::pi * i / 200.0;
    const double north = 300 * std::sin(a), east = 300 * std::cos(a);
    char line[160];
    std::snprintf(line, sizeof line, "<trkpt lat=\"%.9f\" lon=\"%.9f\"><ele>%.3f</ele></trkpt>\n",
                  48.0 + north / 111194.0, 11.0 + east / 74555.0, 400.0 + 5 * std::sin(a));
    text += line;
  }
  return text + "</trkseg></trk></gpx>\n";
}

}  // namespace gripline::testing_support
