#include "measured/estimates/session_delays.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <random>
#include <span>
#include <string_view>

#include "measured/estimates/displacement_lag.hpp"
#include "measured/estimates/fine_delay.hpp"
#include "measured/estimates/independent_blocks.hpp"
#include "measured/readings/bridged_readings.hpp"
#include "measured/session/centre_of_gravity.hpp"
#include "measured/session/gripline_log.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::measured {
namespace {

using Values = std::vector<double>;

/// The median time from one row to the next [s].
double median_step(const Session& s) {
  Values steps;
  for (std::size_t i = 1; i < s.rows(); ++i) steps.push_back(s.t[i] - s.t[i - 1]);
  return median(std::move(steps));
}

/// The median time from one reading of a channel to the next [s]; 0 where there are not two.
double median_step(const Session& s, std::size_t channel) {
  Values steps;
  std::size_t last = s.rows();
  for (std::size_t i = 0; i < s.rows(); ++i) {
    if (std::isnan(s.at(i, channel))) continue;
    if (last < i) steps.push_back(s.t[i] - s.t[last]);
    last = i;
  }
  return median(std::move(steps), 0.0);
}

/// Channels on one even grid, for correlations. It is as coarse as the sparsest of them is read: on a finer one, what
/// lies between its readings would count as if it were known, and beats with the grid.
class Grid {
 public:
  double dt = 0.02;
  std::size_t n = 0;
  bool of_sparse = false;  // coarser than the rows, for a channel that is read in few of them

  Grid(const Session& s, std::initializer_list<std::size_t> compared) : s_(s), t0_(s.t.front()), row_(median_step(s)) {
    constexpr double sparse = 1.5;  // rows
    const double of_rows = std::clamp(row_, 0.02, 0.1);
    dt = of_rows;
    for (const std::size_t c : compared) {
      const double step = median_step(s, c);
      if (!(step > sparse * row_)) continue;
      sparse_[c] = true;
      dt = std::max(dt, std::min(step, even_motion));
    }
    if (std::ranges::find(sparse_, true) != sparse_.end()) {
      bridged_ = s;
      bridged_->reading = bridged_readings(s.t, s.reading, even_motion);
    }
    of_sparse = dt > of_rows;
    if (of_sparse) beside_ = static_cast<int>(std::lround(0.5 * dt / row_));
    n = static_cast<std::size_t>((s.t.back() - t0_) / dt);
  }
  /// Of one that is read in few of the rows what is between two readings is on the straight line, with no delay of its
  /// own; one that is read far more often than there are samples is the mean around them.
  Values channel(std::size_t c) const {
    Values out(n);
    for (std::size_t k = 0; k < n; ++k) {
      const double t = t0_ + static_cast<double>(k) * dt;
      out[k] = sparse_[c] ? bridged_->interpolate(c, t) : mean_around(c, t);
    }
    return out;
  }
  Values command(bool steering) const {
    Values out(n);
    std::size_t i = 0;
    for (std::size_t k = 0; k < n; ++k) {
      const double t = t0_ + static_cast<double>(k) * dt;
      while (i + 1 < s_.rows() && s_.t[i + 1] <= t) ++i;
      const auto& a = s_.command[i];
      const auto& b = s_.command[std::min(i + 1, s_.rows() - 1)];
      const double share = i + 1 < s_.rows() ? (t - s_.t[i]) / (s_.t[i + 1] - s_.t[i]) : 0.0;
      out[k] = steering ? a.delta + share * (b.delta - a.delta) : a.d + share * (b.d - a.d);
    }
    return out;
  }
  /// Central difference: no delay of its own.
  Values rate(const Values& y) const {
    Values out(y.size(), not_a_number);
    for (std::size_t k = 1; k + 1 < y.size(); ++k) out[k] = (y[k + 1] - y[k - 1]) / (2.0 * dt);
    return out;
  }

