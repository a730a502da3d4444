// A quantity given at stations of a closed road: linear between them, and periodic.
#pragma once

#include <cstddef>
#include <vector>

namespace gripline {

class StationTable {
 public:
  /// The same value everywhere.
  StationTable(double value = 0.0) : values_{value} {}  // NOLINT(google-explicit-constructor): a number is a table
  /// Stations strictly increasing inside [0, period); throws GeometryError otherwise or if a value is NaN.
  /// An infinite value (no wall) holds up to the next station: nothing is interpolated from it.
  StationTable(double period, std::vector<double> stations, std::vector<double> values);

  double at(double s) const;
  bool constant() const { return values_.size() == 1; }
  /// Between them it is linear; empty where it is constant.
  const std::vector<double>& stations() const { return stations_; }
  double minimum() const;
  double maximum() const;

 private:
  double period_ = 0.0;
  std::vector<double> stations_;
  std::vector<double> values_;
  std::vector<std::size_t> bucket_;  ///< last station at or before the start of the i-th equal share of the period
};

}  // namespace gripline
