#include "calibrate/forecast/forecast_lanes.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "car/integrator.hpp"

namespace gripline::calibrate::forecast {
namespace {

constexpr double force_limit = 5.0;  // [m/s2]
constexpr double steer_limit = 0.3;  // [rad]
// [s] without a reading of a channel after which a model's own way is no better than none: the next reading is taken as
// it is.
constexpr double lost_after = 3.0;

bool same(double a, double b) { return a == b; }
bool same(const Dual8& a, const Dual8& b) {
  return a.v == b.v && std::equal(std::begin(a.d), std::end(a.d), std::begin(b.d));
}

/// From 0 to 1 as s goes there, level at both ends.
template <class T>
T eased(const T& s) {
  if (!(value(s) > 0.0)) return T(0);
  if (!(value(s) < 1.0)) return T(1);
  return s * s * (3.0 - 2.0 * s);
}

}  // namespace

double Stiffness::lag_at(double v) const {
  const std::size_t i = v < speed[1] ? 0 : 1;
  const double share = (v - speed[i]) / (speed[i + 1] - speed[i]);
  return std::max(0.0, lag[i] + share * (lag[i + 1] - lag[i]));
}

template <class T>
void Lanes<T>::set_start(std::size_t lane, const LaneStart& start) {
  time_[lane] = start.time;
  read_until_[lane] = start.read_until;
  set_known_until(lane, start.known_until);
}

template <class T>
void Lanes<T>::start_from_log(std::size_t lane, const LaneStart& start) {
  set_start(lane, start);
  take_state_of_log(lane);
  find_next_rows(lane);
}

template <class T>
void Lanes<T>::start_from(std::size_t lane, const LaneStart& start, const LaneStates<T>& states, std::size_t row) {
  set_start(lane, start);
  const auto copy = [&](const std::vector<T>& rows, std::size_t size, std::vector<T>& to) {
    std::copy_n(rows.begin() + static_cast<std::ptrdiff_t>(row * size), size,
                to.begin() + static_cast<std::ptrdiff_t>(lane * size));
  };
  copy(states.x, channels, x_);
  copy(states.memory, s_.memory(), memory_);
  copy(states.pending, pending_size, pending_);
  find_next_rows(lane);
}

template <class T>
void Lanes<T>::append_states(std::size_t lane, LaneStates<T>& to) const {
  const auto append = [lane](const std::vector<T>& rows, std::size_t size, std::vector<T>& end) {
    const auto first = rows.begin() + static_cast<std::ptrdiff_t>(lane * size);
    end.insert(end.end(), first, first + static_cast<std::ptrdiff_t>(size));
  };
  append(x_, channels, to.x);
  append(memory_, s_.memory(), to.memory);
  append(pending_, pending_size, to.pending);
}

template <class T>
void Lanes<T>::keep_first(std::size_t count) {
  n_ = std::min(n_, count);
}

/// Commands are known up to `until`, and so is a speed that is prescribed.
template <class T>
void Lanes<T>::set_known_until(std::size_t lane, double until) {
  const CommandGrid& all = s_.commands;
  const Session& log = s_.session;
  known_until_[lane] = until;
  known_[lane] = std::clamp<std::size_t>(all.shown_by(until), 1, all.sample.size());
  own_[lane].clear();
  own_dual_[lane].clear();
  if (along_log(lane) || !(s_.longest_every() > 0.0)) return;
  const double begin = time_[lane] - s_.look_back - 2.0 * all.dt;
  const auto first = static_cast<std::size_t>(std::max(0.0, std::floor((begin - all.t0) / all.dt)));
  const std::size_t row = std::min(log.row_before(until + 1e-9), log.rows() - 1);
  all.copy_shown(until, log.command[row], first, own_[lane]);
  if constexpr (!std::is_same_v<T, double>) all.copy_shown(until, log.command[row], first, own_dual_[lane]);
  own_t0_[lane] = all.t0 + static_cast<double>(std::min(first, known_[lane] - 1)) * all.dt;
}

template <class T>
void Lanes<T>::update_place(std::size_t lane) {
  const T* const row = x_.data() + lane * channels;
  if (s_.road != nullptr)
    at_[lane] =
        s_.road->at(time_[lane], value(row[Channel::x]), value(row[Channel::y]), value(row[Channel::yaw]), hint_[lane]);
  else
    at_[lane] = Place{};
  at_[lane].t = time_[lane] - s_.session.t.front();
}

/// Of every channel, from the lane's state and time on.
template <class T>
void Lanes<T>::find_next_rows(std::size_t lane) {
  for (std::size_t g = 0; g < groups; ++g) {
    const double shown = time_[lane] + value(s_.delay(g));
    row_[lane * groups + g] = static_cast<std::size_t>(
        std::upper_bound(s_.session.t.begin(), s_.session.t.end(), shown + 1e-9) - s_.session.t.begin());
  }
  const Session& log = s_.session;
  last_shown_[lane] = log.t[std::min(log.row_before(read_until_[lane] + 1e-9), log.rows() - 1)];
  hint_[lane] = not_a_number;
  for (std::size_t c = 0; c < channels; ++c) {
    std::size_t next = std::max<std::size_t>(1, row_[lane * groups + delay_group[c]]);
    while (next > 1 && std::isnan(log.at(next - 1, c)) && time_[lane] - log.t[next - 1] <= lost_after) --next;
    last_read_[lane * channels + c] =
        std::isnan(log.at(next - 1, c)) ? time_[lane] - 2.0 * lost_after : log.t[next - 1];
  }
  update_place(lane);
}

/// The measured state at the lane's time, memory steady, nothing pending.
template <class T>
void Lanes<T>::take_state_of_log(std::size_t lane) {
  T* const row = x_.data() + lane * channels;
  Row<T> target{};
  for (std::size_t c = 0; c < channels; ++c) {
    const T shown = s_.delay(delay_group[c]) + time_[lane];
    const std::size_t last = std::min(s_.session.row_before(read_until_[lane]), s_.session.rows() - 1);
    std::size_t i = s_.session.row_before(value(shown) + 1e-9);
    if (i >= s_.session.rows()) i = 0;
    i = std::min(i, last);
    while (i > 0 && std::isnan(s_.session.at(i, c))) --i;
    // A pose or speed that was not read yet, as the heading of a car that stands, begins where it will: not at 0. That
    // channel judges no start before its first reading.
    if (c <= measured::Channel::vx && s_.session.has[c])
      while (i < last && std::isnan(s_.session.at(i, c))) ++i;
    const double y = s_.session.at(i, c);
    target[c] = T(std::isnan(y) ? 0.0 : y);
    if (i + 1 <= last && !std::isnan(s_.session.at(i + 1, c)) && value(shown) > s_.session.t[i]) {
      const double slope = (s_.session.at(i + 1, c) - y) / (s_.session.t[i + 1] - s_.session.t[i]);
      if (std::isfinite(slope)) target[c] += (shown - s_.session.t[i]) * slope;
    }
    row[c] = target[c];
  }
  std::fill_n(pending_.begin() + static_cast<std::ptrdiff_t>(lane * pending_size), pending_size, T(0));
  update_place(lane);
  for (int i = 0; i < 8; ++i) s_.approach(row, target, s_.read(row, at_[lane]));
  if (s_.memory() == 0) return;
  // Steady memory for what is measured, by values: it is forgotten during the pre-roll.
  std::vector<double> motion(channels), steady(s_.memory());
  for (std::size_t c = 0; c < channels; ++c) motion[c] = value(row[c]);
  const History<double> past = history<double>(lane, time_[lane]);
  const auto now = past.at(0.0);
  const ActingCommand<double> command{now.d, now.delta, now.delta_rate};
  CarBatch<double> batch;
  batch.n = 1;
  batch.motion = motion.data();
  batch.command = &command;
  batch.at = &at_[lane];
  batch.history = &past;
  batch.params = s_.car_values;
  s_.car.start_memory(batch, steady.data());
  std::copy(steady.begin(), steady.end(), memory_.begin() + static_cast<std::ptrdiff_t>(lane * s_.memory()));
}

template <class T>
void Lanes<T>::set_commands(double elapsed) {
  for (std::size_t i = 0; i < n_; ++i) {
    history_[i] = history<T>(i, time_[i] + elapsed);
    const auto now = history<double>(i, time_[i] + elapsed).at(0.0);
    command_[i] = {T(now.d), T(now.delta), T(now.delta_rate)};
  }
}

template <class T>
void Lanes<T>::evaluate_rates(bool begin) {
  CarBatch<T> batch;
  batch.n = n_;
  batch.motion = stage_x_.data();
  batch.command = command_.data();
  batch.memory = stage_m_.data();
  batch.at = at_.data();
  batch.params = s_.car_params;
  batch.history = history_.data();
  batch.motion_rate = rate_.data();
  batch.memory_rate = rate_m_.data();
  s_.car.rates(batch, scratch_);
  if (s_.session.prescribed_speed)
    for (std::size_t i = 0; i < n_; ++i) prescribe_speed(i);
  if (begin) first_rate_ = rate_;
}

/// The speed follows the log's, by the mean acceleration over the step from where it is.
template <class T>
void Lanes<T>::prescribe_speed(std::size_t lane) {
  // A straight line over gaps says how fast the car went, whatever it did.
  constexpr double longest_gap = 10.0;  // [s]
  const Session& log = s_.session;
  const T shown = time_[lane] + step_ + s_.delay(delay_group[Channel::vx]);
  double until = known_until_[lane];
  if (along_log(lane)) {  // what is kept for a start must not have seen rows after it
    const std::size_t row = log.row_before(value(shown) + 1e-9);
    const std::size_t next = row >= log.rows() ? 0 : log.t[row] < value(shown) - 1e-9 ? row + 1 : row;
    until = std::min(until, log.t[std::min(next, log.rows() - 1)]);
  }
  const double at_most = std::min(value(shown), until);
  const auto [speed, slope] = log.bridge(Channel::vx, at_most, until, longest_gap);
  const std::size_t first = lane * channels, i = first + Channel::vx;
  rate_[i] = T(0);
  if (std::isnan(speed)) return;
  T target(speed);
  if (value(shown) <= until) target += (shown - at_most) * slope;  // its derivative only
  // What axes show of the car's own side speed, which are turned, is none of its speed.
  target = (target - s_.axes.sine * begin_[first + Channel::vy]) / s_.axes.cosine;
  rate_[i] = (target - begin_[i]) * (1.0 / step_);
}

/// As many as the slowest lane needs.
template <class T>
int Lanes<T>::substeps_for(double h) const {
  double slowest = 1e9, lag = 0.0;
  for (std::size_t i = 0; i < n_; ++i) {
    const double v = std::abs(value(x_[i * channels + Channel::vx]));
    slowest = std::min(slowest, std::max(v, s_.options.v_min));
    lag = std::max(lag, s_.stiff.lag_at(v));
  }
  // A lag longer than a substep is followed closely enough that one more substep does not show in what is predicted.
  const double pace = h * std::max(s_.stiff.lateral / slowest / 2.0, lag);
  constexpr double most = 12;
  return pace < most ? std::max(1, static_cast<int>(std::ceil(pace - 1e-9))) : static_cast<int>(most);
}

template <class T>
int Lanes<T>::advance(double h) {
  const int substeps = substeps_for(h);
  advance(h, substeps);
  return substeps;
}

template <class T>
void Lanes<T>::advance(double h, int substeps) {
  for (std::size_t i = 0; i < n_; ++i) update_place(i);
  begin_ = x_;
  step_ = h;
  const double step = h / substeps;
  const std::size_t states = n_ * channels, memories = n_ * s_.memory();
  // Not by a Stepper: rates follow a prescribed speed, and of the stages before only the last one's are kept, from
  // which each stage starts: a_ij = 0 but for j = i - 1, where it is c_i.
  static const Tableau& rk4 = *find_tableau("rk4");
  const auto node = rk4.c, weight = rk4.b;
  for (int sub = 0; sub < substeps; ++sub) {
    x_start_ = x_;
    m_start_ = memory_;
    for (std::size_t stage = 0; stage < 4; ++stage) {
      if (stage == 0) {
        stage_x_ = x_start_;
        stage_m_ = m_start_;
      } else {
        for (std::size_t i = 0; i < states; ++i) stage_x_[i] = x_start_[i] + rate_[i] * (node[stage] * step);
        for (std::size_t i = 0; i < memories; ++i) stage_m_[i] = m_start_[i] + rate_m_[i] * (node[stage] * step);
      }
      if (stage == 0 || node[stage] != node[stage - 1]) set_commands((sub + node[stage]) * step);
      evaluate_rates(sub == 0 && stage == 0);
      for (std::size_t i = 0; i < states; ++i) x_[i] += rate_[i] * (weight[stage] * step);
      for (std::size_t i = 0; i < memories; ++i) memory_[i] += rate_m_[i] * (weight[stage] * step);
    }
  }
  for (std::size_t i = 0; i < n_; ++i) {
    time_[i] += h;
    limit_when_slow(i);
  }
}

/// Tyres that roll slowly do not slip: the yaw rate cannot exceed what full lock gives, and brakes do not drive back.
template <class T>
void Lanes<T>::limit_when_slow(std::size_t lane) {
  T* const now = x_.data() + lane * channels;
  const T* const then = begin_.data() + lane * channels;
  if (value(then[Channel::vx]) > 0.0 && value(now[Channel::vx]) < 0.0 && value(command_[lane].d) <= 0.0)
    now[Channel::vx] = T(0);
  const T v = value(now[Channel::vx]) < 0.0 ? -now[Channel::vx] : now[Channel::vx];
  if (value(v) >= s_.options.v_min) return;
  const T most = v * (std::tan(s_.options.delta_max) / s_.options.wheelbase);
  if (std::abs(value(now[Channel::yaw_rate])) > value(most))
    now[Channel::yaw_rate] = value(now[Channel::yaw_rate]) > 0.0 ? most : -most;
  const T side = 0.5 * s_.options.wheelbase * most;
  if (std::abs(value(now[Channel::vy])) > value(side)) now[Channel::vy] = value(now[Channel::vy]) > 0.0 ? side : -side;
}

/// Quadratic through the state and rate at the begin and the state at the end of the step.
template <class T>
void Lanes<T>::interpolate(std::size_t lane, const T& share, T* state) const {
  for (std::size_t c = 0; c < channels; ++c) {
    const std::size_t i = lane * channels + c;
    const T along = first_rate_[i] * step_;
    state[c] = begin_[i] + share * (along + share * (x_[i] - begin_[i] - along));
  }
}

// A row that shows the car at a share s of a step moves the states with the weight 1 - w(s) at the end of this step and
// w(s) at the end of the next, by what it then still shows beyond them: nothing jumps where a delay carries a row over
// the end of a step.
template <class T>
void Lanes<T>::correct(double h) {
  for (std::size_t lane = 0; lane < n_; ++lane) {
    T* const rest = pending_.data() + lane * pending_size;
    const T* const row = x_.data() + lane * channels;
    const bool due = any_due(lane);
    const StepInnovations& seen = due ? collect_innovations(lane, h) : no_innovations_;
    if (due) reset_lost_channels(lane);
    if (!any_weight(seen, rest)) {  // as along all of a prediction
      follow_when_slow(lane, h, no_innovations_, {});
      std::fill_n(rest, pending_size, T(0));
      continue;
    }
    const Row<T> before = s_.read(row, at_[lane]);
    Row<T> target = before;
    bool any = false;
    for (std::size_t c = 0; c < channels; ++c) {
      const T weight = seen.now.weight[c] + rest[channels + c];
      if (!(value(weight) > 0.0)) continue;
      any = true;
      const T sum = seen.now.innovation[c] + rest[c];
      // After a jump that no car makes, of another marker or satellite, rows are hardly followed (Cauchy's weight).
      const T mean = sum / weight, inverse_square = (seen.now.inverse_square[c] + rest[2 * channels + c]) / weight;
      // Rows of one step count together as one.
      target[c] += (value(weight) > 1.0 ? mean : sum) / (1.0 + mean * mean * inverse_square);
    }
    if (any) apply_gains(lane, before, target);
    follow_when_slow(lane, h, seen, before);
    const Row<T> after = s_.read(row, at_[lane]);
    for (std::size_t c = 0; c < channels; ++c) {
      rest[c] = seen.later.innovation[c] - seen.later.weight[c] * (after[c] - before[c]);
      rest[channels + c] = seen.later.weight[c];
      rest[2 * channels + c] = seen.later.inverse_square[c];
    }
  }
}

/// Puts the channels of the rows seen now that were not read for long, or never, on what they show.
template <class T>
void Lanes<T>::reset_lost_channels(std::size_t lane) {
  std::array<bool, channels> fresh{};
  bool any = false;
  for (std::size_t c = 0; c < channels; ++c) {
    if (std::isnan(value(innovations_.last[c]))) continue;
    const double now = time_[lane] + value(s_.delay(delay_group[c]));
    double& last = last_read_[lane * channels + c];
    fresh[c] = now - last > lost_after;
    any = any || fresh[c];
    last = now;
  }
  if (!any) return;
  T* const row = x_.data() + lane * channels;
  T* const rest = pending_.data() + lane * pending_size;
  const Row<T> before = s_.read(row, at_[lane]);
  Row<T> target = before;
  for (std::size_t c = 0; c < channels; ++c)
    if (fresh[c]) target[c] += innovations_.last[c];
  const Row<T> z = state_of(lane, before, target);
  for (std::size_t c = 0; c < channels; ++c) {
    if (!fresh[c]) continue;
    row[c] = z[c];
    innovations_.last[c] = T(0);
    for (Sums* const sums : {&innovations_.now, &innovations_.later})
      sums->innovation[c] = sums->weight[c] = sums->inverse_square[c] = T(0);
    rest[c] = rest[channels + c] = rest[2 * channels + c] = T(0);
  }
}

/// Whether any row seen now or a step ago has weight.
template <class T>
bool Lanes<T>::any_weight(const StepInnovations& seen, const T* rest) {
  for (std::size_t c = 0; c < channels; ++c)
    if (value(seen.now.weight[c]) > 0.0 || value(seen.later.weight[c]) > 0.0 || value(rest[channels + c]) > 0.0)
      return true;
  return false;
}

/// Whether any row falls into the step just made.
template <class T>
bool Lanes<T>::any_due(std::size_t lane) const {
  const Session& log = s_.session;
  for (std::size_t g = 0; g < groups; ++g) {
    const std::size_t row = row_[lane * groups + g];
    if (row >= log.rows()) continue;
    if (log.t[row] <= time_[lane] + value(s_.delay(g)) + 1e-9 && log.t[row] <= read_until_[lane] + 1e-9) return true;
  }
  return false;
}

/// The last row at or before a time: nearly always the one before the next that a group of channels waits for.
template <class T>
std::size_t Lanes<T>::row_at(std::size_t lane, std::size_t group, double time) const {
  const std::vector<double>& t = s_.session.t;
  const std::size_t next = row_[lane * groups + group];
  const bool before = next > 0 && t[next - 1] <= time && (next == t.size() || t[next] > time);
  return before ? next - 1 : s_.session.row_before(time);
}

template <class T>
const typename Lanes<T>::StepInnovations& Lanes<T>::collect_innovations(std::size_t lane, double h) {
  const Session& log = s_.session;
  StepInnovations& seen = innovations_;
  seen = no_innovations_;
  for (std::size_t g = 0, next = 0; g < groups; g = next) {
    std::size_t row = row_[lane * groups + g];
    // Channels of one clock are read together.
    next = g + 1;
    while (next < groups && row_[lane * groups + next] == row && same(s_.delay(next), s_.delay(g))) ++next;
    const double end = time_[lane] + value(s_.delay(g));
    for (; row < log.rows() && log.t[row] <= end + 1e-9 && log.t[row] <= read_until_[lane] + 1e-9; ++row) {
      const T share = (T(log.t[row] - (time_[lane] - h)) - s_.delay(g)) * (1.0 / h);
      const Row<T> shown = reading_at(lane, share);
      const T late = eased(share), soon = 1.0 - late;
      for (std::size_t c = 0; c < channels; ++c) {
        if (delay_group[c] < g || delay_group[c] >= next || std::isnan(log.at(row, c))) continue;
        const T innovation = difference_of(c, T(log.at(row, c)), shown[c]);
        const double inverse_square = inverse_square_of(row, c);
        seen.last[c] = innovation;
        seen.last_inverse_square[c] = inverse_square;
        for (const auto& [sums, weight] : {std::pair(&seen.now, soon), std::pair(&seen.later, late)}) {
          sums->innovation[c] += weight * innovation;
          sums->weight[c] += weight;
          sums->inverse_square[c] += weight * inverse_square;
        }
      }
    }
    std::fill_n(row_.begin() + static_cast<std::ptrdiff_t>(lane * groups + g), next - g, row);
  }
  return seen;
}

/// What the log shows of a channel, linear between rows; NaN where it shows nothing.
template <class T>
T Lanes<T>::log_at(std::size_t lane, std::size_t channel, const T& shown) const {
  const Session& log = s_.session;
  const double now = value(shown);
  const std::size_t i = row_at(lane, delay_group[channel], now + 1e-9);
  T reading(log.interpolate_from(i, channel, now));
  if (i + 1 >= log.rows()) return reading;
  const double slope = (log.at(i + 1, channel) - log.at(i, channel)) / (log.t[i + 1] - log.t[i]);
  if (std::isfinite(slope)) reading += (shown - now) * slope;  // its derivative only
  return reading;
}

/// The state near the lane's, which reads `now`, that reads `shown`.
template <class T>
Row<T> Lanes<T>::state_of(std::size_t lane, const Row<T>& now, const Row<T>& shown) const {
  Row<T> z{}, reads = now;
  std::copy_n(x_.begin() + static_cast<std::ptrdiff_t>(lane * channels), channels, z.begin());
  // Of a sensor whose scale is wrong the third pass leaves the cube of its error.
  for (int i = 0; i < 3; ++i) {
    if (i > 0) reads = s_.read(z.data(), at_[lane]);
    s_.approach(z.data(), shown, reads);
  }
  return z;
}

template <class T>
void Lanes<T>::apply_gains(std::size_t lane, const Row<T>& now, const Row<T>& target) {
  T* const row = x_.data() + lane * channels;
  const Row<T> z = state_of(lane, now, target);
  T* const remembered = memory_.data() + lane * s_.memory();
  T *const steer = remembered + s_.steer_memory, *const force = remembered + s_.force_memory;
  const auto moved = [&](std::size_t c) { return z[c] - row[c]; };
  const T turn = s_[ForecastParameter::gain_yaw_rate] * moved(Channel::yaw_rate) +
                 s_[ForecastParameter::gain_turn] * moved(Channel::yaw);
  *force += s_[ForecastParameter::gain_force] * moved(Channel::vx);
  const T speed = value(row[Channel::vx]) > 2.0 * s_.options.v_min ? row[Channel::vx] : T(2.0 * s_.options.v_min);
  *steer += s_[ForecastParameter::gain_steer] * turn * s_.options.wheelbase / speed;
  *force = clamp_value(*force, -force_limit, force_limit);
  *steer = clamp_value(*steer, -steer_limit, steer_limit);
  row[Channel::x] += s_[ForecastParameter::gain_position] * moved(Channel::x);
  row[Channel::y] += s_[ForecastParameter::gain_position] * moved(Channel::y);
  row[Channel::yaw] += s_[ForecastParameter::gain_yaw] * moved(Channel::yaw);
  row[Channel::vx] += s_[ForecastParameter::gain_speed] * moved(Channel::vx);
  row[Channel::vy] += s_[ForecastParameter::gain_lateral] * moved(Channel::vy);
  row[Channel::yaw_rate] += turn;
}

/// How fast the car is by the log; by its model where the log's last word on that is old.
template <class T>
T Lanes<T>::speed_of(std::size_t lane, const T& shown) const {
  constexpr double old = 0.3;  // [s]
  T v = log_at(lane, Channel::vx, shown);
  if (std::isnan(value(v))) v = T(s_.session.bridge(Channel::vx, value(shown), value(shown), old).value);
  if (std::isnan(value(v))) v = x_[lane * channels + Channel::vx];
  return value(v) < 0.0 ? -v : v;
}

/// Where the car hardly moves, its state becomes the one that is read, with the derivatives of delays and frames: a
/// model is stiff there, and says little. All of it below v_min, less and less of it up to a quarter above. A channel
/// that has no reading around the step's end moves by the last one in the step. Rows near jumps count less, as
/// elsewhere.
template <class T>
void Lanes<T>::follow_when_slow(std::size_t lane, double h, const StepInnovations& seen, const Row<T>& before) {
  const Session& log = s_.session;
  const double last = last_shown_[lane];
  const auto shown_at = [&](std::size_t g) {
    const T now = time_[lane] + s_.delay(g);
    return value(now) < last ? now : T(last);
  };
  const T v = speed_of(lane, shown_at(delay_group[Channel::vx]));
  if (!(value(v) < 1.25 * s_.options.v_min)) return;
  const T slow = eased((1.25 * s_.options.v_min - v) * (1.0 / (0.25 * s_.options.v_min)));
  Row<T> target = s_.read(x_.data() + lane * channels, at_[lane]);
  const Row<T> now = target;
  T most(0);
  for (std::size_t g = 0; g < groups; ++g) {
    // Of a step in which the log ends for this start: what it showed then, and the model's way from there.
    const T left = (T(last - (time_[lane] - h)) - s_.delay(g)) * (1.0 / h);
    if (!(value(left) > 0.0)) continue;
    const T weight = slow * eased(left);
    if (value(weight) > value(most)) most = weight;
    const T shown = shown_at(g);
    for (std::size_t c = 0; c < channels; ++c) {
      if (delay_group[c] != g) continue;
      T off = seen.last[c] - (now[c] - before[c]);
      double inverse_square = seen.last_inverse_square[c];
      const T reading = value(left) < 1.0 ? T(not_a_number) : log_at(lane, c, shown);
      if (!std::isnan(value(reading))) {
        const std::size_t row = std::min(row_at(lane, g, value(shown) + 1e-9), log.rows() - 1);
        off = difference_of(c, reading, now[c]);
        inverse_square =
            std::max(inverse_square_of(row, c), log.t[row] < value(shown) - 1e-9 ? inverse_square_of(row + 1, c) : 0.0);
      }
      if (!std::isnan(value(off))) target[c] += weight * off / (1.0 + off * off * inverse_square);
    }
  }
  if (!(value(most) > 0.0)) return;
  const Row<T> z = state_of(lane, now, target);
  std::copy(z.begin(), z.end(), x_.begin() + static_cast<std::ptrdiff_t>(lane * channels));
  T* const remembered = memory_.data() + lane * s_.memory();
  for (const std::size_t disturbance : {s_.steer_memory, s_.force_memory}) remembered[disturbance] *= 1.0 - most;
}

template class Lanes<double>;
template class Lanes<Dual8>;

}  // namespace gripline::calibrate::forecast
