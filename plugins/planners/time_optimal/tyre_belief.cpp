#include "planners/time_optimal/tyre_belief.hpp"

#include <algorithm>
#include <cmath>
#include <gripline/slip.hpp>

#include "planners/time_optimal/lap_dynamics.hpp"

namespace gripline::time_optimal {
namespace {

AxleTyres generic_tyres(const Car& car, const LapParams& k) {
  const AxleTyres tyres{{k.front_B, k.front_C, k.balance * car.lr}, {k.rear_B, k.rear_C, car.lf}};
  return scaled_to(tyres, 1.0);
}

/// A shape at a stated peak force over mass; `mu` and its deviation `sigma` say how well that is known.
AxlePrior prior_of(const MagicFormula& shape, double D, double mu, double sigma) {
  return {{shape.B, shape.C, std::max(D, 1e-3)}, std::max(0.08, sigma / std::max(mu, 1e-3))};
}

}  // namespace

TyreBelief::TyreBelief(const Car& car, const LapParams& params) : car_(car), generic_(generic_tyres(car, params)) {}

void TyreBelief::see(const State& x) {
  const double forward = std::max(std::abs(x.vx), car_.v_min);
  front_seen_.add(front_slip(forward, x.vy, x.omega, steered_along_motion(x.vx, x.delta), car_.lf));
  rear_seen_.add(rear_slip(forward, x.vy, x.omega, car_.lr));
}

AxleTyres TyreBelief::tyres(const Belief& belief, const TyreCurve* learned) const {
  const double weight = gravity / (car_.lf + car_.lr);
  const AxlePrior front =
      prior_of(generic_.front, belief.mu_front * weight * car_.lr, belief.mu_front, belief.sigma_front);
  const AxlePrior rear = prior_of(generic_.rear, belief.mu_rear * weight * car_.lf, belief.mu_rear, belief.sigma_rear);
  if (learned == nullptr) return {front.shape, rear.shape};
  return {fit_learned(*learned, Axle::front, car_.m, front_seen_.visited(), front),
          fit_learned(*learned, Axle::rear, car_.m, rear_seen_.visited(), rear)};
}

double TyreBelief::visited_slip() const { return std::max(front_seen_.visited(), rear_seen_.visited()); }

}  // namespace gripline::time_optimal
