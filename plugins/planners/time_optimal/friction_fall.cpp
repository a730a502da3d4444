#include "planners/time_optimal/friction_fall.hpp"

#include <algorithm>

namespace gripline::time_optimal {
namespace {

constexpr double rise_share = 0.67;  // of the way back, that ends a fall
constexpr double settling = 0.2;     // [s] that a risen belief is waited for

}  // namespace

bool SeenFriction::sure() const { return step >= 0 && 2.0 * spread <= (1.0 - FrictionFall::share) * mu; }

bool SeenFriction::below(double friction) const { return step >= 0 && (sure() ? mu : mu + 2.0 * spread) < friction; }

FrictionFall::FrictionFall(const SeenFriction& before, double level, const SeenFriction& here, double dt,
                           double detection_time)
    : before_(before),
      level_(level),
      dt_(dt),
      detection_time_(detection_time),
      last_evidence_(here.step),
      lowest_(here.mu),
      sure_(here.sure()),
      begin_(before.piece),
      joined_(before.piece),
      low_(here.piece),
      last_(here.piece) {}

FrictionFall::Now FrictionFall::see(const SeenFriction& here) {
  lowest_ = std::min(lowest_, here.mu);
  // A learner that had come to believe too much comes back to less.
  const double again = std::min(share * level_, lowest_ + rise_share * (level_ - lowest_));
  if (here.below(again)) {
    if (ended_) return Now::again;
    low_ = here.piece;
    last_evidence_ = here.step;
    ++evidence_;
    sure_ = sure_ || here.sure();
  }
  const bool back = here.sure() && here.mu >= again;
  risen_ = back ? risen_ + dt_ : 0.0;
  if (!back && !ended_) {
    ended_ = seconds(here.step - last_evidence_) > detection_time_;
    last_ = ended_ ? low_ : here.piece;
  }
  return back ? Now::back : Now::lasts;
}

bool FrictionFall::is_over() const { return risen_ >= settling; }

}  // namespace gripline::time_optimal
