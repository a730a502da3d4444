#include "diagnose/model/linear_model.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "diagnose/model/dual_pass.hpp"
#include "diagnose/model/transition.hpp"
#include "diagnose/thresholds.hpp"
#include "measured/replay/replay.hpp"
#include "util/exponential.hpp"
#include "util/statistics.hpp"

namespace gripline::diagnose {

namespace {

/// Fills F and the inputs; writes the rates of `regressors`. Returns the fastest rate of settling of a memory
/// [1/s], which may need shorter steps than the motion.
double add_transitions(const StagedCar& car, const Trace& trace, std::span<const std::size_t> along,
                       std::span<Regressor> regressors, LinearModel& lm) {
  const std::size_t N = lm.states, m = lm.memories(), body = channels + m;
  for (Regressor& r : regressors) r.rate.resize(lm.n * 3);
  lm.F.resize((lm.n - 1) * N * N);
  lm.input0.resize((lm.n - 1) * N * 3);
  lm.input1.resize((lm.n - 1) * N * 3);
  // Jacobian of the rates at a sample, and at the one before; their mean rules the step between.
  std::vector<double> A(N * N, 0.0), before(N * N, 0.0);
  for (std::size_t c = 0; c < noise_states; ++c) {
    A[(3 + c) * N + body + c] = before[(3 + c) * N + body + c] = 1.0;
    A[(body + c) * (N + 1)] = before[(body + c) * (N + 1)] = -1.0 / lm.noise_time;
  }
  double fastest = 0.0;
  const DualPass pass{car, trace, lm.memory};
  pass.run(along, true, [&](std::size_t k, const Dual8* rate, const Dual8* memory_rate) {
    const auto row = [&](std::size_t i, const Dual8& r) {
      for (std::size_t c = 0; c < 4; ++c) A[i * N + 2 + c] = r.d[c];
      for (std::size_t j = 0; j < m; ++j) A[i * N + channels + j] = r.d[4 + j];
    };
    for (std::size_t i = 0; i < channels; ++i) row(i, rate[i]);
    for (std::size_t j = 0; j < m; ++j) row(channels + j, memory_rate[j]);
    for (std::size_t j = channels; j < body; ++j) fastest = std::max(fastest, std::abs(A[j * (N + 1)]));
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < along.size(); ++i) regressors[i].rate[k * 3 + c] = rate[3 + c].d[4 + m + i];
    if (k > 0) {
      for (std::size_t i = 0; i < N * N; ++i) before[i] = 0.5 * (before[i] + A[i]);
      transition(before.data(), N, lm.dt, lm.F.data() + (k - 1) * N * N, lm.input0.data() + (k - 1) * N * 3,
                 lm.input1.data() + (k - 1) * N * 3);
    }
    before = A;
  });
  return fastest;
}

/// Fills `by_command`: what a command that is higher by one half-way between two samples, and less towards them, adds
/// to the state at the second. Its mean over the step is one half; through a memory it acts as that memory's mean.
void add_commands(const StagedCar& car, const Trace& trace, LinearModel& lm) {
  const std::size_t N = lm.states, m = lm.memories();
  const auto by = measured::rates_by_command(car, trace, lm.memory);
  lm.by_command.assign((lm.n - 1) * 2 * N, 0.0);
  lm.command_variation = measured::command_variation(trace.log);
  for (std::size_t k = 0; k + 1 < lm.n; ++k) {
    const double* const F = lm.F.data() + k * N * N;
    const double *const in0 = lm.input0.data() + k * N * 3, *const in1 = lm.input1.data() + k * N * 3;
    for (std::size_t i = 0; i < by.size(); ++i) {
      double* const to = lm.by_command.data() + (k * 2 + i) * N;
      const auto mean = [&](const std::vector<double>& rate, std::size_t width, std::size_t c) {
        return 0.5 * (rate[k * width + c] + rate[(k + 1) * width + c]);
      };
      for (std::size_t c = 0; c < 3; ++c) {
        const double rate = 0.5 * mean(by[i].motion, channels, 3 + c);
        for (std::size_t r = 0; r < N; ++r) to[r] += (in0[r * 3 + c] + in1[r * 3 + c]) * rate;
      }
      for (std::size_t j = 0; j < m; ++j) {
        const std::size_t at = channels + j;
        const double rate = 0.5 * lm.dt * mean(by[i].memory, m, j);
        const double z = std::log(std::clamp(F[at * (N + 1)], 1e-9, 1.0));
        for (std::size_t r = 0; r < channels; ++r) to[r] += F[r * N + at] * rate * phi2(z) / phi1(z);
        to[at] += rate * phi1(z);
      }
    }
  }
}

/// Puts two states more behind the memory in all arrays: the errors of both commands, constant over each step. An error
/// over a whole step does twice what `by_command` has for one that is 0 at both ends and 1 half-way.
void add_command_errors(const std::vector<measured::RoundingError>& rounding_error, LinearModel& lm) {
  const std::size_t N = lm.states, body = N - noise_states, more = Commands{}.size(), M = N + more;
  const auto to = [&](std::size_t i) { return i < body ? i : i + more; };
  const std::size_t steps = lm.n - 1;
  std::vector<double> F(steps * M * M), in0(steps * M * 3), in1(steps * M * 3), by(steps * more * M),
      offset(steps * (body + more));
  for (std::size_t k = 0; k < steps; ++k) {
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t j = 0; j < N; ++j) F[(k * M + to(i)) * M + to(j)] = lm.F[(k * N + i) * N + j];
      for (std::size_t c = 0; c < 3; ++c) {
        in0[(k * M + to(i)) * 3 + c] = lm.input0[(k * N + i) * 3 + c];
        in1[(k * M + to(i)) * 3 + c] = lm.input1[(k * N + i) * 3 + c];
      }
      for (std::size_t c = 0; c < more; ++c) {
        by[(k * more + c) * M + to(i)] = lm.by_command[(k * more + c) * N + i];
        F[(k * M + to(i)) * M + body + c] = 2.0 * lm.by_command[(k * more + c) * N + i];
      }
      if (i < body) offset[k * (body + more) + i] = lm.offset[k * body + i];
    }
    for (std::size_t c = 0; c < more; ++c) F[(k * M + body + c) * M + body + c] = rounding_error[k].autoregression[c];
  }
  lm.states = M;
  lm.rounding_error = rounding_error;
  lm.F = std::move(F);
  lm.input0 = std::move(in0);
  lm.input1 = std::move(in1);
  lm.by_command = std::move(by);
  lm.offset = std::move(offset);
}

