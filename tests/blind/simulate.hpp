// Logs of blind cases: the nominal car with hidden effects under the driver's commands, integrated in steps of 2.5 ms
// by the classical Runge-Kutta method; commands linear between samples (framework/doc/diagnose-cases.md).
#pragma once

#include <optional>

#include "blind/drive.hpp"
#include "blind/outside.hpp"
#include "diagnose/model/candidates.hpp"
#include "measured/replay/trace.hpp"

namespace gripline::blind {

/// The outside effect as an Effect: its forces and accelerations.
class OutsideTyre final : public gripline::Effect {
 public:
  explicit OutsideTyre(const Outside& o) : o_(o) {}
  Stage stage() const noexcept override { return Stage::tyre; }
  void apply(const Points<double>& p) const override {
    for (std::size_t i = 0; i < p.n; ++i) {
      p.q[i].peak_front *= o_.grip() * o_.front(p.q[i].vx) * o_.side(p.q[i].slip_front);
      p.q[i].peak_rear *= o_.grip() * o_.side(p.q[i].slip_rear);
    }
  }
  void apply(const Points<Dual8>&) const override {}

 private:
  const Outside& o_;
};

struct Plan {
  const diagnose::Catalogue* catalogue = nullptr;
  diagnose::ModelSpec model;  // effects of the catalogue, values of the nominal parameters
  std::optional<blind::Effect> outside;
  double latency = 0;  // of all readings [s]
  double seconds = 60, dt = 0.02;
  double roughness = 0;      // process noise of framework/doc/diagnose-cases.md, times this
  double noise_time = 0.25;  // its correlation time [s]
  Style style;
};

struct Log {
  measured::Log log;  // exact readings
  double laps = 0;
};

/// Process noise (framework/doc/diagnose-cases.md): accelerations with a correlation time [s].
class Disturbance {
 public:
  Disturbance(double size, double correlation_time, bool full, Random& r)
      : on_(size > 0.0), time_(correlation_time), sigma_{size * 0.1, size * 0.1, size * (full ? 0.05 : 0.8)}, r_(r) {
    for (std::size_t i = 0; on_ && i < 3; ++i) value_[i] = sigma_[i] * normal(r);
  }
  void advance(double h) {
    const double keep = std::exp(-h / time_), fresh = std::sqrt(1.0 - keep * keep);
    for (std::size_t i = 0; on_ && i < 3; ++i) value_[i] = keep * value_[i] + fresh * sigma_[i] * normal(r_);
  }
  const std::array<double, 3>& value() const { return value_; }