 private:
  /// Over rows to both sides, of which both or neither count: else what is missing would make a delay.
  double mean_around(std::size_t c, double t) const {
    double sum = s_.interpolate(c, t), count = 1.0;
    for (int j = 1; j <= beside_; ++j) {
      const double both = s_.interpolate(c, t - j * row_) + s_.interpolate(c, t + j * row_);
      if (!std::isnan(both)) sum += both, count += 2.0;
    }
    return sum / count;
  }
  const Session& s_;
  double t0_, row_;
  int beside_ = 0;  // rows to each side that a sample is the mean of
  std::array<bool, channels> sparse_{};
  std::optional<Session> bridged_;  // where a channel is sparse
};

/// Mean over `seconds` to both sides.
Values mean_around(const Values& y, double dt, double seconds) {
  const auto half = static_cast<std::ptrdiff_t>(seconds / dt + 1e-6);
  Values sum(y.size() + 1, 0.0), count(y.size() + 1, 0.0), out(y.size(), not_a_number);
  for (std::size_t k = 0; k < y.size(); ++k) {
    sum[k + 1] = sum[k] + (std::isnan(y[k]) ? 0.0 : y[k]);
    count[k + 1] = count[k] + (std::isnan(y[k]) ? 0.0 : 1.0);
  }
  for (std::ptrdiff_t k = 0; k < static_cast<std::ptrdiff_t>(y.size()); ++k) {
    const auto first = static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, k - half));
    const auto last =
        static_cast<std::size_t>(std::min<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(y.size()), k + half + 1));
    const double n = count[last] - count[first];
    if (n > 0.0 && !std::isnan(y[static_cast<std::size_t>(k)]))
      out[static_cast<std::size_t>(k)] = (sum[last] - sum[first]) / n;
  }
  return out;
}

/// Jumps become as large as what is typical.
void clip(Values& y) {
  Values sizes;
  for (const double v : y)
    if (!std::isnan(v)) sizes.push_back(std::abs(v));
  if (sizes.empty()) return;
  const double most = 1.5 * lower_quantile(std::move(sizes), 0.98);
  for (double& v : y)
    if (!std::isnan(v)) v = std::clamp(v, -most, most);
}

/// The part of a signal that shows delays: without jumps, noise below 0.1 s (of sparse readings below two of them) and
/// trends over several seconds.
Values manoeuvres(Values y, const Grid& grid) {
  clip(y);
  y = mean_around(y, grid.dt, grid.of_sparse ? std::max(0.08, grid.dt) : 0.08);
  const Values trend = mean_around(y, grid.dt, 3.0);
  for (std::size_t k = 0; k < y.size(); ++k) y[k] -= trend[k];
  clip(y);
  return y;
}

/// Sums for a correlation at every lag, by blocks of the log.
class LagSums {
 public:
  LagSums(const Values& late, const Values& early, double dt) : dt_(dt) {
    const std::size_t block = samples_of_block(dt, late.size());
    blocks_ = std::max<std::size_t>(1, late.size() / block);
    constexpr double earliest = -0.6, latest = 1.2;  // [s]
    first_ = std::lround(earliest / dt);
    lags_ = static_cast<std::size_t>(std::lround(latest / dt) - first_) + 1;
    sums_.assign(blocks_ * lags_, {});
    for (std::size_t l = 0; l < lags_; ++l)
      for (std::size_t k = 0; k < early.size(); ++k) {
        const std::ptrdiff_t j = static_cast<std::ptrdiff_t>(k + l) + first_;
        if (j < 0 || j >= static_cast<std::ptrdiff_t>(late.size())) continue;
        const double a = late[static_cast<std::size_t>(j)], b = early[k];
        if (std::isnan(a + b)) continue;
        Sums& s = sums_[std::min(k / block, blocks_ - 1) * lags_ + l];
        s.ab += a * b, s.aa += a * a, s.bb += b * b;
      }
    leave_out_empty();
  }

  /// Delay of highest correlation when blocks count so often each; the correlation through `at`.
  double best(const std::vector<int>& weight, double* at = nullptr) const {
    Values correlation(lags_, 0.0);
    for (std::size_t l = 0; l < lags_; ++l) {
      Sums all;
      for (std::size_t b = 0; b < blocks_; ++b) {
        const Sums& s = sums_[b * lags_ + l];
        all.ab += weight[b] * s.ab, all.aa += weight[b] * s.aa, all.bb += weight[b] * s.bb;
      }
      if (all.aa > 0.0 && all.bb > 0.0) correlation[l] = all.ab / std::sqrt(all.aa * all.bb);
    }
    const auto top =
        static_cast<std::size_t>(std::max_element(correlation.begin(), correlation.end()) - correlation.begin());
    if (at != nullptr) *at = correlation[top];
    double offset = 0.0;
    if (top > 0 && top + 1 < lags_) {
      const double a = correlation[top - 1], b = correlation[top], c = correlation[top + 1];
      const double bend = a - 2.0 * b + c;
      if (bend < 0.0) offset = 0.5 * (a - c) / bend;
    }
    return (static_cast<double>(first_) + static_cast<double>(top) + offset) * dt_;
  }
  std::size_t blocks() const { return blocks_; }
  /// Whether a delay is nearer than a step to the end of the lags, where the correlation may rise further.
  bool is_at_end(double delay) const {
    const double steps = delay / dt_ - static_cast<double>(first_);
    return steps < 1.0 || steps > static_cast<double>(lags_) - 2.0;
  }

