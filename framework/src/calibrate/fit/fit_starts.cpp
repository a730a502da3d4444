#include "calibrate/fit/fit_starts.hpp"

#include <cmath>

namespace gripline::calibrate {
namespace {

/// The starts that `keep` chooses by their time since the log's begin, with what the log shows of them.
template <class Keep>
FitLog kept_of(const FitLog& all, const Keep& keep) {
  FitLog part = all;
  part.starts.time.clear();
  part.truth.clear();
  const std::size_t per_start = all.starts.horizons.size() * channels;
  for (std::size_t i = 0; i < all.starts.time.size(); ++i) {
    if (!keep(all.starts.time[i] - all.session->t.front())) continue;
    part.starts.time.push_back(all.starts.time[i]);
    part.truth.insert(part.truth.end(), all.truth.begin() + static_cast<std::ptrdiff_t>(i * per_start),
                      all.truth.begin() + static_cast<std::ptrdiff_t>((i + 1) * per_start));
  }
  return part;
}

}  // namespace

bool HeldOutTimes::holds(double since_begin) const { return std::fmod(since_begin, every) >= every - length; }

FitLog part_of(const FitLog& all, const HeldOutTimes& times, bool judged) {
  return kept_of(all, [&](double from) {
    const bool first = times.holds(from), last = times.holds(from + all.starts.horizons.back());
    return judged ? first && last : !first && !last;
  });
}

std::vector<FitLog> thinned(const std::vector<FitLog>& logs, std::size_t every) {
  constexpr double length = 5.0;  // [s]
  std::vector<FitLog> out;
  for (const FitLog& log : logs) {
    double stretch = -1.0;
    std::size_t seen = 0;
    out.push_back(kept_of(log, [&](double from) {
      const double now = std::floor(from / length);
      seen += now != stretch;  // stretches with starts
      stretch = now;
      return (seen - 1) % every == 0;
    }));
  }
  return out;
}

}  // namespace gripline::calibrate
