/// \file
/// The data that crosses plugin boundaries: doubles in plain structs.
///
/// SI units and ISO axes throughout: x forward, y left, yaw counter-clockwise, steering positive to the left. No Eigen,
/// JSON or std::string here: their layout follows compiler flags and versions, ours must not.
///
/// "Algorithm 1" is the algorithm of Kalaria, Lin, Dolan, arXiv 2303.08235.
#pragma once

#include <cstddef>
#include <cstdint>

#include <gripline/dual.hpp>

namespace gripline {

/// Acceleration of free fall [m/s2].
inline constexpr double gravity = 9.81;

/// State of a car: pose of the centre of gravity, velocities in the car's axes, steering.
struct State {
  double x = 0;      ///< position [m]
  double y = 0;      ///< position [m]
  double yaw = 0;    ///< heading [rad], unwrapped: it goes on beyond a full turn
  double vx = 0;     ///< velocity forward [m/s]
  double vy = 0;     ///< velocity to the left [m/s]
  double omega = 0;  ///< yaw rate [rad/s]
  double delta = 0;  ///< steering angle last commanded, at the road wheels [rad]
};
/// Numbers in a State, for rows of a Prediction.
inline constexpr int state_size = 7;
/// The State of such a row.
constexpr State state_of(const double* row) { return {row[0], row[1], row[2], row[3], row[4], row[5], row[6]}; }

/// What a controller decides for one step.
struct Input {
  double d = 0;       ///< throttle (d > 0) or brake (d < 0) [-]
  double ddelta = 0;  ///< rate of the commanded steering angle [rad/s]
};

/// When and where: the time and the Frenet coordinates of a point, with the road there. True friction is not part of
/// it; `grip` is what a planner expects.
struct Place {
  double t = 0;             ///< time since the start of the run [s]
  double s = 0;             ///< station on the centre line [m]
  double n = 0;             ///< offset from the centre line to its left [m]
  double lap_fraction = 0;  ///< s over the length [-], in file order whichever way the car drives
  double yaw_line = 0;      ///< heading of the centre line [rad]
  double kappa = 0;         ///< curvature of the centre line [1/m], positive to the left
  double grade = 0;         ///< slope along the direction of travel [rad], positive uphill
  double bank = 0;          ///< slope across it [rad], positive where the right side is higher
  double direction = 1;     ///< +1: the car drives along the file, -1: against it
  double grip = 1;          ///< of a RefPoint: friction there over friction below the car, as the planner expects it
                            ///< [-]; in everything that is observed or sampled 1
};

/// Constants of a car that every plugin of a stack may know. Friction is not among them.
struct Car {
  double m = 0;           ///< mass [kg]
  double Iz = 0;          ///< yaw inertia [kg m2]
  double lf = 0;          ///< centre of gravity to front axle [m]
  double lr = 0;          ///< centre of gravity to rear axle [m]
  double length = 0;      ///< of the outline, centred on the centre of gravity [m]
  double width = 0;       ///< of the outline [m]
  double d_min = 0;       ///< least throttle, negative where the car brakes [-]
  double d_max = 0;       ///< largest throttle [-]
  double delta_max = 0;   ///< largest steering angle to either side [rad]
  double ddelta_max = 0;  ///< largest steering rate to either side [rad/s]
  double v_ref = 1;       ///< typical speed: the unit of u = vx / v_ref [m/s]
  double v_min = 0;       ///< below this speed models hold their slip terms [m/s]
};

/// One of the two axles.
enum class Axle : int {
  front = 0,  ///< the steered one
  rear = 1    ///< the other
};

/// The stages in which a car is evaluated, in this order. An effect acts in one stage and changes its quantities.
enum class Stage : int {
  command,  ///< the commands that act: d, delta, delta_rate
  drive,    ///< drive train, brakes and resistance
  load,     ///< inertia, geometry, axle loads
  tyre,     ///< slip angles and the tyres' peak and stiffness
  force,    ///< lateral forces
  body,     ///< accelerations and slopes
  reading   ///< what sensors show of a state
};
/// Number of stages.
inline constexpr int stage_count = 7;
/// The bit of a stage in VehicleModel::stages.
constexpr unsigned stage_bit(Stage stage) { return 1u << static_cast<unsigned>(stage); }

/// The working quantities of one car at one instant. A vehicle model fills a stage, effects of that stage change it,
/// the next stage builds on it. Effects read everything of earlier stages and write their own stage only.
template <class T>
struct Quantities {
  /// \name State, given
  ///@{
  T yaw;    ///< heading [rad]
  T vx;     ///< velocity forward [m/s]
  T vy;     ///< velocity to the left [m/s]
  T omega;  ///< yaw rate [rad/s]
  ///@}
  /// \name Stage::command
  ///@{
  T d;           ///< throttle that acts [-]
  T delta;       ///< road wheel angle [rad]
  T delta_rate;  ///< its rate [rad/s]
  ///@}
  /// \name Stage::drive
  /// Drive force Fd = (motor - emf vx) d for d >= 0, brake d for d < 0; resistance Fres = rolling + drag vx^2.
  ///@{
  T motor;    ///< drive force at rest and full throttle [N]
  T emf;      ///< loss of drive force with speed (back-EMF) [N s/m]
  T brake;    ///< brake force at d = -1 [N]
  T rolling;  ///< rolling resistance [N]
  T drag;     ///< drag over speed squared [N s2/m2]
  ///@}
  /// \name Stage::load
  ///@{
  T drive_force;  ///< Fd [N]: given on entry, the vehicle's own from here on (brakes that hold), not for effects to write
  T m;            ///< mass [kg]
  T Iz;           ///< yaw inertia [kg m2]
  T lf;           ///< centre of gravity to front axle [m]
  T lr;           ///< centre of gravity to rear axle [m]
  T load_front;  ///< axle load relative to the nominal car's static one [-]
  T load_rear;   ///< axle load relative to the nominal car's static one [-]
  ///@}
  /// \name Stage::tyre
  /// A positive slip angle pushes its axle to the left (positive force).
  ///@{
  T slip_front;   ///< delta (backwards -delta) - atan2(vy + lf omega, |vx|) [rad]: effects must not write it
  T slip_rear;    ///< -atan2(vy - lr omega, |vx|) [rad]: effects must not write it
  T peak_front;   ///< peak lateral force of the axle [N]
  T peak_rear;    ///< peak lateral force of the axle [N]
  T stiff_front;  ///< stiffness factor B of the Magic Formula [1/rad]
  T stiff_rear;   ///< stiffness factor B of the Magic Formula [1/rad]
  ///@}
  /// \name Stage::force
  ///@{
  T force_front;  ///< lateral force of the axle, in the wheels' axes, positive to the left [N]
  T force_rear;   ///< lateral force of the axle, positive to the left [N]
  ///@}
  /// \name Stage::body
  ///@{
  T ax;     ///< vx' on level ground, vy omega included [m/s2]
  T ay;     ///< vy' on level ground, -vx omega included [m/s2]
  T aw;     ///< omega' [rad/s2]
  T grade;  ///< adds -g sin(grade) to vx' [rad]
  T bank;   ///< adds +g sin(bank) to vy' [rad]
  ///@}
};

/// What sensors show of a state: the quantities of Stage::reading.
template <class T>
struct Reading {
  T x;      ///< position [m]
  T y;      ///< position [m]
  T yaw;    ///< heading [rad]
  T vx;     ///< velocity forward [m/s]
  T vy;     ///< velocity to the left [m/s]
  T omega;  ///< yaw rate [rad/s]
};

/// What a command does between two samples.
enum class Hold : int {
  zoh,  ///< throttle and steering angle held from the sample on (zero-order hold)
  foh,  ///< both lines between samples (first-order hold)
  rate  ///< steering a line between samples, throttle held until the sample
};

/// Throttle and steering angle commanded at one instant.
template <class T>
struct CommandSample {
  T d;      ///< throttle [-]
  T delta;  ///< steering angle [rad]
};

/// Commands up to now, equally spaced: sample i was given at t0 + i dt (zoh) or reached then (foh, rate; the throttle
/// of rate held until then). Read-only; owned by the caller.
template <class T>
struct History {
  const CommandSample<T>* samples = nullptr;  ///< oldest first
  std::size_t count = 0;                      ///< of samples
  double t0 = 0;                              ///< time of the oldest [s]
  double dt = 0;                              ///< between samples [s]
  double now = 0;                             ///< the instant that is being evaluated, same clock as t0 [s]
  Hold hold = Hold::foh;                      ///< what the commands did between samples

