// A car driven around a track by a controller plugin, step by step, for tests of controllers.
#pragma once

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "support/planner_support.hpp"

namespace gripline::testing_support {

/// The 1:43 car on a track with `friction_speed` as planner: what a controller is given at every step, and what becomes
/// of what it decides.
class DrivingScene {
 public:
  struct Options {
    bool mobil = false;
    double pace = 0.95;     // of the speeds at the friction believed
    double belief = 0.9;    // friction the planner believes; the truth is 0.909
    double tyre_error = 1;  // tyre forces in the controller's model over the true ones
  };

  DrivingScene(const Registry& registry, const Options& options)
      : registry_(registry),
        car_(car_1_43()),
        track_(options.mobil ? ethz_mobil() : ethz()),
        course_(track_, car_),
        plant_(registry, dt),
        model_instance_(create<VehicleModel>(registry.find(abi::Kind::vehicle, "dynamic"), PluginContext{},
                                             values_of(registry.find(abi::Kind::vehicle, "dynamic")))),
        model_(StagedCar(*model_instance_, model_numbers(options.tyre_error)),
               {dt, Hold::zoh, {find_tableau("rk4"), 1}}),
        planner_(make_planner(options.pace)),
        x_(start_state(track_)) {
    belief_.mu_front = belief_.mu_rear = options.belief;
    belief_.trusted = true;
  }

  static constexpr double dt = 0.02;
  const Car& car() const { return car_; }
  CorrectedModel& model() { return model_; }

  Instance<Controller> controller(const char* id, std::vector<std::pair<std::string, double>> params) const {
    const PluginEntry& entry = registry_.find(abi::Kind::controller, id);
    return create<Controller>(entry, PluginContext{.car = car_, .dt = dt}, values_of(entry, params));
  }

  /// What is seen now, and the references of a horizon of `points`.
  const Observation& observe() {
    const CoursePoint at = course_.locate(x_.x, x_.y, hint_);
    hint_ = at.s;
    now_ = {};
    now_.t = static_cast<double>(step_) * dt;
    now_.step = step_;
    now_.x = x_;
    now_.d = d_;
    now_.at.s = at.s;
    now_.at.n = at.n;
    outside_ = outside_ || at.n > at.left || at.n < -at.right;
    return now_;
  }
  std::span<const RefPoint> references(int points) {
    references_.resize(static_cast<std::size_t>(points));
    planner_->plan(now_, belief_, nullptr, references_);
    return references_;
  }

  void drive(const Input& u) {
    d_ = u.d;
    x_ = plant_.advance(x_, u);
    x_.delta = std::clamp(x_.delta, -car_.delta_max, car_.delta_max);
    ++step_;
  }

  const State& state() const { return x_; }
  bool was_outside() const { return outside_; }

 private:
  std::vector<double> model_numbers(double tyre_error) const {
    std::vector<double> numbers;
    const PluginEntry& entry = registry_.find(abi::Kind::vehicle, "dynamic");
    for (const abi::ParamDecl& p : entry.params()) {
      const std::string name = p.name;
      numbers.push_back(published(entry, p) * (name == "Df" || name == "Dr" ? tyre_error : 1.0));
    }
    return numbers;
  }
  Instance<SpeedPlanner> make_planner(double pace) {
    const PluginEntry& entry = registry_.find(abi::Kind::planner, "friction_speed");
    const std::vector<std::pair<std::string, double>> params = {{"pace", pace}};
    PluginContext context{.car = car_, .dt = dt};
    context.course = &course_;
    context.nominal = &model_;
    return create<SpeedPlanner>(entry, context, values_of(entry, params));
  }

  const Registry& registry_;
  Car car_;
  Track track_;
  TrackCourse course_;
  DynamicCar plant_;
  Instance<VehicleModel> model_instance_;
  CorrectedModel model_;
  Instance<SpeedPlanner> planner_;
  Belief belief_;
  State x_;
  double d_ = 0, hint_ = std::numeric_limits<double>::quiet_NaN();
  std::int64_t step_ = 0;
  bool outside_ = false;
  Observation now_;
  std::vector<RefPoint> references_;
};

/// One step of a drive, to be solved again by others.
struct Instant {
  Observation now;
  std::vector<RefPoint> references;
};

/// Larger of two inputs' differences, as shares of their ranges.
inline double input_difference(const Input& a, const Input& b, const Car& car) {
  return std::max(std::abs(a.d - b.d) / (car.d_max - car.d_min), std::abs(a.ddelta - b.ddelta) / (2 * car.ddelta_max));
}

/// A prediction that can be made to fail.
class Failing : public Prediction {
 public:
  explicit Failing(Prediction& good) : good_(good) {}
  bool broken = false;
  long calls = 0;
  int states() const noexcept override { return good_.states(); }
  double dt() const noexcept override { return good_.dt(); }
  void start(const State& now, std::span<double> x) const override { good_.start(now, x); }
  void step(std::size_t n, std::span<const double> x, std::span<const double> u, std::span<const Place> at,
            std::span<double> x_next, std::span<double> a, std::span<double> b) override {
    ++calls;
    good_.step(n, x, u, at, x_next, a, b);
    if (broken) std::fill(x_next.begin(), x_next.end(), std::numeric_limits<double>::quiet_NaN());
  }
  Rates rates(const State& x, const Input& u, const Place& at) override { return good_.rates(x, u, at); }

 private:
  Prediction& good_;
};

}  // namespace gripline::testing_support
