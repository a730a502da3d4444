#include "measured/replay/replay.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "util/exponential.hpp"

namespace gripline::measured {
namespace {

constexpr std::size_t chunk = 32;

/// Part of a step from its ends within which held commands, which jump there, are looked up.
constexpr double off_its_ends = 1e-9;

/// Fractions of a step between which the commands that act are smooth: 0, their breakpoints, 1, each piece cut so that
/// none is longer than 1 / substeps.
std::vector<double> step_knots(const StagedCar& car, const Log& log, int substeps) {
  std::vector<double> corners{0.0};
  const auto add_breakpoint = [&](double late) {
    const double at = late - std::floor(late);
    if (at > 1e-6 && at < 1.0 - 1e-6) corners.push_back(at);
  };
  const auto add_breakpoints = [&](double delay) {
    const double late = delay / log.dt + log.hold.lag;
    add_breakpoint(late);
    if (!log.fine.empty()) add_breakpoint(late + 0.5);
  };
  add_breakpoints(0.0);
  car.for_each_delay(add_breakpoints);
  corners.push_back(1.0);
  std::sort(corners.begin(), corners.end());
  const auto same = [](double a, double b) { return b - a < 1e-9; };
  corners.erase(std::unique(corners.begin(), corners.end(), same), corners.end());
  std::vector<double> knots{0.0};
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const double length = corners[i + 1] - corners[i];
    const int pieces = std::max(1, static_cast<int>(std::ceil(length * substeps - 1e-9)));
    for (int p = 1; p <= pieces; ++p) knots.push_back(corners[i] + length * p / pieces);
  }
  return knots;
}

}  // namespace

LogStepper::LogStepper(const StagedCar& car, const Log& log, int substeps)
    : car_(car),
      log_(log),
      m_(static_cast<std::size_t>(car.memory())),
      looks_back_(car.look_back() > 0.0),
      knots_(step_knots(car, log, substeps)),
      rk4_(find_tableau("rk4")) {}

void LogStepper::advance(std::span<const std::size_t> sample, std::span<const Place> from, std::span<const Place> to,
                         double* x, double* memory) {
  const std::size_t n = sample.size();
  for (auto* rows : {&xs_, &kx_, &sum_x_}) rows->resize(n * channels);
  for (auto* rows : {&ms_, &km_, &sum_m_}) rows->resize(n * m_);
  command_.resize(n);
  at_.resize(n);
  history_.resize(n);
  CarBatch<double> batch;
  batch.n = n;
  batch.motion = xs_.data();
  batch.memory = ms_.data();
  batch.command = command_.data();
  batch.at = at_.data();
  batch.motion_rate = kx_.data();
  batch.memory_rate = km_.data();
  if (looks_back_) batch.history = history_.data();
  for (std::size_t piece = 0; piece + 1 < knots_.size(); ++piece) {
    const double h = (knots_[piece + 1] - knots_[piece]) * log_.dt;
    // Not by a Stepper: the place moves along within a step, and commands are looked up in the log at every stage. Each
    // stage starts from the rates of the one before: a_ij = 0 but for j = i - 1, where it is c_i.
    const auto node = rk4_->c, weight = rk4_->b;
    for (std::size_t stage = 0; stage < 4; ++stage) {
      const double share = knots_[piece] + node[stage] * (knots_[piece + 1] - knots_[piece]);
      const double within = std::clamp(share, knots_[piece] + off_its_ends, knots_[piece + 1] - off_its_ends);
      if (stage != 2)  // at the time of stage 1
        for (std::size_t i = 0; i < n; ++i) {
          command_[i] = command_at(log_, sample[i], log_.hold.in_steps() ? within : share);
          at_[i] = between(from[i], to[i], share, log_.dt);
          if (looks_back_)
            history_[i] = history_at(log_, log_.hold.in_steps() ? from[i].t + within * log_.dt : at_[i].t);
        }
      for (std::size_t i = 0; i < n * channels; ++i) xs_[i] = stage == 0 ? x[i] : x[i] + node[stage] * h * kx_[i];
      for (std::size_t i = 0; i < n * m_; ++i) ms_[i] = stage == 0 ? memory[i] : memory[i] + node[stage] * h * km_[i];
      car_.rates(batch);
      for (std::size_t i = 0; i < n * channels; ++i)
        sum_x_[i] = (stage == 0 ? 0.0 : sum_x_[i]) + weight[stage] * kx_[i];
      for (std::size_t i = 0; i < n * m_; ++i) sum_m_[i] = (stage == 0 ? 0.0 : sum_m_[i]) + weight[stage] * km_[i];
    }
    for (std::size_t i = 0; i < n * channels; ++i) x[i] += h * sum_x_[i];
    for (std::size_t i = 0; i < n * m_; ++i) memory[i] += h * sum_m_[i];
  }
}

