// One effect plugin on a bench: quantities in, changed quantities out, values and derivatives.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "plugin/registry.hpp"
#include "support/paths.hpp"

namespace gripline::test {

inline const Registry& plugins() {
  static const Registry registry({testing_support::plugin_dir()});
  return registry;
}

/// A car with round numbers.
inline PluginContext bench_car() {
  PluginContext context;
  context.car.m = 2.0;
  context.car.Iz = 0.5;
  context.car.lf = 0.4;
  context.car.lr = 0.6;
  context.car.v_ref = 5.0;
  return context;
}

/// Quantities in the middle of a corner, every one of them different.
inline Quantities<double> bench_quantities() {
  Quantities<double> q{};
  q.yaw = 0.7, q.vx = 4.0, q.vy = -0.3, q.omega = 1.2;
  q.d = 0.5, q.delta = 0.1, q.delta_rate = 0.25;
  q.motor = 10.0, q.emf = 1.5, q.brake = 8.0, q.rolling = 0.6, q.drag = 0.05;
  q.drive_force = 2.0, q.m = 2.0, q.Iz = 0.5, q.lf = 0.4, q.lr = 0.6, q.load_front = 1.1, q.load_rear = 0.9;
  q.slip_front = 0.05, q.slip_rear = 0.04, q.peak_front = 9.0, q.peak_rear = 7.0, q.stiff_front = 4.0,
  q.stiff_rear = 5.0;
  q.force_front = 3.0, q.force_rear = 2.5;
  q.ax = 0.4, q.ay = 1.6, q.aw = -0.8, q.grade = 0.01, q.bank = -0.02;
  return q;
}

template <class T>
Quantities<T> lift(const Quantities<double>& q) {
  static_assert(sizeof(Quantities<double>) % sizeof(double) == 0);
  constexpr std::size_t n = sizeof(Quantities<double>) / sizeof(double);
  Quantities<T> out{};
  const auto* const from = reinterpret_cast<const double*>(&q);
  auto* const to = reinterpret_cast<T*>(&out);
  for (std::size_t i = 0; i < n; ++i) to[i] = T(from[i]);
  return out;
}

class EffectBench {
 public:
  explicit EffectBench(const std::string& id) : entry_(plugins().find(abi::Kind::effect, id)) {
    std::vector<abi::ParamValue> values;
    for (const abi::ParamDecl& p : entry_.params()) values.push_back({p.default_value, Table{}});
    effect_ = create<Effect>(entry_, bench_car(), values);
  }

  Quantities<double> q = bench_quantities();
  Place at;
  std::vector<double> memory, memory_rate;
  std::vector<CommandSample<double>> commands;
  double now = 0, dt = 0.02;

  const Effect& effect() const { return *effect_; }
  const PluginEntry& entry() const { return entry_; }

  /// The quantities after the effect with these parameters.
  Quantities<double> apply(std::vector<double> params) {
    Quantities<double> out = q;
    run(out, params.data());
    return out;
  }

  /// Its memory at the start of a run.
  std::vector<double> start_memory(const std::vector<double>& params) const {
    Quantities<double> begin = q;
    std::vector<double> first(static_cast<std::size_t>(effect_->memory()));
    Points<double> points;
    points.n = 1;
    points.q = &begin;
    points.at = &at;
    points.params = params.data();
    points.memory_stride = first.size();
    effect_->start_memory(points, first.data());
    return first;
  }

  /// Derivatives by every parameter of one quantity: exact ones against central differences.
  void expect_exact_derivatives(const std::vector<double>& params) {
    constexpr std::size_t n = sizeof(Quantities<double>) / sizeof(double);
    for (std::size_t p = 0; p < params.size(); ++p) {
      const double step = 1e-6;
      std::vector<double> up = params, down = params;
      up[p] += step;
      down[p] -= step;
      const Quantities<double> high = apply(up), low = apply(down);
      std::vector<Dual8> seeded(params.begin(), params.end());
      seeded[p].d[0] = 1.0;
      Quantities<Dual8> dual = lift<Dual8>(q);
      run(dual, seeded.data());
      const auto* const h = reinterpret_cast<const double*>(&high);
      const auto* const l = reinterpret_cast<const double*>(&low);
      const auto* const d = reinterpret_cast<const Dual8*>(&dual);
      for (std::size_t i = 0; i < n; ++i)
        EXPECT_NEAR(d[i].d[0], (h[i] - l[i]) / (2.0 * step), 1e-5 * (1.0 + std::abs(d[i].d[0])))
            << entry_.decl->id << ", parameter " << p << ", quantity " << i;
    }
  }

 private:
  template <class T>
  void run(Quantities<T>& out, const T* params) {
    const std::vector<T> mem(memory.begin(), memory.end());
    std::vector<T> rate(memory.size());
    std::vector<CommandSample<T>> past;
    for (const CommandSample<double>& c : commands) past.push_back({T(c.d), T(c.delta)});
    const History<T> history{past.data(), past.size(), 0.0, dt, now, Hold::foh};
    Points<T> points;
    points.n = 1;
    points.q = &out;
    points.at = &at;
    points.params = params;
    points.memory = mem.data();
    points.memory_rate = rate.data();
    points.memory_stride = mem.size();
    points.history = &history;
    effect_->apply(points);
    if constexpr (std::is_same_v<T, double>) memory_rate = rate;
  }

  const PluginEntry& entry_;
  Instance<Effect> effect_{nullptr, nullptr};
};

}  // namespace gripline::test
