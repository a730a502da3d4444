#include "world/world.hpp"

#include <algorithm>
#include <array>
#include <boost/container/small_vector.hpp>
#include <cmath>

#include <gripline/slip.hpp>

#include "car/instant.hpp"
#include "world/friction_factor.hpp"

namespace gripline {
namespace {

constexpr double step_error = 1e-4;   // of v_ref, that a control step may have by its integration
constexpr double largest_slip = 1.5;  // [rad], beyond any tyre's peak

/// Largest value of a curve over [0, largest_slip]: a grid, then golden section around its best point.
template <class F>
double peak_of(F&& force) {
  constexpr int count = 300;
  int best = 0;
  double top = force(0.0);
  for (int i = 1; i <= count; ++i)
    if (const double f = force(largest_slip * i / count); f > top) top = f, best = i;
  double lo = largest_slip * std::max(0, best - 1) / count;
  double hi = largest_slip * std::min(count, best + 1) / count;
  constexpr double golden = 0.6180339887498949;
  double a = hi - golden * (hi - lo), b = lo + golden * (hi - lo);
  double at_a = force(a), at_b = force(b);
  for (int i = 0; i < 40; ++i) {
    if (at_a < at_b) {
      lo = a, a = b, at_a = at_b;
      b = lo + golden * (hi - lo), at_b = force(b);
    } else {
      hi = b, b = a, at_b = at_a;
      a = hi - golden * (hi - lo), at_a = force(a);
    }
  }
  return std::max(top, force(0.5 * (lo + hi)));
}

double static_load(const Car& car, Axle axle) {
  const double wheelbase = car.lf + car.lr;
  return car.m * gravity * (axle == Axle::front ? car.lr : car.lf) / wheelbase;
}

/// What a tyre's curve depends on: not on commands, which the curve replaces, nor on what becomes of the forces.
bool shapes_forces(const Effect& effect) { return Stage::command < effect.stage() && effect.stage() < Stage::body; }
bool is_behind_actuators(const Effect& effect) { return effect.stage() != Stage::command && effect.memory() == 0; }

}  // namespace

/// The road under a point, for plants that ask for it at every wheel.
class World::WorldGround final : public Ground {
 public:
  explicit WorldGround(const World& world) : world_(world) {}
  Patch at(double x, double y, double yaw) const override {
    const Track& track = *world_.spec_.track;
    const CurveLocation found = track.locate(x, y, world_.place_.s);
    const Track::Slope slope = track.slope(found, yaw);
    return {slope.grade, slope.bank, world_.friction_.factor(world_.step_, world_.time(), found.s)};
  }

 private:
  const World& world_;
};

/// A vehicle model with effects, advanced by the framework's integrator.
class World::ModelCar final : public World::CarDynamics {
 public:
  ModelCar(const WorldSpec& spec, const PluginContext& context, const State& start, const Place& at)
      : car_(context.car),
        vehicle_(spec.vehicle, context, &friction_),
        model_(vehicle_.car(), options(spec)),
        tyres_(vehicle_.car_of(shapes_forces)),
        behind_actuators_(vehicle_.car_of(is_behind_actuators)),
        true_params_(behind_actuators_.params().begin(), behind_actuators_.params().end()),
        true_dual_params_(true_params_.begin(), true_params_.end()),
        substeps_by_error_(spec.car.substeps_by_error) {
    model_.reset(start, 0.0, at);
    acting_ = acting_under(start, Input{}, at);
  }

