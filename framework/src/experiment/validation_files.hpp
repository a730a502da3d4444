// What both kinds of validation measure and write: channels of a drive, true and predicted.
#pragma once

#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "car/corrected_model.hpp"
#include "util/csv_writer.hpp"

namespace gripline {

/// One channel's agreement: coefficient of determination 1 - sum (e - p)^2 / sum (e - mean e)^2, and error in `unit`.
struct ChannelScore {
  std::string estimator, channel, unit;
  std::size_t n = 0;
  double r2 = 0, rmse = 0;
};

/// Truth and prediction of one channel along a lap; slip angles [rad] where the channel is an axle's force.
struct ChannelTrace {
  std::vector<double> t, truth, predicted, slip;
  void add(double time, double true_value, double prediction, double slip_angle = NAN) {
    t.push_back(time);
    truth.push_back(true_value);
    predicted.push_back(prediction);
    slip.push_back(slip_angle);
  }
};
/// e_vx, e_vy, e_omega [m/s2, m/s2, rad/s2], force_front, force_rear [N].
using ChannelTraces = std::array<ChannelTrace, 5>;

/// What the model of a step leaves unexplained, as rates of vx, vy, omega.
std::array<double, 3> unexplained(const State& after, const State& predicted, double dt);

/// OUT/validation.csv (estimator,channel,unit,n,r2,rmse) and OUT/validation_traces.csv, kept until write().
class ValidationFiles {
 public:
  ValidationFiles();
  ValidationFiles(const ValidationFiles&) = delete;  // its writers append to its own texts
  /// Adds the channels that have values, and their scores to `all`.
  void add(const std::string& estimator, const ChannelTraces& traces, std::vector<ChannelScore>& all);
  /// Each file is then complete or the one that was there. Throws std::runtime_error when the disk refuses.
  void write(const std::filesystem::path& out) const;

 private:
  std::string scores_text_, traces_text_;
  CsvWriter scores_, traces_;
};

}  // namespace gripline
