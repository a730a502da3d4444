// Where the road is slippery, learned from a friction that is believed as the car drives.
//
//   friction(s, t) = mu(t) grip(s)
//
// A belief that falls within a moment and, less than half a lap later, comes back was that of a place: what was believed
// there, once it had settled, over what is believed behind it is its grip. One that falls and stays fallen is the whole
// road's. While a learner finds the new friction its belief is not sure: that part of the road belongs to the place, if it
// is short. On the next lap the place is known before the car is there; in it mu(t) is held, and lowered where even less
// is believed than the place explains. Each lap measures a place anew: where it begins and ends and its grip are those of
// the last lap that told them otherwise, and it is forgotten when the belief does not fall there any more. A stretch that
// became slippery while the car was on it is known from there on; when the belief falls to its grip before that, it begins
// there at once.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

namespace gripline::time_optimal {

class FrictionPlaces {
 public:
  /// Of a closed road in so many pieces, with `dt` seconds between steps; a learner takes up to `doubt` seconds to find a
  /// new friction. Steps do not allocate.
  FrictionPlaces(std::size_t pieces, double dt, double doubt)
      : dt_(dt),
        doubt_(doubt),
        grip_(pieces, 1.0),
        passed_(pieces),
        recent_(static_cast<std::size_t>(std::max(1.0, std::round((doubt + latest) / dt)))) {
    beliefs_.reserve(pieces);
  }

  /// Once per control step: the car is on this piece and believes this friction of the road below it, with a standard
  /// deviation of `spread`. Whether a grip changed.
  bool step(std::size_t piece, double mu, double spread = 0.0) {
    ++now_;
    const Seen here{piece, mu, spread, now_};
    bool changed = false;
    if (now_ > 1 && way_from(piece_, piece) > size() / 8 && way_from(piece, piece_) > size() / 8) {
      changed = give_up();
      holding_ = false;
      since_ = now_;
    }
    note(here);
    changed = watch(here) || changed;
    changed = begin_earlier(here) || changed;
    if (grip_[piece] < 1.0) {
      in_place(piece, mu);
    } else if (holding_) {
      changed = behind_place(mu) || changed;
    } else {
      mu_ = mu;
    }
    recent_[static_cast<std::size_t>(now_) % recent_.size()] = here;
    piece_ = piece;
    return changed;
  }
  /// mu(t): the friction believed, without the place that the car is in; NaN before the first step.
  double mu() const { return mu_; }
  /// Whether the car is in a known place, so that its belief is not that of the road ahead.
  bool holding() const { return holding_; }
  double grip(std::size_t piece) const { return grip_[piece]; }

 private:
  static constexpr double fall = 0.9;    // of the friction before it, that makes a place
  static constexpr double most = 0.67;   // of the way back, that ends it
  static constexpr double settle = 0.2;  // [s] that a risen belief is waited for
  static constexpr double latest = 0.2;  // [s] at most from the begin of a place to a belief that is not sure any more
  static constexpr double shortest = 0.1;  // [s] of evidence of less friction
  static constexpr double longest = 0.5;   // share of the road
  static constexpr double slack = 0.95;    // of what a place explains
  static constexpr double patience = 0.4;  // [s] behind a place, for the belief to come back
  static constexpr double same = 0.2;      // [s] by which the ends of a place are the same,
  static constexpr double alike = 0.05;    // and share of its grip

  /// A belief and where it was.
  struct Seen {
    std::size_t piece = 0;
    double mu = 0, spread = 0;
    long step = -1;  // -1: never
    bool sure() const { return step >= 0 && 2.0 * spread <= (1.0 - fall) * mu; }
    /// Evidence of less friction than this.
    bool below(double friction) const { return step >= 0 && (sure() ? mu : mu + 2.0 * spread) < friction; }
  };
  /// A belief that fell and has not come back yet.
  struct Fallen {
    Seen before;         // the last sure belief of the friction that it fell from
    double level;        // that friction
    long last_evidence;  // step
    int evidence;        // steps
    double lowest;       // friction believed since
    bool surely;         // less is believed surely, not only surely less
    std::size_t begin;   // piece where the place begins, if it is one
    std::size_t last;    // piece where the belief was not back yet
    std::size_t low;     // piece with the last evidence
    double risen;        // [s] for which it has been back
    bool ended;          // long without evidence
    std::size_t joined;  // pieces from `begin` up to here, where a known place began, were joined to it; `begin`: none
  };

