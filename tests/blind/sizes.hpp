// Typical sizes of the catalogue's effects, per car, and how a case draws from them (framework/doc/effects.md).
#pragma once

#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace gripline::blind {

using Random = std::mt19937_64;
inline double uniform(Random& r, double low, double high) {
  return low + (high - low) * (static_cast<double>(r() >> 11) * 0x1.0p-53);
}
inline double normal(Random& r) {
  const double u = uniform(r, 1e-12, 1.0), v = uniform(r, 0.0, 1.0);
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v);
}
inline std::size_t pick(Random& r, std::size_t n) { return static_cast<std::size_t>(r() % n); }
inline double sign(Random& r) { return r() % 2 == 0 ? 1.0 : -1.0; }

/// An effect of a case: id and parameters by name.
struct Effect {
  std::string id;
  std::map<std::string, double> params;
};

/// How an effect's size is drawn for one car.
struct Size {
  std::string param;
  double low, high;  // of its absolute value; an empty range: this car has no such case
  int sign;          // +1, -1, or 0 for either
};

inline const std::map<std::string, std::array<Size, 2>>& sizes() {
  static const std::map<std::string, std::array<Size, 2>> table = {
      {"aero_drag", {{{"a", 0.2, 0.8, 1}, {"a", 0.15, 0.6, 1}}}},
      {"rolling_res", {{{"a", 0.15, 0.6, 1}, {"a", 0.1, 0.4, 1}}}},
      {"drive_gain", {{{"k", 0.06, 0.2, 0}, {"k", 0.06, 0.2, 0}}}},
      {"back_emf", {{{"k", 0.05, 0.18, 0}, {"k", 0.05, 0.18, 0}}}},
      {"brake_gain", {{{"k", 0.08, 0.25, 0}, {"k", 0.08, 0.25, 0}}}},
      {"brake_fade", {{{"k", 0, 0, 1}, {"k", 0.15, 0.5, 1}}}},
      {"motor_lag", {{{"tau", 0.03, 0.15, 1}, {"tau", 0.05, 0.3, 1}}}},
      {"steer_lag", {{{"tau", 0.02, 0.06, 1}, {"tau", 0.03, 0.15, 1}}}},
      {"input_delay", {{{"T", 0.02, 0.06, 1}, {"T", 0.03, 0.15, 1}}}},
      {"sensor_latency", {{{"T", 0.02, 0.06, 1}, {"T", 0.03, 0.15, 1}}}},
      {"steer_gain", {{{"k", 0.04, 0.15, 0}, {"k", 0.04, 0.15, 0}}}},
      {"steer_offset", {{{"d0", 0.005, 0.03, 0}, {"d0", 0.005, 0.03, 0}}}},
      {"friction_scale", {{{"k", 0.05, 0.15, 0}, {"k", 0.05, 0.15, 0}}}},
      {"friction_drift", {{{"k", 0.06, 0.2, -1}, {"k", 0.06, 0.2, -1}}}},
      {"friction_patch", {{{"k", 0.12, 0.3, -1}, {"k", 0.12, 0.3, -1}}}},
      {"downforce", {{{"k", 0.05, 0.25, 1}, {"k", 0.05, 0.25, 1}}}},
      {"load_transfer", {{{"h_over_L", 0.1, 0.3, 1}, {"h_over_L", 0.1, 0.3, 1}}}},
      {"comb_slip", {{{"k", 0.4, 1, 1}, {"k", 0.4, 1, 1}}}},
      {"relaxation", {{{"sigma", 0.03, 0.1, 1}, {"sigma", 0.3, 1, 1}}}},
      {"front_stiff", {{{"k", 0.1, 0.3, 0}, {"k", 0.1, 0.3, 0}}}},
      {"rear_stiff", {{{"k", 0.1, 0.25, 0}, {"k", 0.1, 0.25, 0}}}},
      {"front_grip", {{{"k", 0.05, 0.13, 0}, {"k", 0.05, 0.13, 0}}}},
      {"rear_grip", {{{"k", 0.04, 0.1, 0}, {"k", 0.04, 0.1, 0}}}},
      {"mass", {{{"k", 0.05, 0.25, 1}, {"k", 0.05, 0.25, 1}}}},
      {"yaw_inertia", {{{"k", 0.1, 0.35, 0}, {"k", 0.1, 0.35, 0}}}},
      {"cog_shift", {{{"k", 0.05, 0.12, 0}, {"k", 0.05, 0.12, 0}}}},
      {"diff_yaw", {{{"k", 1, 5, 1}, {"k", 0.3, 1.2, 1}}}},
      {"torque_vec", {{{"k", 0.3, 1, 0}, {"k", 0.3, 1, 0}}}},
      {"vx_bias", {{{"b", 0.02, 0.08, 0}, {"b", 0.1, 0.5, 0}}}},
      {"vx_scale", {{{"k", 0.01, 0.05, 0}, {"k", 0.01, 0.05, 0}}}},
      {"yawrate_bias", {{{"b", 0.04, 0.15, 0}, {"b", 0.006, 0.03, 0}}}},
      {"wind", {{{"wx", 0, 0, 1}, {"wx", 6, 15, 0}}}},
      {"plane_tilt", {{{"tx", 0.006, 0.03, 0}, {"tx", 0.01, 0.04, 0}}}},
      {"grade", {{{"c", 0.015, 0.05, 0}, {"c", 0.015, 0.05, 0}}}},
      {"bank", {{{"c", 0.015, 0.05, 0}, {"c", 0.03, 0.08, 0}}}},
  };
  return table;
}

