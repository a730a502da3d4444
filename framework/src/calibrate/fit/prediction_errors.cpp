#include "calibrate/fit/prediction_errors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "measured/readings/bridged_readings.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::calibrate {
namespace {

constexpr double farthest = 15.0;      // scales: an error beyond is a spin, and no more wrong for being larger
constexpr double steepest = 1e5;       // scales per standard deviation of a prior
constexpr std::size_t directions = 8;  // of a Dual8

/// What a move of one of an unknown's own units does to the parameter.
double step_of(const Unknown& u, double value) { return u.log ? value : 1.0; }

/// The first row at or after a time; of Speed::own the first from there until `end` that has a speed, where one has.
std::size_t row_of_start(const Session& s, double wanted, double end, FitLog::Speed speed) {
  const auto row = static_cast<std::size_t>(std::lower_bound(s.t.begin(), s.t.end(), wanted - 1e-9) - s.t.begin());
  if (speed != FitLog::Speed::own) return row;
  std::size_t next = row;
  while (next < s.rows() && s.t[next] <= end && std::isnan(s.at(next, measured::Channel::vx))) ++next;
  return next < s.rows() && s.t[next] <= end ? next : row;
}

/// The last speed that was read at a row or in the half second before it; NaN where none was.
double speed_lately(const Session& s, std::size_t row) {
  double v = s.at(row, measured::Channel::vx);
  for (std::size_t i = row; std::isnan(v) && i > 0 && s.t[row] - s.t[i - 1] < 0.5; --i)
    v = s.at(i - 1, measured::Channel::vx);
  return v;
}

/// When a channel is read.
struct Readings {
  double first = std::numeric_limits<double>::infinity(), last = -first;  // [s]
  /// [s] between two of them over which it moves evenly: of a channel slower than the rows about its pace, so that what
  /// lost readings leave is no reading.
  double bridged = 0;
};

Readings readings_of(const Session& s, std::size_t channel) {
  Readings out;
  std::vector<double> steps;
  for (std::size_t i = 0; i < s.rows(); ++i) {
    if (std::isnan(s.at(i, channel))) continue;
    if (std::isinf(out.first))
      out.first = s.t[i];
    else
      steps.push_back(s.t[i] - out.last);
    out.last = s.t[i];
  }
  out.bridged = 1.5 * std::min(upper_median(std::move(steps), 0.0), measured::even_motion);
  return out;
}

/// The reading of a channel at a time, between rows also where not both of them have it. A row without it says that it
/// was not read then.
double reading_at(const Session& s, std::size_t channel, double time, const Readings& readings) {
  const double plain = s.interpolate(channel, time);
  if (!std::isnan(plain) || time > readings.last) return plain;
  const std::size_t row = s.row_before(time + 1e-9);
  if (row >= s.rows() || time <= s.t[row] + 1e-9) return plain;
  return s.bridge(channel, time, readings.last, readings.bridged).value;
}

}  // namespace

std::vector<double> readings_at(const Session& s, const Starts& starts) {
  std::array<Readings, channels> readings;
  for (std::size_t c = 0; c < channels; ++c) readings[c] = readings_of(s, c);
  // Before the first heading a prediction of the place has no direction.
  using measured::Channel;
  for (const std::size_t place : {Channel::x, Channel::y})
    if (s.has[Channel::yaw]) readings[place].first = std::max(readings[place].first, readings[Channel::yaw].first);
  std::vector<double> all;
  for (const double start : starts.time)
    for (const double h : starts.horizons)
      for (std::size_t c = 0; c < channels; ++c) {
        const bool known = readings[c].first <= start + 1e-9 && !(c == Channel::vx && s.prescribed_speed);
        all.push_back(known ? reading_at(s, c, start + h, readings[c]) : not_a_number);
      }
  return all;
}

std::string never_compared(const FitLog& log) {
  std::string names;
  const Session& s = *log.session;
  for (std::size_t c = 0; c < channels; ++c) {
    bool compared = !s.has[c] || (c == measured::Channel::vx && s.prescribed_speed);
    for (std::size_t k = c; k < log.truth.size() && !compared; k += channels) compared = !std::isnan(log.truth[k]);
    if (!compared) names += (names.empty() ? "" : ", ") + std::string(measured::channel_info[c].words);
  }
  return names.empty() ? names
                       : names +
                             ": read too seldom, or not where predictions end: not compared; a horizon that is a "
                             "multiple of the time between rows, or a log with more readings, may help";
}

