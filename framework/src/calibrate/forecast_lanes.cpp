#include "calibrate/forecast_lanes.hpp"

#include <algorithm>
#include <cmath>

namespace gripline::calibrate::forecast {
namespace {

constexpr double force_limit = 5.0;  // [m/s2]
constexpr double steer_limit = 0.3;  // [rad]

}  // namespace

template <class T>
void Lanes<T>::place(std::size_t lane) {
  const T* const row = x.data() + lane * channels;
  if (s_.road != nullptr)
    at[lane] = s_.road->at(time[lane], value(row[0]), value(row[1]), value(row[2]), hint_[lane]);
  else
    at[lane] = Place{};
  at[lane].t = time[lane] - s_.session.t.front();
}

template <class T>
void Lanes<T>::seek(std::size_t lane) {
  for (std::size_t g = 0; g < groups; ++g) {
    const double shown = time[lane] + value(s_.delay(g));
    row_[lane * groups + g] = static_cast<std::size_t>(
        std::upper_bound(s_.session.t.begin(), s_.session.t.end(), shown + 1e-9) - s_.session.t.begin());
  }
  hint_[lane] = nothing;
  place(lane);
}

template <class T>
void Lanes<T>::start(std::size_t lane) {
  T* const row = x.data() + lane * channels;
  Row<T> target{};
  for (std::size_t c = 0; c < channels; ++c) {
    const T shown = s_.delay(group_of[c]) + time[lane];
    const std::size_t last = std::min(s_.session.row_before(read_until[lane]), s_.session.rows() - 1);
    std::size_t i = s_.session.row_before(value(shown) + 1e-9);
    if (i >= s_.session.rows()) i = 0;
    i = std::min(i, last);
    while (i > 0 && std::isnan(s_.session.at(i, c))) --i;
    const double y = s_.session.at(i, c);
    target[c] = T(std::isnan(y) ? 0.0 : y);
    if (i + 1 <= last && !std::isnan(s_.session.at(i + 1, c)) && value(shown) > s_.session.t[i]) {
      const double slope = (s_.session.at(i + 1, c) - y) / (s_.session.t[i + 1] - s_.session.t[i]);
      if (std::isfinite(slope)) target[c] += (shown - s_.session.t[i]) * slope;
    }
    row[c] = target[c];
  }
  place(lane);
  for (int i = 0; i < 8; ++i) {
    const Row<T> shown = s_.read(row, at[lane]);
    for (std::size_t c = 0; c < channels; ++c) row[c] += target[c] - shown[c];
  }
  if (s_.memory() == 0) return;
  // Steady memory for what is measured, by values: it is forgotten during the pre-roll.
  std::vector<double> motion(channels), steady(s_.memory());
  for (std::size_t c = 0; c < channels; ++c) motion[c] = value(row[c]);
  History<double> past;
  past.samples = s_.commands.sample.data();
  past.count = std::max<std::size_t>(1, std::min(known[lane], s_.commands.sample.size()));
  past.t0 = s_.commands.t0;
  past.dt = s_.commands.dt;
  past.now = time[lane];
  past.hold = Hold::foh;
  const auto now = past.at(0.0);
  const ActingCommand<double> command{now.d, now.delta, now.delta_rate};
  CarBatch<double> batch;
  batch.n = 1;
  batch.motion = motion.data();
  batch.command = &command;
  batch.at = &at[lane];
  batch.history = &past;
  batch.params = s_.values;
  s_.car.start_memory(batch, steady.data());
  std::copy(steady.begin(), steady.end(), memory.begin() + static_cast<std::ptrdiff_t>(lane * s_.memory()));
}

template <class T>
void Lanes<T>::rates(double elapsed, bool begin) {
  for (std::size_t i = 0; i < n; ++i) {
    history_[i] = history(i, time[i] + elapsed);
    const auto now = history_[i].at(T(0));
    command_[i] = {now.d, now.delta, now.delta_rate};
  }
  CarBatch<T> batch;
  batch.n = n;
  batch.motion = stage_x_.data();
  batch.command = command_.data();
  batch.memory = stage_m_.data();
  batch.at = at.data();
  batch.params = s_.params;
  batch.history = history_.data();
  batch.motion_rate = rate_.data();
  batch.memory_rate = rate_m_.data();
  s_.car.rates(batch);
  if (s_.session.prescribed_speed)
    for (std::size_t i = 0; i < n; ++i) prescribe(i, elapsed);
  if (begin) first_rate_ = rate_;
}

/// The speed follows the log's, by the mean acceleration over the step from where it is.
template <class T>
void Lanes<T>::prescribe(std::size_t lane, double) {
  const double shown = time[lane] + step_ + value(s_.delay(group_of[3]));
  const double until = std::min(shown, s_.commands.known_at[std::min(known[lane], s_.commands.known_at.size()) - 1]);
  const double target = s_.session.interpolate(3, until, 10.0);
  const std::size_t i = lane * channels + 3;
  rate_[i] = T(std::isfinite(target) ? (target - value(begin_[i])) / step_ : 0.0);
}

template <class T>
void Lanes<T>::advance(double h) {
  for (std::size_t i = 0; i < n; ++i) place(i);
  begin_ = x;
  step_ = h;
  double slowest = 1e9;
  for (std::size_t i = 0; i < n; ++i)
    slowest = std::min(slowest, std::max(std::abs(value(x[i * channels + 3])), s_.options.v_min));
  const int substeps = std::clamp(static_cast<int>(std::ceil(h * s_.stiffness / slowest / 2.0)), 1, 12);
  const double step = h / substeps;
  constexpr double node[4] = {0, 0.5, 0.5, 1}, weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
  for (int sub = 0; sub < substeps; ++sub) {
    x_start_ = x;
    m_start_ = memory;
    for (int stage = 0; stage < 4; ++stage) {
      if (stage == 0) {
        stage_x_ = x_start_;
        stage_m_ = m_start_;
      } else {
        for (std::size_t i = 0; i < x.size(); ++i) stage_x_[i] = x_start_[i] + rate_[i] * (node[stage] * step);
        for (std::size_t i = 0; i < memory.size(); ++i) stage_m_[i] = m_start_[i] + rate_m_[i] * (node[stage] * step);
      }
      rates((sub + node[stage]) * step, sub == 0 && stage == 0);
      for (std::size_t i = 0; i < x.size(); ++i) x[i] += rate_[i] * (weight[stage] * step);
      for (std::size_t i = 0; i < memory.size(); ++i) memory[i] += rate_m_[i] * (weight[stage] * step);
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    time[i] += h;
    hold_slow(i);
  }
}

/// Tyres that roll slowly do not slip: the yaw rate cannot exceed what full lock gives, and brakes do not drive back.
template <class T>
void Lanes<T>::hold_slow(std::size_t lane) {
  T* const now = x.data() + lane * channels;
  const T* const then = begin_.data() + lane * channels;
  if (value(then[3]) > 0.0 && value(now[3]) < 0.0 && value(command_[lane].d) <= 0.0) now[3] = T(0);
  const double v = std::abs(value(now[3]));
  if (v >= s_.options.v_min) return;
  const double most = v * std::tan(s_.options.delta_max) / s_.options.wheelbase;
  if (std::abs(value(now[5])) > most) now[5] = T(value(now[5]) > 0.0 ? most : -most);
  const double side = 0.5 * s_.options.wheelbase * most;
  if (std::abs(value(now[4])) > side) now[4] = T(value(now[4]) > 0.0 ? side : -side);
}

/// Quadratic through the state and rate at the begin and the state at the end of the step.
template <class T>
void Lanes<T>::interpolate(std::size_t lane, const T& share, T* state) const {
  for (std::size_t c = 0; c < channels; ++c) {
    const std::size_t i = lane * channels + c;
    const T along = first_rate_[i] * step_;
    state[c] = begin_[i] + share * (along + share * (x[i] - begin_[i] - along));
  }
}

template <class T>
void Lanes<T>::correct(double h) {
  const Session& log = s_.session;
  for (std::size_t lane = 0; lane < n; ++lane) {
    Row<T> innovation{};
    std::array<int, channels> count{};
    bool any = false;
    for (std::size_t g = 0; g < groups; ++g) {
      std::size_t& row = row_[lane * groups + g];
      const double end = time[lane] + value(s_.delay(g));
      for (; row < log.rows() && log.t[row] <= end + 1e-9 && log.t[row] <= read_until[lane] + 1e-9; ++row) {
        const T share = (T(log.t[row] - (time[lane] - h)) - s_.delay(g)) * (1.0 / h);
        const Row<T> shown = reading_at(lane, share);
        for (std::size_t c = 0; c < channels; ++c) {
          if (group_of[c] != g || std::isnan(log.at(row, c))) continue;
          innovation[c] += log.at(row, c) - shown[c];
          ++count[c];
          any = true;
        }
      }
    }
    if (any) shift(lane, innovation, count);
  }
}

template <class T>
void Lanes<T>::shift(std::size_t lane, const Row<T>& innovation, const std::array<int, channels>& count) {
  T* const row = x.data() + lane * channels;
  Row<T> target = s_.read(row, at[lane]);
  for (std::size_t c = 0; c < channels; ++c)
    if (count[c] > 0) target[c] += innovation[c] * (1.0 / count[c]);
  Row<T> z{};
  std::copy_n(row, channels, z.begin());
  for (int i = 0; i < 3; ++i) {
    const Row<T> shown = s_.read(z.data(), at[lane]);
    for (std::size_t c = 0; c < channels; ++c) z[c] += target[c] - shown[c];
  }
  T* const steer = memory.data() + (lane + 1) * s_.memory() - 2;
  T* const force = steer + 1;
  if (count[3] > 0 && std::abs(value(z[3])) < s_.options.v_min) {
    // Values only: what a stiff model made of its derivatives at this speed ends here.
    for (std::size_t c = 0; c < channels; ++c) row[c] = T(value(z[c]));
    *steer = *force = T(0);
    return;
  }
  const auto moved = [&](std::size_t c) { return z[c] - row[c]; };
  const T turn = s_[Extra::gain_yaw_rate] * moved(5) + s_[Extra::gain_turn] * moved(2);
  *force += s_[Extra::gain_force] * moved(3);
  const T speed = value(row[3]) > 2.0 * s_.options.v_min ? row[3] : T(2.0 * s_.options.v_min);
  *steer += s_[Extra::gain_steer] * turn * s_.options.wheelbase / speed;
  *force = clamp_value(*force, -force_limit, force_limit);
  *steer = clamp_value(*steer, -steer_limit, steer_limit);
  row[0] += s_[Extra::gain_position] * moved(0);
  row[1] += s_[Extra::gain_position] * moved(1);
  row[2] += s_[Extra::gain_yaw] * moved(2);
  row[3] += s_[Extra::gain_speed] * moved(3);
  row[4] += s_[Extra::gain_lateral] * moved(4);
  row[5] += turn;
}

template class Lanes<double>;
template class Lanes<Dual8>;

}  // namespace gripline::calibrate::forecast