 private:
  bool on_;
  double time_;
  std::array<double, 3> sigma_, value_{};
  Random& r_;
};

/// Empty when the car spins, leaves the road or becomes slower than 0.3 v_ref.
inline std::optional<Log> simulate(const Plan& plan, const measured::Road& road, int car_kind, Random& r) {
  const Car& body = plan.catalogue->car();
  StagedCar car = plan.catalogue->build(plan.model);
  std::optional<Outside> outside;
  if (plan.outside) outside.emplace(*plan.outside, body.v_ref);
  std::optional<OutsideTyre> tyre;
  if (outside) car.add(tyre.emplace(*outside), {}, "outside");

  const Track& track = road.track();
  Driver driver(track, car_kind, plan.style, r);
  const double s0 = uniform(r, 0.0, track.length());
  const CurvePoint begin = track.at(s0);
  const double turn = plan.style.direction > 0 ? 0.0 : std::numbers::pi;
  std::array<double, 6> x = {begin.x, begin.y, begin.yaw + turn, 0.95 * driver.speed_at(s0), 0.0, 0.0};
  x[5] = x[3] * begin.kappa * plan.style.direction;
  const auto m = static_cast<std::size_t>(car.memory());
  std::vector<double> memory(m);

  const int pieces = static_cast<int>(std::round(plan.dt / 0.0025));
  Log out;
  measured::Log& log = out.log;
  log.dt = plan.dt;
  const double h = log.dt / pieces;
  const auto lead = static_cast<std::size_t>(std::round(plan.latency / h));
  const auto n = static_cast<std::size_t>(std::round(plan.seconds / log.dt)) + 1;
  Disturbance disturbance(plan.roughness, plan.noise_time, car_kind == 1, r);
  double hint = std::nan(""), last_fraction = std::nan("");

  const auto rates = [&](double t, const std::array<double, 6>& at, const std::vector<double>& mem,
                         ActingCommand<double> command, const Place& place, std::array<double, 6>& rate,
                         std::vector<double>& mem_rate, bool start) {
    CarBatch<double> batch;
    const History<double> history{log.command.data(), log.command.size(), 0.0, log.dt, t, Hold::foh};
    if (outside) outside->command(t, at[3], command.d, command.delta);
    batch.n = 1;
    batch.motion = at.data();
    batch.command = &command;
    batch.memory = mem.data();
    batch.at = &place;
    batch.history = &history;
    batch.motion_rate = rate.data();
    batch.memory_rate = mem_rate.data();
    if (start) return car.start_memory(batch, mem_rate.data());
    car.rates(batch);
    for (std::size_t c = 0; c < 3; ++c) rate[3 + c] += disturbance.value()[c];
    if (outside) outside->accelerate(place, at[3], at[5], rate[3], rate[4], rate[5]);
  };
  const auto command_at = [&](double t) -> ActingCommand<double> {
    const auto& c = log.command;
    const double position = std::max(0.0, t / log.dt);
    const std::size_t i = std::min(static_cast<std::size_t>(position + 1e-9), c.size() - 1);
    const std::size_t j = std::min(i + 1, c.size() - 1);
    const double w = std::clamp(position - static_cast<double>(i), 0.0, 1.0);
    return {c[i].d + w * (c[j].d - c[i].d), c[i].delta + w * (c[j].delta - c[i].delta),
            t < 0.0 ? 0.0 : (c[j].delta - c[i].delta) / log.dt};
  };
  const auto rounded = [](Driver::Command c) {
    return CommandSample<double>{std::round(c.d * 1e5) * 1e-5, std::round(c.delta * 1e6) * 1e-6};
  };

  std::array<double, 6> k{}, sum{}, mid{};
  std::vector<double> km(m), sum_m(m), mid_m(m);
  log.command.push_back(rounded(driver.decide(0.0, x[0], x[1], x[2], x[3], x[4], x[5], log.dt)));
  bool started = false;
  const std::size_t steps = (n - 1) * pieces + lead;
  for (std::size_t i = 0; i <= steps; ++i) {
    const double t = (static_cast<double>(i) - static_cast<double>(lead)) * h;
    const Place place = road.at(t, x[0], x[1], x[2], hint);
    if (!started && m > 0) rates(t, x, memory, command_at(t), place, k, km, true), memory = km;
    started = true;
    // The reading of sample j shows the state `lead` pieces ago; the driver sees the state now.
    if (i % pieces == 0) {
      Reading<double> reading{x[0], x[1], x[2], x[3], x[4], x[5]};
      car.read(&reading, 1, &place, nullptr);
      log.reading.insert(log.reading.end(), {reading.x, reading.y, reading.yaw, reading.vx, reading.vy, reading.omega});
      if (!std::isnan(last_fraction)) {
        const double step = place.lap_fraction - last_fraction;
        out.laps += std::abs(step - std::round(step));
      }
      last_fraction = place.lap_fraction;
      const bool off = std::abs(place.n) > 1.6 * track.half_width_left(0.0);
      if (off || !(x[3] > 0.32 * body.v_ref) || std::abs(x[4]) > 0.6 * x[3]) return std::nullopt;
    }
    if (i == steps) break;
    if (i >= lead && (i - lead) % pieces == 0)
      log.command.push_back(rounded(driver.decide(t, x[0], x[1], x[2], x[3], x[4], x[5], log.dt)));
    constexpr double node[4] = {0, 0.5, 0.5, 1}, weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    for (int stage = 0; stage < 4; ++stage) {
      const double share = node[stage] * h;
      for (std::size_t c = 0; c < 6; ++c) mid[c] = x[c] + (stage == 0 ? 0.0 : share * k[c]);
      for (std::size_t c = 0; c < m; ++c) mid_m[c] = memory[c] + (stage == 0 ? 0.0 : share * km[c]);
      double near = hint;
      const Place there = stage == 0 ? place : road.at(t + share, mid[0], mid[1], mid[2], near);
      rates(t + share, mid, mid_m, command_at(t + share), there, k, km, false);
      for (std::size_t c = 0; c < 6; ++c) sum[c] = (stage == 0 ? 0.0 : sum[c]) + weight[stage] * k[c];
      for (std::size_t c = 0; c < m; ++c) sum_m[c] = (stage == 0 ? 0.0 : sum_m[c]) + weight[stage] * km[c];
    }
    for (std::size_t c = 0; c < 6; ++c) x[c] += h * sum[c];
    for (std::size_t c = 0; c < m; ++c) memory[c] += h * sum_m[c];
    disturbance.advance(h);
    if (outside)
      outside->warm(std::abs(x[4] - 0.5 * x[5] * body.lr) * std::abs(x[5] * x[3]) / (0.02 * body.v_ref * 4.0), h);
  }
  log.command.resize(n);
  return out;
}

}  // namespace gripline::blind
