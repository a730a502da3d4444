// One log: the observer along it as far as starts need it, then predictions from them. A part of the forecaster.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "calibrate/forecast/forecast_lanes.hpp"

namespace gripline::calibrate::forecast {

/// A stretch of rows without long gaps, on an even grid of the car's time.
struct Stretch {
  double begin = 0, end = 0;  // rows [s]
  std::size_t steps = 0;
};

/// A number of steps rounded up; none where it is negative or no number.
inline std::size_t whole_steps(double steps) {
  return std::isfinite(steps) && steps > 0.0 ? static_cast<std::size_t>(std::ceil(steps)) : 0;
}

/// The observer along a block of a stretch that holds starts, and its states where they begin.
template <class T>
struct Block {
  std::size_t stretch = 0;
  std::size_t begin = 0;          // grid point where the observer begins, whatever the delays
  double slowest = 0;             // [m/s] about the least speed on the way
  std::vector<std::size_t> kept;  // grid points, rising
  LaneStates<T> states;           // a row for each of them
};

/// To be called in this order: observe(), then predict() for the same starts. Holds a reference to its setting.
template <class T>
class ForecastRun {
 public:
  explicit ForecastRun(const Setting<T>& setting) : s_(setting) {
    latest_ = earliest_ = value(s_.delay(0));
    for (std::size_t g = 0; g < groups; ++g) {
      known_delays_ = known_delays_ && std::isfinite(value(s_.delay(g)));
      latest_ = std::max(latest_, value(s_.delay(g)));
      earliest_ = std::min(earliest_, value(s_.delay(g)));
    }
    split_at_gaps();
  }

  /// Carries the states along the log as far as starts need them.
  void observe(const Starts& starts, ObserverSteps* steps) {
    if (!known_delays_) return;
    request_blocks(starts);
    std::vector<Block<T>*> blocks;
    for (auto& [where, block] : blocks_) {
      block.slowest = slowest_in(block);
      blocks.push_back(&block);
    }
    // The slowest lane decides on the steps of all: lanes of like speeds are integrated together.
    if (s_.options.lanes > 1)
      std::stable_sort(blocks.begin(), blocks.end(),
                       [](const Block<T>* a, const Block<T>* b) { return a->slowest < b->slowest; });
    const std::size_t at_once = s_.options.lanes;
    const bool known = steps != nullptr && !steps->empty();
    for (std::size_t i = 0, group = 0; i < blocks.size(); i += at_once, ++group) {
      const auto together = std::span(blocks).subspan(i, std::min(at_once, blocks.size() - i));
      if (known)
        observe(together, {.given = &(*steps)[group]});
      else
        observe(together, {.recorded = steps != nullptr ? &steps->emplace_back() : nullptr});
    }
  }

  /// predicted: starts x horizons x 6 readings, NaN where the log has no rows to start from, and from where the state
  /// is not finite on.
  void predict(const Starts& starts, std::vector<T>& predicted) {
    const std::size_t h = starts.horizons.size();
    predicted.assign(starts.time.size() * h * channels, T(not_a_number));
    if (!known_delays_) return;
    std::vector<std::size_t> usable;
    for (std::size_t i = 0; i < starts.time.size(); ++i)
      if (stretch_of(starts.time[i]) < stretches_.size()) usable.push_back(i);
    // The slowest lane decides on the steps of all: lanes of like speeds are integrated together.
    if (s_.options.lanes > 1)
      std::stable_sort(usable.begin(), usable.end(), [&](std::size_t a, std::size_t b) {
        return speed_at(starts.time[a]) < speed_at(starts.time[b]);
      });
    const std::size_t at_once = s_.options.lanes;
    for (std::size_t j = 0; j < h; j = last_of(j, h))
      for (std::size_t i = 0; i < usable.size(); i += at_once)
        predict(starts, {j, last_of(j, h)}, std::span(usable).subspan(i, std::min(at_once, usable.size() - i)),
                predicted);
  }

 private:
  /// Horizons [first, last) that are predicted by one integration.
  struct Horizons {
    std::size_t first, last;
  };
  std::size_t last_of(std::size_t first, std::size_t count) const {
    return s_.options.own_commands ? first + 1 : count;
  }

