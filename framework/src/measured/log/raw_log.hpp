// A log row by row as it was written, before resampling.
#pragma once

#include "measured/finding.hpp"
#include "measured/log/log.hpp"
#include "util/csv.hpp"

namespace gripline::measured {

inline constexpr double shortest_log = 5.0;  // [s]

/// Rows with a time and both commands; SI units, commands as in CommandSample.
struct RawLog {
  std::vector<double> t, d, delta;
  std::vector<double> reading;   // rows x 6
  std::vector<std::size_t> row;  // of the table
  std::size_t size() const { return t.size(); }
  double& at(std::size_t i, std::size_t c) { return reading[i * channels + c]; }
  double at(std::size_t i, std::size_t c) const { return reading[i * channels + c]; }
  /// These rows only.
  RawLog picked(std::span<const std::size_t> rows) const;
};

/// Throws InputError with the table's file and, where given, the line of a row.
[[noreturn]] void refuse(const CsvTable& table, const std::string& message, std::size_t row = SIZE_MAX);

/// Throws InputError when columns are missing or stand there twice.
RawLog read_columns(const CsvTable& table);
/// The note on a log without vy_mps.
Finding absent_lateral_speed(const CsvTable& table);
/// The step that most of these times [s] are apart, to the microsecond where it is that; of rows in bursts their mean.
/// 0 of less than two times.
double sampling_interval(std::span<const double> times);
/// Returns the sample time [s]. Throws InputError when time runs backward; of rows with equal stamps the first is kept.
double check_time(const CsvTable& table, RawLog& raw, std::vector<Finding>& health);

}  // namespace gripline::measured
