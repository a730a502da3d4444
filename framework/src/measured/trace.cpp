#include "measured/trace.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/course_adapter.hpp"

namespace gripline::diagnose {
namespace {

constexpr std::size_t chunk = 32;

/// (e^z - 1) / z and (e^z - 1 - z) / z^2: weights of a linear input to z' = a z + c(t) over one step.
double phi1(double z) { return std::abs(z) < 1e-4 ? 1.0 + 0.5 * z : std::expm1(z) / z; }
double phi2(double z) { return std::abs(z) < 1e-3 ? 0.5 + z / 6.0 : (std::expm1(z) - z) / (z * z); }

History<double> history_at(const Measured& log, double now) {
  History<double> history;
  history.samples = log.command.data();
  history.count = log.command.size();
  history.t0 = log.t0;
  history.dt = log.dt;
  history.now = now;
  history.hold = Hold::foh;
  return history;
}

/// Fractions of a step between which the commands that act are smooth: 0, the kink of delayed commands, 1, each piece
/// cut so that none is longer than 1 / substeps.
std::vector<double> step_knots(const StagedCar& car, double dt, int substeps) {
  std::vector<double> corners{0.0};
  const double delay = car.look_back() / dt;
  const double kink = delay - std::floor(delay);
  if (kink > 1e-6 && kink < 1.0 - 1e-6) corners.push_back(kink);
  corners.push_back(1.0);
  std::vector<double> knots{0.0};
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const double length = corners[i + 1] - corners[i];
    const int pieces = std::max(1, static_cast<int>(std::ceil(length * substeps - 1e-9)));
    for (int p = 1; p <= pieces; ++p) knots.push_back(corners[i] + length * p / pieces);
  }
  return knots;
}

}  // namespace

Place Road::at(double t, double x, double y, double yaw, double& hint) const {
  const CurveLocation found = std::isnan(hint) ? track_->locate(x, y) : track_->locate(x, y, hint);
  hint = found.s;
  return place_of(*track_, found, t, x, y, yaw);
}

void Trace::set_motion(std::vector<double> rows, const Road& road) {
  motion = std::move(rows);
  at.resize(size());
  double hint = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 0; k < size(); ++k) {
    const double* const row = motion.data() + k * channels;
    at[k] = road.at(log.t0 + static_cast<double>(k) * log.dt, row[0], row[1], row[2], hint);
  }
  if (command_dual.empty())
    for (const CommandSample<double>& c : log.command) command_dual.push_back({Dual8(c.d), Dual8(c.delta)});
}

ActingCommand<double> command_at(const Measured& log, std::size_t k, double share) {
  const CommandSample<double>& a = log.command[k];
  const CommandSample<double>& b = log.command[std::min(k + 1, log.size() - 1)];
  return {a.d + share * (b.d - a.d), a.delta + share * (b.delta - a.delta), (b.delta - a.delta) / log.dt};
}

Place between(const Place& from, const Place& to, double share, double dt) {
  Place p = from;
  p.t += share * dt;
  double step = to.lap_fraction - from.lap_fraction;
  step -= std::round(step);
  p.lap_fraction += share * step;
  p.lap_fraction -= std::floor(p.lap_fraction);
  p.grade += share * (to.grade - from.grade);
  p.bank += share * (to.bank - from.bank);
  return p;
}

ActingCommand<double> Trace::command(std::size_t k, double share) const { return command_at(log, k, share); }

Place Trace::place(std::size_t k, double share) const {
  return between(at[k], at[std::min(k + 1, size() - 1)], share, log.dt);
}

