/// \file
/// What plugins implement (VehicleModel, Effect, Estimator, SpeedPlanner, Controller, Plant) and what they are given
/// (PluginContext, Course, Prediction, Truth, Ground). The contract of each call stands above it.
/// "The paper", with its Algorithm 1, is Kalaria, Lin, Dolan, arXiv 2303.08235.
///
/// Rules of every call, unless its contract says otherwise:
/// - The caller allocates and owns all arrays; they are valid until the call returns. A span of length 0 means "not
///   wanted"; other lengths are as the contract says and not checked. Arrays of one call do not overlap. n, where a
///   call has it, may be 0. Objects behind references and pointers live longer than the plugin that was given them.
/// - `const` calls may come from several threads at once, so they keep no scratch in the instance. All others come one
///   after the other per instance; different instances may be called at the same time.
/// - An exception derived from std::exception ends the run with the plugin's name, the time and its text; all complete
///   rows are kept. A number that is not finite, where one is returned or filled, is treated the same.
/// - Calls made in every control step (apply, evaluate, update, belief, plan, control, advance) allocate nothing. One
///   that solves or fits something anew once in many steps (a lap, say), or that calls a solver which allocates by
///   itself, may; a simulated race waits for it, a car could not.
/// - Only fixed-layout data crosses: no containers, no ownership. The library that makes an instance destroys it.
#pragma once

#include <cstdint>
#include <span>

#include <gripline/types.hpp>

