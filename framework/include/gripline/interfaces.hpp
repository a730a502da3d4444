// What plugins implement and what they are given. One class per role; the contract of each call stands above it.
//
// Common rules. The caller allocates; spans of length 0 mean "not wanted". `const` calls may come from several threads
// at once, all others are serial per instance. An exception ends the run with the plugin's name and the text, every
// complete row kept; non-finite output is treated the same. Nothing here owns anything across the boundary.
#pragma once

#include <cstdint>
#include <span>

#include <gripline/types.hpp>

namespace gripline {

/// The equations of a car, evaluated in stages. `evaluate` fills the quantities of every stage in [first, last]: stage
/// by stage from the quantities before them, so that the host can let effects act in between; the two overloads are one
/// formula in two scalars. A model fills only stages it has; `load` must fill m, Iz, lf, lr and drive_force, `body`
/// must fill ax, ay, aw and copies grade and bank from the place. At Stage::command the host has set d, delta,
/// delta_rate.
class VehicleModel {
 public:
  virtual ~VehicleModel() = default;
  /// Bits of the stages this model has (stage_bit). An effect of another stage is refused with that reason.
  virtual unsigned stages() const noexcept = 0;
  virtual void evaluate(Stage first, Stage last, const Points<double>& points) const = 0;
  virtual void evaluate(Stage first, Stage last, const Points<Dual8>& points) const = 0;
};

/// A change of one stage's quantities: a missing physical effect, or what an estimator learned.
/// Effects with memory integrate it along: `apply` reads points.memory and writes points.memory_rate.
class Effect {
 public:
  virtual ~Effect() = default;
  virtual Stage stage() const noexcept = 0;
  /// Number of doubles of memory per car.
  virtual int memory() const noexcept { return 0; }
  /// How far back [s] this effect reads the commands with these parameters; 0 when it does not.
  virtual double look_back(std::span<const double> /*params*/) const noexcept { return 0.0; }
  /// Writes the memory's value at the start of a run (its steady value) to memory[i * memory_stride + j] through the
  /// pointer points.memory_rate. Called with all stages before this effect evaluated. Default: zero.
  virtual void start(const Points<double>& /*points*/) const {}
  virtual void apply(const Points<double>& points) const = 0;
  virtual void apply(const Points<Dual8>& points) const = 0;
  /// Effects of Stage::reading change readings; all others leave them alone.
  virtual void read(const Readings<double>& /*readings*/) const {}
  virtual void read(const Readings<Dual8>& /*readings*/) const {}
};

/// Lateral tyre force as somebody knows it.
class TyreCurve {
 public:
  virtual ~TyreCurve() = default;
  /// Fills force [N] (and, where not empty, its standard deviation sigma [N]) of the axle at each slip angle [rad], at
  /// the axle's present load. False when there is no tyre to ask about; the spans are then left alone.
  virtual bool tyre_force(Axle axle, std::span<const double> slip, std::span<double> force,
                          std::span<double> sigma) const = 0;
};

/// Learns from every step what the nominal model misses, and what that says of friction. As an effect it acts in
/// Stage::body, after the nominal model and its effects filled it.
class Estimator : public Effect, public TyreCurve {
 public:
  Stage stage() const noexcept override { return Stage::body; }
  /// Algorithm 1, lines 5-7. Called once per step, before and after the stack trusts what was learned.
  virtual void update(const Sample& sample) = 0;
  /// What it believes now; mu_init until it learned anything.
  virtual Belief belief() const = 0;
  bool tyre_force(Axle, std::span<const double>, std::span<double>, std::span<double>) const override { return false; }
};

/// x_{k+1} = f(x_k, u_k) of the nominal model with its effects, exactly differentiated through the integrator. Made by
/// the framework for controllers and planners. A row of x is a State (7 numbers in the order of the struct) followed by
/// the effects' memory; a row of u is (d, ddelta).
class Prediction {
 public:
  virtual ~Prediction() = default;
  /// Length of a row of x: 7 + memory.
  virtual int states() const noexcept = 0;
  /// Length of a step [s].
  virtual double dt() const noexcept = 0;
  /// Writes the row for a state observed now: the state, then the memory as the framework carried it along.
  virtual void start(const State& now, std::span<double> x) const = 0;
  /// n independent steps at once. x: n rows, u: n rows of 2, at: n places, x_next: n rows. A (row-major, per step
  /// states x states) and B (states x 2) are derivatives of x_next by x and u; empty when not wanted. Allocates only
  /// when n grows. Not const: it works in its own buffers.
  virtual void step(std::size_t n, std::span<const double> x, std::span<const double> u, std::span<const Place> at,
                    std::span<double> x_next, std::span<double> A, std::span<double> B) = 0;
  /// Rates (vx', vy', omega') of one state under a held input, without memory effects: for planners that need the
  /// car's real drive, brake and steering limits. Loads per axle as in Quantities: relative to the static ones.
  struct Rates {
    double vx = 0, vy = 0, omega = 0;
    double load_front = 1, load_rear = 1;
    double drive_force = 0;  // as in Quantities [N]
  };
  virtual Rates rates(const State& x, const Input& u, const Place& at) = 0;
};

/// Options of the minimum-curvature line.
struct LineOptions {
  double margin = 0;         // kept from both edges beside half the car's width [m]
  double max_curvature = 0;  // soft bound, 0 for none [1/m]
};

/// The road as every stack may see it.
class Course {
 public:
  virtual ~Course() = default;
  virtual double length() const noexcept = 0;  // of the centre line [m]
  virtual CoursePoint at(double s) const = 0;
  /// Nearest point of the centre line; near station `hint_s` when that is not NaN, else anywhere.
  virtual CoursePoint locate(double x, double y, double hint_s) const = 0;
  /// Minimum-curvature line (eq. (1) of the paper) as line.size() samples equally spaced along it, closed (the first
  /// sample is not repeated). Computed on call: seconds, not microseconds.
  virtual void minimum_curvature(const LineOptions& options, std::span<LinePoint> line) const = 0;
};

/// Chooses the reference. Algorithm 1, line 14.
class SpeedPlanner {
 public:
  virtual ~SpeedPlanner() = default;
  /// Fills horizon[k], k = 0 .. size-1, for the times now.t + k dt. `learned` is null until the stack trusts it.
  virtual void plan(const Observation& now, const Belief& belief, const TyreCurve* learned,
                    std::span<RefPoint> horizon) = 0;
  /// The closed line that `plan` follows at this moment, for the deviation metric and the report; the span stays valid
  /// until the next call of plan.
  virtual std::span<const LinePoint> line() const = 0;
};

/// Drives. Algorithm 1, line 15.
class Controller {
 public:
  virtual ~Controller() = default;
  /// How many reference points it wants: N + 1, the first for now.
  virtual int horizon() const noexcept = 0;
  virtual Command control(const Observation& now, std::span<const RefPoint> horizon, Prediction& model) = 0;
  /// The states predicted in the last call, for the report; may be empty.
  virtual std::span<const State> predicted() const { return {}; }
};

/// What is true of the world now. Handed only to plugins that declare `needs_truth`.
class Truth {
 public:
  virtual ~Truth() = default;
  virtual double factor() const = 0;                            // friction factor under the car
  virtual double mu(Axle axle) const = 0;                       // peak lateral force over the axle's static load
  virtual double tyre_force(Axle axle, double slip) const = 0;  // at static load, with the present factor [N]
  /// Fills ax, ay, aw of points from yaw, vx, vy, omega, d, delta as the true car would have them (its effects
  /// without memory included). False when the world's car is a black box; points are then left alone.
  virtual bool accelerations(const Points<double>& points) const = 0;
  virtual bool accelerations(const Points<Dual8>& points) const = 0;
};

/// The road under a point of the world, friction included: for plants only.
class Ground {
 public:
  virtual ~Ground() = default;
  struct Patch {
    double grade = 0, bank = 0;  // along and across `yaw`, signs as in Place [rad]
    double factor = 1;           // friction [-]
  };
  virtual Patch at(double x, double y, double yaw) const = 0;
};

/// A car from outside: advances by itself, with whatever hidden states it has. Worlds only.
class Plant {
 public:
  virtual ~Plant() = default;
  /// Puts the car at rest or rolling at this state, hidden states steady.
  virtual void reset(const State& x, const Ground& ground) = 0;
  /// Advances by dt [s] under commands held (d, steering angle delta [rad]); returns the state after it.
  virtual State advance(double d, double delta, double dt, const Ground& ground) = 0;
  /// Static peak lateral force over static load of an axle at factor 1, and the force at a slip angle: for Truth.
  virtual double mu(Axle axle) const = 0;
  virtual double tyre_force(Axle axle, double slip) const = 0;
  /// Tyre forces at the last step, lateral per axle [N]: for validation files.
  virtual double axle_force(Axle axle) const = 0;
};

/// What an instance is made from, beside its own parameters. Pointers outlive the instance.
struct PluginContext {
  Car car;
  double dt = 0;                    // control step [s]
  Hold hold = Hold::zoh;            // what commands do within a step
  std::uint64_t seed = 1;           // of this run
  double mu_init = 1;               // what the stack believes before it learned
  const Course* course = nullptr;   // null for models and effects of offline work
  Prediction* nominal = nullptr;    // the stack's nominal model; null for models, effects and plants
  const Truth* truth = nullptr;     // null unless the plugin declares needs_truth
  const char* cache_dir = nullptr;  // where an expensive, content-addressed result may be kept; null: nowhere
  void (*progress)(void* context, const char* what, double fraction) = nullptr;  // may be null
  void* progress_context = nullptr;
};

}  // namespace gripline
