#include "planners/time_optimal/friction_places.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace gripline::time_optimal {
namespace {

constexpr double fall_share = FrictionFall::share;
constexpr double longest_delay = 0.2;     // [s] at most from the begin of a place to a belief that is not sure any more
constexpr double least_evidence = 0.1;    // [s] of evidence of less friction
constexpr double largest_place = 0.5;     // share of the road
constexpr double explained_share = 0.95;  // of what a place explains
constexpr double longest_return = 0.4;    // [s] behind a place, for the belief to come back
constexpr double same_end = 0.2;          // [s] by which the ends of a place are the same,
constexpr double same_grip = 0.05;        // and share of its grip

}  // namespace

FrictionPlaces::FrictionPlaces(std::size_t pieces, double dt, double detection_time)
    : dt_(dt),
      detection_time_(detection_time),
      grip_(pieces, 1.0),
      passed_(pieces),
      recent_(static_cast<std::size_t>(std::max(1.0, std::round((detection_time + longest_delay) / dt)))) {
  beliefs_.reserve(pieces);
}

bool FrictionPlaces::step(std::size_t piece, double mu, double spread) {
  ++now_;
  const Seen here{piece, mu, spread, now_};
  bool changed = false;
  if (now_ > 1 && way_from(piece_, piece) > near_pieces() && way_from(piece, piece_) > near_pieces()) {
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

std::size_t FrictionPlaces::first_of_place(std::size_t i) const {
  for (std::size_t n = 0; n < size() && grip_[before(i)] < 1.0; ++n) i = before(i);
  return i;
}

std::size_t FrictionPlaces::last_of_place(std::size_t i) const {
  for (std::size_t n = 0; n < size() && grip_[after(i)] < 1.0; ++n) i = after(i);
  return i;
}

/// Notes the belief on all pieces that were passed in this step; of a car that was carried elsewhere, on its own only.
void FrictionPlaces::note(const Seen& here) {
  std::size_t way = way_from(piece_, here.piece);
  if (now_ <= 1 || way > near_pieces()) way = 0;
  for (std::size_t k = 0; k <= way; ++k) {
    const std::size_t i = (here.piece + size() - k) % size();
    if (k > 0 && i == piece_) break;
    passed_[i] = here;
  }
}

/// Follows a belief that falls until it comes back. Whether it was that of a place, which is known then.
bool FrictionPlaces::watch(const Seen& here) {
  if (!fall_) {
    look_for_fall(here);
    return false;
  }
  const bool was_sure = fall_->is_sure();
  const FrictionFall::Now now = fall_->see(here);
  if (now == FrictionFall::Now::again) return give_up();
  if (fall_->is_sure() && !was_sure) fall_->begin_at(begin_of(fall_->before()));
  const std::size_t way = way_from(fall_->before().piece, here.piece);
  if (now != FrictionFall::Now::back && static_cast<double>(way) > largest_place * static_cast<double>(size()))
    return give_up();  // the whole road's
  return fall_->is_over() && learn(here.mu);
}

/// Forgets a fall that was not that of a place. If a known place was extended backwards for it (begin_earlier()), that
/// is undone. Whether a grip changed.
bool FrictionPlaces::give_up() {
  if (!fall_) return false;
  const FrictionFall fall = *fall_;
  fall_.reset();
  for (std::size_t i = fall.begin(); i != fall.joined(); i = after(i)) grip_[i] = 1.0;
  return fall.has_joined();
}

/// A sure fall just before a known place, to about its grip, is the place's: mu(t) stays what it was before the fall.
/// Whether the place begins earlier now.
bool FrictionPlaces::begin_earlier(const Seen& here) {
  if (!fall_ || !fall_->is_sure() || fall_->has_joined() || holding_) return false;
  std::size_t first = fall_->begin();
  for (std::size_t n = 0; n < near_pieces() && !(grip_[first] < 1.0); ++n) first = after(first);
  const double grip = grip_[first], explained = fall_->level() * grip;
  if (first == fall_->begin() || !(grip < 1.0) || !(std::abs(here.mu - explained) <= 2.0 * same_grip * explained))
    return false;
  for (std::size_t i = fall_->begin(); i != first; i = after(i)) grip_[i] = grip;
  fall_->join(first);
  mu_ = fall_->level();
  return true;
}

/// Whether much more was surely believed a moment ago.
void FrictionPlaces::look_for_fall(const Seen& here) {
  const long first = std::max(since_, now_ - std::lround(detection_time_ / dt_));
  double level = 0;
  for (long k = first; k < now_; ++k)
    if (recent(k).sure()) level = std::max(level, recent(k).mu);
  if (!here.below(fall_share * level)) return;
  for (long k = now_ - 1; k >= first; --k)
    if (recent(k).sure() && recent(k).mu >= fall_share * level) {
      fall_.emplace(recent(k), level, here, dt_, detection_time_);
      if (here.sure()) fall_->begin_at(begin_of(recent(k)));
      return;
    }
}

/// The place of a fall that ended, where mu is believed now: in place of what was known there. Whether that is new.
bool FrictionPlaces::learn(double mu) {
  const FrictionFall fall = *fall_;
  const std::size_t before_fall = fall.before().piece, begin = fall.begin(), last = fall.last();
  const double level = fall_share * fall.level(), grip = settled(before_fall, last, level) / mu;
  const std::size_t pieces = way_from(begin, last);
  const bool place = fall.evidence() >= least_evidence && grip < fall_share &&
                     static_cast<double>(pieces) <= largest_place * static_cast<double>(size()) &&
                     way_from(before_fall, last) <= pieces;
  if (!place) return give_up();
  fall_.reset();
  if (is_known(fall, grip)) return false;
  // The rest of what was known of this place, but not a neighbour.
  const auto was_of_it = [&](std::size_t i) { return grip_[i] < 1.0 && !passed_[i].below(level); };
  for (std::size_t i = before(begin); was_of_it(i); i = before(i)) grip_[i] = 1.0;
  for (std::size_t i = after(last); was_of_it(i); i = after(i)) grip_[i] = 1.0;
  for (std::size_t i = begin;; i = after(i)) {
    grip_[i] = grip;
    if (i == last) return true;
  }
}

/// Where a place begins: the slower the estimator detects the new friction, the longer its estimate stayed the old one.
std::size_t FrictionPlaces::begin_of(const Seen& sure_before) const {
  const double took = seconds(now_ - sure_before.step);
  const long early = std::lround(std::clamp(took, 0.0, longest_delay) / dt_);
  const long step = std::max(since_, sure_before.step - early);
  return step > now_ - static_cast<long>(recent_.size()) ? recent(step).piece : sure_before.piece;
}

/// The quartile of what was believed on some pieces, of what is evidence of less than `level`: a learner takes its time
/// to find less friction, and more to find that it is back. NaN where nothing is evidence.
double FrictionPlaces::settled(std::size_t first, std::size_t last, double level) {
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
bool FrictionPlaces::is_known(const FrictionFall& fall, double grip) const {
  const std::size_t before_fall = fall.before().piece;
  for (std::size_t i = before_fall;; i = after(i)) {
    if (!(std::abs(grip_[i] - grip) <= same_grip * grip)) return false;
    if (i == fall.last()) break;
  }
  const std::size_t first = first_of_place(before_fall), last = last_of_place(fall.last());
  const auto steps = [&](std::size_t from, std::size_t to) { return passed_[to].step - passed_[from].step; };
  const bool passed = steps(fall.last(), last) >= 0;  // the car is not in it any more
  return passed && seconds(steps(first, fall.begin())) <= same_end && seconds(steps(fall.last(), last)) <= same_end;
}

void FrictionPlaces::in_place(std::size_t piece, double mu) {
  if (!holding_) {
    holding_ = true;
    as_before_ = true;
    entered_ = piece;
    // It may begin a little earlier than was known.
    if (fall_ && seconds(now_ - fall_->before().step) < detection_time_ &&
        mu >= explained_share * fall_->level() * grip_[piece])
      mu_ = fall_->level();
  }
  const double explained = mu_ * grip_[piece];
  if (mu < 0.5 * (mu_ + explained)) as_before_ = false;
  if (mu < explained_share * explained) mu_ = mu / grip_[piece];
  behind_ = 0;
}

/// A step just behind a place: holds what was believed before it until the belief comes back or has had its time. True
/// where the belief did not fall in the place, which is forgotten then.
bool FrictionPlaces::behind_place(double mu) {
  behind_ += dt_;
  if (mu < fall_share * mu_ && behind_ < longest_return) return false;
  holding_ = false;
  if (mu < mu_) mu_ = mu;
  if (!as_before_) return false;
  for (std::size_t i = first_of_place(entered_); grip_[i] < 1.0; i = after(i)) grip_[i] = 1.0;
  return true;
}

}  // namespace gripline::time_optimal
