#include "calibrate/forecaster.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace gripline::calibrate {
namespace {

using measured::CommandGrid;
using measured::Road;

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t groups = 4;  // of channels with one delay: position, yaw, velocity, yaw rate
constexpr std::array<std::size_t, channels> group_of = {0, 0, 1, 2, 2, 3};
constexpr double force_limit = 5.0;  // [m/s2]
constexpr double steer_limit = 0.3;  // [rad]

template <class T>
using Row = std::array<T, channels>;

/// Everything that stays the same during a run.
template <class T>
struct Setting {
  const StagedCar& car;
  const ForecastOptions& options;
  const Session& session;
  const CommandGrid& commands;
  const Road* road;
  const T* params;  // of the car
  const T* extra;
  const double* values;  // of params
  double stiffness;      // [m/s2] eigenvalue of the lateral motion times speed

  const T& operator[](Extra e) const { return extra[static_cast<std::size_t>(e)]; }
  const T& delay(std::size_t group) const { return extra[static_cast<std::size_t>(Extra::delay_position) + group]; }
  std::size_t memory() const { return static_cast<std::size_t>(car.memory()); }

  Row<T> read(const T* x, const Place& at) const {
    Reading<T> r{x[0], x[1], x[2], x[3], x[4], x[5]};
    car.read(&r, 1, &at, params);
    return {r.x, r.y, r.yaw, r.vx, r.vy, r.omega};
  }
};

/// n copies of the car, each at its own time of the log.
template <class T>
class Lanes {
 public:
  Lanes(const Setting<T>& setting, std::size_t n)
      : n(n),
        x(n * channels),
        memory(n * setting.memory()),
        time(n),
        read_until(n),
        known(n),
        at(n),
        s_(setting),
        begin_(n * channels),
        first_rate_(n * channels),
        row_(n * groups),
        hint_(n, nothing) {
    for (auto* v : {&stage_x_, &rate_, &sum_x_, &x_start_}) v->resize(n * channels);
    for (auto* v : {&stage_m_, &rate_m_, &sum_m_, &m_start_}) v->resize(n * setting.memory());
    command_.resize(n);
    history_.resize(n);
  }

  std::size_t n;
  std::vector<T> x, memory;
  std::vector<double> time;        // of the car
  std::vector<double> read_until;  // rows after this are not looked at
  std::vector<std::size_t> known;  // commands
  std::vector<Place> at;

  /// Puts a lane on the measured state at its time, memory steady.
  void start(std::size_t lane);
  /// To be called once x, memory and time of a lane are set: finds the next row of every channel.
  void seek(std::size_t lane);
  /// One step of all lanes.
  void advance(double h);
  /// Lets the rows that fell into the step just made move the states.
  void correct(double h);
  /// Readings at a time inside the step just made.
  Row<T> reading_at(std::size_t lane, const T& share) const {
    T state[channels];
    interpolate(lane, share, state);
    return s_.read(state, at[lane]);
  }

 private:
  void rates(double elapsed, bool begin);
  void prescribe(std::size_t lane, double elapsed);
  void place(std::size_t lane);
  void interpolate(std::size_t lane, const T& share, T* state) const;
  void shift(std::size_t lane, const Row<T>& innovation, const std::array<int, channels>& count);
  void hold_slow(std::size_t lane);
  History<T> history(std::size_t lane, double now) const {
    History<T> past;
    past.samples = s_.commands.template data<T>();
    past.count = std::max<std::size_t>(1, std::min(known[lane], s_.commands.sample.size()));
    past.t0 = s_.commands.t0;
    past.dt = s_.commands.dt;
    past.now = now;
    past.hold = Hold::foh;
    return past;
  }

  const Setting<T>& s_;
  std::vector<T> begin_, first_rate_, stage_x_, rate_, sum_x_, x_start_, stage_m_, rate_m_, sum_m_, m_start_;
  std::vector<ActingCommand<T>> command_;
  std::vector<History<T>> history_;
  std::vector<std::size_t> row_;  // next row by lane and group
  std::vector<double> hint_;
  double step_ = 0;  // length of the step just made [s]
};

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

/// A stretch of rows without long gaps and the observer's states along it, on an even grid of the car's time.
template <class T>
struct Stretch {
  double begin = 0, end = 0;  // rows [s]
  std::size_t steps = 0;
  std::vector<T> x, memory;  // steps + 1 rows
};

template <class T>
class Run {
 public:
  Run(const Setting<T>& setting) : s_(setting) {
    latest_ = earliest_ = value(s_.delay(0));
    for (std::size_t g = 0; g < groups; ++g) {
      latest_ = std::max(latest_, value(s_.delay(g)));
      earliest_ = std::min(earliest_, value(s_.delay(g)));
    }
    split();
  }