/// Effects that a car (0: rc43, 1: full) can lack.
inline std::vector<std::string> effects_of(int car) {
  std::vector<std::string> ids;
  for (const auto& [id, size] : sizes())
    if (size[static_cast<std::size_t>(car)].high > 0.0) ids.push_back(id);
  return ids;
}

/// Draws an effect; `share` of the typical size.
inline Effect draw(const std::string& id, int car, double share, Random& r) {
  const Size& size = sizes().at(id)[static_cast<std::size_t>(car)];
  double value = share * std::exp(uniform(r, std::log(size.low), std::log(size.high)));
  const double direction = size.sign == 0 ? sign(r) : size.sign;
  value *= direction;
  Effect e{id, {{size.param, value}}};
  if (id == "friction_patch") {
    e.params["s0"] = uniform(r, 0.0, 1.0);
    e.params["w"] = uniform(r, 0.08, 0.2);
  } else if (id == "wind" || id == "plane_tilt") {
    const double angle = uniform(r, 0.0, 2.0 * std::numbers::pi);
    const bool wind = id == "wind";
    e.params[wind ? "wx" : "tx"] = value * std::cos(angle);
    e.params[wind ? "wy" : "ty"] = value * std::sin(angle);
  } else if (id == "grade" || id == "bank") {
    // A few waves around the lap; the largest coefficient has the size drawn. A grade has no mean.
    std::array<double, 10> c{};
    for (int wave = 1; wave <= 3; ++wave) {
      const double a = normal(r) / wave, b = normal(r) / wave;
      for (int i = 0; i < 10; ++i) {
        const double phase = 2.0 * std::numbers::pi * wave * i / 10.0;
        c[static_cast<std::size_t>(i)] += a * std::cos(phase) + b * std::sin(phase);
      }
    }
    if (id == "bank") {
      const double mean = normal(r) * 0.5;
      for (double& x : c) x += mean;
    }
    double largest = 0.0;
    for (const double x : c) largest = std::max(largest, std::abs(x));
    e.params.clear();
    for (std::size_t i = 0; i < c.size(); ++i) e.params["c" + std::to_string(i)] = value * c[i] / largest;
  }
  return e;
}

}  // namespace gripline::blind