FitLog::FitLog(const Session& s, double grid_step, std::vector<double> horizons, double every, double slowest,
               Speed speed)
    : session(&s), commands(s, grid_step) {
  starts.horizons = std::move(horizons);
  const double last = s.t.back() - starts.horizons.back();
  double wanted = s.t.front();
  while (wanted <= last) {
    const double end = std::min(wanted + every - 1e-9, last);  // where the next start is due, or the last one
    const std::size_t row = row_of_start(s, wanted, end, speed);
    if (row >= s.rows() || s.t[row] > last) break;
    const bool later = starts.time.empty() || s.t[row] > starts.time.back();
    if (later && std::abs(speed_lately(s, row)) >= slowest) starts.time.push_back(s.t[row]);
    wanted += every;
  }
  truth = readings_at(s, starts);
}

bool lies_on(const Session& s, const Track& track) {
  std::size_t seen = 0, on = 0;
  const std::size_t step = std::max<std::size_t>(1, s.rows() / 300);
  for (std::size_t i = 0; i < s.rows(); i += step) {
    if (!std::isfinite(s.at(i, 0) + s.at(i, 1))) continue;
    ++seen;
    const CurveLocation found = track.locate(s.at(i, 0), s.at(i, 1));
    on += std::abs(found.n) < 1.5 * (track.half_width_left(found.s) + track.half_width_right(found.s));
  }
  return 10 * on >= seen && on > 0;
}

std::vector<std::vector<double>> PredictionErrors::errors(std::span<const double> params,
                                                          std::vector<ObserverSteps>* steps) const {
  std::vector<std::vector<double>> all;
  if (steps != nullptr) steps->assign(logs_.size(), {});
  for (const FitLog& log : logs_) {
    std::vector<double> predicted;
    std::optional<measured::Road> road;
    if (log.track) road.emplace(log.track);
    forecaster_.run<double>(*log.session, log.commands, road ? &*road : nullptr, params, log.starts, predicted,
                            steps != nullptr ? &(*steps)[all.size()] : nullptr);
    for (std::size_t k = 0; k < predicted.size(); ++k)
      predicted[k] = measured::difference_of(k % channels, predicted[k], log.truth[k]);
    all.push_back(std::move(predicted));
  }
  return all;
}

double PredictionErrors::weight_of(const FitLog& log, std::size_t k) const {
  const double channel = weighing.channel[k % channels];
  const double horizon = weighing.horizon[k / channels % log.starts.horizons.size()];
  return log.weight * channel * channel * horizon;
}

double PredictionErrors::loss(double z, double weight, double* slope_weight) const {
  const double q = std::sqrt(1.0 + z * z / (weighing.huber_delta * weighing.huber_delta));
  if (slope_weight != nullptr) *slope_weight = weight / q;
  return weight * 2.0 * weighing.huber_delta * weighing.huber_delta * (q - 1.0);
}

double PredictionErrors::cost(std::span<const double> params, std::vector<ObserverSteps>* steps) const {
  double sum = 0.0;
  const auto all = errors(params, steps);
  for (std::size_t l = 0; l < logs_.size(); ++l)
    for (std::size_t k = 0; k < all[l].size(); ++k) {
      if (std::isnan(logs_[l].truth[k])) continue;
      double z = all[l][k] / weighing.scale[k % channels];
      if (!(std::abs(z) < farthest)) z = farthest;
      sum += loss(z, weight_of(logs_[l], k), nullptr);
    }
  return sum;
}

/// Forward differentiation, some unknowns at a time.
PredictionErrors::Predicted PredictionErrors::predict_with_slopes(const FitLog& log, std::span<const double> params,
                                                                  std::span<const Unknown> unknowns,
                                                                  ObserverSteps& steps) const {
  const std::size_t n = unknowns.size();
  std::optional<measured::Road> road;
  if (log.track) road.emplace(log.track);
  Predicted out{std::vector<double>(log.truth.size()),
                Eigen::MatrixXd(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(log.truth.size()))};
  std::vector<Dual8> seeded, predicted;
  for (std::size_t first = 0; first == 0 || first < n; first += directions) {
    const std::size_t last = std::min(first + directions, n);
    seeded.assign(params.begin(), params.end());
    for (std::size_t u = first; u < last; ++u) {
      const double step = step_of(unknowns[u], params[unknowns[u].index]);
      seeded[unknowns[u].index].d[u - first] = step;
      for (const Unknown::Same& s : unknowns[u].same) seeded[s.index].d[u - first] = step;
    }
    forecaster_.run<Dual8>(*log.session, log.commands, road ? &*road : nullptr, seeded, log.starts, predicted, &steps);
    for (std::size_t k = 0; k < predicted.size(); ++k) {
      out.value[k] = predicted[k].v;
      for (std::size_t u = first; u < last; ++u)
        out.slope(static_cast<Eigen::Index>(u), static_cast<Eigen::Index>(k)) = predicted[k].d[u - first];
    }
  }
  return out;
}

