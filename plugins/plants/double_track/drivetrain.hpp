// Engine, clutch and automatic gearbox.
//
// The engine gives  throttle T_full(n) - (1 - throttle) T_drag(n),  linear between the rows of its table. Below idle
// speed the clutch slips: the engine stays at idle and its drag fades out, so that a standing car is not pulled. The
// gearbox changes by road speed: up at the end of a gear's range, down below its beginning; the overlap of neighbouring
// ranges is the hysteresis. While it changes, the torque goes to zero and comes back.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include <gripline/types.hpp>

namespace gripline::double_track {

namespace detail {
template <class... Values>
std::string text(const char* format, Values... values) {
  std::array<char, 256> line{};
  std::snprintf(line.data(), line.size(), format, values...);
  return line.data();
}
}  // namespace detail

/// Torque over engine speed at full and at closed throttle.
class Engine {
 public:
  Engine() = default;
  /// Rows [speed rad/s, full-throttle torque N m, drag torque at closed throttle N m]; std::invalid_argument with one
  /// line when a row makes no sense.
  explicit Engine(const Table& table) {
    using detail::text;
    if (table.cols != 3)
      throw std::invalid_argument(
          text("engine_torque has %zu columns, expected 3: engine speed [rad/s], torque at full "
               "throttle [N m], drag torque at closed throttle [N m]",
               table.cols));
    if (table.rows < 2)
      throw std::invalid_argument(text("engine_torque has %zu row(s), expected at least 2", table.rows));
    rows_.clear();
    for (std::size_t i = 0; i < table.rows; ++i) {
      const Row row{table.at(i, 0), table.at(i, 1), table.at(i, 2)};
      if (i > 0 && !(row.speed > rows_.back().speed))
        throw std::invalid_argument(
            text("engine_torque goes back: row %zu is at %g rad/s after %g rad/s, expected "
                 "engine speeds that rise",
                 i + 1, row.speed, rows_.back().speed));
      if (row.full < 0.0 || row.drag < 0.0)
        throw std::invalid_argument(
            text("engine_torque row %zu has torques %g and %g N m, expected none below 0 (drag "
                 "is given as a positive number)",
                 i + 1, row.full, row.drag));
      rows_.push_back(row);
    }
    if (!(rows_.front().speed > 0.0))
      throw std::invalid_argument(
          text("engine_torque begins at %g rad/s, expected the idle speed, above 0", rows_.front().speed));
  }

  double idle() const { return rows_.front().speed; }
  double fastest() const { return rows_.back().speed; }

  /// Torque [N m] at a throttle in [0, 1] when the gearbox input turns at `speed` [rad/s]. Beyond the table's end the
  /// limiter cuts the fuel within 20 rad/s.
  double torque(double throttle, double speed) const {
    const double turning = std::max(speed, idle());
    std::size_t i = 1;
    while (i + 1 < rows_.size() && rows_[i].speed < turning) ++i;
    const Row& a = rows_[i - 1];
    const Row& b = rows_[i];
    const double w = std::min(1.0, (turning - a.speed) / (b.speed - a.speed));
    const double limiter = std::clamp(1.0 - (turning - fastest()) / 20.0, 0.0, 1.0);
    const double engaged = std::clamp(2.0 * speed / idle() - 1.0, 0.0, 1.0);
    const double full = (a.full + w * (b.full - a.full)) * limiter;
    const double drag = (a.drag + w * (b.drag - a.drag)) * engaged;
    return throttle * full - (1.0 - throttle) * drag;
  }

 private:
  struct Row {
    double speed, full, drag;
  };
  std::vector<Row> rows_{{80.0, 0.0, 0.0}, {700.0, 0.0, 0.0}};
};

/// Ratios and the ranges of road speed in which they are used.
class GearMap {
 public:
  GearMap() = default;
  /// Rows [gear, ratio, from m/s, to m/s]; std::invalid_argument with one line when a row makes no sense.
  explicit GearMap(const Table& table) {
    using detail::text;
    if (table.cols != 4)
      throw std::invalid_argument(
          text("gears has %zu columns, expected 4: gear, ratio, from [m/s], to [m/s]", table.cols));
    if (table.rows < 1) throw std::invalid_argument("gears is empty, expected one row per gear");
    gears_.clear();
    for (std::size_t i = 0; i < table.rows; ++i) add(i, table);
    if (gears_.front().from > 0.0)
      throw std::invalid_argument(text("gears has a gap: gear 1 begins at %g m/s, expected 0", gears_.front().from));
  }

