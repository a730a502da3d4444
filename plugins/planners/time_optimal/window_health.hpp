// How a window of the lap does (receding_laps.hpp): whether Newton steps still find something better, and for how long
// there has been no plan that can be driven.
//
//   stuck     for some Newton steps nothing better was found: the window begins again at a larger barrier
//   stalled   for some time there was no plan: the barrier is raised, again and again
//   lost      for longer: what the car leaves behind is not a start for the next lap
//   given up  the window begins again for the car believed, each time later by as much, up to the most; where the
//             belief has moved, as soon as it is lost, since the car that was solved for is another one
#pragma once

#include <algorithm>
#include <cmath>

namespace gripline::time_optimal {

class WindowHealth {
 public:
  /// `dt`: of a control step [s].
  explicit WindowHealth(double dt) : dt_(dt) {}

  void newton_step(bool good) { failed_ = good ? 0 : failed_ + 1; }
  bool is_stuck() const { return failed_ > most_failed; }
  /// What was stuck begins from other states.
  void restart() { failed_ = 0; }

  /// A control step with or without a plan that can be driven: whether it makes the window a stalled one.
  [[nodiscard]] bool control_step(bool drivable) {
    stalled_ = drivable ? 0 : stalled_ + 1;
    lost_ = drivable ? 0 : lost_ + 1;
    if (drivable) patience_ = first_patience;
    if (!longer(stalled_, most_stalled)) return false;
    stalled_ = 0;
    return true;
  }
  bool is_lost() const { return longer(lost_, least_patience); }
  /// `moved`: by how much the car believed differs from the one that is solved for, of tyre force over its peak or of
  /// resistance over weight.
  bool is_given_up(double moved) const { return longer(lost_, patience_) || (is_lost() && moved > other_car); }
  /// The window begins again for the car believed.
  void begin_for(double moved) {
    patience_ = moved > other_car ? first_patience : std::min(patience_ + first_patience, most_patience);
    lost_ = 0;
  }

 private:
  static constexpr int most_failed = 8;  // Newton steps
  // Without a plan that can be driven [s]:
  static constexpr double most_stalled = 0.3;
  static constexpr double least_patience = 0.5, first_patience = 1.0, most_patience = 3.0;
  static constexpr double other_car = 0.05;

  /// Whether so many control steps last longer than this [s], to the nearest step.
  bool longer(int steps, double seconds) const { return steps > std::lround(seconds / dt_); }

  double dt_;       // [s]
  int failed_ = 0;  // Newton steps one after the other that found nothing better
  // Control steps one after the other without a plan that can be driven:
  int stalled_ = 0;                   // since the barrier was last raised for that
  int lost_ = 0;                      // since the window last began again for the car believed
  double patience_ = first_patience;  // [s] of lost_ beyond which it does so
};

}  // namespace gripline::time_optimal