  /// Carries the states along the log as far as starts need them.
  void observe(const Starts& starts) {
    std::vector<Lane> lanes = wanted_lanes(starts);
    // The slowest lane decides on the steps of all: like goes with like.
    if (s_.options.lanes > 1)
      std::stable_sort(lanes.begin(), lanes.end(), [](const Lane& a, const Lane& b) { return a.slowest < b.slowest; });
    const std::size_t at_once = s_.options.lanes;
    for (std::size_t i = 0; i < lanes.size(); i += at_once)
      observe(std::span(lanes).subspan(i, std::min(at_once, lanes.size() - i)));
  }

  void predict(const Starts& starts, std::vector<T>& predicted) {
    const std::size_t h = starts.horizons.size();
    predicted.assign(starts.time.size() * h * channels, T(nothing));
    std::vector<std::size_t> usable;
    for (std::size_t i = 0; i < starts.time.size(); ++i)
      if (find(starts.time[i]) < stretches_.size()) usable.push_back(i);
    // The slowest lane decides on the steps of all: like goes with like.
    if (s_.options.lanes > 1)
      std::stable_sort(usable.begin(), usable.end(), [&](std::size_t a, std::size_t b) {
        return speed_at(starts.time[a]) < speed_at(starts.time[b]);
      });
    const std::size_t at_once = s_.options.lanes;
    for (std::size_t i = 0; i < usable.size(); i += at_once)
      predict(starts, std::span(usable).subspan(i, std::min(at_once, usable.size() - i)), predicted);
  }

 private:
  struct Lane {
    std::size_t stretch, first, last;  // grid points [first, last) are kept
    double slowest = 0;                // [m/s] about the least speed on the way
  };

  /// Grid point from which a start rolls on; negative where it begins before the observer has seen enough.
  double steps_before(const Stretch<T>& from, double start) const {
    return std::floor((start - std::max(latest_, 0.0) - from.begin) / s_.options.step + 1e-9);
  }

  /// One lane per block of the log that holds a start, from the first to the last grid point that is asked for.
  std::vector<Lane> wanted_lanes(const Starts& starts) const {
    const auto block = std::max<std::size_t>(1, static_cast<std::size_t>(s_.options.block / s_.options.step));
    std::map<std::pair<std::size_t, std::size_t>, Lane> blocks;
    for (const double start : starts.time) {
      const std::size_t i = find(start);
      if (i >= stretches_.size()) continue;
      const double back = steps_before(stretches_[i], start);
      if (back < 0.0) continue;
      const std::size_t k = std::min(static_cast<std::size_t>(back), stretches_[i].steps);
      const auto [at, fresh] = blocks.try_emplace({i, k / block}, Lane{i, k, k + 1});
      at->second.first = std::min(at->second.first, k);
      at->second.last = std::max(at->second.last, k + 1);
    }
    std::vector<Lane> lanes;
    for (auto& [where, lane] : blocks) {
      lane.slowest = slowest_in(lane);
      lanes.push_back(lane);
    }
    return lanes;
  }

  double slowest_in(const Lane& lane) const {
    constexpr double often = 0.2;  // [s]
    const double begin = stretches_[lane.stretch].begin;
    double least = speed_at(begin + static_cast<double>(lane.last) * s_.options.step);
    for (double t = static_cast<double>(lane.first) * s_.options.step - s_.options.pre_roll;
         t < static_cast<double>(lane.last) * s_.options.step; t += often)
      least = std::min(least, speed_at(begin + std::max(0.0, t)));
    return std::max(least, s_.options.v_min);
  }

  void split() {
    const auto& t = s_.session.t;
    std::size_t first = 0;
    for (std::size_t i = 1; i <= t.size(); ++i) {
      if (i < t.size() && t[i] - t[i - 1] <= s_.options.longest_gap) continue;
      Stretch<T> stretch;
      stretch.begin = t[first];
      stretch.end = t[i - 1];
      const double last = stretch.end - earliest_;
      stretch.steps = static_cast<std::size_t>(std::max(0.0, std::ceil((last - stretch.begin) / s_.options.step)));
      stretch.x.resize((stretch.steps + 1) * channels);
      stretch.memory.resize((stretch.steps + 1) * s_.memory());
      stretches_.push_back(std::move(stretch));
      first = i;
    }
  }

  /// The stretch that a start at this time belongs to, or one past the last.
  std::size_t find(double time) const {
    for (std::size_t i = 0; i < stretches_.size(); ++i)
      if (time >= stretches_[i].begin - 1e-9 && time <= stretches_[i].end + 1e-9) return i;
    return stretches_.size();
  }

  double speed_at(double time) const {
    const std::size_t row = s_.session.row_before(time + 1e-9);
    const double v = row < s_.session.rows() ? s_.session.at(row, 3) : nothing;
    return std::isnan(v) ? 0.0 : std::abs(v);
  }

