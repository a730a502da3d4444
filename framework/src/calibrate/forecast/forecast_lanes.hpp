// Copies of a car that move together along a log, each at its own time, and how the log's rows move their states. Parts
// of the forecaster; forecaster.hpp says what they are for.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "calibrate/forecast/forecaster.hpp"
#include "measured/replay/velocity_axes.hpp"
#include "util/numbers.hpp"

namespace gripline::calibrate::forecast {

using measured::Channel;
using measured::CommandGrid;
using measured::difference_of;
using measured::Road;

inline constexpr std::size_t groups = measured::delay_groups;
using measured::delay_group;

template <class T>
using Row = std::array<T, channels>;
inline constexpr std::size_t pending_size = 3 * channels;

/// How fast the car forgets, straight on, by differences of its rates.
struct Stiffness {
  static constexpr std::size_t speeds = 3;
  double lateral = 0;                  // [m/s2] largest eigenvalue of the lateral motion at v_ref, times speed
  std::array<double, speeds> speed{};  // [m/s] rising
  std::array<double, speeds> lag{};    // [1/s] of the fastest lag among the effects, there

  /// Fastest lag at a speed: linear between those, and beyond them as between the last two.
  double lag_at(double v) const;
};

/// Everything that stays the same during a run.
template <class T>
struct Setting {
  const StagedCar& car;
  const ForecastOptions& options;
  const Session& session;
  const CommandGrid& commands;
  const Road* road;
  const T* car_params;                     // with those of its disturbances and frames
  const T* forecast_params;                // by ForecastParameter
  const double* car_values;                // of car_params
  std::size_t steer_memory, force_memory;  // where a car's memory holds the disturbances
  Stiffness stiff;
  double look_back;                 // [s] at which the effects read past commands
  Row<double> cauchy_scale;         // innovation of each channel from which on a row near a jump is hardly followed
  const std::vector<char>& jumped;  // by row: whether the log jumped there or shortly before as no car does
  measured::VelocityAxes<T> axes;   // of its readings

  const T& operator[](ForecastParameter one) const { return forecast_params[static_cast<std::size_t>(one)]; }
  const T& delay(std::size_t group) const {
    return forecast_params[static_cast<std::size_t>(ForecastParameter::delay_position) + group];
  }
  std::size_t memory() const { return static_cast<std::size_t>(car.memory()); }
  double longest_every() const {  // [s]
    return std::max(session.throttle_between.every, session.steering_between.every);
  }

  Row<T> read(const T* x, const Place& at) const {
    Reading<T> r{x[0], x[1], x[2], x[3], x[4], x[5]};
    car.read(&r, 1, &at, car_params);
    return {r.x, r.y, r.yaw, r.vx, r.vy, r.omega};
  }
  /// Moves a state that reads as `reads` towards one that reads as `shown`. Turned axes leave nothing to a next pass,
  /// levers what heading and yaw rate moved in this one, a wrong scale its share.
  void approach(T* x, const Row<T>& shown, const Row<T>& reads) const {
    Row<T> off;
    for (std::size_t c = 0; c < channels; ++c) off[c] = shown[c] - reads[c];
    axes.turn_back(off[Channel::vx], off[Channel::vy]);
    for (std::size_t c = 0; c < channels; ++c) x[c] += off[c];
  }
};

/// States of lanes at some moments, a row for each.
template <class T>
struct LaneStates {
  std::vector<T> x, memory;
  /// What the last step's rows show beyond the states, times what is left of their weights; these weights; their
  /// inverse squares (Lanes::Sums), times them.
  std::vector<T> pending;
};

/// Where a lane begins [s], and how far it may look. Where commands are known further than rows are read it predicts,
/// else it goes along the log.
struct LaneStart {
  double time = 0;         // of the car
  double read_until = 0;   // rows after this are not looked at
  double known_until = 0;  // commands are known so far, and so is a speed that is prescribed
};

/// n copies of the car, each at its own time of the log. Every lane is to be started before the first step.
template <class T>
class Lanes {
 public:
  /// The setting must outlive it.
  Lanes(const Setting<T>& setting, std::size_t n)
      : s_(setting),
        n_(n),
        x_(n * channels),
        memory_(n * setting.memory()),
        pending_(n * pending_size),
        time_(n),
        read_until_(n),
        at_(n),
        begin_(n * channels),
        first_rate_(n * channels),
        known_until_(n),
        known_(n),
        own_(n),
        own_dual_(n),
        own_t0_(n),
        row_(n * groups),
        last_shown_(n),
        last_read_(n * channels),
        hint_(n, not_a_number) {
    no_innovations_.last.fill(T(not_a_number));
    for (auto* v : {&stage_x_, &rate_, &x_start_}) v->resize(n * channels);
    for (auto* v : {&stage_m_, &rate_m_, &m_start_}) v->resize(n * setting.memory());
    command_.resize(n);
    history_.resize(n);
  }

  /// Puts a lane on the measured state at its time, memory steady.
  void start_from_log(std::size_t lane, const LaneStart& start);
  /// Puts a lane on states that were kept, those of a row.
  void start_from(std::size_t lane, const LaneStart& start, const LaneStates<T>& states, std::size_t row);
  /// Keeps the states of a lane for start_from().
  void append_states(std::size_t lane, LaneStates<T>& to) const;
  /// The lanes behind the first `count` move no more, nor do they decide on substeps.
  void keep_first(std::size_t count);
  /// How many lanes move.
  std::size_t size() const { return n_; }
  double time(std::size_t lane) const { return time_[lane]; }

