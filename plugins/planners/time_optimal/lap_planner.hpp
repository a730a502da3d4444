// What the planners of time-optimal laps share: what is believed of the car, and references along a lap, however it is
// solved.
//
//   mu_plan = factor (mu - sigma sigma_mu), rising by at most `rise` per second; start mu_init until mu is trusted
//   v_driven = pace' v,   pace' of pace_reserve.hpp
//
// Speeds are stated along the car's axis, v cos(beta).
#pragma once

#include <algorithm>
#include <cmath>
#include <gripline/plugin.hpp>
#include <gripline/slip.hpp>
#include <limits>
#include <numbers>
#include <optional>

#include "common/planning/join_path.hpp"
#include "common/planning/planner_context.hpp"
#include "common/planning/recovery_path.hpp"
#include "planners/time_optimal/lap_parameters.hpp"
#include "planners/time_optimal/lap_plan.hpp"
#include "planners/time_optimal/lap_setup.hpp"
#include "planners/time_optimal/pace_reserve.hpp"
#include "planners/time_optimal/resistance_fit.hpp"
#include "planners/time_optimal/tyre_fit.hpp"

namespace gripline::time_optimal {

using namespace planning;

/// Beliefs, and references along a lap, however it is solved.
class LapPlanner : public SpeedPlanner {
 public:
  /// What the planners do differently. The library's laps are bounded by its own least friction.
  struct Manner {
    double least_mu = -std::numeric_limits<double>::infinity();  // that is planned for
    double most_mu = std::numeric_limits<double>::infinity();
    double reach = 0.4;  // see JoinPath
    // On the way to the line references advance as fast as they are planned, not as fast as the line beside them.
    bool at_own_speed = false;
    AxleSharing sharing{};
    double slip_slow = 0, slip_fast = 0;  // see LapProblem [m/s]
  };
  LapPlanner(const PluginContext& context, const LapParams& params, const Manner& manner)
      : k_(params),
        manner_(manner),
        car_(context.car),
        dt_(context.dt),
        mu_init_(context.mu_init),
        course_(context.course),
        generic_(generic_tyres(context.car, params)),
        nominal_(context.nominal),
        typical_{scaled_to(generic_, std::sqrt(params.mu_lo * params.mu_hi)), {params.rolling, params.drag}},
        setup_(context, options(context.car, params, manner), typical_),
        line_(setup_),
        resistance_(typical_.resistance, context.car.v_ref),
        join_(context.car, setup_.base().length(), manner.reach),
        recovery_(context.car, setup_.base()),
        mu_plan_(params.start * context.mu_init),
        reserve_(params, setup_.top_speed()) {}

  void plan(const Observation& now, const Belief& belief, const TyreCurve* learned,
            std::span<RefPoint> horizon) override {
    const double forward = std::max(std::abs(now.x.vx), car_.v_min);
    front_seen_.add(front_slip(forward, now.x.vy, now.x.omega, now.x.delta, car_.lf));
    rear_seen_.add(rear_slip(forward, now.x.vy, now.x.omega, car_.lr));
    AxleTyres tyres = believed_tyres(belief, learned);
    const MagicFormula front = tyres.front;
    double spread = (belief.sigma_front * car_.lr + belief.sigma_rear * car_.lf) / (car_.lf + car_.lr);
    if (belief.trusted) see(now, tyres, spread);
    relative_spread_ = spread / std::max(mu_of(tyres), 1e-3);
    approach(belief.trusted ? k_.factor * (mu_of(tyres) - k_.sigma * spread) : k_.start * mu_init_);
    reserve_.set(mu_plan_, belief.trusted);
    const bool replan = belief.trusted && learned != nullptr && k_.replan;
    rear_ = replan ? tyres.rear : generic_.rear;
    if (replan && before_) resistance_.learn(*before_, now, dt_, front, car_, *nominal_);
    before_ = now;
    const CarBelief car{tyres, resistance_.value()};
    update(replan ? &car : nullptr, now);
    const double tightened = car_.width * (k_.tighten + k_.tighten_sigma * relative_spread_);
    const double station = line_.locate(now.x.x, now.x.y);
    const auto on_line = [&](double s) { return reference(s, line_.at(s), now.x.yaw, tightened); };
    const double here = mu_plan_ * grip_here();
    if (recovery_.update(now, station, here, on_line)) {
      join_.forget();
      const auto speed = [&](double s) { return driven_speed(line_.at(s).v); };
      recovery_.fill(
          now, dt_, on_line, speed, [&](double v) { return gain(v); }, horizon);
      return;
    }
    join_.update(now, on_line(station), here, static_cast<double>(horizon.size()) * dt_);
    sample(now, station, tightened, horizon);
    join_.move(horizon);
  }
  std::span<const LinePoint> line() const override { return line_.samples(); }

 protected:
  /// Sets line_ for this step; null: nothing is learned of the car.
  virtual void update(const CarBelief* learned, const Observation& now) = 0;
  /// May replace what is believed here, its friction's deviation included, by what is believed of the road ahead.
  virtual void see(const Observation& /*now*/, AxleTyres& /*tyres*/, double& /*spread*/) {}
  /// Friction below the car over mu_plan().
  virtual double grip_here() const { return 1.0; }
  /// Friction expected at a station of the base line over that believed below the car.
  virtual double grip_ahead(double /*station*/) const { return 1.0; }

  /// What is driven where v is planned [m/s].
  double driven_speed(double v) const { return reserve_.pace(v) * v; }

