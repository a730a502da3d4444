// The simulated world: advances the car, holds the true friction, computes what the sensors show. No other class
// knows the true friction.
#pragma once

#include <memory>
#include <random>

#include "geometry/course_adapter.hpp"
#include "geometry/lap_counter.hpp"
#include "world/world_spec.hpp"

namespace gripline {

class World {
 public:
  /// The spec must outlive the world.
  World(const WorldSpec& spec, std::uint64_t seed);
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// Algorithm 1, line 3: the car under these commands for one control step. Commands beyond the car's limits are
  /// clamped; returns what was applied.
  Input advance(const Input& wanted);
  /// The commands as the car's limits let them through.
  Input clamp_to_limits(const Input& wanted) const;

  /// What sensors show now.
  const Observation& observe() const { return observation_; }

  /// False once the car's state is no longer finite; the world is then not advanced any further.
  bool finite() const;
  /// The plugin that moves the car, for messages.
  std::string plant_id() const { return spec_.plant.empty() ? spec_.vehicle.model.id() : spec_.plant.id(); }

  /// True state; `delta` is the steering angle commanded last.
  const State& state() const { return state_; }
  const Place& place() const { return place_; }
  double time() const { return place_.t; }
  std::int64_t step() const { return step_; }
  const Truth& truth() const;
  const Track& track() const { return *spec_.track; }
  const Course& course() const { return course_; }
  const WorldSpec& spec() const { return spec_; }

  /// What acts at an instant: throttle and road wheel angle after the actuators, lateral axle forces [N], and the slip
  /// angles under that wheel angle [rad]. Of a plant plugin the commands are those given; no others are known.
  struct Acting {
    double d = 0, delta = 0, force_front = 0, force_rear = 0, slip_front = 0, slip_rear = 0;
  };
  /// True slip angle now, while the last command is held [rad].
  double slip(Axle axle) const { return axle == Axle::front ? held_.slip_front : held_.slip_rear; }
  /// At the start of the last step.
  Acting acting() const;
  /// Now, when `next` is applied now. The forces of a plant that is a plugin are those at the end of its last step,
  /// which are under that step's command.
  Acting acting_under(const Input& next) const;

  /// The centre of gravity, or a corner of the car, is outside the edges.
  bool outside() const { return outside_; }
  bool body_outside() const { return body_outside_; }
  /// A corner of the car has reached a wall.
  bool crashed() const { return crashed_; }
  /// Moment at which a lap ended within the last step [s].
  std::optional<double> lap_ended() const { return lap_ended_; }
  int laps() const { return laps_.laps(); }
  /// Distance along the centre line since the start [m].
  double covered() const { return laps_.covered(); }

 private:
  class ModelCar;
  class PluginPlant;
  class TruthView;
  class WorldGround;
  /// How the car moves: a vehicle model integrated here, or a plant plugin that integrates itself.
  class CarDynamics {
   public:
    virtual ~CarDynamics() = default;
    /// Told before everything else of a step: where it begins, and the friction that holds over it.
    virtual void begin_step(const Place& at, double factor) = 0;
    virtual State advance(const State& x, const Input& u, const Place& at) = 0;
    /// Where the step began, at factor 1 and at static load: peak force over that load, and the force at a slip angle.
    virtual double peak_mu(Axle axle) const = 0;
    virtual double curve(Axle axle, double slip) const = 0;
    virtual Acting acting() const = 0;
    virtual Acting acting_under(const State& x, const Input& next, const Place& at) = 0;
    /// Passes a reading through the car's own effects.
    virtual void read(Reading<double>& reading, const Place& at) const = 0;
    virtual bool accelerations(const Points<double>& points) const = 0;
    virtual bool accelerations(const Points<Dual8>& points) const = 0;
  };

  void arrive(double t);
  void begin_step();
  void sense();

  const WorldSpec& spec_;
  FrictionSchedule friction_;
  Sensors sensors_;
  TrackCourse course_;
  LapCounter laps_;
  State state_;
  Place place_;
  std::int64_t step_ = 0;
  double factor_ = 1.0;  // held over the step that begins now
  double d_ = 0.0;
  Acting held_;  // while the last command is
  Observation observation_;
  double sensed_hint_ = 0.0;
  bool outside_ = false, body_outside_ = false, crashed_ = false;
  std::optional<double> lap_ended_;
  std::unique_ptr<WorldGround> road_;
  std::unique_ptr<CarDynamics> dynamics_;
  std::unique_ptr<TruthView> truth_;
};

}  // namespace gripline
