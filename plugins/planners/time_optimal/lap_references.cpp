#include "planners/time_optimal/lap_references.hpp"

#include <algorithm>
#include <cmath>
#include <gripline/plugin.hpp>
#include <numbers>

namespace gripline::time_optimal {

LapReferences::LapReferences(const PluginContext& context, const LapParams& params, bool at_own_speed,
                             const Sources& from)
    : car_(context.car),
      dt_(context.dt),
      course_(context.course),
      from_car_speed_(params.from_car_speed),
      at_own_speed_(at_own_speed),
      from_(from) {}

double LapReferences::gain(double v) const {
  return from_car_speed_ ? std::max(0.0, from_.setup->full_throttle(v, step_.resistance)) : 1e9;
}

/// The sideslip angle at the pace that is driven. A car that keeps something back of the friction that there is needs
/// less side force, and slips less: as far as its rear tyres say, in a steady turn. One that is slower since there is
/// less friction than the plan is for slips as far as planned.
double LapReferences::sideslip(const PlanPoint& p) const {
  const double use = from_.reserve->use_of_friction(p.v);
  if (use >= 1.0) return p.beta;
  const MagicFormula& rear = step_.rear;
  const double turn = car_.lr * p.kappa, slip = turn - p.beta;
  const double force = use * use * rear.force(std::min(std::abs(slip), rear.slip(0.999 * rear.D)));
  return turn - std::copysign(std::min(rear.slip(force), std::abs(slip)), slip);
}

/// At a station of the base line, where the plan leads through p.
RefPoint LapReferences::at(double s, const PlanPoint& p, double yaw_near) const {
  const planning::ClosedLine& base = from_.setup->base();
  const CoursePoint c = course_->locate(p.x, p.y, base.samples()[base.bracket(s).first].station);
  RefPoint r;
  r.s = s;
  r.x = p.x;
  r.y = p.y;
  r.yaw = yaw_near + std::remainder(p.yaw - yaw_near, 2.0 * std::numbers::pi);
  r.kappa = p.kappa;
  r.beta = sideslip(p);
  r.v = driven_speed(p.v) * std::cos(r.beta);
  // Room along the path's normal; the offset is measured along the centre line's.
  const double across = std::max(0.5, std::cos(p.yaw - c.yaw));
  r.left = (c.left - c.n) / across - step_.tightened;
  r.right = (c.right + c.n) / across - step_.tightened;
  r.at.s = c.s;
  r.at.n = c.n;
  r.at.lap_fraction = c.lap_fraction;
  r.at.yaw_line = c.yaw;
  r.at.kappa = c.kappa;
  r.at.grade = c.grade;
  r.at.bank = c.bank;
  return r;
}

double LapReferences::way_stretch(double s, const PlanPoint& p) const {
  return at_own_speed_ ? from_.join->stretch(s, p.kappa) : 1.0;
}

/// The first advance is with the car's own speed; references then gain speed as the car can until they drive the plan.
/// Each advance takes the speed half-way.
void LapReferences::sample(const Observation& now, double station, std::span<RefPoint> horizon) const {
  double s = station, yaw = now.x.yaw;
  double v = std::max(std::hypot(now.x.vx, now.x.vy), 0.01);
  for (std::size_t k = 0; k < horizon.size(); ++k) {
    RefPoint& r = horizon[k];
    const PlanPoint here = from_.line->at(s);
    r = at(s, here, yaw);
    r.at.t = now.t + static_cast<double>(k) * dt_;
    r.at.direction = now.at.direction;
    yaw = r.yaw;
    if (k > 0) {
      v = std::min({driven_speed(here.v), from_.join->speed(s), v + gain(v) * dt_});
      r.v = v * std::cos(r.beta);
    }
    const double half = s + 0.5 * dt_ * v / (here.stretch * way_stretch(s, here));
    const PlanPoint middle = from_.line->at(half);
    const double planned = driven_speed(middle.v);
    const double advance = k > 0 && v >= driven_speed(here.v) ? planned : v;  // a car at the planned speed keeps to it
    const double way = middle.stretch * way_stretch(half, middle);
    s = wrap_periodic(s + dt_ * advance / way, from_.setup->base().length());
  }
}

}  // namespace gripline::time_optimal
