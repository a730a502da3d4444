#include "calibrate/predict/judged_log.hpp"

#include <cmath>

#include "measured/channels.hpp"
#include "measured/log/log_outliers.hpp"

namespace gripline::calibrate {

using measured::Channel;

JudgedLog::JudgedLog(const FitLog& as_read) : session_(*as_read.session), log_(as_read) {
  gross_outliers_ = measured::drop_gross_outliers(session_);
  place_spikes_ = measured::drop_place_spikes(session_);
  log_.session = &session_;
  log_.truth = readings_at(session_, log_.starts);
  for (const double start : log_.starts.time) {
    const std::size_t row = session_.row_before(start + 1e-9);
    bool follows = false;
    for (std::size_t c = 0; c < channels; ++c) follows = follows || follows_outlier(*as_read.session, row, c);
    follows_outlier_.push_back(follows);
  }
}

/// Whether the reading of a row was left out or, of places, one of the three before: what is predicted follows places
/// by its gain, and has then left a wild one again.
bool JudgedLog::follows_outlier(const Session& as_read, std::size_t row, std::size_t channel) const {
  const auto gone = [&](std::size_t i) {
    return std::isnan(session_.at(i, channel)) && !std::isnan(as_read.at(i, channel));
  };
  if (gone(row)) return true;
  std::size_t readings = channel == Channel::x || channel == Channel::y ? 3 : 0;
  for (std::size_t i = row; readings > 0 && i-- > 0;) {
    if (std::isnan(as_read.at(i, channel))) continue;
    if (gone(i)) return true;
    --readings;
  }
  return false;
}

bool JudgedLog::counts(std::size_t start, double slowest) const {
  return !follows_outlier_[start] && std::abs(session_.interpolate(Channel::vx, log_.starts.time[start])) >= slowest;
}

CountedStarts JudgedLog::counted(std::size_t horizon, double slowest) const {
  CountedStarts out;
  for (std::size_t i = 0; i < log_.starts.time.size(); ++i) {
    if (!counts(i, slowest)) continue;
    out.start.push_back(i);
    out.time.push_back(log_.starts.time[i]);
    const double* const truth = log_.truth.data() + log_.starts.reading_index(i, horizon);
    out.truth.insert(out.truth.end(), truth, truth + channels);
  }
  return out;
}

}  // namespace gripline::calibrate