  void observe(std::span<const Lane> wanted) {
    const double h = s_.options.step;
    const auto pre = static_cast<std::size_t>(s_.options.pre_roll / h);
    Lanes<T> lanes(s_, wanted.size());
    std::vector<std::size_t> k(wanted.size());
    std::size_t most = 0;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      k[i] = wanted[i].first - std::min(wanted[i].first, pre);
      most = std::max(most, wanted[i].last - k[i]);
      lanes.time[i] = stretches_[wanted[i].stretch].begin + static_cast<double>(k[i]) * h;
      lanes.read_until[i] = stretches_[wanted[i].stretch].end;
      lanes.known[i] = s_.commands.known(lanes.read_until[i]);
      lanes.start(i);
      lanes.seek(i);
    }
    for (std::size_t step = 0; step < most; ++step) {
      for (std::size_t i = 0; i < wanted.size(); ++i) {
        if (k[i] >= wanted[i].first && k[i] < wanted[i].last) keep(lanes, i, stretches_[wanted[i].stretch], k[i]);
        ++k[i];
      }
      lanes.advance(h);
      lanes.correct(h);
    }
  }

  void keep(const Lanes<T>& lanes, std::size_t i, Stretch<T>& to, std::size_t k) const {
    const std::size_t m = s_.memory();
    std::copy_n(lanes.x.begin() + static_cast<std::ptrdiff_t>(i * channels), channels,
                to.x.begin() + static_cast<std::ptrdiff_t>(k * channels));
    std::copy_n(lanes.memory.begin() + static_cast<std::ptrdiff_t>(i * m), m,
                to.memory.begin() + static_cast<std::ptrdiff_t>(k * m));
  }

  void begin_at(Lanes<T>& lanes, std::size_t i, double start, double last) const {
    const Stretch<T>& from = stretches_[find(start)];
    const double h = s_.options.step;
    const double back = steps_before(from, start);
    lanes.read_until[i] = start;
    lanes.known[i] = s_.commands.known(start + last);
    const auto k = std::min(static_cast<std::size_t>(std::max(0.0, back)), from.steps);
    lanes.time[i] = from.begin + static_cast<double>(k) * h;
    if (back < 0.0) {  // what was kept there has seen later rows
      lanes.start(i);
    } else {
      const std::size_t m = s_.memory();
      std::copy_n(from.x.begin() + static_cast<std::ptrdiff_t>(k * channels), channels,
                  lanes.x.begin() + static_cast<std::ptrdiff_t>(i * channels));
      std::copy_n(from.memory.begin() + static_cast<std::ptrdiff_t>(k * m), m,
                  lanes.memory.begin() + static_cast<std::ptrdiff_t>(i * m));
    }
    lanes.seek(i);
  }

  void predict(const Starts& starts, std::span<const std::size_t> which, std::vector<T>& predicted) const {
    const double h = s_.options.step;
    const double last = starts.horizons.back();
    Lanes<T> lanes(s_, which.size());
    std::size_t steps = 0;
    for (std::size_t i = 0; i < which.size(); ++i) {
      const double start = starts.time[which[i]];
      begin_at(lanes, i, start, last);
      const double until = start + last - earliest_ - lanes.time[i];
      steps = std::max(steps, static_cast<std::size_t>(std::ceil(until / h - 1e-9)));
    }
    for (std::size_t step = 0; step < steps; ++step) {
      lanes.advance(h);
      for (std::size_t i = 0; i < which.size(); ++i)
        for (std::size_t j = 0; j < starts.horizons.size(); ++j)
          show(lanes, i, starts.time[which[i]] + starts.horizons[j],
               predicted.data() + (which[i] * starts.horizons.size() + j) * channels);
      lanes.correct(h);
    }
  }

  /// Writes the readings of channels whose time for a row at `time` lies in the step just made.
  void show(const Lanes<T>& lanes, std::size_t i, double time, T* out) const {
    const double h = s_.options.step;
    for (std::size_t g = 0; g < groups; ++g) {
      const double from_end = lanes.time[i] - (time - value(s_.delay(g)));
      if (from_end < -1e-9 || from_end >= h - 1e-9) continue;
      const T share = (T(time - (lanes.time[i] - h)) - s_.delay(g)) * (1.0 / h);
      const Row<T> shown = lanes.reading_at(i, share);
      for (std::size_t c = 0; c < channels; ++c)
        if (group_of[c] == g) out[c] = shown[c];
    }
  }

  const Setting<T>& s_;
  double latest_ = 0, earliest_ = 0;
  std::vector<Stretch<T>> stretches_;
};

