// One log: the observer along it as far as starts need it, then predictions from them. A part of the forecaster.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "calibrate/forecast_lanes.hpp"

namespace gripline::calibrate::forecast {

/// A stretch of rows without long gaps and the observer's states along it, on an even grid of the car's time.
template <class T>
struct Stretch {
  double begin = 0, end = 0;  // rows [s]
  std::size_t steps = 0;
  std::vector<T> x, memory, pending;  // steps + 1 rows
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
    for (std::size_t j = 0; j < h; j = last_of(j, h))
      for (std::size_t i = 0; i < usable.size(); i += at_once)
        predict(starts, {j, last_of(j, h)}, std::span(usable).subspan(i, std::min(at_once, usable.size() - i)),
                predicted);
  }

 private:
  struct Lane {
    std::size_t stretch, first, last;  // grid points [first, last) are kept
    std::size_t begin = 0;             // grid point where the observer begins, whatever the delays
    double slowest = 0;                // [m/s] about the least speed on the way
  };

  /// Horizons [first, last) that are predicted by one integration.
  struct Horizons {
    std::size_t first, last;
  };
  std::size_t last_of(std::size_t first, std::size_t count) const {
    return s_.options.own_commands ? first + 1 : count;
  }

  /// Grid point from which a start rolls on whose commands are known up to `until`; negative where it begins before the
  /// observer has seen enough.
  double steps_before(const Stretch<T>& from, double start, double until) const {
    const double time = std::min(start - std::max(latest_, 0.0), until - s_.longest_every());
    return std::floor((time - from.begin) / s_.options.step + 1e-9);
  }
  /// Up to when a start's first integration knows the commands.
  double first_known(const Starts& starts, double start) const {
    return start + starts.horizons[last_of(0, starts.horizons.size()) - 1];
  }

  /// One lane per block of the log that holds a start, from the first to the last grid point that is asked for.
  std::vector<Lane> wanted_lanes(const Starts& starts) const {
    const auto block = std::max<std::size_t>(1, static_cast<std::size_t>(s_.options.block / s_.options.step));
    const auto pre = static_cast<std::size_t>(s_.options.pre_roll / s_.options.step);
    std::map<std::pair<std::size_t, std::size_t>, Lane> blocks;
    for (const double start : starts.time) {
      const std::size_t i = find(start);
      if (i >= stretches_.size()) continue;
      const auto kept = [&](double until) {
        const double back = steps_before(stretches_[i], start, until);
        return std::min(static_cast<std::size_t>(std::max(0.0, back)), stretches_[i].steps);
      };
      if (steps_before(stretches_[i], start, start + starts.horizons.back()) < 0.0) continue;
      const std::size_t k = kept(first_known(starts, start)), last = kept(start + starts.horizons.back());
      // Starts share a lane, and the lane begins, by the log's clock: nothing jumps where a delay changes.
      const auto shown =
          static_cast<std::size_t>(std::max(0.0, (start - stretches_[i].begin) / s_.options.step + 1e-6));
      const std::size_t begin = std::min(k, shown - std::min(shown, pre));
      const auto [at, fresh] = blocks.try_emplace({i, shown / block}, Lane{i, k, last + 1, begin});
      at->second.begin = std::min(at->second.begin, begin);
      at->second.first = std::min(at->second.first, k);
      at->second.last = std::max(at->second.last, last + 1);
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
    for (double t = static_cast<double>(lane.begin) * s_.options.step;
         t < static_cast<double>(lane.last) * s_.options.step; t += often)
      least = std::min(least, speed_at(begin + t));
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
      stretch.pending.resize((stretch.steps + 1) * pending_size);
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
    Lanes<T> lanes(s_, wanted.size());
    std::vector<std::size_t> k(wanted.size());
    std::size_t most = 0;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      k[i] = wanted[i].begin;
      most = std::max(most, wanted[i].last - k[i]);
      lanes.time[i] = stretches_[wanted[i].stretch].begin + static_cast<double>(k[i]) * h;
      lanes.read_until[i] = stretches_[wanted[i].stretch].end;
      lanes.know(i, lanes.read_until[i]);
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
    std::copy_n(lanes.pending.begin() + static_cast<std::ptrdiff_t>(i * pending_size), pending_size,
                to.pending.begin() + static_cast<std::ptrdiff_t>(k * pending_size));
  }

  void begin_at(Lanes<T>& lanes, std::size_t i, double start, double last) const {
    const Stretch<T>& from = stretches_[find(start)];
    const double h = s_.options.step;
    const double back = steps_before(from, start, start + last);
    lanes.read_until[i] = start;
    const auto k = std::min(static_cast<std::size_t>(std::max(0.0, back)), from.steps);
    lanes.time[i] = from.begin + static_cast<double>(k) * h;
    lanes.know(i, start + last);
    if (back < 0.0) {  // what was kept there has seen later rows
      lanes.start(i);
    } else {
      const std::size_t m = s_.memory();
      std::copy_n(from.x.begin() + static_cast<std::ptrdiff_t>(k * channels), channels,
                  lanes.x.begin() + static_cast<std::ptrdiff_t>(i * channels));
      std::copy_n(from.memory.begin() + static_cast<std::ptrdiff_t>(k * m), m,
                  lanes.memory.begin() + static_cast<std::ptrdiff_t>(i * m));
      std::copy_n(from.pending.begin() + static_cast<std::ptrdiff_t>(k * pending_size), pending_size,
                  lanes.pending.begin() + static_cast<std::ptrdiff_t>(i * pending_size));
    }
    lanes.seek(i);
  }

  void predict(const Starts& starts, Horizons horizons, std::span<const std::size_t> which,
               std::vector<T>& predicted) const {
    const double h = s_.options.step;
    const double last = starts.horizons[horizons.last - 1];
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
        for (std::size_t j = horizons.first; j < horizons.last; ++j)
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

}  // namespace gripline::calibrate::forecast
