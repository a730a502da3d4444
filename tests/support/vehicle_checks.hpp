// What the tests of vehicle models share: a model evaluated at one instant, and its derivatives against differences.
#pragma once

#include <functional>

#include "support/learning_rig.hpp"

namespace gripline::rig {

/// vx, vy, omega, d, delta, delta_rate.
using Instant = std::array<double, 6>;

template <class T>
Quantities<T> evaluate(const VehicleModel& model, const std::array<T, 6>& at, const std::vector<T>& params,
                       const Place& place = {}) {
  Quantities<T> q{};
  q.vx = at[0];
  q.vy = at[1];
  q.omega = at[2];
  q.d = at[3];
  q.delta = at[4];
  q.delta_rate = at[5];
  Points<T> points;
  points.n = 1;
  points.q = &q;
  points.at = &place;
  points.params = params.data();
  model.evaluate(Stage::command, Stage::body, points);
  return q;
}

inline std::vector<double> numbers(const std::vector<gripline::abi::ParamValue>& values) {
  std::vector<double> out;
  for (const auto& one : values) out.push_back(one.number);
  return out;
}

/// Derivatives of ax, ay, aw by the instant and by every parameter against central differences; the worst error
/// relative to max(1, size).
inline double derivative_error(const VehicleModel& model, const Instant& at, const std::vector<double>& params) {
  const std::size_t total = at.size() + params.size();
  double worst = 0;
  for (std::size_t j = 0; j < total; ++j) {
    std::array<Dual8, 6> dual_at;
    for (std::size_t i = 0; i < at.size(); ++i) dual_at[i] = Dual8(at[i]);
    std::vector<Dual8> dual_params(params.begin(), params.end());
    (j < at.size() ? dual_at[j] : dual_params[j - at.size()]).d[3] = 1.0;
    const Quantities<Dual8> exact = evaluate(model, dual_at, dual_params);

    Instant moved_at = at;
    std::vector<double> moved = params;
    double& variable = j < at.size() ? moved_at[j] : moved[j - at.size()];
    const double kept = variable, h = 1e-6 * std::max(1e-3, std::abs(kept));
    variable = kept + h;
    const Quantities<double> hi = evaluate(model, moved_at, moved);
    variable = kept - h;
    const Quantities<double> lo = evaluate(model, moved_at, moved);
    const double found[] = {exact.ax.d[3], exact.ay.d[3], exact.aw.d[3]};
    const double expected[] = {(hi.ax - lo.ax) / (2 * h), (hi.ay - lo.ay) / (2 * h), (hi.aw - lo.aw) / (2 * h)};
    for (int c = 0; c < 3; ++c)
      worst = std::max(worst, std::abs(found[c] - expected[c]) / std::max(1.0, std::abs(expected[c])));
  }
  return worst;
}

/// A model by id with parameters changed by name.
struct TestedModel {
  explicit TestedModel(const std::string& id, const Settings& settings = {})
      : entry(registry().find(gripline::abi::Kind::vehicle, id)),
        params(numbers(values_of(entry, settings))),
        model(create<VehicleModel>(entry, PluginContext{}, values_of(entry, settings))) {}
  Quantities<double> at(const Instant& instant, const Place& place = {}) const {
    return evaluate(*model, instant, params, place);
  }
  const PluginEntry& entry;
  std::vector<double> params;
  Instance<VehicleModel> model;
};

/// Seeded instants a car could be in: 0.5 to 3 m/s, sliding, steering, driving and braking.
inline std::vector<Instant> instants(int count, bool braking = true) {
  std::mt19937_64 random(7);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  std::vector<Instant> all;
  for (int i = 0; i < count; ++i)
    all.push_back({uniform(0.5, 3), uniform(-0.6, 0.6), uniform(-8, 8), uniform(braking ? -0.1 : 0.05, 1),
                   uniform(-0.35, 0.35), uniform(-5, 5)});
  return all;
}

}  // namespace gripline::rig
