#include "measured/replay/trace.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "measured/log/rounding.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {

void Trace::set_motion(std::vector<double> rows, const Road& road) {
  motion = std::move(rows);
  at.resize(size());
  double hint = not_a_number;
  for (std::size_t k = 0; k < size(); ++k) {
    const double* const row = motion.data() + k * channels;
    at[k] =
        road.at(log.t0 + static_cast<double>(k) * log.dt, row[Channel::x], row[Channel::y], row[Channel::yaw], hint);
  }
  if (command_dual.empty()) copy_commands();
}

void Trace::copy_commands() {
  command_dual.clear();
  for (const CommandSample<double>& c : log.fine.empty() ? log.command : log.fine)
    command_dual.push_back({Dual8(c.d), Dual8(c.delta)});
}

void Trace::bend_commands(const Commands& bend) {
  measured::bend_commands(log, bend);
  copy_commands();
}

void Trace::unround_commands(const Commands& steps) {
  measured::unround_commands(log, steps);
  copy_commands();
}

void Trace::cut(std::size_t samples) {
  if (samples >= size()) return;
  log.command.resize(samples);
  if (!log.fine.empty()) log.fine.resize(2 * samples - 1);
  if (!log.interpolated.empty()) log.interpolated.resize(samples);
  if (!log.rounding_error.empty()) log.rounding_error.resize(samples);
  log.reading.resize(samples * channels);
  motion.resize(samples * channels);
  at.resize(samples);
  copy_commands();
}

History<Dual8> Trace::history(std::size_t k) const {
  const History<double> h = history_at_sample(log, at[k].t);
  return {command_dual.data(), command_dual.size(), h.t0, h.dt, h.now, h.hold};
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
ActingCommand<double> Trace::command(std::size_t k) const { return command_at_sample(log, k); }

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

namespace {

/// Value at sample k of the least-squares quadratic through a channel's readings at these samples, four or more.
double local_quadratic(const Log& log, std::size_t channel, std::size_t k, std::span<const std::size_t> samples) {
  double s0 = 0, s1 = 0, s2 = 0, s3 = 0, s4 = 0, y0 = 0, y1 = 0, y2 = 0;
  for (const std::size_t j : samples) {
    const double y = log.reading[j * channels + channel];
    const double z = static_cast<double>(j) - static_cast<double>(k);
    s0 += 1, s1 += z, s2 += z * z, s3 += z * z * z, s4 += z * z * z * z;
    y0 += y, y1 += y * z, y2 += y * z * z;
  }
  // Cramer's rule for the value at z = 0.
  const double det = s0 * (s2 * s4 - s3 * s3) - s1 * (s1 * s4 - s2 * s3) + s2 * (s1 * s3 - s2 * s2);
  return (y0 * (s2 * s4 - s3 * s3) - s1 * (y1 * s4 - y2 * s3) + s2 * (y1 * s3 - y2 * s2)) / det;
}

}  // namespace

std::vector<double> smooth_readings(const Log& log, int half) {
  constexpr std::size_t least = 4;  // readings that a quadratic is fitted to
  std::vector<double> rows(log.size() * channels, 0.0);
  for (std::size_t c = 0; c < channels; ++c) {
    const std::vector<std::size_t> at = samples_with(log, c);
    if (at.size() < least) continue;  // hardly ever read
    const auto around = [&](std::size_t k, std::size_t width) {
      return std::span<const std::size_t>(std::ranges::lower_bound(at, k - std::min(k, width)),
                                          std::ranges::upper_bound(at, k + width));
    };
    for (std::size_t k = 0; k < log.size(); ++k) {
      auto width = static_cast<std::size_t>(half);
      while (around(k, width).size() < least) width *= 2;
      rows[k * channels + c] = local_quadratic(log, c, k, around(k, width));
    }
  }
  return rows;
}

}  // namespace gripline::measured