void predict_one_step(const StagedCar& car, const Trace& trace, const std::vector<double>& memory, int substeps,
                      std::vector<double>& next) {
  const std::size_t steps = trace.size() - 1;
  const auto m = static_cast<std::size_t>(car.memory());
  const std::size_t width = channels + m;
  next.resize(steps * width);
  LogStepper stepping(car, trace.log, substeps);
  std::vector<double> x(chunk * channels), mem(chunk * m);
  std::array<std::size_t, chunk> sample{};
  for (std::size_t begin = 0; begin < steps; begin += chunk) {
    const std::size_t n = std::min(chunk, steps - begin);
    for (std::size_t i = 0; i < n; ++i) sample[i] = begin + i;
    std::copy_n(trace.motion.begin() + static_cast<std::ptrdiff_t>(begin * channels), n * channels, x.begin());
    std::copy_n(memory.begin() + static_cast<std::ptrdiff_t>(begin * m), n * m, mem.begin());
    stepping.advance({sample.data(), n}, {trace.at.data() + begin, n}, {trace.at.data() + begin + 1, n}, x.data(),
                     mem.data());
    for (std::size_t i = 0; i < n; ++i) {
      std::copy_n(x.begin() + static_cast<std::ptrdiff_t>(i * channels), channels,
                  next.begin() + static_cast<std::ptrdiff_t>((begin + i) * width));
      std::copy_n(mem.begin() + static_cast<std::ptrdiff_t>(i * m), m,
                  next.begin() + static_cast<std::ptrdiff_t>((begin + i) * width + channels));
    }
  }
}

namespace {

/// Integrates the memory of a car's effects along a trace by an exponential method (each memory linearised by itself),
/// for which stiff lags need no short steps.
class MemoryIntegrator {
 public:
  MemoryIntegrator(const StagedCar& car, const Trace& trace)
      : car_(car),
        trace_(trace),
        m_(static_cast<std::size_t>(car.memory())),
        x_((m_ + 1) * channels),
        memory_((m_ + 1) * m_),
        rate_((m_ + 1) * m_),
        command_(m_ + 1),
        at_(m_ + 1),
        history_(m_ + 1),
        now_(m_),
        first_(m_),
        slope_(m_) {
    batch_.motion = x_.data();
    batch_.memory = memory_.data();
    batch_.command = command_.data();
    batch_.at = at_.data();
    batch_.memory_rate = rate_.data();
    if (car.look_back() > 0.0) batch_.history = history_.data();
    go_to(0, 0.0, 1);
    car.start_memory(batch_, now_.data());
  }
  const std::vector<double>& now() const { return now_; }

  /// From sample k to k + 1.
  void advance(std::size_t k) {
    constexpr int substeps = 2;
    const double h = trace_.log.dt / substeps;
    for (int s = 0; s < substeps; ++s) {
      // The slope of a memory's rate changes little within a sample and is taken at its beginning.
      if (s == 0)
        rates_and_slopes(k);
      else
        rates_at(k, static_cast<double>(s) / substeps);
      std::copy_n(rate_.begin(), m_, first_.begin());
      go_to(k, static_cast<double>(s + 1) / substeps, 1);
      car_.memory_rates(batch_);
      for (std::size_t j = 0; j < m_; ++j) {
        const double z = h * slope_[j];
        now_[j] += h * (phi1(z) * first_[j] + phi2(z) * (rate_[j] - first_[j]));
      }
    }
  }

 private:
  /// Sets `copies` rows of the batch to the reference `share` of a step after sample k.
  void go_to(std::size_t k, double share, std::size_t copies) {
    const auto between_samples = share == 0.0 ? std::array<double, 6>{} : trace_.reference(k, share);
    for (std::size_t i = 0; i < copies; ++i) {
      for (std::size_t c = 0; c < channels; ++c)
        x_[i * channels + c] = share == 0.0 ? trace_.motion[k * channels + c] : between_samples[c];
      command_[i] = trace_.command(k, share);
      at_[i] = trace_.place(k, share);
      const double within =
          trace_.log.hold.in_steps() ? std::clamp(share, off_its_ends, 1.0 - off_its_ends) - share : 0.0;
      history_[i] = history_at(trace_.log, at_[i].t + within * trace_.log.dt);
    }
    batch_.n = copies;
  }
  void rates_at(std::size_t k, double share) {
    go_to(k, share, 1);
    std::copy(now_.begin(), now_.end(), memory_.begin());
    car_.memory_rates(batch_);
  }
  /// Row 0: the memory as it is; row 1 + j: memory j moved a little, for the slope of its rate.
  void rates_and_slopes(std::size_t k) {
    go_to(k, 0.0, m_ + 1);
    for (std::size_t i = 0; i <= m_; ++i)
      std::copy(now_.begin(), now_.end(), memory_.begin() + static_cast<std::ptrdiff_t>(i * m_));
    for (std::size_t j = 0; j < m_; ++j) memory_[(j + 1) * m_ + j] += 1e-6 * (1.0 + std::abs(now_[j]));
    car_.memory_rates(batch_);
    for (std::size_t j = 0; j < m_; ++j)
      slope_[j] = (rate_[(j + 1) * m_ + j] - rate_[j]) / (memory_[(j + 1) * m_ + j] - now_[j]);
  }

