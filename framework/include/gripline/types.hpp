// The data that crosses plugin boundaries: doubles in plain structs.
//
// SI units and ISO axes throughout: x forward, y left, yaw counter-clockwise, steering positive to the left. No Eigen,
// JSON or std::string here: their layout follows compiler flags and versions, ours must not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <gripline/dual.hpp>

namespace gripline {

inline constexpr double gravity = 9.81;  // [m/s2]

/// State of a car: pose [m, m, rad, yaw unwrapped], velocities in the car's axes at the centre of gravity
/// [m/s, m/s, rad/s], and the steering angle last commanded [rad].
struct State {
  double x = 0, y = 0, yaw = 0, vx = 0, vy = 0, omega = 0, delta = 0;
};
inline constexpr int state_size = 7;

/// What a controller decides for one step: throttle or brake d [-], rate of the commanded steering angle [rad/s].
struct Input {
  double d = 0, ddelta = 0;
};

/// When and where. `s` is the station on the centre line [m], `n` the offset to its left [m]; `lap_fraction` is s over
/// the length, in file order whichever way the car drives; `direction` is +1 along the file, -1 against it. `grade` > 0
/// is uphill along the direction of travel, `bank` > 0 means the right side is higher [rad]. Never friction.
struct Place {
  double t = 0, s = 0, n = 0, lap_fraction = 0, yaw_line = 0, kappa = 0, grade = 0, bank = 0, direction = 1;
};

/// Constants of a car that every plugin of a stack may know. Friction is not among them.
struct Car {
  double m = 0, Iz = 0, lf = 0, lr = 0;                        // [kg, kg m2, m, m]
  double length = 0, width = 0;                                // outline, centred on the centre of gravity [m]
  double d_min = 0, d_max = 0, delta_max = 0, ddelta_max = 0;  // limits of the commands [-, -, rad, rad/s]
  double v_ref = 1;                                            // typical speed, the unit of u = vx / v_ref [m/s]
  double v_min = 0;                                            // below this speed models hold their slip terms [m/s]
};

enum class Axle : int { front = 0, rear = 1 };

/// The stages in which a car is evaluated, in this order. An effect hooks one stage and changes its quantities.
enum class Stage : int { command, drive, load, tyre, force, body, reading };
inline constexpr int stage_count = 7;
constexpr unsigned stage_bit(Stage stage) { return 1u << static_cast<unsigned>(stage); }

/// The working quantities of one car at one instant. A vehicle model fills a stage, effects of that stage change it,
/// the next stage builds on it. Effects read everything of earlier stages and write their own stage only.
template <class T>
struct Quantities {
  // state, given
  T yaw, vx, vy, omega;
  // command: effective throttle [-], road wheel angle [rad] and its rate [rad/s]
  T d, delta, delta_rate;
  // drive: Fd = (motor - emf vx) d for d >= 0, brake d for d < 0 [N, N s/m, N]; Fres = rolling + drag vx^2 [N, N s2/m2]
  T motor, emf, brake, rolling, drag;
  // load: inertia, geometry [kg, kg m2, m, m], axle loads relative to the static ones of the nominal car [-].
  // drive_force Fd [N] is computed on entry to this stage and read-only.
  T drive_force, m, Iz, lf, lr, load_front, load_rear;
  // tyre: peak lateral force [N] and stiffness factor B [1/rad] per axle. slip_* [rad] are read-only.
  T slip_front, slip_rear, peak_front, peak_rear, stiff_front, stiff_rear;
  // force: lateral force per axle, positive to the left [N]
  T force_front, force_rear;
  // body: rates of vx, vy, omega without slope [m/s2, m/s2, rad/s2]; then slope angles [rad], which add
  // -g sin(grade) to vx' and +g sin(bank) to vy'
  T ax, ay, aw, grade, bank;
};

/// What sensors show of a state; the quantities of Stage::reading.
template <class T>
struct Reading {
  T x, y, yaw, vx, vy, omega;
};

enum class Hold : int { zoh, foh, rate };

template <class T>
struct CommandSample {
  T d, delta;
};

/// Commands up to now, equally spaced: sample i was given at t0 + i dt (zoh) or reached then (foh, rate; the throttle
/// of rate held until then). Read-only; owned by the caller.
template <class T>
struct History {
  const CommandSample<T>* samples = nullptr;
  std::size_t count = 0;
  double t0 = 0, dt = 0;
  double now = 0;  // the instant that is being evaluated, same clock as t0
  Hold hold = Hold::foh;