  /// One step of all lanes, `h` [s] long, in as many substeps as the slowest lane needs; returns how many.
  int advance(double h);
  /// The same in so many substeps, 1 or more.
  void advance(double h, int substeps);
  /// Lets the rows that fell into the step just made move the states.
  void correct(double h);
  /// Whether a lane's state is not finite: it stays so.
  bool is_lost(std::size_t lane) const {
    const std::span state(x_.data() + lane * channels, channels);
    return !std::ranges::all_of(state, [](const T& x) { return std::isfinite(value(x)); });
  }
  /// Readings at a time inside the step just made.
  Row<T> reading_at(std::size_t lane, const T& share) const {
    T state[channels];
    interpolate(lane, share, state);
    return s_.read(state, at_[lane]);
  }

 private:
  void set_start(std::size_t lane, const LaneStart& start);
  void set_known_until(std::size_t lane, double until);
  void take_state_of_log(std::size_t lane);
  void find_next_rows(std::size_t lane);
  int substeps_for(double h) const;
  void set_commands(double elapsed);
  void evaluate_rates(bool begin);
  void prescribe_speed(std::size_t lane);
  void update_place(std::size_t lane);
  void interpolate(std::size_t lane, const T& share, T* state) const;
  /// Innovations, ones and inverse squares of the Cauchy scale (0 far from jumps), times their weights at the end of a
  /// step.
  struct Sums {
    Row<T> innovation{}, weight{}, inverse_square{};
  };
  /// What the rows of a step say: what moves the states at its end, and at the end of the next; innovation and inverse
  /// square of the last reading, NaN where a channel had none.
  struct StepInnovations {
    Sums now, later;
    Row<T> last;
    Row<double> last_inverse_square{};
  };
  const StepInnovations& collect_innovations(std::size_t lane, double h);
  void reset_lost_channels(std::size_t lane);
  bool any_due(std::size_t lane) const;
  std::size_t row_at(std::size_t lane, std::size_t group, double time) const;
  bool along_log(std::size_t lane) const { return known_until_[lane] <= read_until_[lane]; }
  T log_at(std::size_t lane, std::size_t channel, const T& shown) const;
  double inverse_square_of(std::size_t row, std::size_t channel) const {
    return s_.jumped[row] != 0 ? 1.0 / (s_.cauchy_scale[channel] * s_.cauchy_scale[channel]) : 0.0;
  }
  static bool any_weight(const StepInnovations& seen, const T* rest);
  Row<T> state_of(std::size_t lane, const Row<T>& now, const Row<T>& shown) const;
  void apply_gains(std::size_t lane, const Row<T>& now, const Row<T>& target);
  void follow_when_slow(std::size_t lane, double h, const StepInnovations& seen, const Row<T>& before);
  T speed_of(std::size_t lane, const T& shown) const;
  void limit_when_slow(std::size_t lane);
  /// Commands up to `now`; as numbers, for what takes no derivatives of them, with V = double.
  template <class V>
  History<V> history(std::size_t lane, double now) const {
    const std::vector<CommandSample<V>>& own = own_commands<V>()[lane];
    History<V> past;
    past.samples = own.empty() ? s_.commands.template data<V>() : own.data();
    past.count = own.empty() ? known_[lane] : own.size();
    past.t0 = own.empty() ? s_.commands.t0 : own_t0_[lane];
    past.dt = s_.commands.dt;
    past.now = now;
    past.hold = Hold::foh;
    return past;
  }
  template <class V>
  const std::vector<std::vector<CommandSample<V>>>& own_commands() const {
    if constexpr (std::is_same_v<V, double>)
      return own_;
    else
      return own_dual_;
  }

  const Setting<T>& s_;
  std::size_t n_;                          // those that move: the first
  std::vector<T> x_, memory_, pending_;    // by lane, as in LaneStates
  std::vector<double> time_, read_until_;  // [s]
  std::vector<Place> at_;
  std::vector<T> begin_, first_rate_, stage_x_, rate_, x_start_, stage_m_, rate_m_, m_start_;
  std::vector<ActingCommand<T>> command_;
  std::vector<History<T>> history_;
  StagedCar::Scratch<T> scratch_;
  std::vector<double> known_until_;  // [s] commands
  std::vector<std::size_t> known_;   // samples of both commands
  // Of predictions, where commands are read every so often; else empty. The second is left empty where T = double.
  std::vector<std::vector<CommandSample<double>>> own_;
  std::vector<std::vector<CommandSample<Dual8>>> own_dual_;
  std::vector<double> own_t0_;      // time of its first sample [s]
  std::vector<std::size_t> row_;    // next row by lane and group
  std::vector<double> last_shown_;  // [s] time of the last row that a lane looks at
  std::vector<double> last_read_;   // [s] by lane and channel: time of the last row that had it
  std::vector<double> hint_;
  double step_ = 0;  // length of the step just made [s]
  StepInnovations innovations_, no_innovations_;
};

extern template class Lanes<double>;
extern template class Lanes<Dual8>;

}  // namespace gripline::calibrate::forecast