  int count() const { return static_cast<int>(gears_.size()); }
  double ratio(int gear) const { return gears_[static_cast<std::size_t>(gear)].ratio; }
  /// The gear (from 0) after a look at the road speed, when `gear` was engaged.
  int next(int gear, double speed) const {
    const Gear& now = gears_[static_cast<std::size_t>(gear)];
    if (speed > now.to && gear + 1 < count()) return gear + 1;
    if (speed < now.from && gear > 0) return gear - 1;
    return gear;
  }
  /// The highest gear whose range holds this speed.
  int at(double speed) const {
    for (int gear = count() - 1; gear > 0; --gear)
      if (speed >= gears_[static_cast<std::size_t>(gear)].from) return gear;
    return 0;
  }

 private:
  struct Gear {
    double ratio, from, to;
  };
  void add(std::size_t i, const Table& table) {
    using detail::text;
    const double number = table.at(i, 0);
    const Gear gear{table.at(i, 1), table.at(i, 2), table.at(i, 3)};
    if (number != static_cast<double>(i + 1))
      throw std::invalid_argument(text("gears has a gap: row %zu is gear %g, expected gear %zu", i + 1, number, i + 1));
    if (!(gear.ratio > 0.0) || !(gear.to > gear.from))
      throw std::invalid_argument(
          text("gear %zu has ratio %g from %g to %g m/s, expected a ratio above 0 and a range "
               "that is not empty",
               i + 1, gear.ratio, gear.from, gear.to));
    if (i > 0) {
      const Gear& below = gears_.back();
      if (!(gear.ratio < below.ratio))
        throw std::invalid_argument(text("gear %zu has ratio %g after %g of gear %zu, expected ratios that fall", i + 1,
                                         gear.ratio, below.ratio, i));
      if (!(gear.from < below.to))
        throw std::invalid_argument(
            text("gears has a gap: gear %zu ends at %g m/s and gear %zu begins at %g m/s, "
                 "expected ranges that overlap",
                 i, below.to, i + 1, gear.from));
      if (!(gear.from > below.from) || !(gear.to > below.to))
        throw std::invalid_argument(text("gear %zu is used from %g to %g m/s, expected both above gear %zu's %g and %g",
                                         i + 1, gear.from, gear.to, i, below.from, below.to));
    }
    gears_.push_back(gear);
  }

  std::vector<Gear> gears_{{1.0, 0.0, 1e9}};
};

/// The gear engaged now.
class Gearbox {
 public:
  Gearbox() = default;
  Gearbox(GearMap map, double shift_time) : map_(std::move(map)), shift_time_(shift_time) {}

  void reset(double speed) {
    gear_ = map_.at(speed);
    remaining_ = 0.0;
  }
  void advance(double speed, double step) {
    const double before = remaining_;
    remaining_ = std::max(0.0, remaining_ - step);
    if (before > 0.5 * shift_time_ && remaining_ <= 0.5 * shift_time_) gear_ = wanted_;
    if (remaining_ > 0.0) return;
    wanted_ = map_.next(gear_, speed);
    if (wanted_ == gear_) return;
    remaining_ = shift_time_;
    if (shift_time_ <= 0.0) gear_ = wanted_;
  }
  double ratio() const { return map_.ratio(gear_); }
  /// Share of the torque that gets through: 1, or less during a change.
  double engaged() const { return remaining_ > 0.0 ? std::abs(2.0 * remaining_ / shift_time_ - 1.0) : 1.0; }
  int gear() const { return gear_ + 1; }

 private:
  GearMap map_;
  double shift_time_ = 0.0;
  double remaining_ = 0.0;
  int gear_ = 0;
  int wanted_ = 0;
};

}  // namespace gripline::double_track