/// Largest eigenvalue of the lateral motion times speed, from the rates at v_ref.
double lateral_stiffness(const StagedCar& car, const double* params, double v_ref) {
  const auto m = static_cast<std::size_t>(car.memory());
  constexpr double e = 1e-4;
  std::array<double, 3 * channels> x{}, rate{};
  for (std::size_t i = 0; i < 3; ++i) x[i * channels + 3] = v_ref;
  x[1 * channels + 4] = e * v_ref;
  x[2 * channels + 5] = e * v_ref;
  std::vector<double> memory(3 * m), memory_rate(3 * m);
  const std::array<ActingCommand<double>, 3> command{};
  const std::array<Place, 3> at{};
  const CommandSample<double> idle{};
  History<double> past;
  past.samples = &idle;
  past.count = 1;
  past.dt = 0.01;
  const std::array<History<double>, 3> history{past, past, past};
  CarBatch<double> batch;
  batch.n = 3;
  batch.motion = x.data();
  batch.command = command.data();
  batch.memory = memory.data();
  batch.at = at.data();
  batch.params = params;
  batch.history = history.data();
  batch.motion_rate = rate.data();
  batch.memory_rate = memory_rate.data();
  car.rates(batch);
  const double a11 = (rate[channels + 4] - rate[4]) / (e * v_ref);
  const double a22 = (rate[2 * channels + 5] - rate[5]) / (e * v_ref);
  return 1.2 * std::max(std::abs(a11), std::abs(a22)) * v_ref;
}

constexpr std::array<ExtraInfo, extra_count> infos = {{
    {"steer_tau", "s", 0.05, 60, 2, 1.0, true},
    {"force_tau", "s", 0.05, 60, 2, 1.0, true},
    {"gain_position", "1", 0, 1, 0.7, 0.3, false},
    {"gain_yaw", "1", 0, 1, 0.7, 0.3, false},
    {"gain_speed", "1", 0, 1, 0.7, 0.3, false},
    {"gain_lateral", "1", 0, 1, 0.3, 0.3, false},
    {"gain_yaw_rate", "1", 0, 1, 0.5, 0.3, false},
    {"gain_turn", "1/s", 0, 20, 0.5, 2.0, false},
    {"gain_force", "1/s", 0, 20, 0.5, 1.0, false},
    {"gain_steer", "1", 0, 1, 0.05, 0.2, false},
    {"delay_position", "s", -0.5, 1, 0, 0.1, false},
    {"delay_yaw", "s", -0.5, 1, 0, 0.1, false},
    {"delay_velocity", "s", -0.5, 1, 0, 0.1, false},
    {"delay_yaw_rate", "s", -0.5, 1, 0, 0.3, false},
}};

}  // namespace

std::span<const ExtraInfo> extra_infos() { return infos; }

Forecaster::Forecaster(const StagedCar& car, ForecastOptions options)
    : car_params_(car.params().size()), car_(car), options_(options) {
  // Their parameters follow the car's: the first two extras.
  car_.add(steer_, {infos[0].start}, "steering disturbance");
  car_.add(force_, {infos[1].start}, "force disturbance");
  const measured::Frame &pose = options.pose, &velocity = options.velocity;
  if (pose.point_given || pose.yaw_given || velocity.point_given || velocity.yaw_given)
    car_.add(frames_, {pose.x, pose.y, pose.yaw, velocity.x, velocity.y, velocity.yaw}, "frames of the map");
}

std::vector<double> Forecaster::defaults() const {
  std::vector<double> all(car_.params().begin(), car_.params().begin() + static_cast<std::ptrdiff_t>(car_params_));
  for (const ExtraInfo& info : infos) all.push_back(info.start);
  return all;
}

template <class T>
void Forecaster::run(const Session& session, const CommandGrid& commands, const Road* road, std::span<const T> params,
                     const Starts& starts, std::vector<T>& predicted) const {
  std::vector<double> values(car_.params().size());
  // The car's own, its disturbances', and those of the frames, which nobody moves.
  std::vector<T> of_car(params.begin(), params.begin() + static_cast<std::ptrdiff_t>(car_params_ + 2));
  for (std::size_t i = of_car.size(); i < car_.params().size(); ++i) of_car.push_back(T(car_.params()[i]));
  for (std::size_t i = 0; i < of_car.size(); ++i) values[i] = value(of_car[i]);
  const Setting<T> setting{car_,
                           options_,
                           session,
                           commands,
                           road,
                           of_car.data(),
                           params.data() + car_params_,
                           values.data(),
                           lateral_stiffness(car_, values.data(), options_.v_ref)};
  Run<T> run(setting);
  run.observe(starts);
  run.predict(starts, predicted);
}

template void Forecaster::run(const Session&, const CommandGrid&, const Road*, std::span<const double>, const Starts&,
                              std::vector<double>&) const;
template void Forecaster::run(const Session&, const CommandGrid&, const Road*, std::span<const Dual8>, const Starts&,
                              std::vector<Dual8>&) const;

}  // namespace gripline::calibrate