  const StagedCar& car_;
  const Trace& trace_;
  std::size_t m_;
  std::vector<double> x_, memory_, rate_;
  std::vector<ActingCommand<double>> command_;
  std::vector<Place> at_;
  std::vector<History<double>> history_;
  CarBatch<double> batch_;
  std::vector<double> now_, first_, slope_;
};

}  // namespace

std::vector<double> simulate_memory(const StagedCar& car, const Trace& trace) {
  const auto m = static_cast<std::size_t>(car.memory());
  std::vector<double> rows(trace.size() * m);
  if (m == 0) return rows;
  MemoryIntegrator memory(car, trace);
  std::copy_n(memory.now().begin(), m, rows.begin());
  for (std::size_t k = 0; k + 1 < trace.size(); ++k) {
    memory.advance(k);
    std::copy_n(memory.now().begin(), m, rows.begin() + static_cast<std::ptrdiff_t>((k + 1) * m));
  }
  return rows;
}

namespace {

/// All samples of a trace as a batch of instants, which points into this and into the trace.
struct Instants {
  explicit Instants(const Trace& trace) : command(trace.size()), history(trace.size()) {
    for (std::size_t k = 0; k < trace.size(); ++k) {
      command[k] = trace.command(k);
      history[k] = history_at_sample(trace.log, trace.at[k].t);
    }
    batch.n = trace.size();
    batch.motion = trace.motion.data();
    batch.command = command.data();
    batch.at = trace.at.data();
    batch.history = history.data();
  }
  Instants(const Instants&) = delete;
  Instants& operator=(const Instants&) = delete;

  std::vector<ActingCommand<double>> command;
  std::vector<History<double>> history;
  CarBatch<double> batch;
};

/// Rates of the motion and of the memory at every sample.
void all_rates(const StagedCar& car, const Trace& trace, const std::vector<double>& memory, std::vector<double>& rate,
               std::vector<double>& memory_rate) {
  rate.resize(trace.size() * channels);
  memory_rate.resize(memory.size());
  Instants instants(trace);
  CarBatch<double>& batch = instants.batch;
  batch.memory = memory.data();
  batch.motion_rate = rate.data();
  batch.memory_rate = memory_rate.data();
  car.rates(batch);
}

}  // namespace

std::vector<double> steady_memory(const StagedCar& car, const Trace& trace) {
  std::vector<double> steady(trace.size() * static_cast<std::size_t>(car.memory()));
  if (!steady.empty()) car.start_memory(Instants(trace).batch, steady.data());
  return steady;
}

std::vector<double> rates_at_samples(const StagedCar& car, const Trace& trace, const std::vector<double>& memory) {
  std::vector<double> rate, memory_rate;
  all_rates(car, trace, memory, rate, memory_rate);
  return rate;
}

std::vector<double> memory_rates(const StagedCar& car, const Trace& trace, const std::vector<double>& memory) {
  std::vector<double> rate, memory_rate;
  all_rates(car, trace, memory, rate, memory_rate);
  return memory_rate;
}

std::array<CommandRates, 2> rates_by_command(const StagedCar& car, const Trace& trace,
                                             const std::vector<double>& memory) {
  constexpr double step = 1e-4;  // [1] and [rad], above rounding
  std::vector<double> rate, memory_rate;
  all_rates(car, trace, memory, rate, memory_rate);
  std::array<CommandRates, 2> by;
  for (std::size_t i = 0; i < by.size(); ++i) {
    Trace moved = trace;
    for (auto* const commands : {&moved.log.command, &moved.log.fine})
      for (CommandSample<double>& c : *commands) (i == 0 ? c.d : c.delta) += step;
    all_rates(car, moved, memory, by[i].motion, by[i].memory);
    for (std::size_t k = 0; k < rate.size(); ++k) by[i].motion[k] = (by[i].motion[k] - rate[k]) / step;
    for (std::size_t k = 0; k < memory_rate.size(); ++k) by[i].memory[k] = (by[i].memory[k] - memory_rate[k]) / step;
  }
  return by;
}

}  // namespace gripline::measured