  void begin_step(const Place& at, double factor) override {
    if (!has_tyres()) return;
    on_the_flat_.t = at.t;
    on_the_flat_.s = at.s;
    on_the_flat_.lap_fraction = at.lap_fraction;
    // Beside the friction factor only effects, which may depend on time and place, move the peaks.
    const bool moved = tyres_.effects() > 1 && curves_moved();
    if (peaks_.empty() || moved) find_peaks();
    model_.set_parameter(factor_at(), factor);
    true_params_[factor_at()] = factor;
    true_dual_params_[factor_at()] = Dual8(factor);
  }
  State advance(const State& x, const Input& u, const Place& at) override {
    acting_ = acting_under(x, u, at);
    if (!substeps_by_error_) return model_.advance(x, u, at);
    return model_.advance_within({step_error * car_.v_ref, car_.lf + car_.lr}, x, u, at);
  }
  Acting acting_under(const State& x, const Input& next, const Place& at) override {
    const Quantities<double> q = model_.quantities(x, next, at);
    Acting acting = {q.d, q.delta};
    if (has_tyres()) acting.force_front = q.force_front, acting.force_rear = q.force_rear;
    const bool axles = vehicle_.has_stage(Stage::load);  // where effects may move them
    const double forward = std::abs(q.vx);
    acting.slip_front = front_slip(forward, q.vy, q.omega, steered_along_motion(q.vx, q.delta), axles ? q.lf : car_.lf);
    acting.slip_rear = rear_slip(forward, q.vy, q.omega, axles ? q.lr : car_.lr);
    return acting;
  }
  void read(Reading<double>& reading, const Place& at) const override { model_.car().read(&reading, 1, &at, nullptr); }
  double peak_mu(Axle axle) const override {
    return peaks_.empty() ? 0.0 : peaks_[static_cast<std::size_t>(axle)] / static_load(car_, axle);
  }
  Acting acting() const override { return acting_; }

  /// Force at a slip angle on a straight at reference speed without drive: front by the wheels' angle, rear by
  /// drifting. At static load: forces are taken to go with the load, and what effects add to it is divided out.
  double curve(Axle axle, double slip) const override {
    if (!has_tyres()) return 0.0;
    const bool front = axle == Axle::front;
    const double v = car_.v_ref, sideways = front ? 0.0 : -v * std::tan(std::clamp(slip, -1.55, 1.55));
    const double motion[] = {0, 0, 0, v, sideways, 0};
    const Quantities<double> q = steady(motion, {0.0, front ? slip : 0.0, 0.0});
    const double force = front ? q.force_front : q.force_rear, load = front ? q.load_front : q.load_rear;
    return load > 0.0 ? force / load : force;  // a model may have no loads
  }

  bool accelerations(const Points<double>& points) const override { return fill(points, true_params_); }
  bool accelerations(const Points<Dual8>& points) const override { return fill(points, true_dual_params_); }

 private:
  static StepOptions options(const WorldSpec& spec) { return {spec.dt, spec.hold, spec.vehicle.integration}; }
  /// Friction is the first effect: the others change the peaks it leaves.
  std::size_t factor_at() const { return model_.car().param_offset(0); }
  /// Whether the curves changed since the last call: those that are the same to the last bit at slips over their whole
  /// range are taken for the same.
  bool curves_moved() {
    const auto before = forces_;
    for (const Axle axle : {Axle::front, Axle::rear}) {
      double slip = largest_slip;
      for (double& force : forces_[static_cast<std::size_t>(axle)]) force = curve(axle, slip), slip *= 0.5;
    }
    return forces_ != before;
  }
  void find_peaks() {
    peaks_.clear();
    for (const Axle axle : {Axle::front, Axle::rear})
      peaks_.push_back(peak_of([&](double slip) { return curve(axle, slip); }));
  }
  bool has_tyres() const { return vehicle_.has_stage(Stage::tyre); }

  /// Quantities of the tyres at factor 1 (callers multiply by the schedule's), with memory at its steady value.
  Quantities<double> steady(const double* motion, const ActingCommand<double>& command) const {
    boost::container::small_vector<double, 16> memory(static_cast<std::size_t>(tyres_.memory())), rate(memory.size());
    InstantBatch<double> instant(motion, command, on_the_flat_, 1.0, Hold::zoh);
    CarBatch<double>& batch = instant.batch;
    if (!memory.empty()) {
      tyres_.start_memory(batch, memory.data());
      batch.memory = memory.data();
      batch.memory_rate = rate.data();
    }
    Quantities<double> q{};
    tyres_.quantities(batch, &q);
    return q;
  }

