// One measured log, by the time from its first row on: rows as they were written, in SI units and axes of this project.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include <gripline/types.hpp>

#include "measured/channels.hpp"
#include "measured/readings/between_rows.hpp"
#include "measured/readings/bridged_readings.hpp"
#include "util/numbers.hpp"

namespace gripline::measured {

/// Where a sensor is mounted: ahead of and left of the centre of gravity [m], axes turned to the left by `yaw` [rad].
struct Frame {
  double x = 0, y = 0, yaw = 0;
  bool x_given = false, y_given = false, yaw_given = false;
  bool given() const { return x_given || y_given || yaw_given; }
};

/// A reading between rows, and its change per second: 0 where it is held, missing or stands in a row.
struct BridgedReading {
  double value = not_a_number;
  double slope = 0;
};

struct Session {
  std::string name;
  double begin = 0;             // what the log's own clock shows at t = 0 [s]
  std::vector<double> t;        // rows [s], strictly rising
  std::vector<double> reading;  // rows x 6, NaN where nothing was read; yaw unwrapped
  std::array<bool, channels> has{};
  std::vector<double> written_yaw;             // by row, as the log wraps it [rad]
  std::vector<CommandSample<double>> command;  // by row
  BetweenRows throttle_between, steering_between;
  Frame pose, velocity;           // of the units whose readings these are
  bool prescribed_speed = false;  // no throttle is known: vx is taken from the log

  std::size_t rows() const { return t.size(); }
  double at(std::size_t row, std::size_t channel) const { return reading[row * channels + channel]; }
  /// The reading at a time between two rows that both have it and are at most `longest_gap` [s] apart, linear; or NaN.
  double interpolate(std::size_t channel, double time, double longest_gap = even_motion) const;
  /// As `interpolate`, where `row` is known to be the last one at or before the time.
  double interpolate_from(std::size_t row, std::size_t channel, double time, double longest_gap = even_motion) const;
  /// The reading at a time as rows up to `until` show it: linear between the readings around it, whatever rows without
  /// one lie between, the last one where none follows by then. NaN where the readings around it, or the last one and
  /// the time, are more than `longest_gap` [s] apart.
  BridgedReading bridge(std::size_t channel, double time, double until, double longest_gap) const;
  /// Index of the last row at or before `time`; rows() when there is none.
  std::size_t row_before(double time) const;
};

/// Commands on an even grid for effects that look back. A sample between two rows is known as soon as the later one was
/// written, or, of commands that are held, the last that its mean holds.
struct CommandGrid {
  double t0 = 0, dt = 0.01;
  std::vector<CommandSample<double>> sample;
  std::vector<CommandSample<Dual8>> dual;
  std::vector<double> row_at;  // time of the row that the sample follows from, where no command is read every so often
  std::array<std::vector<double>, 2> fixed_at;  // of throttle and steering: time of the row that fixed the sample
  std::vector<double> known_at;                 // the later of them

  CommandGrid() = default;
  /// `dt`: spacing [s]; linear between samples. Over gaps the command is held. One that is held between rows is its
  /// mean over the step of the grid around each sample.
  CommandGrid(const Session& session, double dt);
  /// How many samples follow from rows at or before `time`.
  std::size_t known(double time) const;
  /// How many samples follow from rows at or before `time` when a command that moves to its next reading stays as it is
  /// until that is there.
  std::size_t shown_by(double time) const;
  /// Samples from number `first` to the last of those, as they are known at `time`; `now`: the commands of its last
  /// row.
  template <class T>
  void copy_shown(double time, const CommandSample<double>& now, std::size_t first,
                  std::vector<CommandSample<T>>& to) const;
  template <class T>
  const CommandSample<T>* data() const {
    if constexpr (std::is_same_v<T, double>)
      return sample.data();
    else
      return dual.data();
  }

 private:
  /// Straight lines to each new reading of a command that is read `every` so often.
  void ramp(const Session& session, double CommandSample<double>::*command, double every, std::vector<double>& fixed);
};

}  // namespace gripline::measured