 private:
  struct Sums {
    double ab = 0, aa = 0, bb = 0;
  };
  /// Blocks in a gap of either channel: drawn, they would say nothing and pass for evidence.
  void leave_out_empty() {
    std::size_t kept = 0;
    for (std::size_t b = 0; b < blocks_; ++b) {
      const std::span<const Sums> of(sums_.data() + b * lags_, lags_);
      if (std::ranges::none_of(of, [](const Sums& s) { return s.aa > 0.0 && s.bb > 0.0; })) continue;
      std::ranges::copy(of, sums_.begin() + static_cast<std::ptrdiff_t>(kept++ * lags_));
    }
    blocks_ = kept;
    sums_.resize(blocks_ * lags_);
  }
  double dt_;
  long first_ = 0;  // lag, in steps of dt
  std::size_t blocks_ = 0, lags_ = 0;
  std::vector<Sums> sums_;
};

/// A channel and what it is the rate of.
struct OneMotion {
  const Values& rate;
  const Values& sum;
};

/// `motion`: where both channels show one.
void add_delay(std::vector<PairDelay>& delays, const Grid& grid, const char* channel, const Values& late,
               const char* against, const Values& early, const std::optional<OneMotion>& motion) {
  constexpr double least_correlation = 0.5;
  constexpr int draws = 200;
  constexpr std::size_t fewest_blocks = 3;
  const LagSums sums(manoeuvres(late, grid), manoeuvres(early, grid), grid.dt);
  if (sums.blocks() < fewest_blocks) return;
  PairDelay delay{channel, against, 0, 0, 0, 0, motion.has_value(), sums.blocks()};
  delay.seconds = sums.best(std::vector<int>(sums.blocks(), 1), &delay.correlation);
  if (!(delay.correlation > least_correlation)) return;
  if (sums.is_at_end(delay.seconds)) return;
  std::mt19937 random(1);
  Values drawn;
  for (int i = 0; i < draws; ++i) {
    std::vector<int> weight(sums.blocks(), 0);
    for (std::size_t b = 0; b < sums.blocks(); ++b) ++weight[random() % sums.blocks()];
    drawn.push_back(sums.best(weight));
  }
  std::sort(drawn.begin(), drawn.end());
  delay.low = std::min(drawn[static_cast<std::size_t>(0.025 * draws)], delay.seconds);
  delay.high = std::max(drawn[static_cast<std::size_t>(0.975 * draws)], delay.seconds);
  // Where the two differ by more, it is no pure delay that makes the channels differ. Differences of sparse readings
  // are mostly noise: there the correlation's own interval says what agrees with it.
  constexpr double agree = 0.5;  // of a step
  if (motion)
    if (const auto fine = fine_delay(motion->rate, motion->sum, grid.dt, delay.seconds);
        fine && (std::abs(*fine - delay.seconds) < agree * grid.dt ||
                 (grid.of_sparse && *fine > delay.low && *fine < delay.high))) {
      const double by = *fine - delay.seconds;
      delay.seconds += by, delay.low += by, delay.high += by;
    }
  delays.push_back(delay);
}

/// A channel as it would be without its delay.
Values earlier(const Values& y, double seconds, double dt) {
  const auto whole = static_cast<std::size_t>(seconds / dt);
  const double share = seconds / dt - static_cast<double>(whole);
  Values out(y.size(), not_a_number);
  for (std::size_t k = 0; k + whole + 1 < y.size(); ++k) out[k] = std::lerp(y[k + whole], y[k + whole + 1], share);
  return out;
}

/// Way along the heading; NaN where it is not known, and then without what was gone there.
Values way_of_place(const Values& x, const Values& y, const Values& yaw) {
  Values out(x.size(), not_a_number);
  double way = 0.0;
  for (std::size_t k = 1; k < x.size(); ++k) {
    const double heading = 0.5 * (yaw[k] + yaw[k - 1]);
    const double step = (x[k] - x[k - 1]) * std::cos(heading) + (y[k] - y[k - 1]) * std::sin(heading);
    if (std::isnan(step)) continue;
    way += step;
    out[k] = way;
  }
  return out;
}

