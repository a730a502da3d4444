// Whether a command changes in a log as a logger shows it that reads it every so often and repeats it in between.
#pragma once

#include <cstddef>

namespace gripline::measured {

/// Judges by the changes so far: where most of them came sooner than such a logger could show them, the log is not of
/// one, and its commands stand in the rows as they were given.
class ReadingPace {
 public:
  /// `every`: time between two readings [s]; `begin`: of the log [s].
  ReadingPace(double every, double begin) : every_(every), last_(begin) {}
  /// To be called at each change [s], in their order.
  void change(double time) {
    // The change before the first one lies before the log, at a time that is not known: the first counts as read.
    ++(any_ && time - last_ < 0.75 * every_ ? sooner_ : as_read_);
    any_ = true;
    last_ = time;
  }
  /// Whether at least half of the changes so far came no sooner than three quarters of `every` after another.
  bool kept() const { return sooner_ <= as_read_; }
  /// Time of the last change; `begin` before the first [s].
  double last() const { return last_; }

 private:
  double every_, last_;
  bool any_ = false;
  std::size_t sooner_ = 0, as_read_ = 0;
};

}  // namespace gripline::measured
