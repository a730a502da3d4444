#include "calibrate/predict/prediction_samples.hpp"

#include <charconv>
#include <cmath>
#include <numbers>

#include "measured/channels.hpp"

namespace gripline::calibrate {
namespace {

using measured::Channel;

/// Turns between the unwrapped yaw and the one in the log's column at a row, and whether that column wraps.
class YawColumn {
 public:
  explicit YawColumn(const Session& session) : session_(session) {}
  /// A predicted yaw as the column would show it, judged by the rows up to `start`, which never falls.
  double shown(double yaw, double start) {
    const double pi = std::numbers::pi;
    for (; row_ < session_.rows() && session_.t[row_] <= start + 1e-9; ++row_) {
      const double written = session_.written_yaw[row_];
      if (std::isnan(written)) continue;
      turns_ = session_.at(row_, Channel::yaw) - written;
      inside_ = inside_ && std::abs(written) <= pi + 1e-3;
    }
    const double value = yaw - turns_;
    return inside_ ? std::remainder(value, 2.0 * pi) : value;
  }

 private:
  const Session& session_;
  std::size_t row_ = 0;
  double turns_ = 0;
  bool inside_ = true;
};

/// A cell; empty where there is no such number.
void append(std::string& line, double value, int digits) {
  if (!line.empty()) line += ',';
  if (!std::isfinite(value)) return;
  char buffer[64];
  const auto [end, code] = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, digits);
  if (code == std::errc()) line.append(buffer, end);
}

}  // namespace

std::string samples_table(const Session& session, const Starts& starts, std::span<const double> predicted) {
  constexpr int of_times = 6, of_places = 5, of_others = 7;  // digits after the point
  std::string out = "start_s,t_s,x_m,y_m,yaw_rad,vx_mps,vy_mps,yaw_rate_radps\n";
  YawColumn yaw(session);
  for (std::size_t i = 0; i < starts.time.size(); ++i)
    for (std::size_t j = 0; j < starts.horizons.size(); ++j) {
      const double* const p = predicted.data() + starts.reading_index(i, j);
      if (!std::isfinite(p[Channel::vx])) continue;
      const bool place = session.has[Channel::x];
      std::string line;
      append(line, session.begin + starts.time[i], of_times);
      append(line, session.begin + starts.time[i] + starts.horizons[j], of_times);
      append(line, place ? p[Channel::x] : NAN, of_places);
      append(line, place ? p[Channel::y] : NAN, of_places);
      append(line, session.has[Channel::yaw] ? yaw.shown(p[Channel::yaw], starts.time[i]) : NAN, of_others);
      for (const std::size_t c : {Channel::vx, Channel::vy, Channel::yaw_rate}) append(line, p[c], of_others);
      out += line + '\n';
    }
  return out;
}

}  // namespace gripline::calibrate
