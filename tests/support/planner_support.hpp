// What tests of planners and simple controllers stand on: the two roads, the 1:43 car, and the `dynamic` plugin as
// plant and as nominal model.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include <gripline/interfaces.hpp>

#include "car/corrected_model.hpp"
#include "geometry/course_adapter.hpp"
#include "geometry/track.hpp"
#include "plugin/registry.hpp"
#include "support/paths.hpp"
#include "support/published_car.hpp"

namespace gripline::testing_support {

/// The published car. Its formulas hold from half of the 0.1 m/s on at which it starts here, so that none of these
/// tests is about what models hold below v_min.
inline Car car_1_43() {
  Car car = conformance::published::car;
  car.v_min = 0.05;
  return car;
}

inline Track make_track(const char* name, const Pose& origin, std::span<const Segment> segments, double half_width,
                        const Pose& start) {
  TrackShape shape{.name = name,
                   .centre = ClosedCurve::from_segments(origin, segments, 1e-3),
                   .half_width_right = half_width,
                   .half_width_left = half_width,
                   .grade = 0.0,
                   .bank = 0.0,
                   .start = start,
                   .points = std::nullopt};
  return Track(std::move(shape));
}

/// ETHZ as straights and arcs (worlds/tracks/ethz.json).
inline Track ethz() {
  const double deg = std::numbers::pi / 180.0;
  const auto line = [](double length) { return Segment::line(length); };
  const auto arc = [deg](double radius, double turn) { return Segment::arc(radius, turn * deg); };
  const std::array segments{
      line(1.725341),       arc(0.2, 180),    line(0.608589),       arc(0.245, -135),     line(0.210675),
      arc(0.585, -90),      line(0.462664),   arc(0.1896, -10.391), arc(0.7076, -42.439), arc(0.65, -40.579),
      arc(0.5913, -44.846), arc(0.18, 3.256), line(0.90879),        arc(0.2, 135),        line(0.6212),
      arc(0.285, 90),       line(0.03),       arc(0.2, -180),       line(0.115),          arc(0.215, 180),
      line(0.815),          arc(0.2, 90),     arc(0.2, -90),        line(0.36),           arc(0.755, 90),
      line(0.97),           arc(0.985, 90),   line(1.345),          arc(0.2, 135)};
  return make_track("ethz", {-0.8664213562373095, 1.1185786437626906, -45 * deg}, segments, 0.185,
                    {-0.84574, 1.0979, -45 * deg});
}

/// ETHZMobil (worlds/tracks/ethz_mobil.json): radii of 0.3 m and straights of 0.6, 1.2 and 2.4 m, driven clockwise.
inline Track ethz_mobil() {
  const double right = -std::numbers::pi / 2;
  const auto line = [](double length) { return Segment::line(length); };
  const auto arc = [](double turn) { return Segment::arc(0.3, turn); };
  const std::array segments{arc(2 * right), line(0.6),  arc(-2 * right), line(0.6),       arc(2 * right),
                            line(1.2),      arc(right), line(0.6),       arc(-2 * right), line(0.6),
                            arc(2 * right), line(1.2),  arc(right),      line(2.4)};
  return make_track("ethzMobil", {1.2, 0.9, 0.0}, segments, 0.23, {1.2, 0.9, 0.0});
}

/// Values for a plugin's declared parameters: its defaults, some by name overridden.
inline std::vector<abi::ParamValue> values_of(const PluginEntry& entry,
                                              std::span<const std::pair<std::string, double>> changed = {}) {
  std::vector<abi::ParamValue> values;
  for (const abi::ParamDecl& p : entry.params()) values.push_back({p.default_value, {}});
  for (const auto& [name, number] : changed) {
    std::size_t i = 0;
    while (i < entry.params().size() && name != entry.params()[i].name) ++i;
    if (i == entry.params().size()) throw std::invalid_argument("no parameter " + name);
    values[i].number = number;
  }
  return values;
}

/// The `dynamic` plugin with tyres of a friction factor: plant and nominal model in one.
class DynamicCar {
 public:
  DynamicCar(const Registry& registry, double dt, double factor = 1.0)
      : entry_(registry.find(abi::Kind::vehicle, "dynamic")),
        instance_(create<VehicleModel>(entry_, PluginContext{}, values_of(entry_))),
        model_(StagedCar(*instance_, numbers(entry_)), {dt, Hold::zoh, {find_tableau("rk4"), 20}}) {
    set_factor(factor);
  }
  void set_factor(double factor) {
    for (std::size_t i = 0; i < entry_.params().size(); ++i) {
      const std::string name = entry_.params()[i].name;
      if (name == "Df" || name == "Dr") model_.set_parameter(i, published(entry_, entry_.params()[i]) * factor);
    }
  }
  Prediction& prediction() { return model_; }

  /// One control step with the command held, steering at its angle after the step's rate.
  State advance(const State& x, const Input& u) { return model_.advance(x, u, {}); }

 private:
  static std::vector<double> numbers(const PluginEntry& entry) {
    std::vector<double> numbers;
    for (const abi::ParamDecl& p : entry.params()) numbers.push_back(published(entry, p));
    return numbers;
  }
  const PluginEntry& entry_;
  Instance<VehicleModel> instance_;
  CorrectedModel model_;
};

inline Registry plugins() { return Registry({plugin_dir()}); }

/// The 1:43 car for a planner on a road, which predicts with the true tyres where a test changes nothing.
class PlannerRig {
 protected:
  PluginContext context_on(const Track& track) {
    course_ = std::make_unique<TrackCourse>(track, car_);
    PluginContext context;
    context.car = car_;
    context.dt = 0.02;
    context.course = course_.get();
    context.nominal = &model_.prediction();
    context.mu_init = 1.0;
    return context;
  }

  Registry registry_ = plugins();
  Car car_ = car_1_43();
  Track ethz_ = ethz();
  Track mobil_ = ethz_mobil();
  DynamicCar model_{registry_, 0.02};
  std::unique_ptr<TrackCourse> course_;
};

/// The published start: the track's start pose at 0.1 m/s.
inline State start_state(const Track& track) {
  State x;
  x.x = track.start().x;
  x.y = track.start().y;
  x.yaw = track.start().yaw;
  x.vx = 0.1;
  return x;
}

}  // namespace gripline::testing_support
