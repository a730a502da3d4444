#include "planners/time_optimal/adaptive_laps.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "planners/time_optimal/tyre_fit.hpp"

namespace gripline::time_optimal {

AdaptiveLaps::AdaptiveLaps(const LapSetup& setup, std::vector<LapMember> members, const AdaptiveOptions& options)
    : setup_(&setup), options_(options), members_(std::move(members)) {
  for (const LapMember& m : members_) shown_.push_back({m.plan, m.plan, 0});
}

void AdaptiveLaps::advance_order() {
  if (order_.due < 0) return;
  ++order_.wait;
  if (order_.due-- > 0) return;
  if (!order_.worked_on) solve_order();
  if (order_.due >= 0 || !order_.solved) return;
  longest_wait_ = std::max(longest_wait_, order_.wait);
  Transition& shown = shown_[order_.member];
  shown.from = shown.now;
  shown.left = options_.transition;
}

void AdaptiveLaps::solve_order() {
  LapMember& member = members_[order_.member];
  const SolveOutcome outcome = solve_again(*setup_, order_.belief, member);
  // Where no lap is found for a car the old lap stays, and no solve for this car is ordered again.
  if (!outcome.solved) member.belief = order_.belief;
  order_.worked_on = true;
  order_.solved = outcome.solved;
  const int takes = static_cast<int>(std::min(std::ceil(outcome.work / options_.work_per_step), 1e6));
  if (takes > options_.latency) order_.due = takes - options_.latency - 1;
}

bool AdaptiveLaps::out_of_date(const CarBelief& learned, std::size_t member) const {
  const LapMember& m = members_[member];
  for (const double v : {0.25 * setup_->top_speed(), 0.75 * setup_->top_speed()})
    if (std::abs(learned.resistance.at(v) - m.belief.resistance.at(v)) > options_.tolerance * gravity) return true;
  return difference(m.belief.tyres, scaled_to(learned.tyres, m.mu), options_.slip_range) > options_.tolerance;
}

void AdaptiveLaps::place_order(const CarBelief& learned, std::size_t nearest, std::size_t other) {
  if (order_.due >= 0) return;
  for (const std::size_t member : {nearest, other}) {
    if (!out_of_date(learned, member)) continue;
    order_ = {.member = member,
              .belief = {scaled_to(learned.tyres, members_[member].mu), learned.resistance},
              .due = options_.latency};
    return;
  }
}

void AdaptiveLaps::advance_transitions() {
  for (std::size_t i = 0; i < shown_.size(); ++i) {
    Transition& s = shown_[i];
    if (s.left == 0) continue;
    --s.left;
    interpolate(members_[i].plan, s.from, static_cast<double>(s.left) / options_.transition, s.now);
  }
}

void AdaptiveLaps::step(const CarBelief* learned, double mu, LapPlan& out) {
  std::size_t upper = 0;
  while (upper + 1 < members_.size() && members_[upper].mu < mu) ++upper;
  const std::size_t lower = upper > 0 ? upper - 1 : 0;
  const double gap = members_[upper].mu - members_[lower].mu;
  const double share = gap > 0 ? std::clamp((mu - members_[lower].mu) / gap, 0.0, 1.0) : 1.0;
  advance_order();
  if (learned != nullptr) place_order(*learned, share > 0.5 ? upper : lower, share > 0.5 ? lower : upper);
  advance_transitions();
  interpolate(shown_[lower].now, shown_[upper].now, share, out);
}

}  // namespace gripline::time_optimal
