// A belief of friction that fell within a moment, followed until it is back, as behind a slippery place, or until it
// cannot be that of a place any more (friction_places.hpp).
//
//   begin ... before ... low ... last     pieces of the road, in the order in which they are passed
//
// `before` has the last sure belief of the friction that it fell from. The place, if it is one, begins there or a
// little earlier, at `begin`, which is set once a belief was surely less. `low` is the piece with the last evidence of
// less friction. The place ends at `last`: the last piece on which the belief was not back yet, or `low` where there
// was no evidence for long. Then the fall has ended, and its belief has only to be sure again.
#pragma once

#include <cstddef>

namespace gripline::time_optimal {

/// A friction that is believed, with its standard deviation, and where and when.
struct SeenFriction {
  std::size_t piece = 0;
  double mu = 0, spread = 0;
  long step = -1;  // -1: never
  bool sure() const;
  /// Evidence of less friction than this.
  bool below(double friction) const;
};

class FrictionFall {
 public:
  static constexpr double share = 0.9;  // of the friction before it, below which a belief has fallen

  enum class Now {
    lasts,  // not back, or not surely
    back,   // in this step
    again   // it had ended and falls again: the first fall may have been the whole road's
  };

  /// From `before`, the last sure belief of a friction of about `level`, to `here`, which is evidence of less. `dt`
  /// seconds between steps; the estimator takes up to `detection_time` [s] to detect a new friction.
  FrictionFall(const SeenFriction& before, double level, const SeenFriction& here, double dt, double detection_time);

  /// The belief of the next step.
  Now see(const SeenFriction& here);

  const SeenFriction& before() const { return before_; }
  double level() const { return level_; }
  /// Whether a belief since was surely less, and not only evidence of it.
  bool is_sure() const { return sure_; }
  /// For how long there was evidence of less friction [s].
  double evidence() const { return seconds(evidence_); }
  /// Whether the belief has been back for so long that it has settled.
  bool is_over() const;
  std::size_t begin() const { return begin_; }
  std::size_t last() const { return last_; }

  /// The place begins here. Before anything is joined to it.
  void begin_at(std::size_t piece) { begin_ = joined_ = piece; }
  /// The pieces from begin() up to `piece`, where a known place began, are that place's now.
  void join(std::size_t piece) { joined_ = piece; }
  /// `piece` of join(); begin() where nothing was joined.
  std::size_t joined() const { return joined_; }
  bool has_joined() const { return joined_ != begin_; }

 private:
  double seconds(long steps) const { return dt_ * static_cast<double>(steps); }

  SeenFriction before_;
  double level_, dt_, detection_time_;  // friction, [s], [s]
  long last_evidence_;                  // step
  long evidence_ = 1;                   // steps
  double lowest_;                       // friction believed since
  bool sure_;
  bool ended_ = false;  // long without evidence
  double risen_ = 0;    // [s] for which it has been back
  std::size_t begin_, joined_, low_, last_;
};

}  // namespace gripline::time_optimal