/// Variances of the first memories. What was commanded before a trace is not known: they may be off their steady values
/// by as much as memories are along the trace (mean squares), and those of a car that has just started have not built
/// up at all.
std::vector<double> first_variances(const StagedCar& car, const Trace& trace, const std::vector<double>& memory) {
  const auto m = static_cast<std::size_t>(car.memory());
  const std::vector<double> steady = measured::steady_memory(car, trace);
  std::vector<double> variance(m, 0.0);
  for (std::size_t i = 0; i < memory.size(); ++i)
    variance[i % m] += std::pow(memory[i] - steady[i], 2) / static_cast<double>(trace.size());
  for (std::size_t j = 0; j < m; ++j) variance[j] += steady[j] * steady[j];
  return variance;
}

/// Fills the offsets: one-step predictions from the reference less the reference.
void add_offsets(const StagedCar& car, const Trace& trace, LinearModel& lm) {
  const std::size_t m = lm.memories(), body = channels + m;
  predict_one_step(car, trace, lm.memory, lm.substeps, lm.offset);
  for (std::size_t k = 0; k + 1 < lm.n; ++k) {
    double* const f = lm.offset.data() + k * body;
    for (std::size_t c = 0; c < channels; ++c) f[c] -= trace.motion[(k + 1) * channels + c];
    for (std::size_t j = 0; j < m; ++j) f[channels + j] -= lm.memory[(k + 1) * m + j];
  }
}