/// Speed along the heading by differences of the place.
Values speed_of_place(const Grid& grid, const Values& x, const Values& y, const Values& yaw) {
  const Values dx = grid.rate(x), dy = grid.rate(y);
  Values out(x.size(), not_a_number);
  for (std::size_t k = 0; k < x.size(); ++k) out[k] = dx[k] * std::cos(yaw[k]) + dy[k] * std::sin(yaw[k]);
  return out;
}

void add_yaw_rate_delay(const Session& s, std::vector<PairDelay>& delays) {
  const Grid grid(s, {Channel::yaw, Channel::yaw_rate});
  const Values yaw = grid.channel(Channel::yaw), rate = grid.channel(Channel::yaw_rate);
  add_delay(delays, grid, "yaw_rate", rate, "yaw", grid.rate(yaw), OneMotion{rate, yaw});
}

void add_velocity_delay(const Session& s, std::vector<PairDelay>& delays) {
  const Grid grid(s, {Channel::x, Channel::y, Channel::yaw, Channel::vx});
  const Values x = grid.channel(Channel::x), y = grid.channel(Channel::y), yaw = grid.channel(Channel::yaw),
               vx = grid.channel(Channel::vx);
  const Values way = way_of_place(x, y, yaw);
  add_delay(delays, grid, "velocity", grid.rate(vx), "position", grid.rate(speed_of_place(grid, x, y, yaw)),
            OneMotion{vx, way});
}

void add_steering_delay(const Session& s, std::vector<PairDelay>& delays) {
  const bool by_yaw = s.has[Channel::yaw], by_place = s.has[Channel::x] && by_yaw && !s.has[Channel::vx];
  const std::size_t turning = by_yaw ? Channel::yaw : Channel::yaw_rate, speed = by_place ? Channel::x : Channel::vx;
  const Grid grid(s, {turning, speed});
  const Values turned = grid.channel(turning);
  Values asked = grid.command(true);
  const Values along = by_place ? speed_of_place(grid, grid.channel(Channel::x), grid.channel(Channel::y), turned)
                                : grid.channel(Channel::vx);
  for (std::size_t k = 0; k < grid.n; ++k) asked[k] *= along[k];
  add_delay(delays, grid, by_yaw ? "yaw" : "yaw_rate", by_yaw ? grid.rate(turned) : turned, "delta", asked,
            std::nullopt);
}

void add_throttle_delay(const Session& s, std::vector<PairDelay>& delays) {
  const Grid grid(s, {Channel::vx});
  add_delay(delays, grid, "velocity", grid.rate(grid.channel(Channel::vx)), "d", grid.command(false), std::nullopt);
}

/// `identified`: by group, whether the pose identifies its delay.
std::vector<PairDelay> identified_delays(const Session& s, const std::array<bool, delay_groups>& identified) {
  std::vector<PairDelay> delays;
  if (s.rows() < 100) return delays;
  const auto is_identified = [&](std::size_t channel) { return s.has[channel] && identified[delay_group[channel]]; };
  if (s.has[Channel::yaw] && is_identified(Channel::yaw_rate)) add_yaw_rate_delay(s, delays);
  if (s.has[Channel::x] && is_identified(Channel::vx)) add_velocity_delay(s, delays);
  add_steering_delay(s, delays);
  if (!s.prescribed_speed && s.has[Channel::vx]) add_throttle_delay(s, delays);
  return delays;
}

std::size_t group_of(std::string_view name) {
  return static_cast<std::size_t>(std::ranges::find(delay_names, name) - delay_names.begin());
}

/// The median time between two readings of a pair's channels, of those that are read less often [s].
double coarser_step(const PairDelay& delay, const Session& s) {
  const auto step = [&](std::string_view name) {
    const auto first = std::ranges::find(delay_group, group_of(name)) - delay_group.begin();
    return median_step(s, static_cast<std::size_t>(first));
  };
  return std::max(step(delay.channel), step(delay.against));
}