std::array<double, 6> Trace::reference(std::size_t k, double share) const {
  const auto row = [&](std::ptrdiff_t i) {
    return motion.data() +
           static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i, 0, static_cast<std::ptrdiff_t>(size()) - 1)) *
               channels;
  };
  const auto at_k = static_cast<std::ptrdiff_t>(k);
  const double *a = row(at_k - 1), *b = row(at_k), *c = row(at_k + 1), *d = row(at_k + 2);
  std::array<double, 6> x{};
  for (std::size_t i = 0; i < channels; ++i) {  // Catmull and Rom
    const double m0 = 0.5 * (c[i] - a[i]);
    const double m1 = 0.5 * (d[i] - b[i]);
    const double gap = c[i] - b[i];
    x[i] = b[i] + share * (m0 + share * (3.0 * gap - 2.0 * m0 - m1 + share * (m0 + m1 - 2.0 * gap)));
  }
  return x;
}

std::vector<double> smooth_readings(const Measured& log, int half) {
  const auto n = static_cast<int>(log.size());
  std::vector<double> rows(log.size() * channels);
  for (std::size_t c = 0; c < channels; ++c) {
    for (int k = 0; k < n; ++k) {
      for (int width = half;; width *= 2) {  // wider where readings are missing
        double s0 = 0, s1 = 0, s2 = 0, s3 = 0, s4 = 0, y0 = 0, y1 = 0, y2 = 0;
        int count = 0;
        for (int j = std::max(0, k - width); j <= std::min(n - 1, k + width); ++j) {
          const double y = log.reading[static_cast<std::size_t>(j) * channels + c];
          if (std::isnan(y)) continue;
          const double z = j - k;
          s0 += 1, s1 += z, s2 += z * z, s3 += z * z * z, s4 += z * z * z * z;
          y0 += y, y1 += y * z, y2 += y * z * z;
          ++count;
        }
        double value = 0.0;
        if (count >= 4) {
          // Value at 0 of the quadratic through (z, y) in the least-squares sense, by Cramer's rule.
          const double det = s0 * (s2 * s4 - s3 * s3) - s1 * (s1 * s4 - s2 * s3) + s2 * (s1 * s3 - s2 * s2);
          value = (y0 * (s2 * s4 - s3 * s3) - s1 * (y1 * s4 - y2 * s3) + s2 * (y1 * s3 - y2 * s2)) / det;
        } else if (width < n) {
          continue;
        }
        rows[static_cast<std::size_t>(k) * channels + c] = value;
        break;
      }
    }
  }
  return rows;
}

Stepping::Stepping(const StagedCar& car, const Measured& log, int substeps)
    : car_(car),
      log_(log),
      m_(static_cast<std::size_t>(car.memory())),
      looks_back_(car.look_back() > 0.0),
      knots_(step_knots(car, log.dt, substeps)) {}

