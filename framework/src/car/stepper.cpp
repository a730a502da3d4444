#include "car/stepper.hpp"

#include <algorithm>
#include <cmath>

namespace gripline {

template <class T>
void Stepper<T>::resize(std::size_t n, int memory_count, int stages, int past_count) {
  memory_ = memory_count;
  past_ = past_count;
  const auto m = static_cast<std::size_t>(memory_count);
  const auto k = static_cast<std::size_t>(stages);
  const auto grow = [](auto& vector, std::size_t size) {
    if (vector.size() < size) vector.resize(size);
  };
  grow(motion, n * motion_size);
  grow(memory, n * m);
  grow(ramp, n);
  grow(past, n * static_cast<std::size_t>(past_count));
  grow(stage_motion_, n * motion_size);
  grow(stage_memory_, n * m);
  grow(motion_rate_, k * n * motion_size);
  grow(memory_rate_, k * n * m);
  grow(command_, n);
  grow(place_, n);
  grow(history_, n);
}

template <class T>
void Stepper<T>::stage_inputs(std::size_t n, const Place* at, double from, double c, double h, double dt) {
  const double elapsed = from + c * h;
  const double share = elapsed / dt;
  // A held command changes between steps: stages at either end of a step look back from within it.
  const double now = hold == Hold::foh ? elapsed : from + std::clamp(c, 1e-9, 1.0 - 1e-9) * h;
  for (std::size_t i = 0; i < n; ++i) {
    const Ramp& r = ramp[i];
    command_[i] = {r.begin.d + (r.end.d - r.begin.d) * share, r.begin.delta + (r.end.delta - r.begin.delta) * share,
                   r.begin.delta_rate};
    place_[i] = at[i];
    place_[i].t += elapsed;
    if (past_ > 0) {
      const auto count = static_cast<std::size_t>(past_);
      history_[i] = {past.data() + i * count, count, past_offset, past_dt, now, hold};
    }
  }
}

namespace {

/// y = y0 + h sum_j w_j k_j, row blocks of `size` numbers per Runge-Kutta stage.
template <class T>
void combine(const T* y0, const T* k, std::size_t size, double h, const Tableau& method, int row, T* y) {
  for (std::size_t i = 0; i < size; ++i) y[i] = y0[i];
  const int count = row < method.stages ? row : method.stages;
  for (int j = 0; j < count; ++j) {
    const double w = h * (row < method.stages ? method.weight(row, j) : method.b[static_cast<std::size_t>(j)]);
    if (w == 0.0) continue;
    const T* const kj = k + static_cast<std::size_t>(j) * size;
    for (std::size_t i = 0; i < size; ++i) y[i] += kj[i] * w;
  }
}

}  // namespace

template <class T>
void Stepper<T>::advance(const StagedCar& car, const Tableau& method, double from, double h, double dt, std::size_t n,
                         const Place* at, const T* params) {
  const std::size_t motion_count = n * motion_size;
  const std::size_t memory_count = n * static_cast<std::size_t>(memory_);
  for (int stage = 0; stage < method.stages; ++stage) {
    combine(motion.data(), motion_rate_.data(), motion_count, h, method, stage, stage_motion_.data());
    combine(memory.data(), memory_rate_.data(), memory_count, h, method, stage, stage_memory_.data());
    stage_inputs(n, at, from, method.c[static_cast<std::size_t>(stage)], h, dt);
    CarBatch<T> batch;
    batch.n = n;
    batch.motion = stage_motion_.data();
    batch.command = command_.data();
    batch.memory = memory_ > 0 ? stage_memory_.data() : nullptr;
    batch.at = place_.data();
    batch.params = params;
    batch.history = past_ > 0 ? history_.data() : nullptr;
    batch.motion_rate = motion_rate_.data() + static_cast<std::size_t>(stage) * motion_count;
    batch.memory_rate = memory_ > 0 ? memory_rate_.data() + static_cast<std::size_t>(stage) * memory_count : nullptr;
    car.rates(batch, scratch_);
  }
  combine(motion.data(), motion_rate_.data(), motion_count, h, method, method.stages, stage_motion_.data());
  combine(memory.data(), memory_rate_.data(), memory_count, h, method, method.stages, stage_memory_.data());
  std::copy_n(stage_motion_.begin(), motion_count, motion.begin());
  std::copy_n(stage_memory_.begin(), memory_count, memory.begin());
}

namespace {

/// How long after `from`, both from the start of a step of dt, a delayed command jumps or changes its rate first, if it
/// does so within `left` [s]: across such a breakpoint no Runge-Kutta method keeps its order. Else `left`.
double to_breakpoint(const StagedCar& car, double dt, double from, double left) {
  const double least = 1e-6 * left;  // what is as near is one of its ends
  double first = left;
  car.for_each_delay([&](double delay) {
    const double ahead = delay - dt * std::floor(delay / dt) - from;
    if (ahead > least && ahead < left - least) first = std::min(first, ahead);
  });
  return first;
}

}  // namespace

template <class T>
void Stepper<T>::step(const StagedCar& car, const Integration& integration, double dt, std::size_t n, const Place* at,
                      const T* params) {
  const Tableau& method = *integration.tableau;
  const double h = dt / integration.substeps;
  for (int sub = 0; sub < integration.substeps; ++sub) {
    double from = sub * h, left = h;
    for (;;) {
      const double piece = past_ > 0 ? to_breakpoint(car, dt, from, left) : left;
      advance(car, method, from, piece, dt, n, at, params);
      if (piece == left) break;
      from += piece;
      left -= piece;
    }
  }
}

template <class T>
void Stepper<T>::quantities(const StagedCar& car, double dt, std::size_t n, const Place* at, const T* params,
                            Quantities<T>* q) {
  stage_inputs(n, at, 0.0, 0.0, dt, dt);
  CarBatch<T> batch;
  batch.n = n;
  batch.motion = motion.data();
  batch.command = command_.data();
  batch.memory = memory_ > 0 ? memory.data() : nullptr;
  batch.at = place_.data();
  batch.params = params;
  batch.history = past_ > 0 ? history_.data() : nullptr;
  batch.memory_rate = memory_ > 0 ? memory_rate_.data() : nullptr;
  car.quantities(batch, q);
}

template class Stepper<double>;
template class Stepper<Dual8>;

}  // namespace gripline
