// Exact derivatives of a car's rates and readings along a trace.
#pragma once

#include <span>

#include "diagnose/model/states.hpp"

namespace gripline::diagnose {

/// Rates at every sample and their derivatives in eight lanes. `seed` lists the parameters of the car that take a lane
/// each, after the lanes of the state (yaw, three speeds, memory) if these are asked for: eight lanes in all. Holds
/// references; `memory` has trace.size() rows.
struct DualPass {
  const StagedCar& car;
  const Trace& trace;
  const std::vector<double>& memory;

  static constexpr std::size_t lanes = 8;
  static std::size_t state_lanes(const StagedCar& car) { return 4 + static_cast<std::size_t>(car.memory()); }

  /// Calls sink(sample, rates of the motion (6), rates of the memory) in the order of samples; pointers are valid
  /// during the call.
  template <class Sink>
  void run(std::span<const std::size_t> seed, bool by_state, Sink&& sink) const {
    const auto m = static_cast<std::size_t>(car.memory());
    const std::size_t n = trace.size();
    std::vector<Dual8> params(car.params().begin(), car.params().end());
    const std::size_t first = by_state ? state_lanes(car) : 0;
    for (std::size_t i = 0; i < seed.size(); ++i) params[seed[i]].d[first + i] = 1.0;
    constexpr std::size_t chunk = 8;
    std::vector<Dual8> x(chunk * channels), rate(x.size()), mem(chunk * m), mem_rate(mem.size());
    std::array<ActingCommand<Dual8>, chunk> command;
    std::array<History<Dual8>, chunk> history;
    CarBatch<Dual8> batch;
    batch.params = params.data();
    batch.motion = x.data();
    batch.motion_rate = rate.data();
    batch.memory = mem.data();
    batch.memory_rate = mem_rate.data();
    batch.command = command.data();
    batch.history = history.data();
    for (std::size_t begin = 0; begin < n; begin += chunk) {
      batch.n = std::min(chunk, n - begin);
      batch.at = trace.at.data() + begin;
      for (std::size_t i = 0; i < batch.n; ++i) {
        const std::size_t k = begin + i;
        for (std::size_t c = 0; c < channels; ++c) {
          x[i * channels + c] = Dual8(trace.motion[k * channels + c]);
          if (by_state && c >= 2) x[i * channels + c].d[c - 2] = 1.0;
        }
        for (std::size_t j = 0; j < m; ++j) {
          mem[i * m + j] = Dual8(memory[k * m + j]);
          if (by_state) mem[i * m + j].d[4 + j] = 1.0;
        }
        const auto c = trace.command(k);
        command[i] = {Dual8(c.d), Dual8(c.delta), Dual8(c.delta_rate)};
        history[i] = trace.history(k);
      }
      car.rates(batch);
      for (std::size_t i = 0; i < batch.n; ++i) sink(begin + i, rate.data() + i * channels, mem_rate.data() + i * m);
    }
  }
};

/// Readings by the parameters in `seed`, at most eight (or, by_state, by the six states), at every sample: calls
/// sink(sample, array of six readings).
template <class Sink>
void read_pass(const StagedCar& car, const Trace& trace, std::span<const std::size_t> seed, bool by_state,
               Sink&& sink) {
  std::vector<Dual8> params(car.params().begin(), car.params().end());
  for (std::size_t i = 0; i < seed.size(); ++i) params[seed[i]].d[i] = 1.0;
  for (std::size_t k = 0; k < trace.size(); ++k) {
    std::array<Dual8, channels> v;
    for (std::size_t c = 0; c < channels; ++c) {
      v[c] = Dual8(trace.motion[k * channels + c]);
      if (by_state) v[c].d[c] = 1.0;
    }
    Reading<Dual8> r{v[0], v[1], v[2], v[3], v[4], v[5]};
    car.read(&r, 1, &trace.at[k], params.data());
    const std::array<Dual8, channels> out{r.x, r.y, r.yaw, r.vx, r.vy, r.omega};
    sink(k, out);
  }
}

}  // namespace gripline::diagnose
