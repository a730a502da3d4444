#include "measured/log/log.hpp"

#include <algorithm>
#include <cmath>

#include "util/statistics.hpp"

namespace gripline::measured {

namespace {

/// Second difference of the commands at a sample; none at the ends.
Commands second_difference(const Log& log, std::size_t k) {
  if (k == 0 || k + 1 >= log.size()) return {};
  const CommandSample<double>&a = log.command[k - 1], &b = log.command[k], &c = log.command[k + 1];
  return {a.d - 2.0 * b.d + c.d, a.delta - 2.0 * b.delta + c.delta};
}

/// Sets `fine`: half-way between samples commands are off the straight line by `bend` times the mean of the second
/// differences at both ends.
void interpolate_half_way(Log& log, const Commands& bend) {
  if (log.size() < 2) return;
  for (std::size_t k = 0; k + 1 < log.size(); ++k) {
    const Commands here = second_difference(log, k), next = second_difference(log, k + 1);
    const CommandSample<double>&a = log.command[k], &b = log.command[k + 1];
    log.fine.push_back(a);
    log.fine.push_back({0.5 * (a.d + b.d) + 0.5 * bend[0] * (here[0] + next[0]),
                        0.5 * (a.delta + b.delta) + 0.5 * bend[1] * (here[1] + next[1])});
  }
  log.fine.push_back(log.command.back());
}

}  // namespace

double CommandHold::seconds(double dt) const { return until_next ? dt : halves ? 0.5 * dt : 2.0 * lag * dt; }

CommandHold held_for(double seconds, double dt) {
  constexpr double about = 0.75, exact = 0.01;  // of a sample
  if (seconds > about * dt) return {.until_next = true};
  if (std::abs(seconds - 0.5 * dt) < exact * dt) return {.halves = true};
  return {.lag = 0.5 * seconds / dt};
}

void hold_commands(Log& log, const CommandHold& hold) {
  log.hold = hold;
  log.fine.clear();
  if (hold.halves) interpolate_half_way(log, {});
}

std::vector<std::size_t> samples_with(const Log& log, std::size_t channel) {
  std::vector<std::size_t> at;
  for (std::size_t k = 0; k < log.size(); ++k)
    if (!std::isnan(log.reading[k * channels + channel])) at.push_back(k);
  return at;
}

bool same_readings(std::span<const double> a, std::span<const double> b) {
  return std::ranges::equal(a, b, [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); });
}

bool same_commands(std::span<const CommandSample<double>> a, std::span<const CommandSample<double>> b) {
  return std::ranges::equal(a, b, [](const auto& x, const auto& y) { return x.d == y.d && x.delta == y.delta; });
}

ActingCommand<double> command_at(const Log& log, std::size_t k, double share) {
  if (log.hold.in_steps()) {
    const bool halves = !log.fine.empty();
    const std::vector<CommandSample<double>>& samples = halves ? log.fine : log.command;
    const std::size_t i = std::min(halves ? 2 * k + (share >= 0.5 ? 1 : 0) : k, samples.size() - 1);
    const CommandSample<double>&now = samples[i], &before = samples[i > 0 ? i - 1 : 0];
    return {now.d, now.delta, (now.delta - before.delta) / (halves ? 0.5 * log.dt : log.dt)};
  }
  const std::vector<CommandSample<double>>& samples = log.fine.empty() ? log.command : log.fine;
  double dt = log.dt;
  share -= log.hold.lag;
  if (share < 0.0) {  // before the first command it is as at the first
    share = k > 0 ? share + 1.0 : 0.0;
    k -= k > 0 ? 1 : 0;
  }
  if (!log.fine.empty()) {
    dt *= 0.5;
    const bool late = share >= 0.5;
    k = 2 * k + (late ? 1 : 0);
    share = 2.0 * share - (late ? 1.0 : 0.0);
  }
  const CommandSample<double>& a = samples[std::min(k, samples.size() - 1)];
  const CommandSample<double>& b = samples[std::min(k + 1, samples.size() - 1)];
  return {a.d + share * (b.d - a.d), a.delta + share * (b.delta - a.delta), (b.delta - a.delta) / dt};
}

History<double> history_at(const Log& log, double now) {
  History<double> history;
  const std::vector<CommandSample<double>>& samples = log.fine.empty() ? log.command : log.fine;
  history.samples = samples.data();
  history.count = samples.size();
  history.t0 = log.t0 + log.hold.lag * log.dt;
  history.dt = log.fine.empty() ? log.dt : 0.5 * log.dt;
  history.now = now;
  history.hold = log.hold.in_steps() ? Hold::zoh : Hold::foh;
  return history;
}

ActingCommand<double> command_at_sample(const Log& log, std::size_t k) {
  ActingCommand<double> command = command_at(log, k, 0.0);
  if (!log.hold.in_steps() || k == 0) return command;
  const CommandSample<double>& before = log.fine.empty() ? log.command[k - 1] : log.fine[2 * k - 1];
  command.d = 0.5 * (command.d + before.d);
  command.delta = 0.5 * (command.delta + before.delta);
  return command;
}

History<double> history_at_sample(const Log& log, double now) {
  History<double> history = history_at(log, now);
  if (!log.hold.in_steps()) return history;
  history.hold = Hold::foh;  // from the middle of each step to that of the next
  history.t0 += 0.5 * history.dt;
  return history;
}

void bend_commands(Log& log, const Commands& bend) {
  log.fine.clear();
  if (bend != Commands{} || log.hold.halves) interpolate_half_way(log, bend);
}

Commands command_curvature(std::span<const Log> stretches) {
  Commands square{};
  double count = 0.0;
  for (const Log& log : stretches)
    for (std::size_t k = 1; k + 1 < log.size(); ++k, count += 1.0)
      for (std::size_t i = 0; i < 2; ++i) square[i] += std::pow(second_difference(log, k)[i], 2);
  for (double& one : square) one = count > 0.0 ? std::sqrt(one / count) : 0.0;
  return square;
}

namespace {

/// Moves of a command, over its median one, from which on they are jumps, at an instant that the log does not say, and
/// how many times what is beyond counts. A larger weight takes more of what shows where commands jump for noise. What
/// set them: framework/doc/thresholds.md.
constexpr double jump = 7.0, of_jump = 3.0;

}  // namespace

std::vector<Commands> command_variation(const Log& log) {
  const auto move = [&](std::size_t k, std::size_t i) {
    const CommandSample<double>&a = log.command[k], &b = log.command[k + 1];
    return i == 0 ? b.d - a.d : b.delta - a.delta;
  };
  std::vector<Commands> all(log.size() - std::min<std::size_t>(log.size(), 1));
  for (std::size_t i = 0; i < Commands{}.size(); ++i) {
    std::vector<double> moves;
    for (std::size_t k = 0; k < all.size(); ++k)
      if (move(k, i) != 0.0) moves.push_back(std::abs(move(k, i)));
    const double typical = upper_median(std::move(moves), 0.0);
    for (std::size_t k = 0; k < all.size(); ++k) {
      const double step = move(k, i), here = second_difference(log, k)[i], next = second_difference(log, k + 1)[i],
                   beyond = of_jump * std::max(0.0, std::abs(step) - jump * typical);
      all[k][i] = std::sqrt(step * step + 0.5 * (here * here + next * next) + beyond * beyond);
    }
  }
  return all;
}

}  // namespace gripline::measured