  double dt() const { return dt_; }  // control step [s]
  const LapSetup& setup() const { return setup_; }
  const CarBelief& typical() const { return typical_; }
  /// Standard deviation of the believed friction over that friction.
  double relative_spread() const { return relative_spread_; }
  /// Friction that is planned for.
  double mu_plan() const { return mu_plan_; }
  PlanFollower& followed() { return line_; }
  /// Whether references lead the car to the line from elsewhere.
  bool joins() const { return join_.active() || recovery_.active(); }
  /// Slip that the front or the rear axle exceeded in one of 200 steps [rad].
  double visited_slip() const { return std::max(front_seen_.visited(), rear_seen_.visited()); }
  LapPlan plan_;

 private:
  static SetupOptions options(const Car& car, const LapParams& k, const Manner& manner) {
    return {k.margin * car.width, k.spacing,        k.combined,    k.slip_max,
            manner.slip_slow,     manner.slip_fast, k.brakes, manner.sharing};
  }
  static AxleTyres generic_tyres(const Car& car, const LapParams& k) {
    const AxleTyres tyres{{k.front_B, k.front_C, k.balance * car.lr}, {k.rear_B, k.rear_C, car.lf}};
    return scaled_to(tyres, 1.0);
  }
  AxleTyres believed_tyres(const Belief& belief, const TyreCurve* learned) const {
    const double weight = gravity / (car_.lf + car_.lr);
    const auto prior = [](const MagicFormula& shape, double D, double mu, double sigma) {
      return AxlePrior{{shape.B, shape.C, std::max(D, 1e-3)}, std::max(0.08, sigma / std::max(mu, 1e-3))};
    };
    const AxlePrior front =
        prior(generic_.front, belief.mu_front * weight * car_.lr, belief.mu_front, belief.sigma_front);
    const AxlePrior rear = prior(generic_.rear, belief.mu_rear * weight * car_.lf, belief.mu_rear, belief.sigma_rear);
    if (learned == nullptr) return {front.shape, rear.shape};
    return {fit_learned(*learned, Axle::front, car_.m, front_seen_.visited(), front),
            fit_learned(*learned, Axle::rear, car_.m, rear_seen_.visited(), rear)};
  }

  /// A fall of the friction counts at once, a rise at the rate `rise`.
  void approach(double target) {
    const double allowed = std::min(std::max(target, manner_.least_mu), manner_.most_mu);
    mu_plan_ = std::min(allowed, mu_plan_ + k_.rise * dt_);
  }

  /// The sideslip angle at the pace that is driven. A car that is slower than its plan needs less side force, and slips
  /// less: as far as its rear tyres say, in a steady turn.
  double sideslip(const PlanPoint& p) const {
    const double pace = reserve_.pace(p.v);
    if (pace >= 1.0) return p.beta;
    const double turn = car_.lr * p.kappa, slip = turn - p.beta;
    const double force = pace * pace * rear_.force(std::min(std::abs(slip), rear_.slip(0.999 * rear_.D)));
    return turn - std::copysign(std::min(rear_.slip(force), std::abs(slip)), slip);
  }

  /// At a station of the base line, where the plan leads through p.
  RefPoint reference(double s, const PlanPoint& p, double yaw_near, double tightened) const {
    const ClosedLine& base = setup_.base();
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
    r.left = (c.left - c.n) / across - tightened;
    r.right = (c.right + c.n) / across - tightened;
    r.at.s = c.s;
    r.at.n = c.n;
    r.at.lap_fraction = c.lap_fraction;
    r.at.yaw_line = c.yaw;
    r.at.kappa = c.kappa;
    r.at.grade = c.grade;
    r.at.bank = c.bank;
    r.at.grip = grip_ahead(s);
    return r;
  }

  double way_stretch(double s, const PlanPoint& p) const {
    return manner_.at_own_speed ? join_.stretch(s, p.kappa) : 1.0;
  }

  /// The acceleration by which references may gain speed [m/s2].
  double gain(double v) const {
    return k_.from_car_speed ? std::max(0.0, setup_.full_throttle(v, resistance_.value())) : 1e9;
  }

  /// The first advance is with the car's own speed; references then gain speed as the car can until they drive the
  /// plan. Each advance takes the speed half-way.
  void sample(const Observation& now, double station, double tightened, std::span<RefPoint> horizon) {
    double s = station, yaw = now.x.yaw;
    double v = std::max(std::hypot(now.x.vx, now.x.vy), 0.01);
    for (std::size_t k = 0; k < horizon.size(); ++k) {
      RefPoint& r = horizon[k];
      const PlanPoint here = line_.at(s);
      r = reference(s, here, yaw, tightened);
      r.at.t = now.t + static_cast<double>(k) * dt_;
      r.at.direction = now.at.direction;
      yaw = r.yaw;
      if (k > 0) {
        v = std::min({driven_speed(here.v), join_.speed(s), v + gain(v) * dt_});
        r.v = v * std::cos(r.beta);
      }
      const double half = s + 0.5 * dt_ * v / (here.stretch * way_stretch(s, here));
      const PlanPoint middle = line_.at(half);
      const double planned = driven_speed(middle.v);
      const double advance =
          k > 0 && v >= driven_speed(here.v) ? planned : v;  // a car at the planned speed keeps to it
      const double way = middle.stretch * way_stretch(half, middle);
      s = wrap_periodic(s + dt_ * advance / way, setup_.base().length());
    }
  }

  LapParams k_;
  Manner manner_;
  Car car_;
  double dt_, mu_init_;
  const Course* course_;
  AxleTyres generic_;
  Prediction* nominal_;
  CarBelief typical_;
  LapSetup setup_;
  PlanFollower line_;
  ResistanceFit resistance_;
  std::optional<Observation> before_;
  JoinPath join_;
  RecoveryPath recovery_;
  double mu_plan_;
  PaceReserve reserve_;
  double relative_spread_ = 0;
  MagicFormula rear_;  // that is planned for, up to its friction
  SlipRange front_seen_, rear_seen_;
};

}  // namespace gripline::time_optimal