  std::size_t size() const { return grip_.size(); }
  std::size_t before(std::size_t i) const { return i > 0 ? i - 1 : size() - 1; }
  std::size_t after(std::size_t i) const { return i + 1 < size() ? i + 1 : 0; }
  std::size_t way_from(std::size_t from, std::size_t to) const { return (to + size() - from) % size(); }
  std::size_t first_of_place(std::size_t i) const {
    for (std::size_t n = 0; n < size() && grip_[before(i)] < 1.0; ++n) i = before(i);
    return i;
  }
  std::size_t last_of_place(std::size_t i) const {
    for (std::size_t n = 0; n < size() && grip_[after(i)] < 1.0; ++n) i = after(i);
    return i;
  }
  double seconds(long steps) const { return dt_ * static_cast<double>(steps); }
  const Seen& recent(long step) const { return recent_[static_cast<std::size_t>(step) % recent_.size()]; }

  void note(const Seen& here) {
    // Pieces that were passed within a step; a car that was carried elsewhere passed none.
    std::size_t way = way_from(piece_, here.piece);
    if (now_ <= 1 || way > size() / 8) way = 0;
    for (std::size_t k = 0; k <= way; ++k) {
      const std::size_t i = (here.piece + size() - k) % size();
      if (k > 0 && i == piece_) break;
      passed_[i] = here;
    }
  }

  /// Follows a belief that falls until it comes back. Whether it was that of a place, which is known then.
  bool watch(const Seen& here) {
    if (!fallen_) {
      look_for_fall(here);
      return false;
    }
    Fallen& f = *fallen_;
    f.lowest = std::min(f.lowest, here.mu);
    // A learner that had come to believe too much comes back to less.
    const double again = std::min(fall * f.level, f.lowest + most * (f.level - f.lowest));
    if (here.below(again)) {
      if (f.ended) return give_up();  // a second one: the first is not told from the whole road's
      f.low = here.piece;
      f.last_evidence = now_;
      ++f.evidence;
      if (here.sure() && !f.surely) {
        f.surely = true;
        f.begin = f.joined = begin_of(f);
      }
    }
    const bool back = here.sure() && here.mu >= again;
    f.risen = back ? f.risen + dt_ : 0.0;
    if (!back && !f.ended) {
      f.ended = seconds(now_ - f.last_evidence) > doubt_;
      f.last = f.ended ? f.low : here.piece;
    }
    if (!back && static_cast<double>(way_from(f.before.piece, here.piece)) > longest * static_cast<double>(size()))
      return give_up();  // the whole road's
    return f.risen >= settle && learn(here.mu);
  }

  /// A fall that is that of no place: a known one that was begun earlier for it begins where it did. Whether there is one.
  bool give_up() {
    if (!fallen_) return false;
    const Fallen f = *fallen_;
    fallen_.reset();
    for (std::size_t i = f.begin; i != f.joined; i = after(i)) grip_[i] = 1.0;
    return f.begin != f.joined;
  }

  /// A sure fall just before a known place, to about its grip, is the place's: mu(t) stays what it was before the fall.
  /// Whether the place begins earlier now.
  bool begin_earlier(const Seen& here) {
    if (!fallen_ || !fallen_->surely || fallen_->begin != fallen_->joined || holding_) return false;
    std::size_t first = fallen_->begin;
    for (std::size_t n = 0; n < size() / 8 && !(grip_[first] < 1.0); ++n) first = after(first);
    const double grip = grip_[first], explained = fallen_->level * grip;
    if (first == fallen_->begin || !(grip < 1.0) || !(std::abs(here.mu - explained) <= 2.0 * alike * explained))
      return false;
    for (std::size_t i = fallen_->begin; i != first; i = after(i)) grip_[i] = grip;
    fallen_->joined = first;
    mu_ = fallen_->level;
    return true;
  }

  /// Whether much more was surely believed a moment ago.
  void look_for_fall(const Seen& here) {
    const long first = std::max(since_, now_ - std::lround(doubt_ / dt_));
    double level = 0;
    for (long k = first; k < now_; ++k)
      if (recent(k).sure()) level = std::max(level, recent(k).mu);
    if (!here.below(fall * level)) return;
    for (long k = now_ - 1; k >= first; --k)
      if (recent(k).sure() && recent(k).mu >= fall * level) {
        fallen_ = Fallen{.before = recent(k),
                         .level = level,
                         .last_evidence = now_,
                         .evidence = 1,
                         .lowest = here.mu,
                         .surely = here.sure(),
                         .begin = recent(k).piece,
                         .last = here.piece,
                         .low = here.piece,
                         .risen = 0.0,
                         .ended = false,
                         .joined = recent(k).piece};
        if (here.sure()) fallen_->begin = fallen_->joined = begin_of(*fallen_);
        return;
      }
  }