void Stepping::advance(std::span<const std::size_t> sample, std::span<const Place> from, std::span<const Place> to,
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
    constexpr double node[4] = {0, 0.5, 0.5, 1}, weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    for (int stage = 0; stage < 4; ++stage) {
      const double share = knots_[piece] + node[stage] * (knots_[piece + 1] - knots_[piece]);
      if (stage != 2)
        for (std::size_t i = 0; i < n; ++i) {
          command_[i] = command_at(log_, sample[i], share);
          at_[i] = between(from[i], to[i], share, log_.dt);
          if (looks_back_) history_[i] = history_at(log_, at_[i].t);
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

void step_all(const StagedCar& car, const Trace& trace, const std::vector<double>& memory, int substeps,
              std::vector<double>& next) {
  const std::size_t steps = trace.size() - 1;
  const auto m = static_cast<std::size_t>(car.memory());
  const std::size_t width = channels + m;
  next.resize(steps * width);
  Stepping stepping(car, trace.log, substeps);
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

std::vector<double> run_memory(const StagedCar& car, const Trace& trace) {
  const auto m = static_cast<std::size_t>(car.memory());
  std::vector<double> rows(trace.size() * m);
  if (m == 0) return rows;
  const bool looks_back = car.look_back() > 0.0;
  constexpr int substeps = 2;
  // Row 0: the memory as it is; row 1 + j: memory j moved a little, for the slope of its rate.
  std::vector<double> x((m + 1) * channels), mem((m + 1) * m), mem_rate((m + 1) * m);
  std::vector<ActingCommand<double>> command(m + 1);
  std::vector<Place> at(m + 1);
  std::vector<History<double>> history(m + 1);
  CarBatch<double> batch;
  batch.motion = x.data();
  batch.memory = mem.data();
  batch.command = command.data();
  batch.at = at.data();
  batch.memory_rate = mem_rate.data();
  if (looks_back) batch.history = history.data();
  const auto go_to = [&](std::size_t k, double share, std::size_t copies) {
    const auto ref = share == 0.0 ? std::array<double, 6>{} : trace.reference(k, share);
    for (std::size_t i = 0; i < copies; ++i) {
      for (std::size_t c = 0; c < channels; ++c)
        x[i * channels + c] = share == 0.0 ? trace.motion[k * channels + c] : ref[c];
      command[i] = trace.command(k, share);
      at[i] = trace.place(k, share);
      history[i] = history_at(trace.log, at[i].t);
    }
    batch.n = copies;
  };
  go_to(0, 0.0, 1);
  std::vector<double> now(m);
  car.start_memory(batch, now.data());
  std::copy(now.begin(), now.end(), rows.begin());
  const double h = trace.log.dt / substeps;
  std::vector<double> first(m), slope(m);
  for (std::size_t k = 0; k + 1 < trace.size(); ++k) {
    for (int s = 0; s < substeps; ++s) {
      // How quickly a memory settles changes little within a sample: its slope is asked for once.
      const std::size_t copies = s == 0 ? m + 1 : 1;
      go_to(k, static_cast<double>(s) / substeps, copies);
      for (std::size_t i = 0; i < copies; ++i)
        std::copy(now.begin(), now.end(), mem.begin() + static_cast<std::ptrdiff_t>(i * m));
      for (std::size_t j = 0; j + 1 < copies; ++j) mem[(j + 1) * m + j] += 1e-6 * (1.0 + std::abs(now[j]));
      car.memory_rates(batch);
      for (std::size_t j = 0; j + 1 < copies; ++j)
        slope[j] = (mem_rate[(j + 1) * m + j] - mem_rate[j]) / (mem[(j + 1) * m + j] - now[j]);
      std::copy_n(mem_rate.begin(), m, first.begin());
      go_to(k, static_cast<double>(s + 1) / substeps, 1);
      car.memory_rates(batch);
      for (std::size_t j = 0; j < m; ++j) {
        const double z = h * slope[j];
        now[j] += h * (phi1(z) * first[j] + phi2(z) * (mem_rate[j] - first[j]));
      }
    }
    std::copy(now.begin(), now.end(), rows.begin() + static_cast<std::ptrdiff_t>((k + 1) * m));
  }
  return rows;
}

namespace {

/// Rates of the motion and of the memory at every sample.
void all_rates(const StagedCar& car, const Trace& trace, const std::vector<double>& memory, std::vector<double>& rate,
               std::vector<double>& memory_rate) {
  const std::size_t n = trace.size();
  rate.resize(n * channels);
  memory_rate.resize(memory.size());
  std::vector<ActingCommand<double>> command(n);
  std::vector<History<double>> history(n);
  for (std::size_t k = 0; k < n; ++k) {
    command[k] = trace.command(k, 0.0);
    history[k] = history_at(trace.log, trace.at[k].t);
  }
  CarBatch<double> batch;
  batch.n = n;
  batch.motion = trace.motion.data();
  batch.memory = memory.data();
  batch.command = command.data();
  batch.at = trace.at.data();
  batch.motion_rate = rate.data();
  batch.memory_rate = memory_rate.data();
  batch.history = history.data();
  car.rates(batch);
}

}  // namespace

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

}  // namespace gripline::diagnose
