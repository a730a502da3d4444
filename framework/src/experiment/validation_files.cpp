#include "experiment/validation_files.hpp"

#include "experiment/result_files.hpp"

namespace gripline {
namespace {

constexpr std::array<const char*, 5> channel_names = {"e_vx", "e_vy", "e_omega", "force_front", "force_rear"};
constexpr std::array<const char*, 5> channel_units = {"m/s2", "m/s2", "rad/s2", "N", "N"};

ChannelScore score(const std::string& estimator, std::size_t channel, const ChannelTrace& trace) {
  ChannelScore s = {estimator, channel_names[channel], channel_units[channel], trace.truth.size(), 0, 0};
  double mean = 0.0, residual = 0.0, total = 0.0;
  for (const double e : trace.truth) mean += e / static_cast<double>(s.n);
  for (std::size_t i = 0; i < s.n; ++i) {
    residual += (trace.truth[i] - trace.predicted[i]) * (trace.truth[i] - trace.predicted[i]);
    total += (trace.truth[i] - mean) * (trace.truth[i] - mean);
  }
  s.r2 = total > 0.0 ? 1.0 - residual / total : NAN;
  s.rmse = s.n > 0 ? std::sqrt(residual / static_cast<double>(s.n)) : NAN;
  return s;
}

}  // namespace

std::array<double, 3> unexplained(const State& after, const State& predicted, double dt) {
  return {(after.vx - predicted.vx) / dt, (after.vy - predicted.vy) / dt, (after.omega - predicted.omega) / dt};
}

ValidationFiles::ValidationFiles()
    : scores_(scores_text_, "estimator,channel,unit,n,r2,rmse"),
      traces_(traces_text_, "estimator,channel,t_s,truth,predicted,slip_rad") {}

void ValidationFiles::add(const std::string& estimator, const ChannelTraces& traces, std::vector<ChannelScore>& all) {
  for (std::size_t channel = 0; channel < traces.size(); ++channel) {
    const ChannelTrace& trace = traces[channel];
    if (trace.t.empty()) continue;
    const ChannelScore s = score(estimator, channel, trace);
    all.push_back(s);
    scores_ << s.estimator << s.channel << s.unit << static_cast<std::int64_t>(s.n) << s.r2 << s.rmse;
    scores_.end_row();
    for (std::size_t i = 0; i < trace.t.size(); ++i) {
      traces_ << estimator << channel_names[channel] << trace.t[i] << trace.truth[i] << trace.predicted[i]
              << trace.slip[i];
      traces_.end_row();
    }
  }
}

void ValidationFiles::write(const std::filesystem::path& out) const {
  write_file(out / result_files::validation_traces, traces_text_);
  write_file(out / result_files::validation, scores_text_);
}

}  // namespace gripline