/// Fills the innovations of the reference, and H where the sensors are not the identity.
void add_readings(const StagedCar& car, const Trace& trace, LinearModel& lm) {
  lm.innovation.resize(lm.n * channels);
  read_pass(car, trace, {}, true, [&](std::size_t k, const std::array<Dual8, channels>& out) {
    bool plain = true;
    for (std::size_t c = 0; c < channels; ++c) {
      lm.innovation[k * channels + c] = trace.log.reading[k * channels + c] - out[c].v;
      for (std::size_t j = 0; j < channels; ++j) plain &= out[c].d[j] == (c == j ? 1.0 : 0.0);
    }
    if (plain && lm.H.empty()) return;
    if (lm.H.empty()) {
      lm.H.resize(lm.n * channels * channels);
      for (std::size_t i = 0; i < lm.n * channels; ++i) lm.H[i * channels + i % channels] = 1.0;
    }
    for (std::size_t c = 0; c < channels; ++c)
      std::copy_n(out[c].d, channels, lm.H.begin() + static_cast<std::ptrdiff_t>((k * channels + c) * channels));
  });
}

}  // namespace

LinearModel linearise(const StagedCar& car, const Trace& trace, const Stepping& stepping,
                      std::span<const std::size_t> along, std::span<Regressor> regressors) {
  const auto m = static_cast<std::size_t>(car.memory());
  if (m > max_memory) throw std::invalid_argument("more than 4 hidden states in one model");
  LinearModel lm;
  lm.n = trace.size();
  lm.dt = trace.log.dt;
  lm.noise_time = stepping.noise_time;
  lm.states = channels + m + noise_states;
  lm.memory = simulate_memory(car, trace);
  lm.memory_variance = first_variances(car, trace, lm.memory);
  if (!trace.log.interpolated.empty())
    for (std::size_t k = 0; k + 1 < lm.n; ++k) lm.interpolated.push_back(trace.log.interpolated_step(k));
  const double fastest = add_transitions(car, trace, along, regressors, lm);
  const bool rounded = !trace.log.rounding_error.empty();
  if (stepping.commands || rounded) add_commands(car, trace, lm);
  // Stiff memory settles many times within a sample: there the step must only be stable.
  const double settles = std::min(lm.dt * fastest, thresholds::stiffest);
  const double step = settles < thresholds::stiff ? thresholds::longest_memory_step : thresholds::longest_stiff_step;
  lm.substeps = std::max(stepping.substeps, static_cast<int>(std::ceil(settles / step)));
  add_offsets(car, trace, lm);
  add_readings(car, trace, lm);
  if (rounded) add_command_errors(trace.log.rounding_error, lm);
  if (!stepping.commands) lm.by_command.clear();
  return lm;
}

std::size_t lanes_beside_state(const StagedCar& car) { return DualPass::lanes - DualPass::state_lanes(car); }

int substeps_of_motion(const StagedCar& car, std::span<const Trace> traces) {
  std::vector<double> fastest;
  for (const Trace& trace : traces)
    DualPass{car, trace, simulate_memory(car, trace)}.run({}, true, [&](std::size_t, const Dual8* rate, const Dual8*) {
      double one = 0.0;
      for (std::size_t c = 3; c < channels; ++c) one = std::max(one, std::abs(rate[c].d[c - 2]));
      fastest.push_back(one * trace.log.dt);
    });
  if (fastest.empty()) return 2;
  const double typical = upper_median(std::move(fastest));
  return static_cast<int>(
      std::clamp(std::ceil(typical / thresholds::longest_integration_step), 1.0, thresholds::most_substeps));
}

}  // namespace gripline::diagnose