  /// Grid point from which a start rolls on whose commands are known up to `until`; negative where it begins before the
  /// observer has seen enough.
  double steps_before(const Stretch& from, double start, double until) const {
    const double time = std::min(start - std::max(latest_, 0.0), until - s_.longest_every());
    return std::floor((time - from.begin) / s_.options.step + 1e-9);
  }
  std::size_t grid_point(const Stretch& from, double back) const {
    return std::min(static_cast<std::size_t>(std::max(0.0, back)), from.steps);
  }
  /// Where a start is shown. Starts share a block, and the block begins, by the log's clock: nothing jumps where a
  /// delay changes.
  std::size_t shown_at(const Stretch& stretch, double start) const {
    return static_cast<std::size_t>(std::max(0.0, (start - stretch.begin) / s_.options.step + 1e-6));
  }
  using Key = std::pair<std::size_t, std::size_t>;  // stretch, number of the block in it
  Key key_of(std::size_t stretch, double start) const {
    const auto block = std::max<std::size_t>(1, static_cast<std::size_t>(s_.options.block / s_.options.step));
    return {stretch, shown_at(stretches_[stretch], start) / block};
  }

  /// The blocks of the log that hold a start, and the grid points that are asked for.
  void request_blocks(const Starts& starts) {
    const auto pre = static_cast<std::size_t>(s_.options.pre_roll / s_.options.step);
    const std::size_t h = starts.horizons.size();
    for (const double start : starts.time) {
      const std::size_t i = stretch_of(start);
      if (i >= stretches_.size()) continue;
      for (std::size_t j = 0; j < h; j = last_of(j, h)) {
        const double back = steps_before(stretches_[i], start, start + starts.horizons[last_of(j, h) - 1]);
        if (back < 0.0) continue;
        const std::size_t k = grid_point(stretches_[i], back), shown = shown_at(stretches_[i], start);
        const std::size_t begin = std::min(k, shown - std::min(shown, pre));
        Block<T>& block = blocks_.try_emplace(key_of(i, start), Block<T>{i, begin, 0, {}, {}}).first->second;
        block.begin = std::min(block.begin, begin);
        block.kept.push_back(k);
      }
    }
    for (auto& [where, block] : blocks_) {
      std::sort(block.kept.begin(), block.kept.end());
      block.kept.erase(std::unique(block.kept.begin(), block.kept.end()), block.kept.end());
      block.states.x.reserve(block.kept.size() * channels);
      block.states.memory.reserve(block.kept.size() * s_.memory());
      block.states.pending.reserve(block.kept.size() * pending_size);
    }
  }

  double slowest_in(const Block<T>& block) const {
    constexpr double often = 0.2;  // [s]
    const double begin = stretches_[block.stretch].begin;
    const double last = static_cast<double>(block.kept.back() + 1) * s_.options.step;
    double least = speed_at(begin + last);
    double t = static_cast<double>(block.begin) * s_.options.step;
    while (t < last) {
      least = std::min(least, speed_at(begin + t));
      t += often;
    }
    return std::max(least, s_.options.v_min);
  }

  void split_at_gaps() {
    const auto& t = s_.session.t;
    std::size_t first = 0;
    for (std::size_t i = 1; i <= t.size(); ++i) {
      if (i < t.size() && t[i] - t[i - 1] <= s_.options.longest_gap) continue;
      Stretch stretch;
      stretch.begin = t[first];
      stretch.end = t[i - 1];
      const double last = stretch.end - earliest_;
      stretch.steps = whole_steps((last - stretch.begin) / s_.options.step);
      stretches_.push_back(stretch);
      first = i;
    }
  }

  /// The stretch that a start at this time belongs to, or one past the last.
  std::size_t stretch_of(double time) const {
    for (std::size_t i = 0; i < stretches_.size(); ++i)
      if (time >= stretches_[i].begin - 1e-9 && time <= stretches_[i].end + 1e-9) return i;
    return stretches_.size();
  }

  double speed_at(double time) const {
    const std::size_t row = s_.session.row_before(time + 1e-9);
    const double v = row < s_.session.rows() ? s_.session.at(row, Channel::vx) : not_a_number;
    return std::isnan(v) ? 0.0 : std::abs(v);
  }

