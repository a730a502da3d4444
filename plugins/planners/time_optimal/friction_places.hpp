// Where the road is slippery, learned from a friction that is believed as the car drives.
//
//   friction(s, t) = mu(t) grip(s)
//
// A belief that falls within a moment and, less than half a lap later, comes back was that of a place: what was
// believed there, once it had settled, over what is believed behind it is its grip. One that falls and stays fallen is
// the whole road's. While a learner finds the new friction its belief is not sure: that part of the road belongs to the
// place, if it is short. On the next lap the place is known before the car is there; in it mu(t) is held, and lowered
// where even less is believed than the place explains. Each lap measures a place anew: where it begins and ends and its
// grip are those of the last lap that showed other ones, and it is forgotten when the belief does not fall there any
// more. A stretch that became slippery while the car was on it is known from there on; when the belief falls to its
// grip before that, it begins there at once.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "planners/time_optimal/friction_fall.hpp"

namespace gripline::time_optimal {

class FrictionPlaces {
 public:
  /// Of a closed road in so many pieces, with `dt` seconds between steps; the estimator takes up to
  /// `detection_time` [s] to detect a new friction. Steps do not allocate.
  FrictionPlaces(std::size_t pieces, double dt, double detection_time);

  /// Once per control step: the car is on this piece and believes this friction of the road below it, with a standard
  /// deviation of `spread`. Whether a grip changed.
  bool step(std::size_t piece, double mu, double spread = 0.0);
  /// mu(t): the friction believed, without the place that the car is in; NaN before the first step.
  double mu() const { return mu_; }
  /// Whether the car is in a known place, so that its belief is not that of the road ahead.
  bool holding() const { return holding_; }
  double grip(std::size_t piece) const { return grip_[piece]; }

 private:
  using Seen = SeenFriction;

  std::size_t size() const { return grip_.size(); }
  std::size_t before(std::size_t i) const { return i > 0 ? i - 1 : size() - 1; }
  std::size_t after(std::size_t i) const { return i + 1 < size() ? i + 1 : 0; }
  std::size_t way_from(std::size_t from, std::size_t to) const { return (to + size() - from) % size(); }
  /// At most so many pieces are passed in one step, or lie between a fall and the known place that it may be part of.
  std::size_t near_pieces() const { return size() / 8; }
  double seconds(long steps) const { return dt_ * static_cast<double>(steps); }
  const Seen& recent(long step) const { return recent_[static_cast<std::size_t>(step) % recent_.size()]; }
  std::size_t first_of_place(std::size_t i) const;
  std::size_t last_of_place(std::size_t i) const;

  void note(const Seen& here);

  // A belief that falls, until it comes back.
  void look_for_fall(const Seen& here);
  std::size_t begin_of(const Seen& sure_before) const;
  bool watch(const Seen& here);
  bool begin_earlier(const Seen& here);
  bool give_up();
  bool learn(double mu);
  double settled(std::size_t first, std::size_t last, double level);
  bool is_known(const FrictionFall& fall, double grip) const;

  // A place that is known.
  void in_place(std::size_t piece, double mu);
  bool behind_place(double mu);

  double dt_, detection_time_;  // [s]
  std::vector<double> grip_;
  std::vector<Seen> passed_;     // of each piece, when it was passed last
  std::vector<Seen> recent_;     // of the last steps, by their number
  std::vector<double> beliefs_;  // for settled()
  long now_ = 0, since_ = 1;     // steps: this one, and the first since the car was carried elsewhere
  std::size_t piece_ = 0;        // of the last step
  std::size_t entered_ = 0;      // where the car came into the place that it is in
  double mu_ = std::numeric_limits<double>::quiet_NaN();
  double behind_ = 0;  // [s] since the car left it
  bool holding_ = false;
  bool as_before_ = false;            // the belief has not fallen in this place yet
  std::optional<FrictionFall> fall_;  // of a belief that has not come back yet
};

}  // namespace gripline::time_optimal
