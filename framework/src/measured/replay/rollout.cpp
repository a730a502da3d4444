#include "measured/replay/rollout.hpp"

#include <algorithm>
#include <cmath>

#include "measured/replay/velocity_axes.hpp"

namespace gripline::measured {
namespace {

std::array<double, channels> read_state(const StagedCar& car, const double* x, const Place& at) {
  Reading<double> r{x[Channel::x],  x[Channel::y],  x[Channel::yaw],
                    x[Channel::vx], x[Channel::vy], x[Channel::yaw_rate]};
  car.read(&r, 1, &at, nullptr);
  return {r.x, r.y, r.yaw, r.vx, r.vy, r.omega};
}

/// Substeps for the fastest memory along the trace: its rate constant times a substep stays below 0.8.
int substeps_for(const StagedCar& car, const Trace& trace, const std::vector<double>& memory, int wanted) {
  const auto m = static_cast<std::size_t>(car.memory());
  if (m == 0 || trace.size() == 0) return wanted;
  const std::vector<double> rates = memory_rates(car, trace, memory);
  double fastest = 0.0;
  for (std::size_t j = 0; j < m; ++j) {
    std::vector<double> moved = memory;
    for (std::size_t k = 0; k < trace.size(); ++k) moved[k * m + j] += 1e-6 * (1.0 + std::abs(moved[k * m + j]));
    const std::vector<double> changed = memory_rates(car, trace, moved);
    for (std::size_t k = j; k < memory.size(); k += m)
      fastest = std::max(fastest, std::abs((changed[k] - rates[k]) / (moved[k] - memory[k])));
  }
  return std::max(wanted, static_cast<int>(std::ceil(std::min(trace.log.dt * fastest, 40.0) / 0.8)));
}

}  // namespace

std::vector<double> states_of_readings(const StagedCar& car, const std::vector<double>& readings,
                                       const std::vector<Place>& at) {
  std::vector<double> states = readings;
  const auto axes = VelocityAxes<double>::of(car, nullptr);
  for (std::size_t k = 0; k < at.size(); ++k) {
    double* const x = states.data() + k * channels;
    // Beyond a turn of the velocity's axes sensor errors change little with the state: fixed-point iteration converges.
    for (int i = 0; i < 60; ++i) {
      Channels off = read_state(car, x, at[k]);
      double largest = 0.0;
      for (std::size_t c = 0; c < channels; ++c) {
        off[c] -= readings[k * channels + c];
        if (std::isnan(off[c])) off[c] = 0.0;
        largest = std::max(largest, std::abs(off[c]));
      }
      axes.turn_back(off[Channel::vx], off[Channel::vy]);
      for (std::size_t c = 0; c < channels; ++c) x[c] -= off[c];
      if (largest < 1e-12) break;
    }
  }
  return states;
}

Rollouts roll_out(const StagedCar& car, const Trace& trace, const Road& road, const RolloutOptions& options) {
  Rollouts out;
  out.samples = static_cast<std::size_t>(std::round(options.horizon / trace.log.dt));
  for (std::size_t s = options.first; s + out.samples < trace.size(); s += options.every) out.start.push_back(s);
  const std::size_t n = out.start.size();
  const auto m = static_cast<std::size_t>(car.memory());
  out.error.resize(n * out.samples * channels);
  out.predicted.resize(out.error.size());
  if (n == 0) return out;
  const std::vector<double> memory = simulate_memory(car, trace);
  std::vector<double> x(n * channels), mem(n * m);
  std::vector<std::size_t> sample = out.start;
  std::vector<Place> from(n), to(n);
  std::vector<double> hint(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t s = out.start[i];
    std::copy_n(trace.motion.begin() + static_cast<std::ptrdiff_t>(s * channels), channels,
                x.begin() + static_cast<std::ptrdiff_t>(i * channels));
    std::copy_n(memory.begin() + static_cast<std::ptrdiff_t>(s * m), m,
                mem.begin() + static_cast<std::ptrdiff_t>(i * m));
    from[i] = trace.at[s];
    hint[i] = from[i].s;
  }
  LogStepper stepping(car, trace.log, substeps_for(car, trace, memory, options.substeps));
  for (std::size_t j = 0; j < out.samples; ++j) {
    for (std::size_t i = 0; i < n; ++i) {
      const double* const row = x.data() + i * channels;
      const double cosine = std::cos(row[Channel::yaw]), sine = std::sin(row[Channel::yaw]);
      double ahead = hint[i];
      to[i] = road.at(from[i].t + trace.log.dt,
                      row[Channel::x] + trace.log.dt * (row[Channel::vx] * cosine - row[Channel::vy] * sine),
                      row[Channel::y] + trace.log.dt * (row[Channel::vx] * sine + row[Channel::vy] * cosine),
                      row[Channel::yaw], ahead);
    }
    stepping.advance(sample, from, to, x.data(), mem.data());
    for (std::size_t i = 0; i < n; ++i) {
      const double* const row = x.data() + i * channels;
      ++sample[i];
      from[i] = road.at(trace.log.t0 + static_cast<double>(sample[i]) * trace.log.dt, row[Channel::x], row[Channel::y],
                        row[Channel::yaw], hint[i]);
      const auto shown = read_state(car, row, from[i]);
      for (std::size_t c = 0; c < channels; ++c) {
        const std::size_t at = (i * out.samples + j) * channels + c;
        out.predicted[at] = shown[c];
        out.error[at] = shown[c] - trace.log.reading[sample[i] * channels + c];
      }
    }
  }
  return out;
}

double SquaredErrors::rms() const { return readings == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(readings)); }

SquaredErrors squared_errors(const Rollouts& rollouts, std::size_t first, std::size_t last, const Channels& sigma) {
  SquaredErrors out;
  for (std::size_t i = first; i < last; ++i) {
    if (std::isnan(rollouts.error[i]) && std::isfinite(rollouts.predicted[i])) continue;  // no reading
    double ratio = std::abs(rollouts.error[i]) / sigma[i % channels];
    if (!(ratio < most_deviation)) ratio = most_deviation;
    out.sum += ratio * ratio;
    ++out.readings;
  }
  return out;
}

double rms(const Rollouts& rollouts, const Channels& sigma) {
  return squared_errors(rollouts, 0, rollouts.error.size(), sigma).rms();
}

}  // namespace gripline::measured