  /// A command at one instant.
  struct Value {
    T d;           ///< throttle [-]
    T delta;       ///< steering angle [rad]
    T delta_rate;  ///< its rate [rad/s]
  };
  /// Command and its rate `age` seconds ago; before the first sample the first command held.
  Value at(const T& age) const {
    if (count == 0) return {T(0), T(0), T(0)};
    const T position = (T(now - t0) - age) * (1.0 / dt);
    if (!(position > T(0))) return {samples[0].d, samples[0].delta, T(0)};
    const std::size_t i = static_cast<std::size_t>(value(position));
    if (hold == Hold::zoh) {
      const CommandSample<T>& held = samples[i < count ? i : count - 1];
      return {held.d, held.delta, i > 0 && i < count ? (held.delta - samples[i - 1].delta) * (1.0 / dt) : T(0)};
    }
    if (i + 1 >= count) return {samples[count - 1].d, samples[count - 1].delta, T(0)};
    const T slope = (samples[i + 1].delta - samples[i].delta) * (1.0 / dt);
    const T w = position - static_cast<double>(i);
    const T d = hold == Hold::rate ? samples[i + 1].d : samples[i].d + (samples[i + 1].d - samples[i].d) * w;
    return {d, samples[i].delta + (samples[i + 1].delta - samples[i].delta) * w, slope};
  }
};

/// n instants evaluated in one call: a horizon, a batch of rollouts. All arrays are the caller's, of length n unless
/// said otherwise, and none of them overlap.
template <class T>
struct Points {
  std::size_t n = 0;           ///< number of instants
  Quantities<T>* q = nullptr;  ///< read and written; null at Stage::reading
  const Place* at = nullptr;   ///< when and where
  const T* params = nullptr;   ///< values of the callee's declared parameters in the order of declaration (0 in the
                               ///< place of a table), the same for all instants, with derivatives where wanted
  const T* memory = nullptr;   ///< the callee's own: memory[i * memory_stride + j] is its j-th at instant i; null when
                               ///< it has none
  T* memory_rate = nullptr;    ///< to be written, arranged as memory: its rates [per s]
  std::size_t memory_stride = 0;        ///< from one instant to the next in memory and memory_rate
  const History<T>* history = nullptr;  ///< commands up to each instant; null unless some effect reads past ones
  Reading<T>* reading = nullptr;        ///< at Stage::reading: read and written; null at all other stages
};

/// What the stack sees at an instant.
struct Observation {
  double t = 0;           ///< time since the start of the run [s]
  std::int64_t step = 0;  ///< number of the control step, from 0
  State x;                ///< as sensed; delta is the steering angle last commanded
  Place at;               ///< where that is
  double d = 0;           ///< throttle commanded in the step that ended now [-]
};

/// One step as the stack saw it, for learning. `u` was held over the step; the steering command of the step is
/// x_next.delta (zoh) with rate u.ddelta.
struct Sample {
  double t = 0;           ///< at the start of the step [s]
  double dt = 0;          ///< length of the step [s]
  std::int64_t step = 0;  ///< its number, from 0
  State x;                ///< sensed at its start
  Input u;                ///< commanded for it
  Place at;               ///< where it started
  State x_next;           ///< sensed at its end
  Place at_next;          ///< where it ended
  double e_vx = 0;        ///< residual (x_next - f_nom(x, u)) / dt of vx, unexplained by the nominal model [m/s2]
  double e_vy = 0;        ///< residual of vy: (x_next - f_nom(x, u)) / dt [m/s2] (Algorithm 1, line 4)
  double e_omega = 0;     ///< residual of omega: (x_next - f_nom(x, u)) / dt [rad/s2]
  double d_lag = 0;  ///< throttle commanded minus the throttle that acts in the middle of the step: by lags, gains or
                     ///< delays of the nominal model, and half a ramp where commands move within a step [-]
  double delta_lag = 0;   ///< steering angle commanded minus the one that acts then, likewise [rad]
  double ddelta_lag = 0;  ///< rate of that command minus the rate at which the wheels turn then, likewise [rad/s]
};

/// A stack's estimate of friction: peak lateral force of an axle over that axle's static load, and its standard
/// deviation.
struct Belief {
  double mu_front = 1;     ///< [-]
  double mu_rear = 1;      ///< [-]
  double sigma_front = 0;  ///< standard deviation of mu_front [-]
  double sigma_rear = 0;   ///< standard deviation of mu_rear [-]
  bool trusted = false;    ///< whether plans may rest on it. The stack sets it (true after its adapt_after and its
                           ///< careful_until); what an estimator writes here is overwritten
};

/// mu of the whole car: axle values weighted by static load.
inline double total_mu(const Belief& belief, const Car& car) {
  return (belief.mu_front * car.lr + belief.mu_rear * car.lf) / (car.lf + car.lr);
}

/// Standard deviation of total_mu. The errors of both axles are assumed fully correlated, so standard deviations add.
inline double total_sigma(const Belief& belief, const Car& car) {
  return (belief.sigma_front * car.lr + belief.sigma_rear * car.lf) / (car.lf + car.lr);
}

/// Where the car should be k steps ahead. All members are finite: where no edge is to hold the car back, `left` and
/// `right` are large numbers, such as a kilometre.
struct RefPoint {
  double s = 0;      ///< station on the closed line that the planner counts along [m], not the distance driven: where
                     ///< the plan leaves that line, as a time-optimal lap does, of the point of the line beside it
  double x = 0;      ///< position [m]
  double y = 0;      ///< position [m]
  double yaw = 0;    ///< heading of the path [rad]; the car's own is planned to be yaw - beta
  double kappa = 0;  ///< curvature of the path [1/m], positive to the left
  double v = 0;      ///< planned speed along the car's axis, vx [m/s]: that along the path times cos(beta)
  double left = 0;   ///< distance to the track's left edge along the point's normal (-sin yaw, cos yaw) [m]
  double right = 0;  ///< distance to the right edge against that normal, a positive number [m]
  Place at;          ///< the same point on the centre line
  double beta = 0;   ///< planned sideslip angle atan2(vy, vx) [rad]
};

/// What a controller decided, and how the solve went.
struct Command {
  Input u;             ///< for the step that begins now; the host clips it to the car's limits
  int iterations = 0;  ///< of the solver
  bool solved = true;  ///< false: the solver failed, u is a fallback
  double cost = 0;     ///< of the solution
};

/// A point of a course: on the centre line at station s, with offset n to its left where a position was asked about.
/// Directions are those of the file, whichever way the car drives.
struct CoursePoint {
  double s = 0;             ///< station [m]
  double n = 0;             ///< offset to the left [m]
  double x = 0;             ///< position on the centre line [m]
  double y = 0;             ///< position on the centre line [m]
  double yaw = 0;           ///< heading of the centre line [rad]
  double kappa = 0;         ///< its curvature [1/m], positive to the left
  double left = 0;          ///< half width to the left [m]
  double right = 0;         ///< half width to the right [m]
  double grade = 0;         ///< slope along file order [rad], positive uphill
  double bank = 0;          ///< slope across it [rad], positive where the right side is higher
  double lap_fraction = 0;  ///< as in Place [-]
};

/// A sample of a closed driving line, in file order.
struct LinePoint {
  double s = 0;        ///< arc length along this line [m]
  double x = 0;        ///< position [m]
  double y = 0;        ///< position [m]
  double yaw = 0;      ///< heading [rad]
  double kappa = 0;    ///< curvature [1/m], positive to the left
  double left = 0;     ///< distance to the track's left edge [m]
  double right = 0;    ///< distance to the right edge, a positive number [m]
  double station = 0;  ///< of the same point on the centre line [m]
  double grade = 0;    ///< as in CoursePoint [rad]
  double bank = 0;     ///< as in CoursePoint [rad]
};

/// A table parameter: rows x cols numbers; owned by the host for the life of the instance.
struct Table {
  const double* data = nullptr;  ///< row-major; null when the user gave none
  std::size_t rows = 0;          ///< 0 when the user gave none
  std::size_t cols = 0;          ///< of every row; the first column rises
  /// The number in a row and column, both from 0.
  constexpr double at(std::size_t row, std::size_t col) const { return data[row * cols + col]; }
};

}  // namespace gripline
