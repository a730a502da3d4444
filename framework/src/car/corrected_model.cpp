#include "car/corrected_model.hpp"

#include <algorithm>
#include <boost/container/small_vector.hpp>
#include <cassert>
#include <cmath>

#include "car/instant.hpp"

namespace gripline {

CorrectedModel::CorrectedModel(StagedCar car, StepOptions options)
    : car_(std::move(car)), options_(options), dual_params_(car_.params().begin(), car_.params().end()) {
  past_ = past_commands();
  current_.resize(static_cast<std::size_t>(car_.memory()) + 2 * static_cast<std::size_t>(past_));
  for (std::vector<double>* const row : {&row_, &row_next_, &row_finer_})
    row->resize(static_cast<std::size_t>(states()));
}

void CorrectedModel::set_parameter(std::size_t number, double value) {
  car_.params()[number] = value;
  dual_params_[number] = Dual8(value);
  assert(past_commands() == past_);
}

/// How many past commands the effects and the hold need.
int CorrectedModel::past_commands() const {
  const double back = car_.look_back();
  const int past = back > 0.0 ? static_cast<int>(std::ceil(back / options_.dt - 1e-9)) + 1 : 0;
  return options_.hold == Hold::foh ? std::max(past, 1) : past;
}

void CorrectedModel::start(const State& now, std::span<double> x) const {
  const double state[] = {now.x, now.y, now.yaw, now.vx, now.vy, now.omega, now.delta};
  std::copy(std::begin(state), std::end(state), x.begin());
  std::copy(current_.begin(), current_.end(), x.begin() + state_size);
}

/// Rows and inputs into the stepper's arrays: motion, memory, the ramp of the commands, the past ones.
template <class T>
void CorrectedModel::load(Stepper<T>& stepper, std::size_t n, const T* rows, const T* inputs, std::size_t stride) {
  const auto memory = static_cast<std::size_t>(car_.memory());
  const auto past = static_cast<std::size_t>(past_);
  const bool reads_past = past > 0;
  stepper.resize(n, car_.memory(), options_.integration.tableau->stages, reads_past ? past_ + 1 : 0);
  stepper.hold = options_.hold;
  stepper.past_dt = options_.dt;
  // The newest sample begins to act at the start of the step (zoh) or is reached at its end.
  stepper.past_offset = -options_.dt * static_cast<double>(stepper.hold == Hold::zoh ? past_ : past_ - 1);
  for (std::size_t i = 0; i < n; ++i) {
    const T* const row = rows + i * stride;
    const T d = inputs[2 * i];
    const T rate = inputs[2 * i + 1];
    const T delta = row[6] + rate * options_.dt;
    std::copy_n(row, motion_size, stepper.motion.begin() + static_cast<std::ptrdiff_t>(i * motion_size));
    std::copy_n(row + state_size, memory, stepper.memory.begin() + static_cast<std::ptrdiff_t>(i * memory));
    const T* const commands = row + state_size + memory;
    auto& ramp = stepper.ramp[i];
    ramp.end = {d, delta, rate};
    ramp.begin = ramp.end;
    if (options_.hold != Hold::zoh) ramp.begin.delta = row[6];
    if (options_.hold == Hold::foh) ramp.begin.d = commands[2 * (past - 1)];
    if (!reads_past) continue;
    CommandSample<T>* const samples = stepper.past.data() + i * (past + 1);
    for (std::size_t j = 0; j < past; ++j) samples[j] = {commands[2 * j], commands[2 * j + 1]};
    samples[past] = {d, delta};
  }
}

template <class T>
void CorrectedModel::unload(const Stepper<T>& stepper, std::size_t i, T* row) const {
  const auto memory = static_cast<std::size_t>(car_.memory());
  const auto past = static_cast<std::size_t>(past_);
  std::copy_n(stepper.motion.begin() + static_cast<std::ptrdiff_t>(i * motion_size), motion_size, row);
  row[6] = stepper.ramp[i].end.delta;
  std::copy_n(stepper.memory.begin() + static_cast<std::ptrdiff_t>(i * memory), memory, row + state_size);
  T* const commands = row + state_size + memory;
  for (std::size_t j = 0; j < past; ++j) {
    const CommandSample<T>& sample = stepper.past[i * (past + 1) + j + 1];
    commands[2 * j] = sample.d;
    commands[2 * j + 1] = sample.delta;
  }
}

void CorrectedModel::values(std::size_t n, const double* x, const double* u, const Place* at, double* x_next) {
  const auto nx = static_cast<std::size_t>(states());
  load(stepper_, n, x, u, nx);
  stepper_.step(car_, options_.integration, options_.dt, n, at, nullptr);
  for (std::size_t i = 0; i < n; ++i) unload(stepper_, i, x_next + i * nx);
}

/// Rows and inputs as duals whose eight directions are the variables first .. first + 7, counted over the row from yaw
/// on and then the inputs: position needs none, nothing depends on it.
void CorrectedModel::seed_block(std::size_t n, const double* x, const double* u, int first) {
  const int nx = states();
  const auto stride = static_cast<std::size_t>(nx);
  for (std::size_t i = 0; i < n; ++i) {
    for (int j = 0; j < nx; ++j) {
      Dual8& value = dual_rows_[i * stride + static_cast<std::size_t>(j)];
      value = Dual8(x[i * stride + static_cast<std::size_t>(j)]);
      const int direction = j - 2 - first;
      if (j >= 2 && direction >= 0 && direction < 8) value.d[direction] = 1.0;
    }
    for (int j = 0; j < 2; ++j) {
      Dual8& value = dual_inputs_[2 * i + static_cast<std::size_t>(j)];
      value = Dual8(u[2 * i + static_cast<std::size_t>(j)]);
      const int direction = nx + j - 2 - first;
      if (direction >= 0 && direction < 8) value.d[direction] = 1.0;
    }
  }
}

void CorrectedModel::derivatives(std::size_t n, const double* x, const double* u, const Place* at, double* x_next,
                                 double* A, double* B) {
  const int nx = states();
  const auto stride = static_cast<std::size_t>(nx);
  if (dual_rows_.size() < (n + 1) * stride) dual_rows_.resize((n + 1) * stride);
  if (dual_inputs_.size() < 2 * n) dual_inputs_.resize(2 * n);
  if (A != nullptr) std::fill_n(A, n * stride * stride, 0.0);
  for (int first = 0; first < nx; first += 8) {  // nx - 2 of the row and two inputs: nx directions
    seed_block(n, x, u, first);
    load(dual_stepper_, n, dual_rows_.data(), dual_inputs_.data(), stride);
    dual_stepper_.step(car_, options_.integration, options_.dt, n, at, dual_params_.data());
    Dual8* const row = dual_rows_.data() + n * stride;
    for (std::size_t i = 0; i < n; ++i) {
      unload(dual_stepper_, i, row);
      for (std::size_t r = 0; r < stride; ++r) {
        if (first == 0) x_next[i * stride + r] = row[r].v;
        for (int k = 0; k < std::min(8, nx - first); ++k) {
          const int column = first + k + 2;
          if (column >= nx && B != nullptr)
            B[(i * stride + r) * 2 + static_cast<std::size_t>(column - nx)] = row[r].d[k];
          if (column < nx && A != nullptr)
            A[(i * stride + r) * stride + static_cast<std::size_t>(column)] = row[r].d[k];
        }
      }
      if (A == nullptr) continue;
      A[i * stride * stride] = 1.0;
      A[(i * stride + 1) * stride + 1] = 1.0;
    }
  }
}

/// Derivatives only: states that are not finite are found by the callers.
void CorrectedModel::check_derivatives(const double* x_next, const double* A, const double* B) {
  const auto stride = static_cast<std::size_t>(states());
  // Zero times infinity or NaN is NaN, and stays so in a sum.
  const auto finite = [](const double* numbers, std::size_t count) {
    double sum = 0.0;
    for (std::size_t i = 0; i < count; ++i) sum += 0.0 * numbers[i];
    return sum == 0.0;
  };
  if (!finite(x_next, stride)) return;
  if ((A != nullptr && !finite(A, stride * stride)) || (B != nullptr && !finite(B, 2 * stride))) smooth_ = false;
}

void CorrectedModel::step(std::size_t n, std::span<const double> x, std::span<const double> u,
                          std::span<const Place> at, std::span<double> x_next, std::span<double> A,
                          std::span<double> B) {
  if (A.empty() && B.empty())
    values(n, x.data(), u.data(), at.data(), x_next.data());
  else
    derivatives(n, x.data(), u.data(), at.data(), x_next.data(), A.data(), B.data());
  if (n > 0 && !(A.empty() && B.empty())) check_derivatives(x_next.data(), A.data(), B.data());
}

Prediction::Rates CorrectedModel::rates(const State& x, const Input& u, const Place& at) {
  const double motion[] = {x.x, x.y, x.yaw, x.vx, x.vy, x.omega};
  double rate[motion_size];
  // Controllers ask in their step: nothing is allocated for models of usual size.
  boost::container::small_vector<double, 16> memory(static_cast<std::size_t>(car_.memory())),
      memory_rate(memory.size());
  InstantBatch<double> instant(motion, {u.d, x.delta, u.ddelta}, at, options_.dt, options_.hold);
  CarBatch<double>& batch = instant.batch;
  batch.motion_rate = rate;
  if (!memory.empty()) {
    car_.start_memory(batch, memory.data());
    batch.memory = memory.data();
    batch.memory_rate = memory_rate.data();
  }
  StagedCar::Scratch<double> scratch;
  car_.rates(batch, scratch);
  const Quantities<double>& q = scratch.front();  // of the only point
  return {rate[3], rate[4], rate[5], q.load_front, q.load_rear, q.drive_force, q.d, q.delta};
}

void CorrectedModel::reset(const State& x, double d, const Place& at) {
  const auto memory = static_cast<std::size_t>(car_.memory());
  const double motion[] = {x.x, x.y, x.yaw, x.vx, x.vy, x.omega};
  const InstantBatch<double> instant(motion, {d, x.delta, 0.0}, at, options_.dt, options_.hold);
  if (memory > 0) car_.start_memory(instant.batch, current_.data());
  for (int j = 0; j < past_; ++j) {
    current_[memory + 2 * static_cast<std::size_t>(j)] = d;
    current_[memory + 2 * static_cast<std::size_t>(j) + 1] = x.delta;
  }
}

State CorrectedModel::advance(const State& x, const Input& u, const Place& at) {
  start(x, row_);
  const double input[] = {u.d, u.ddelta};
  values(1, row_.data(), input, &at, row_next_.data());
  std::copy(row_next_.begin() + state_size, row_next_.end(), current_.begin());
  return state_of(row_next_.data());
}

State CorrectedModel::advance_within(const StepBound& bound, const State& x, const Input& u, const Place& at) {
  constexpr int most = 256;
  const double input[] = {u.d, u.ddelta};
  const int given = options_.integration.substeps;
  const auto advance_by = [&](int substeps, std::vector<double>& next) {
    options_.integration.substeps = substeps;
    values(1, row_.data(), input, &at, next.data());
  };
  const auto agree = [&] {  // false also where one is no number
    const auto off = [&](int i) {
      return std::abs(row_finer_[static_cast<std::size_t>(i)] - row_next_[static_cast<std::size_t>(i)]);
    };
    return off(3) <= bound.velocity && off(4) <= bound.velocity && bound.wheelbase * off(5) <= bound.velocity;
  };
  start(x, row_);
  advance_by(given, row_next_);
  for (int times = 1; times < most; times *= 2) {
    advance_by(2 * times * given, row_finer_);
    if (agree()) break;
    std::swap(row_next_, row_finer_);
  }
  options_.integration.substeps = given;
  std::copy(row_next_.begin() + state_size, row_next_.end(), current_.begin());
  return state_of(row_next_.data());
}

Quantities<double> CorrectedModel::quantities(const State& x, const Input& u, const Place& at) {
  start(x, row_);
  const double input[] = {u.d, u.ddelta};
  load(stepper_, 1, row_.data(), input, row_.size());
  return loaded_quantities(at);
}

Quantities<double> CorrectedModel::quantities_after(const State& x, const Input& u, const Place& at) {
  start(x, row_);
  const double reached[] = {u.d, 0.0};
  load(stepper_, 1, row_.data(), reached, row_.size());
  stepper_.ramp[0].begin.delta_rate = u.ddelta;
  return loaded_quantities(at);
}

Quantities<double> CorrectedModel::loaded_quantities(const Place& at) {
  Quantities<double> q{};
  stepper_.quantities(car_, options_.dt, 1, &at, nullptr, &q);
  return q;
}

}  // namespace gripline
