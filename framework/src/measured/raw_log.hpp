// A log row by row as it was written, before any grid: what is read, refused and mended there.
#pragma once

#include <limits>

#include "measured/log_file.hpp"
#include "util/csv.hpp"

namespace gripline::diagnose {

inline constexpr std::array<const char*, channels> channel_columns = {"x_m",    "y_m",    "yaw_rad",
                                                                      "vx_mps", "vy_mps", "yaw_rate_radps"};
inline constexpr double shortest_log = 5.0;  // [s]
inline constexpr double nothing_read = std::numeric_limits<double>::quiet_NaN();

struct Raw {
  std::vector<double> t, d, delta;
  std::vector<double> reading;   // rows x 6
  std::vector<std::size_t> row;  // of the table
  std::size_t size() const { return t.size(); }
  double& at(std::size_t i, std::size_t c) { return reading[i * channels + c]; }
  double at(std::size_t i, std::size_t c) const { return reading[i * channels + c]; }
  /// These rows only.
  Raw picked(std::span<const std::size_t> rows) const;
};

std::string short_text(double value, int digits = 3);
/// Throws InputError with the table's file and, where given, the line of a row.
[[noreturn]] void refuse(const CsvTable& table, const std::string& message, std::size_t row = SIZE_MAX);

/// Throws InputError when columns are missing or stand there twice.
Raw read_columns(const CsvTable& table);
Health absent_lateral_speed(const CsvTable& table);
/// Time must run forward; equal stamps lose their later row. Returns the step.
double check_time(const CsvTable& table, Raw& raw, std::vector<Health>& health);

/// What is far off whatever the units: readings that stand grossly apart from those around them are left out, and whole
/// rows when their commands went with them.
void drop_gross_outliers(Raw& raw, std::vector<Health>& health);
/// Readings that stand alone by a few standard deviations.
std::size_t drop_outliers(Raw& raw);
void unwrap_yaw(Raw& raw, std::vector<Health>& health);

/// A heading in radians is seen to jump by half a turn where it is wrapped, which is rare; one in degrees does so in
/// every quick bend.
void check_yaw_is_radians(const CsvTable& table, const Raw& raw);
/// Channels against each other over half a second: a factor of 3.6, 57.3 or 1000 is a unit, and a sign is a frame.
void check_units(const CsvTable& table, const Raw& raw, double dt, const LogExpectations& expected,
                 std::vector<Health>& health);
void check_place(const CsvTable& table, const Raw& raw, const Road& road);

}  // namespace gripline::diagnose