namespace gripline {

/// The equations of a car, evaluated in stages so that effects can act in between. Authors derive from AutoDiffVehicle.
class VehicleModel {
 public:
  virtual ~VehicleModel() = default;
  /// Bits of the stages this model has (stage_bit), always the same. An effect of another stage is refused with that
  /// reason.
  virtual unsigned stages() const noexcept = 0;
  /// Fills the quantities of the stages first .. last of all n points, each stage from the quantities before it; the
  /// host has set the state, d, delta and delta_rate; quantities of stages that the model lacks are zero. Each stage
  /// that it has fills all of its own, which hold anything on entry: `drive` motor, emf, brake, rolling and drag;
  /// `load` drive_force, m, Iz, lf, lr, load_front and load_rear; `tyre` slip_front, slip_rear, peak_front, peak_rear,
  /// stiff_front and stiff_rear; `force` force_front and force_rear; `body` ax, ay, aw, grade and bank, the last two
  /// from the place (0 where the car does not feel the slope). memory and history are null. points.params are the
  /// model's own, in the order of its declaration.
  virtual void evaluate(Stage first, Stage last, const Points<double>& points) const = 0;
  /// The same formula with derivatives: values v are those of the overload above to rounding, within 1e-9 (1 + |v|).
  virtual void evaluate(Stage first, Stage last, const Points<Dual8>& points) const = 0;
};

/// A change of one stage's quantities: a missing physical effect, or what an estimator learned. Authors derive from
/// AutoDiffEffect, or from AutoDiffReading for Stage::reading.
class Effect {
 public:
  virtual ~Effect() = default;
  /// The stage after which it acts, always the same.
  virtual Stage stage() const noexcept = 0;
  /// Number of its states that the host integrates per car (a lagged force, a temperature), always the same. Effects of
  /// Stage::reading have none.
  virtual int memory() const noexcept { return 0; }
  /// The longest delay [s] at which it reads past commands (Points::history) with these parameters, 0 when it reads
  /// none. `params` is as Points::params: all of them in the order of declaration, 0 in the place of a table.
  virtual double look_back(std::span<const double> /*params*/) const noexcept { return 0.0; }
  /// The memory at the start of a run, its steady value: fills memory[i * points.memory_stride + j] for instants i < n
  /// and states j < memory(), in the unit of each state. Called once per run, with all stages before this effect
  /// evaluated; points.memory and points.memory_rate are null, `memory` is zero on entry, which is what stays by
  /// default.
  virtual void start_memory(const Points<double>& /*points*/, double* /*memory*/) const {}
  /// Changes the quantities of its stage in points.q (of Stage::reading: points.reading) for all n points, and writes
  /// every points.memory_rate of its own. Several effects of one stage act one after the other.
  virtual void apply(const Points<double>& points) const = 0;
  /// The same formula with derivatives: values v are those of the overload above to rounding, within 1e-9 (1 + |v|).
  virtual void apply(const Points<Dual8>& points) const = 0;
};

/// Lateral tyre force over slip angle, learned or true.
class TyreCurve {
 public:
  virtual ~TyreCurve() = default;
  /// Fills force [N] and, where not empty, its standard deviation sigma [N] of the axle at each slip angle [rad],
  /// at the axle's static load. Signs as in Quantities: a positive slip angle gives a positive force, to the left.
  /// `force` is as long as `slip`; `sigma` is so too, or empty. False when it has no tyre curve: the spans are then not
  /// written. Planners may call it within their `plan`.
  virtual bool tyre_force(Axle axle, std::span<const double> slip, std::span<double> force,
                          std::span<double> sigma) const = 0;
};

/// Learns from every step what the nominal model misses, and friction from that. As an effect it corrects
/// Stage::body, after the nominal model and its effects filled it: points.params is not to be read, since the
/// parameters of an estimator are not fitted. Authors derive from AutoDiffEffect<D, Estimator>.
class Estimator : public Effect, public TyreCurve {
 public:
  Stage stage() const noexcept override { return Stage::body; }
  /// Algorithm 1, lines 5 to 7: takes in one step. Called once in every step from the first, also while the stack still
  /// drives on the nominal model alone (before its adapt_after).
  virtual void update(const Sample& sample) = 0;
  /// Algorithm 1, line 8: its present estimate. Until it has learned, that is the context's mu_init, or the
  /// friction that one of its own parameters states; a plugin that needs the truth may return the true friction at any
  /// time. `trusted` is the stack's to set. A number that is not finite or below 0 ends the run.
  virtual Belief belief() const = 0;
  /// By default it has no tyre curve.
  bool tyre_force(Axle, std::span<const double>, std::span<double>, std::span<double>) const override { return false; }
};

/// x_{k+1} = f(x_k, u_k) of a model with its effects, exactly differentiated through the integrator. Made by the
/// framework for controllers and planners. A row of x is a State (7 numbers in the order of the struct) followed by the
/// effects' memory and the commands that do not act yet (delays); a row of u is an Input (d, ddelta).
class Prediction {
 public:
  virtual ~Prediction() = default;
  /// Length of a row of x: 7 + memory + 2 per command that does not act yet.
  virtual int states() const noexcept = 0;
  /// Length of a step [s].
  virtual double dt() const noexcept = 0;
  /// Fills the row x (states() numbers) for a state observed now: the state, then memory and past commands as the
  /// framework carried them along.
  virtual void start(const State& now, std::span<double> x) const = 0;
  /// n independent steps of dt() at once: row i goes from x to x_next under u at the place where it starts. Lengths: x
  /// and x_next n states(), u 2 n, at n. A and B are derivatives of x_next by x and u: n matrices states() x states()
  /// and n states() x 2, one after the other, each row-major; either may be empty, when not wanted. x_next must not
  /// overlap x, not even be the same array: x is read again after x_next was written. Numbers that are not finite come
  /// back as such, with no exception; what a plugin of the model throws comes through. Allocates only when n grows. Not
  /// const: it works in its own buffers.
  virtual void step(std::size_t n, std::span<const double> x, std::span<const double> u, std::span<const Place> at,
                    std::span<double> x_next, std::span<double> A, std::span<double> B) = 0;
  /// Rates of a state under a held input, and what the axles carry then.
  struct Rates {
    double vx = 0;           ///< vx' [m/s2]
    double vy = 0;           ///< vy' [m/s2]
    double omega = 0;        ///< omega' [rad/s2]
    double load_front = 1;   ///< as in Quantities, relative to the static load [-]
    double load_rear = 1;    ///< as in Quantities, relative to the static load [-]
    double drive_force = 0;  ///< as in Quantities [N]
    double d = 0;            ///< throttle that acts, as in Quantities: what Stage::command makes of the held one [-]
    double delta = 0;        ///< road wheel angle that acts, likewise [rad]
  };
  /// Rates of one state under a held input, memory at its steady value: for planners that need the car's real drive,
  /// brake and steering limits. x.delta is the command. Errors as in `step`. May allocate.
  virtual Rates rates(const State& x, const Input& u, const Place& at) = 0;
};

/// Options of the minimum-curvature line.
struct LineOptions {
  double margin = 0;         ///< kept from both edges beside half the car's width [m]
  double max_curvature = 0;  ///< soft bound, 0 for none [1/m]
};

/// The road as every stack may see it.
class Course {
 public:
  virtual ~Course() = default;
  /// Length of the centre line [m].
  virtual double length() const noexcept = 0;
  /// The centre line at a station [m]; stations wrap around the lap. The result's s is in [0, length()), its n is 0.
  virtual CoursePoint at(double s) const = 0;
  /// Nearest point of the centre line to a position [m]; near station `hint_s` [m] when that is not NaN, else anywhere.
  /// The result's n is the position's offset, its x and y are on the centre line.
  virtual CoursePoint locate(double x, double y, double hint_s) const = 0;
  /// Fills `line` with the minimum-curvature line (eq. (1) of the paper) as line.size() samples equally spaced along
  /// it, closed (the first sample is not repeated). Takes seconds and allocates: for constructors. Throws what derives
  /// from std::exception when there is no such line, as on a road narrower than the car with its margins; a constructor
  /// may let it through: the plugin is then reported as refused.
  virtual void minimum_curvature(const LineOptions& options, std::span<LinePoint> line) const = 0;
};

/// Chooses the reference trajectory.
class SpeedPlanner {
 public:
  virtual ~SpeedPlanner() = default;
  /// Algorithm 1, line 14: fills horizon[k], every member, k = 0 .. size - 1, for the times now.t + k dt with the
  /// context's dt; the size is the controller's horizon(). `belief` is mu_init, untrusted, and `learned` null until
  /// plans may rest on what was learned (after the stack's adapt_after and its careful_until).
  virtual void plan(const Observation& now, const Belief& belief, const TyreCurve* learned,
                    std::span<RefPoint> horizon) = 0;
  /// The closed line that `plan` follows at this moment, for the deviation metric and the report. Owned by the planner,
  /// valid until the next call of plan; may be empty.
  virtual std::span<const LinePoint> line() const = 0;
  /// The longest time so far from the order of a plan to the step that first drove it [s]; 0 where plans are made
  /// within the step. For the table of results.
  virtual double latency() const noexcept { return 0.0; }
};

/// Computes the commands.
class Controller {
 public:
  virtual ~Controller() = default;
  /// How many reference points it wants: N + 1 of a horizon of N steps, the first for now; at least 1, always the same.
  virtual int horizon() const noexcept = 0;
  /// Algorithm 1, line 15: the command for the step that begins now. `horizon` has horizon() points; `model` is the
  /// nominal model, from the stack's adapt_after on corrected by the estimator. The host clamps commands to the car's
  /// limits.
  virtual Command control(const Observation& now, std::span<const RefPoint> horizon, Prediction& model) = 0;
  /// The states predicted in the last call of control, the first for that instant, then one for every step of the
  /// context's dt; for the report. Owned by the controller, valid until the next call; may be empty.
  virtual std::span<const State> predicted() const { return {}; }
};

/// What is true of the world now. Handed only to plugins that declare `needs_truth`.
class Truth {
 public:
  virtual ~Truth() = default;
  /// Friction factor of the road under the car [-].
  virtual double factor() const = 0;
  /// Peak lateral force of an axle at static load over that load, with the present factor [-].
  virtual double mu(Axle axle) const = 0;
  /// Lateral force [N] of an axle at a slip angle [rad] of its wheels, at the static load of the world's Car and at its
  /// v_ref, without drive, with the present factor; signs as in TyreCurve.
  virtual double tyre_force(Axle axle, double slip) const = 0;
  /// Fills ax, ay, aw, grade and bank of all n points.q from yaw, vx, vy, omega, d, delta, delta_rate and points.at as
  /// the true car would have them. d, delta and delta_rate act, as in Quantities: the true car's effects of
  /// Stage::command are left out, and those that have memory. params, memory and history are not read. False
  /// when the world's car is a Plant; points are then not written.
  virtual bool accelerations(const Points<double>& points) const = 0;
  /// accelerations() with exact derivatives; values v are those of the overload for double within 1e-9 (1 + |v|).
  virtual bool accelerations(const Points<Dual8>& points) const = 0;
};

/// The road under a point of the world, friction included: for plants only.
class Ground {
 public:
  virtual ~Ground() = default;
  /// The road at one point.
  struct Patch {
    double grade = 0;   ///< slope along `yaw`, positive uphill [rad]
    double bank = 0;    ///< slope across `yaw`, positive where the right side is higher [rad]
    double factor = 1;  ///< friction [-]
  };
  /// The road below a position [m] of the world, seen along a heading [rad].
  virtual Patch at(double x, double y, double yaw) const = 0;
};

/// A car that integrates itself, with hidden states of its own. Worlds only.
class Plant {
 public:
  virtual ~Plant() = default;
  /// Puts the car at rest or rolling at this state, hidden states steady. Called before the first `advance`.
  virtual void reset(const State& x, const Ground& ground) = 0;
  /// Advances by dt [s] under commands held (throttle d [-], steering angle delta [rad]), both within the car's limits;
  /// returns the state after it, yaw unwrapped, with delta as commanded.
  virtual State advance(double d, double delta, double dt, const Ground& ground) = 0;
  /// Peak lateral force of an axle over its static load at friction factor 1 [-]: for Truth.
  virtual double mu(Axle axle) const = 0;
  /// Lateral force [N] at a slip angle [rad] at static load and friction factor 1; signs as in TyreCurve: for Truth.
  virtual double tyre_force(Axle axle, double slip) const = 0;
  /// Lateral force of an axle at the end of the last step, in its wheels' axes, positive to the left [N]: for
  /// validation files.
  virtual double axle_force(Axle axle) const = 0;
};

/// What an instance is made from, beside its own parameters. Pointers outlive the instance.
struct PluginContext {
  Car car;                          ///< the stack's car, or the world's
  double dt = 0;                    ///< control step [s]; 0 in offline work
  Hold hold = Hold::zoh;            ///< what commands do within a step
  std::uint64_t seed = 1;           ///< of this run: all randomness of a plugin comes from it. The world draws its
                                    ///< sensors' noise from it too; a plugin that repeats those draws knows the truth
                                    ///< without having declared it, which nothing prevents
  double mu_init = 1;               ///< friction that the stack assumes before it learned [-]
  const Course* course = nullptr;   ///< the road; null for effects and models in offline work
  Prediction* nominal = nullptr;    ///< the stack's nominal model; null for models, effects and plants
  const Truth* truth = nullptr;     ///< null unless the plugin is an estimator, planner or controller that declares
                                    ///< needs_truth
  const char* cache_dir = nullptr;  ///< where an expensive, content-addressed result may be kept; null: it is not kept
  /// Reports the progress of long work to the user: progress_context, its name and the fraction done, 0 to 1. For
  /// constructors. Null when it is not shown.
  void (*progress)(void* context, const char* what, double fraction) = nullptr;
  void* progress_context = nullptr;  ///< first argument of progress
};

}  // namespace gripline