/// Adds a log's blocks, each `length` [s] long.
void PredictionErrors::add_blocks(const FitLog& log, const Predicted& predicted, std::span<const Unknown> unknowns,
                                  double length, BlockedNormalEquations& to) const {
  const auto n = static_cast<Eigen::Index>(unknowns.size());
  const std::size_t per_start = log.starts.horizons.size() * channels;
  std::map<long, std::size_t> block_at;
  for (std::size_t k = 0; k < predicted.value.size(); ++k) {
    if (std::isnan(log.truth[k])) continue;
    const double scale = weighing.scale[k % channels];
    double z = measured::difference_of(k % channels, predicted.value[k], log.truth[k]) / scale;
    const auto j = predicted.slope.col(static_cast<Eigen::Index>(k)) / scale;
    double steep = 0.0;
    for (Eigen::Index u = 0; u < n; ++u)
      steep = std::max(steep, std::abs(j(u)) * unknowns[static_cast<std::size_t>(u)].sigma);
    const bool far = !(std::abs(z) < farthest), wild = !(steep < steepest);
    if (far) z = farthest;
    double w = 0.0;
    to.cost += loss(z, weight_of(log, k), &w);
    const bool undefined = !far && !wild && j.hasNaN();
    if (far || wild || undefined) {
      ++to.dropped;
      to.undefined += undefined ? 1 : 0;
      continue;
    }
    w /= 1.0 + (steep / weighing.steep) * (steep / weighing.steep);
    const long when = std::lround(std::floor((log.starts.time[k / per_start] - log.session->t.front()) / length));
    const auto [at, fresh] = block_at.try_emplace(when, to.hessian.size());
    if (fresh) {
      to.hessian.emplace_back(Eigen::MatrixXd::Zero(n, n));
      to.gradient.emplace_back(Eigen::VectorXd::Zero(n));
    }
    to.hessian[at->second].selfadjointView<Eigen::Lower>().rankUpdate(j, w);
    to.gradient[at->second] += j * (w * z);
  }
}

BlockedNormalEquations PredictionErrors::linearise(std::span<const double> params, std::span<const Unknown> unknowns,
                                                   std::vector<ObserverSteps> steps) const {
  constexpr double enough_blocks = 20.0;
  steps.resize(logs_.size());
  double seconds = 0.0;
  for (const FitLog& log : logs_) seconds += log.session->t.back() - log.session->t.front();
  const double length = std::clamp(seconds / enough_blocks, shortest_block, block_length);
  BlockedNormalEquations out;
  for (std::size_t l = 0; l < logs_.size(); ++l)
    add_blocks(logs_[l], predict_with_slopes(logs_[l], params, unknowns, steps[l]), unknowns, length, out);
  for (Eigen::MatrixXd& h : out.hessian) h = Eigen::MatrixXd(h.selfadjointView<Eigen::Lower>());
  return out;
}

void PredictionErrors::set_scales(std::span<const double> params) {
  std::array<std::vector<double>, channels> squares;
  const auto all = errors(params);
  for (std::size_t l = 0; l < all.size(); ++l)
    for (std::size_t k = 0; k < all[l].size(); ++k)
      if (std::isfinite(all[l][k])) squares[k % channels].push_back(all[l][k] * all[l][k]);
  for (std::size_t c = 0; c < channels; ++c) {
    if (squares[c].empty()) continue;
    std::sort(squares[c].begin(), squares[c].end());
    const std::size_t kept = std::max<std::size_t>(1, squares[c].size() * 97 / 100);
    double sum = 0.0;
    for (std::size_t i = 0; i < kept; ++i) sum += squares[c][i];
    weighing.scale[c] = std::sqrt(sum / static_cast<double>(kept)) + 1e-9;
  }
  weighing.scale[0] = weighing.scale[1] = std::hypot(weighing.scale[0], weighing.scale[1]) / std::sqrt(2.0);
}

}  // namespace gripline::calibrate
