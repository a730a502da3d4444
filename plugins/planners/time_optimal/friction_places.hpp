// Where the road is slippery, learned from a friction that is believed as the car drives.
//
//   friction(s, t) = mu(t) grip(s)
//
// A belief that is sure of itself, falls and, less than half a lap later, comes back was that of a place: what was
// believed there over what is believed behind it is its grip. While a learner finds the new friction its belief is not
// sure: that part of the road belongs to the place, if it is short. One that falls and stays fallen is the whole
// road's. On the next lap the place is known before the car is there; in it mu(t) is held, and lowered where even less is believed
// than the place explains. A place is forgotten when the belief does not fall there any more.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

namespace gripline::time_optimal {

class FrictionPlaces {
 public:
  /// Of a closed road in so many pieces, with `dt` seconds between steps. Steps do not allocate.
  FrictionPlaces(std::size_t pieces, double dt)
      : dt_(dt), grip_(pieces, 1.0), believed_(pieces, 0.0), seen_(pieces, -1), sure_at_(pieces, false) {}

  /// Once per control step: the car is on this piece and believes this friction of the road below it, with a standard
  /// deviation of `spread`. Whether a grip changed.
  bool step(std::size_t piece, double mu, double spread = 0.0) {
    ++now_;
    sure_ = 2.0 * spread <= (1.0 - fall) * mu;
    note(piece, mu);
    bool changed = false;
    if (grip_[piece] < 1.0) {
      in_place(piece, mu);
    } else if (holding_) {
      changed = behind_place(mu);
    } else {
      mu_ = mu;
      changed = sure_ && look_for_place(piece, mu);
    }
    piece_ = piece;
    return changed;
  }
  /// mu(t): the friction believed, without the place that the car is in; NaN before the first step.
  double mu() const { return mu_; }
  /// Whether the car is in a known place, so that its belief is not that of the road ahead.
  bool holding() const { return holding_; }
  double grip(std::size_t piece) const { return grip_[piece]; }

 private:
  static constexpr double fall = 0.9;      // of the friction behind it, that makes a place
  static constexpr double settle = 0.2;    // [s] that a risen belief is waited for
  static constexpr double early = 0.1;     // [s] before the belief was last sure of the friction before a place
  static constexpr double doubt = 0.3;     // [s] at most without a sure belief, at either end and within
  static constexpr double shortest = 0.1;  // [s] of a sure belief in less friction
  static constexpr double longest = 0.5;   // share of the road
  static constexpr double slack = 0.95;    // of what a place explains
  static constexpr double patience = 0.4;  // [s] behind a place, for the belief to come back

  std::size_t size() const { return grip_.size(); }
  std::size_t before(std::size_t i) const { return i > 0 ? i - 1 : size() - 1; }
  double ago(std::size_t i) const { return dt_ * static_cast<double>(now_ - seen_[i]); }

  void note(std::size_t piece, double mu) {
    // Pieces that were passed within a step; a car that was carried elsewhere passed none.
    std::size_t way = (piece + size() - piece_) % size();
    if (now_ <= 1 || way > size() / 8) way = 0;
    for (std::size_t k = 0; k <= way; ++k) {
      const std::size_t i = (piece + size() - k) % size();
      if (k > 0 && i == piece_) break;
      believed_[i] = mu;
      seen_[i] = now_;
      sure_at_[i] = sure_;
    }
  }

  void in_place(std::size_t piece, double mu) {
    if (!holding_) {
      holding_ = true;
      dry_ = true;
      begin_ = piece;
    }
    const double explained = mu_ * grip_[piece];
    if (mu < 0.5 * (mu_ + explained)) dry_ = false;
    if (mu < slack * explained) mu_ = mu / grip_[piece];
    behind_ = 0;
  }

  /// Just behind a place. True where it is forgotten.
  bool behind_place(double mu) {
    behind_ += dt_;
    if (mu < fall * mu_ && behind_ < patience) return false;
    holding_ = false;
    if (mu < mu_) mu_ = mu;
    if (!dry_) return false;
    while (grip_[before(begin_)] < 1.0) begin_ = before(begin_);
    for (std::size_t i = begin_; grip_[i] < 1.0; i = (i + 1) % size()) grip_[i] = 1.0;
    return true;
  }

  /// Whether the car was on this piece before it came to the next one.
  bool came_from(std::size_t i) const {
    const std::size_t after = i + 1 < size() ? i + 1 : 0;
    return seen_[i] >= 0 && seen_[i] <= seen_[after];
  }

  /// A fall of the belief that ended: pieces from the last sure one before it to the last one before it rose again.
  struct Fall {
    std::size_t before, last;
    double mean;  // of the friction believed surely
  };

  /// Whether the belief has come back from a fall, and then the grip of the pieces where it had fallen.
  bool look_for_place(std::size_t piece, double mu) {
    const std::optional<Fall> found = find_fall(piece, mu);
    if (!found || mu < fall * believed_[found->before]) return false;  // it fell for good, and first too far
    std::size_t i = found->before;
    const double since = ago(i);
    while (came_from(before(i)) && ago(before(i)) < since + early) i = before(i);
    for (;; i = (i + 1) % size()) {
      grip_[i] = std::min(grip_[i], found->mean / mu);
      if (i == found->last) return true;
    }
  }

  std::optional<Fall> find_fall(std::size_t piece, double mu) const {
    const auto high = [&](std::size_t i) { return sure_at_[i] && believed_[i] >= fall * mu; };
    std::size_t i = piece;
    for (; ago(i) < settle; i = before(i))  // risen by now
      if (!high(i) || before(i) == piece || !came_from(before(i))) return std::nullopt;
    if (high(i)) return std::nullopt;
    const std::size_t last = i;
    double sum = 0, count = 0, sure_first = 0, sure_last = ago(last);  // [s] ago, going back
    for (double pieces = 1; !high(i); i = before(i), ++pieces) {
      if (grip_[i] < 1.0 || !came_from(before(i)) || pieces > longest * static_cast<double>(size()))
        return std::nullopt;
      if (ago(i) - sure_last > doubt) return std::nullopt;
      if (!sure_at_[i]) continue;
      sure_last = ago(i);
      if (count == 0) sure_first = sure_last;
      sum += believed_[i];
      ++count;
    }
    if (count == 0 || sure_last - sure_first < shortest) return std::nullopt;
    return Fall{i, last, sum / count};
  }

  double dt_;
  std::vector<double> grip_, believed_;
  std::vector<long> seen_;     // the step in which a piece was passed last, -1: never
  std::vector<bool> sure_at_;  // whether the belief was sure then
  long now_ = 0;
  std::size_t piece_ = 0, begin_ = 0;
  double mu_ = std::numeric_limits<double>::quiet_NaN();
  double behind_ = 0;  // [s]
  bool holding_ = false, dry_ = false, sure_ = false;
};

}  // namespace gripline::time_optimal