  /// The true car's accelerations and slopes at the points' states, under the commands that act there.
  template <class T>
  bool fill(const Points<T>& points, const std::vector<T>& params) const {
    for (std::size_t i = 0; i < points.n; ++i) {
      Quantities<T>& q = points.q[i];
      const T motion[] = {T(0), T(0), q.yaw, q.vx, q.vy, q.omega};
      InstantBatch<T> instant(motion, {q.d, q.delta, q.delta_rate}, points.at[i], 1.0, Hold::zoh);
      instant.batch.params = params.data();
      Quantities<T> truth{};
      behind_actuators_.quantities(instant.batch, &truth);
      q.ax = truth.ax;
      q.ay = truth.ay;
      q.aw = truth.aw;
      q.grade = truth.grade;
      q.bank = truth.bank;
    }
    return true;
  }

  Car car_;
  FrictionFactor friction_;
  Vehicle vehicle_;
  CorrectedModel model_;
  StagedCar tyres_;             // at factor 1
  StagedCar behind_actuators_;  // what Truth tells: without effects on commands and those that have memory
  std::vector<double> true_params_;
  std::vector<Dual8> true_dual_params_;
  bool substeps_by_error_;
  Place on_the_flat_;                              // the present time and place, without slopes
  std::vector<double> peaks_;                      // front and rear [N]; empty without tyres
  std::array<std::array<double, 8>, 2> forces_{};  // of the curves, at the slips of curves_moved() [N]
  Acting acting_;
};

/// A plant plugin.
class World::PluginPlant final : public World::CarDynamics {
 public:
  PluginPlant(const WorldSpec& spec, const PluginContext& context, const State& start, const Ground& ground)
      : plant_(create<Plant>(*spec.plant.entry, context, spec.plant.values)),
        ground_(ground),
        car_(context.car),
        dt_(spec.dt) {
    plant_->reset(start, ground_);
  }
  void begin_step(const Place&, double) override {}  // the ground tells the friction
  State advance(const State& x, const Input& u, const Place&) override {
    const double delta = x.delta + dt_ * u.ddelta;
    acting_ = now_under(x, u);
    State next = plant_->advance(u.d, delta, dt_, ground_);
    next.delta = delta;
    return next;
  }
  double peak_mu(Axle axle) const override { return plant_->mu(axle); }
  double curve(Axle axle, double slip) const override { return plant_->tyre_force(axle, slip); }
  Acting acting() const override { return acting_; }
  Acting acting_under(const State& x, const Input& next, const Place&) override { return now_under(x, next); }
  void read(Reading<double>&, const Place&) const override {}
  bool accelerations(const Points<double>&) const override { return false; }
  bool accelerations(const Points<Dual8>&) const override { return false; }

 private:
  /// The plant's forces are those at x, where its last step ended.
  Acting now_under(const State& x, const Input& u) const {
    Acting acting = {u.d, x.delta + dt_ * u.ddelta, plant_->axle_force(Axle::front), plant_->axle_force(Axle::rear)};
    const double forward = std::abs(x.vx);
    acting.slip_front = front_slip(forward, x.vy, x.omega, steered_along_motion(x.vx, acting.delta), car_.lf);
    acting.slip_rear = rear_slip(forward, x.vy, x.omega, car_.lr);
    return acting;
  }

  Instance<Plant> plant_;
  const Ground& ground_;
  Car car_;
  double dt_;
  Acting acting_;
};

class World::TruthView final : public Truth {
 public:
  explicit TruthView(const World& world) : world_(world) {}
  double factor() const override { return world_.factor_; }
  double mu(Axle axle) const override { return world_.factor_ * world_.dynamics_->peak_mu(axle); }
  double tyre_force(Axle axle, double slip) const override {
    return world_.factor_ * world_.dynamics_->curve(axle, slip);
  }
  bool accelerations(const Points<double>& points) const override { return world_.dynamics_->accelerations(points); }
  bool accelerations(const Points<Dual8>& points) const override { return world_.dynamics_->accelerations(points); }

