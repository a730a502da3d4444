// A log as it judges predictions: without outliers, of which only later rows tell that they are some. What is predicted
// reads nothing later, and has met them as they came.
#pragma once

#include <vector>

#include "calibrate/fit/prediction_errors.hpp"

namespace gripline::calibrate {

/// The starts that count for errors and, starts x 6, what the log shows of one horizon after them.
struct CountedStarts {
  std::vector<std::size_t> start;  // indices
  std::vector<double> time;        // [s]
  std::vector<double> truth;
};

class JudgedLog {
 public:
  /// Copies the session of `as_read`, which is what predictions are made from.
  explicit JudgedLog(const FitLog& as_read);
  JudgedLog(const JudgedLog&) = delete;
  JudgedLog& operator=(const JudgedLog&) = delete;

  /// Of the session without outliers.
  const FitLog& log() const { return log_; }
  /// Readings far off all around them.
  std::size_t gross_outliers() const { return gross_outliers_; }
  /// Places that jump there and back.
  std::size_t place_spikes() const { return place_spikes_; }

  /// Whether errors of a start count: the car moves at `slowest` [m/s] or faster, and what the prediction follows of
  /// the last rows is no outlier.
  bool counts(std::size_t start, double slowest) const;
  /// All that count, with the truth at horizon number `horizon`.
  CountedStarts counted(std::size_t horizon, double slowest) const;

 private:
  bool follows_outlier(const Session& as_read, std::size_t row, std::size_t channel) const;

  Session session_;
  FitLog log_;
  std::size_t gross_outliers_ = 0, place_spikes_ = 0;
  std::vector<bool> follows_outlier_;  // by start
};

}  // namespace gripline::calibrate