  /// The place of a fall that ended, where mu is believed now: in place of what was known there. Whether that is new.
  bool learn(double mu) {
    const Fallen f = *fallen_;
    const double level = fall * f.level, grip = settled(f.before.piece, f.last, level) / mu;
    const std::size_t pieces = way_from(f.begin, f.last);
    const bool place = seconds(f.evidence) >= shortest && grip < fall &&
                       static_cast<double>(pieces) <= longest * static_cast<double>(size()) &&
                       way_from(f.before.piece, f.last) <= pieces;
    if (!place) return give_up();
    fallen_.reset();
    if (is_known(f, grip)) return false;
    // The rest of what was known of this place, but not a neighbour.
    const auto was_of_it = [&](std::size_t i) { return grip_[i] < 1.0 && !passed_[i].below(level); };
    for (std::size_t i = before(f.begin); was_of_it(i); i = before(i)) grip_[i] = 1.0;
    for (std::size_t i = after(f.last); was_of_it(i); i = after(i)) grip_[i] = 1.0;
    for (std::size_t i = f.begin;; i = after(i)) {
      grip_[i] = grip;
      if (i == f.last) return true;
    }
  }

  /// The slower a learner finds the new friction, the longer it took before it began to doubt the old one.
  std::size_t begin_of(const Fallen& f) const {
    const double took = seconds(now_ - f.before.step);
    const long early = std::lround(std::clamp(took, 0.0, latest) / dt_);
    const long step = std::max(since_, f.before.step - early);
    return step > now_ - static_cast<long>(recent_.size()) ? recent(step).piece : f.before.piece;
  }

  /// The quartile of what was believed on some pieces, of what is evidence of less than `level`: a learner takes its time to
  /// find less friction, and more to find that it is back. NaN where nothing is evidence.
  double settled(std::size_t first, std::size_t last, double level) {
    beliefs_.clear();
    for (std::size_t i = first;; i = after(i)) {
      if (passed_[i].below(level)) beliefs_.push_back(passed_[i].mu);
      if (i == last) break;
    }
    if (beliefs_.empty()) return std::numeric_limits<double>::quiet_NaN();
    const auto quartile = beliefs_.begin() + static_cast<std::ptrdiff_t>(beliefs_.size() / 4);
    std::nth_element(beliefs_.begin(), quartile, beliefs_.end());
    return *quartile;
  }

  /// Whether a fall is that of a known place, with nearly the same ends and grip.
  bool is_known(const Fallen& f, double grip) const {
    for (std::size_t i = f.before.piece;; i = after(i)) {
      if (!(std::abs(grip_[i] - grip) <= alike * grip)) return false;
      if (i == f.last) break;
    }
    const std::size_t first = first_of_place(f.before.piece), last = last_of_place(f.last);
    const auto steps = [&](std::size_t from, std::size_t to) { return passed_[to].step - passed_[from].step; };
    const bool passed = steps(f.last, last) >= 0;  // the car is not in it any more
    return passed && seconds(steps(first, f.begin)) <= same && seconds(steps(f.last, last)) <= same;
  }

  void in_place(std::size_t piece, double mu) {
    if (!holding_) {
      holding_ = true;
      dry_ = true;
      begin_ = piece;
      // It may begin a little earlier than was known.
      if (fallen_ && seconds(now_ - fallen_->before.step) < doubt_ && mu >= slack * fallen_->level * grip_[piece])
        mu_ = fallen_->level;
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
    for (std::size_t i = first_of_place(begin_); grip_[i] < 1.0; i = after(i)) grip_[i] = 1.0;
    return true;
  }

  double dt_, doubt_;
  std::vector<double> grip_;
  std::vector<Seen> passed_;     // of each piece, when it was passed last
  std::vector<Seen> recent_;     // of the last steps, by their number
  std::vector<double> beliefs_;  // for settled()
  long now_ = 0, since_ = 1;     // steps: this one, and the first since the car was carried elsewhere
  std::size_t piece_ = 0, begin_ = 0;
  double mu_ = std::numeric_limits<double>::quiet_NaN();
  double behind_ = 0;  // [s]
  bool holding_ = false, dry_ = false;
  std::optional<Fallen> fallen_;
};

}  // namespace gripline::time_optimal