  /// Command and its rate `age` seconds ago; before the first sample the first command held.
  struct Value {
    T d, delta, delta_rate;
  };
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
/// said otherwise. `params` are the values of the callee's declared parameters, in the order of its declaration,
/// carrying derivatives where the caller wants them. `memory` and `memory_rate` are the callee's own slice:
/// memory[i * memory_stride + j] is its j-th memory at instant i; null when it has none. `history` is null unless
/// the callee looks back.
template <class T>
struct Points {
  std::size_t n = 0;
  Quantities<T>* q = nullptr;
  const Place* at = nullptr;
  const T* params = nullptr;
  const T* memory = nullptr;
  T* memory_rate = nullptr;
  std::size_t memory_stride = 0;
  const History<T>* history = nullptr;
};

/// n readings changed in one call by an effect of Stage::reading.
template <class T>
struct Readings {
  std::size_t n = 0;
  Reading<T>* r = nullptr;
  const Place* at = nullptr;
  const T* params = nullptr;
};

/// What the stack sees at an instant: the state as sensed, where that is, and the command held until now.
struct Observation {
  double t = 0;
  std::int64_t step = 0;
  State x;
  Place at;
  double d = 0;  // throttle commanded in the step that ended now [-]
};

/// One step as the stack saw it, for learning. `u` was held over the step; the steering command of the step is
/// x_next.delta (zoh) with rate u.ddelta. `e_*` is what the nominal model left unexplained, as a rate:
/// (x_next - f_nom(x, u)) / dt for vx, vy, omega [m/s2, m/s2, rad/s2] (Algorithm 1, line 4).
struct Sample {
  double t = 0, dt = 0;
  std::int64_t step = 0;
  State x;
  Input u;
  Place at;
  State x_next;
  Place at_next;
  double e_vx = 0, e_vy = 0, e_omega = 0;
  // Commands (throttle, steering angle) less what acts of them in the middle of the step, where the nominal model knows
  // lags, gains or delays of the command.
  double d_behind = 0, delta_behind = 0;
};

/// What a stack believes of friction: mu per axle, relative to that axle's static load, and standard deviations.
/// `trusted` says whether the stack uses what it learned (after adapt_after).
struct Belief {
  double mu_front = 1, mu_rear = 1, sigma_front = 0, sigma_rear = 0;
  bool trusted = false;
};

/// mu of the whole car: axle values weighted by static load.
inline double total_mu(const Belief& belief, const Car& car) {
  return (belief.mu_front * car.lr + belief.mu_rear * car.lf) / (car.lf + car.lr);
}

/// Where the car should be k steps ahead. `left` and `right` are the distances [m] from the point to the track's edges
/// along the point's normal (-sin yaw, cos yaw), right as a positive number. `yaw` is the heading of the path; the
/// car's own is planned to be yaw - beta.
struct RefPoint {
  double s = 0, x = 0, y = 0, yaw = 0, kappa = 0, v = 0, left = 0, right = 0;
  Place at;
  double beta = 0;  // sideslip angle [rad]
};

/// What a controller decided, and how the solve went.
struct Command {
  Input u;
  int iterations = 0;
  bool solved = true;
  double cost = 0;
};

/// A point of a course: on the centre line at station s, with offset n to its left where a position was asked about.
/// `left` and `right` are the half widths at s.
struct CoursePoint {
  double s = 0, n = 0, x = 0, y = 0, yaw = 0, kappa = 0, left = 0, right = 0, grade = 0, bank = 0, lap_fraction = 0;
};

/// A sample of a closed driving line, at arc length s of that line and station `station` of the centre line.
struct LinePoint {
  double s = 0, x = 0, y = 0, yaw = 0, kappa = 0, left = 0, right = 0, station = 0, grade = 0, bank = 0;
};

/// A table parameter: rows x cols numbers, row-major; owned by the host for the life of the instance.
struct Table {
  const double* data = nullptr;
  std::size_t rows = 0, cols = 0;
  constexpr double at(std::size_t row, std::size_t col) const { return data[row * cols + col]; }
};

}  // namespace gripline