 private:
  const World& world_;
};

World::World(const WorldSpec& spec, std::uint64_t seed)
    : spec_(spec),
      friction_(spec.friction, spec.dt, seed),
      sensors_(spec.sensors, seed),
      course_(*spec.track, spec.car.car),
      laps_(*spec.track, spec.start) {
  state_.x = spec.start.x;
  state_.y = spec.start.y;
  state_.yaw = spec.start.yaw;
  state_.vx = spec.start_speed;
  PluginContext context = plugin_context(spec);
  context.seed = seed;
  context.course = &course_;
  road_ = std::make_unique<WorldGround>(*this);
  const CurveLocation found = spec.track->locate(Pose{state_.x, state_.y, state_.yaw});
  place_ = place_of(*spec.track, found, 0.0, state_.x, state_.y, state_.yaw);
  sensed_hint_ = found.s;
  if (spec.plant.empty())
    dynamics_ = std::make_unique<ModelCar>(spec, context, state_, place_);
  else
    dynamics_ = std::make_unique<PluginPlant>(spec, context, state_, *road_);
  truth_ = std::make_unique<TruthView>(*this);
  begin_step();
  sense();
}

World::~World() = default;

const Truth& World::truth() const { return *truth_; }

Input World::clamp_to_limits(const Input& wanted) const {
  const Car& car = spec_.car.car;
  Input u;
  u.d = std::clamp(wanted.d, car.d_min, car.d_max);
  u.ddelta = std::clamp(wanted.ddelta, -car.ddelta_max, car.ddelta_max);
  const double delta = std::clamp(state_.delta + spec_.dt * u.ddelta, -car.delta_max, car.delta_max);
  u.ddelta = (delta - state_.delta) / spec_.dt;
  return u;
}

Input World::advance(const Input& wanted) {
  const Input u = clamp_to_limits(wanted);
  state_ = dynamics_->advance(state_, u, place_);
  d_ = u.d;
  ++step_;
  if (!finite()) return u;  // a car that is not finite has no place on the track
  arrive(static_cast<double>(step_) * spec_.dt);
  begin_step();
  sense();
  return u;
}

bool World::finite() const {
  return std::isfinite(state_.x + state_.y + state_.yaw + state_.vx + state_.vy + state_.omega);
}

/// Friction of the step that begins now, which Truth shows before the step, as the published oracle has it.
void World::begin_step() {
  factor_ = friction_.factor(step_, time(), place_.s);
  dynamics_->begin_step(place_, factor_);
  held_ = acting_under({d_, 0.0});
}

/// Where the car is now: place, lap, edges, walls.
void World::arrive(double t) {
  lap_ended_ = laps_.advance(t, state_.x, state_.y);
  const CurveLocation& found = laps_.place();
  place_ = place_of(*spec_.track, found, t, state_.x, state_.y, state_.yaw);
  outside_ = !spec_.track->inside(found);
  body_outside_ = false;
  crashed_ = false;
  const double c = std::cos(state_.yaw), s = std::sin(state_.yaw);
  for (const double along : {-0.5, 0.5}) {
    for (const double across : {-0.5, 0.5}) {
      const double forward = along * spec_.car.car.length, left = across * spec_.car.car.width;
      const CurveLocation corner =
          spec_.track->locate(state_.x + forward * c - left * s, state_.y + forward * s + left * c, found.s);
      body_outside_ = body_outside_ || !spec_.track->inside(corner);
      crashed_ = crashed_ || spec_.track->wall_clearance(corner) <= 0.0;
    }
  }
}

void World::sense() {
  Reading<double> shown = {state_.x, state_.y, state_.yaw, state_.vx, state_.vy, state_.omega};
  dynamics_->read(shown, place_);
  const Reading<double> seen = sensors_.sense(step_, shown);
  observation_.t = time();
  observation_.step = step_;
  observation_.x = {seen.x, seen.y, seen.yaw, seen.vx, seen.vy, seen.omega, state_.delta};
  const CurveLocation found = spec_.track->locate(seen.x, seen.y, sensed_hint_);
  sensed_hint_ = found.s;
  observation_.at = place_of(*spec_.track, found, time(), seen.x, seen.y, seen.yaw);
  observation_.d = d_;
}

World::Acting World::acting() const { return dynamics_->acting(); }
World::Acting World::acting_under(const Input& next) const { return dynamics_->acting_under(state_, next, place_); }

}  // namespace gripline