  /// How many substeps each step of blocks side by side is divided into: as given, or as the lanes need, which is
  /// recorded where that is not null.
  struct Substeps {
    const std::vector<int>* given = nullptr;
    std::vector<int>* recorded = nullptr;
  };
  /// Blocks side by side.
  void observe(std::span<Block<T>*> wanted, const Substeps& substeps) {
    const double h = s_.options.step;
    const auto steps_of = [](const Block<T>* block) { return block->kept.back() - block->begin; };
    // Those that end first come last, where they can be left out.
    std::ranges::stable_sort(wanted, std::greater<>(), steps_of);
    Lanes<T> lanes(s_, wanted.size());
    std::vector<std::size_t> next(wanted.size());  // to be kept
    const std::size_t most = steps_of(wanted.front());
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const Block<T>& block = *wanted[i];
      const Stretch& stretch = stretches_[block.stretch];
      lanes.start_from_log(i, {stretch.begin + static_cast<double>(block.begin) * h, stretch.end, stretch.end});
    }
    for (std::size_t step = 0;; ++step) {
      for (std::size_t i = 0; i < lanes.size(); ++i) {
        Block<T>& block = *wanted[i];
        if (next[i] == block.kept.size() || block.kept[next[i]] != block.begin + step) continue;
        lanes.append_states(i, block.states);
        ++next[i];
      }
      if (step == most) return;
      if (substeps.given != nullptr) {
        while (steps_of(wanted[lanes.size() - 1]) <= step) lanes.keep_first(lanes.size() - 1);
        lanes.advance(h, (*substeps.given)[step]);
      } else {
        const int taken = lanes.advance(h);
        if (substeps.recorded != nullptr) substeps.recorded->push_back(taken);
      }
      lanes.correct(h);
    }
  }

  /// Puts lane i where the observer was last before a start that predicts `last` seconds ahead.
  void start_lane(Lanes<T>& lanes, std::size_t i, double start, double last) const {
    const std::size_t stretch = stretch_of(start);
    const Stretch& from = stretches_[stretch];
    const double back = steps_before(from, start, start + last);
    const std::size_t k = grid_point(from, back);
    const LaneStart begin{from.begin + static_cast<double>(k) * s_.options.step, start, start + last};
    if (back < 0.0) {  // what is kept there has seen later rows
      lanes.start_from_log(i, begin);
      return;
    }
    const Block<T>& block = blocks_.at(key_of(stretch, start));
    const auto row = std::lower_bound(block.kept.begin(), block.kept.end(), k) - block.kept.begin();
    lanes.start_from(i, begin, block.states, static_cast<std::size_t>(row));
  }

  void predict(const Starts& starts, Horizons horizons, std::span<const std::size_t> which,
               std::vector<T>& predicted) const {
    const double h = s_.options.step;
    const double last = starts.horizons[horizons.last - 1];
    Lanes<T> lanes(s_, which.size());
    std::size_t steps = 0;
    for (std::size_t i = 0; i < which.size(); ++i) {
      const double start = starts.time[which[i]];
      start_lane(lanes, i, start, last);
      const double until = start + last - earliest_ - lanes.time(i);
      steps = std::max(steps, whole_steps(until / h - 1e-9));
    }
    for (std::size_t step = 0; step < steps; ++step) {
      lanes.advance(h);
      bool any = false;
      for (std::size_t i = 0; i < which.size(); ++i) {
        if (lanes.is_lost(i)) continue;
        any = true;
        for (std::size_t j = horizons.first; j < horizons.last; ++j)
          write_readings(lanes, i, starts.time[which[i]] + starts.horizons[j],
                         predicted.data() + (which[i] * starts.horizons.size() + j) * channels);
      }
      if (!any) return;
      lanes.correct(h);
    }
  }

  /// Writes the readings of channels whose time for a row at `time` lies in the step just made.
  void write_readings(const Lanes<T>& lanes, std::size_t i, double time, T* out) const {
    const double h = s_.options.step;
    for (std::size_t g = 0; g < groups; ++g) {
      const double from_end = lanes.time(i) - (time - value(s_.delay(g)));
      if (from_end < -1e-9 || from_end >= h - 1e-9) continue;
      const T share = (T(time - (lanes.time(i) - h)) - s_.delay(g)) * (1.0 / h);
      const Row<T> shown = lanes.reading_at(i, share);
      for (std::size_t c = 0; c < channels; ++c)
        if (delay_group[c] == g) out[c] = shown[c];
    }
  }

  const Setting<T>& s_;
  double latest_ = 0, earliest_ = 0;
  bool known_delays_ = true;  // else there is no time to start or to read at
  std::vector<Stretch> stretches_;
  std::map<Key, Block<T>> blocks_;
};

}  // namespace gripline::calibrate::forecast