/// Why a delay that was found counts as none; empty where it counts. Estimates are off by some hundredths of a step
/// beyond their intervals.
std::string why_none(const PairDelay& delay, double step) {
  constexpr double resolved = 0.05;  // of a step
  if (delay.low <= 0.0 && delay.high >= 0.0) return "is not told from 0";
  if (std::abs(delay.seconds) >= std::max(shortest_delay, resolved * step)) return {};
  return "is shorter than a twentieth of what lies between two readings (" + significant(step) + " s)";
}

/// `pose`: how late what the channel is compared with is [s].
std::string remark_on(const PairDelay& delay, const std::string& why, double pose) {
  return std::string(delay.channel) + ": a delay of " + significant(delay.seconds) + " s (" + significant(delay.low) +
         " to " + significant(delay.high) + ") against " + delay.against + ' ' + why + ": " +
         (std::abs(pose) >= shortest_delay
              ? std::string("taken for as late as the ") + delay.against + " (" + significant(pose) + " s)"
              : "none taken off");
}

}  // namespace

std::vector<PairDelay> pairwise_delays(const Session& session) {
  return identified_delays(session, {true, true, true, true});
}

std::vector<PairDelay> pairwise_delays_of_file(const SessionFile& file) {
  std::array<bool, delay_groups> identified{};
  for (std::size_t g = 0; g < identified.size(); ++g) identified[g] = pose_identifies_delay(file, g);
  return identified_delays(at_centre_of_gravity(file), identified);
}

bool pose_identifies_delay(const SessionFile& file, std::size_t group) {
  if (group == delay_group[Channel::vx]) return !file.derived_velocity;
  if (group == delay_group[Channel::yaw_rate]) return !file.derived_yaw;
  return true;
}

std::optional<PairDelay> displacement_delay(const Session& s, double yaw_is_late) {
  for (const std::size_t c : {Channel::x, Channel::yaw, Channel::vx, Channel::vy})
    if (!s.has[c]) return std::nullopt;
  if (s.rows() < 100) return std::nullopt;
  const Grid grid(s, {Channel::x, Channel::y, Channel::yaw, Channel::vx, Channel::vy});
  const Values x = grid.channel(Channel::x), y = grid.channel(Channel::y), vx = grid.channel(Channel::vx),
               vy = grid.channel(Channel::vy);
  Values yaw = grid.channel(Channel::yaw);
  if (yaw_is_late > 0.0) yaw = earlier(yaw, yaw_is_late, grid.dt);
  const auto lag = displacement_lag({x, y, yaw, vx, vy, grid.dt});
  if (!lag) return std::nullopt;
  const double wide = normal_95 * lag->sigma;
  return PairDelay{"velocity",
                   "position",
                   lag->seconds,
                   lag->seconds - wide,
                   lag->seconds + wide,
                   std::sqrt(std::max(0.0, lag->explained)),
                   true,
                   lag->blocks};
}

std::array<double, delay_groups> stated_or_found_delays(const LogMap& map, const std::vector<PairDelay>& found) {
  std::array<double, delay_groups> delays{};
  for (std::size_t g = 0; g < delay_groups; ++g) {
    const auto stated = map.delay(g);
    delays[g] = stated.value_or(g < 2 ? 0.0 : not_a_number);
    if (stated) continue;
    for (const PairDelay& d : found) {
      if (!d.of_clock || std::string_view(d.channel) != delay_names[g]) continue;
      delays[g] = delays[group_of(d.against)] + d.seconds;
    }
  }
  return delays;
}

double place_lateness(const SessionFile& file) {
  for (const PairDelay& d : pairwise_delays_of_file(file))
    if (d.of_clock && group_of(d.channel) == delay_group[Channel::vx] && d.low * d.high > 0.0) return -d.seconds;
  return 0.0;
}

DelaysToTakeOff delays_to_take_off(const LogMap& map, const SessionFile& file) {
  const bool search = std::ranges::any_of(map.channel, [](const auto& c) { return c && !c->delay; });
  std::vector<PairDelay> found = search ? pairwise_delays_of_file(file) : std::vector<PairDelay>{};
  DelaysToTakeOff out;
  for (PairDelay& d : found) {
    if (!d.of_clock || map.delay(group_of(d.channel))) continue;
    const std::string why = why_none(d, coarser_step(d, file.session));
    if (why.empty()) continue;
    if (std::abs(d.seconds) >= shortest_delay)
      out.remarks.push_back(remark_on(d, why, map.delay(group_of(d.against)).value_or(0.0)));
    d.seconds = 0.0;
  }
  out.seconds = stated_or_found_delays(map, found);
  return out;
}

}  // namespace gripline::measured
