// What the planners of time-optimal laps share, however a lap is solved: what is believed of the car (tyre_belief.hpp,
// resistance_fit.hpp), which friction is planned for, and references along the lap (lap_references.hpp).
//
//   mu_plan = factor (mu - sigma sigma_mu), rising by at most `rise` per second; start mu_init until mu is trusted
//   v_driven = pace' v,   pace' of pace_reserve.hpp
//
// Laps are solved for mu_lo at least. A plan for less, to be sure of what is believed, is a lap for mu_lo; where less
// is believed, that lap is driven more slowly.
#pragma once

#include <algorithm>
#include <cmath>
#include <gripline/plugin.hpp>
#include <limits>
#include <optional>
#include <span>

#include "common/planning/join_path.hpp"
#include "common/planning/planned_friction.hpp"
#include "common/planning/planner_context.hpp"
#include "common/planning/recovery_path.hpp"
#include "planners/time_optimal/lap_dynamics.hpp"
#include "planners/time_optimal/lap_parameters.hpp"
#include "planners/time_optimal/lap_plan.hpp"
#include "planners/time_optimal/lap_references.hpp"
#include "planners/time_optimal/lap_setup.hpp"
#include "planners/time_optimal/pace_reserve.hpp"
#include "planners/time_optimal/resistance_fit.hpp"
#include "planners/time_optimal/tyre_belief.hpp"

namespace gripline::time_optimal {

using namespace planning;

/// Beliefs, and references along a lap, however it is solved. A planner's `plan` is these calls, in this order:
/// believe(), plan_for(), its own solver, whose lap it shows to followed(), and drive().
class LapPlanner : public SpeedPlanner {
 public:
  /// What the planners do differently. `time_optimal` sets no bounds of friction: beyond those of its library it has
  /// the first or the last lap.
  struct Manner {
    double least_mu = -std::numeric_limits<double>::infinity();  // that laps are solved for
    double most_mu = std::numeric_limits<double>::infinity();    // that is planned for
    double reach = 0.4;                                          // see JoinPath
    bool at_own_speed = false;                                   // see LapReferences
    AxleSharing sharing{};
    double full_slip_until_speed = 0, small_slip_from_speed = 0;  // see TyreUse [m/s]
  };
  LapPlanner(const PluginContext& context, const LapParams& params, const Manner& manner)
      : k_(params),
        manner_(manner),
        car_(context.car),
        dt_(context.dt),
        mu_init_(context.mu_init),
        tyres_(context.car, params),
        nominal_(context.nominal),
        typical_{scaled_to(tyres_.generic(), std::sqrt(params.mu_lo * params.mu_hi)), {params.rolling, params.drag}},
        setup_(context, options(context.car, params, manner), typical_),
        line_(setup_),
        resistance_(typical_.resistance, context.car.v_ref),
        join_(context.car, setup_.base().length(), manner.reach),
        recovery_(context.car, setup_.base()),
        mu_plan_(params.start * context.mu_init),
        reserve_(params, setup_.top_speed()),
        references_(context, params, manner.at_own_speed, {&setup_, &line_, &reserve_, &join_}) {}
  LapPlanner(const LapPlanner&) = delete;
  LapPlanner& operator=(const LapPlanner&) = delete;

  std::span<const LinePoint> line() const override { return line_.samples(); }

 protected:
  /// What is believed of the car, and of the road below it, in a control step.
  struct Believed {
    AxleTyres tyres;
    double spread = 0;     // standard deviation of their friction
    double friction = 0;   // of the road around the car
    bool trusted = false;  // else all is as the parameters state it
    bool learned = false;  // tyres and resistance: laps are solved for them
  };
  /// `learned`: null where no tyre curves are.
  Believed believe(const Observation& now, const Belief& belief, const TyreCurve* learned) {
    tyres_.see(now.x);
    const AxleTyres tyres = tyres_.tyres(belief, learned);
    const bool replan = belief.trusted && learned != nullptr && k_.replan;
    if (replan && before_) resistance_.learn(*before_, now, dt_, tyres.front, car_, *nominal_);
    before_ = now;
    return {tyres, total_sigma(belief, car_), total_mu(belief, car_), belief.trusted, replan};
  }

  /// Chooses the friction and the share of speeds that are planned for. The car that laps are to be solved for, where
  /// anything is learned of it.
  std::optional<CarBelief> plan_for(const Believed& believed) {
    relative_spread_ = believed.spread / std::max(mu_of(believed.tyres), 1e-3);
    const double start = k_.start * mu_init_;
    const double friction = believed.trusted ? believed.friction : start;
    low_mu_ = std::min({friction, k_.mu_lo, low_mu_ + k_.rise * dt_});
    approach(believed.trusted ? k_.factor * (mu_of(believed.tyres) - k_.sigma * believed.spread) : start);
    reserve_.set(mu_plan_, {.driven = low_mu_, .there = friction}, believed.trusted);
    const CarBelief car{believed.tyres, resistance_.value()};
    references_.set({.rear = believed.learned ? car.tyres.rear : tyres_.generic().rear,
                     .resistance = car.resistance,
                     .tightened = car_.width * (k_.tighten + k_.tighten_sigma * relative_spread_)});
    return believed.learned ? std::optional(car) : std::nullopt;
  }

  /// Fills the horizon from the car's place beside followed() on. `grip_here`: friction below the car over that which
  /// is planned for; `grip_ahead(s)`: friction expected at a station of the base line over that believed below the car.
  template <class Grip>
  void drive(const Observation& now, double grip_here, const Grip& grip_ahead, std::span<RefPoint> horizon) {
    // A solver that asked for the place did so on the plan of the step before.
    const double station = line_.locate(now.x.x, now.x.y, now.x.yaw);
    const auto on_line = [&](double s) {
      RefPoint r = references_.at(s, now.x.yaw);
      r.at.grip = grip_ahead(s);
      return r;
    };
    const double here = mu_plan_ * grip_here;
    if (recovery_.update(now, station, here, on_line)) {
      join_.forget();
      const auto speed = [&](double s) { return driven_speed(line_.at(s).v); };
      const auto gain = [&](double v) { return references_.gain(v); };
      recovery_.fill(now, dt_, on_line, speed, gain, horizon);
      return;
    }
    join_.update(now, station, here, static_cast<double>(horizon.size()) * dt_, on_line);
    references_.sample(now, station, horizon);
    for (RefPoint& r : horizon) r.at.grip = grip_ahead(r.s);
    join_.move(horizon);
  }
  /// On a road that is expected to be alike everywhere.
  void drive(const Observation& now, std::span<RefPoint> horizon) {
    const auto alike = [](double) { return 1.0; };
    drive(now, 1.0, alike, horizon);
  }

  /// What is driven where v is planned [m/s].
  double driven_speed(double v) const { return references_.driven_speed(v); }

  double dt() const { return dt_; }  // control step [s]
  const LapSetup& setup() const { return setup_; }
  const CarBelief& typical() const { return typical_; }
  /// Standard deviation of the believed friction over that friction.
  double relative_spread() const { return relative_spread_; }
  /// Friction that laps are solved for.
  double mu_lap() const { return std::max(mu_plan_, manner_.least_mu); }
  PlanFollower& followed() { return line_; }
  /// Whether references lead the car to the line from elsewhere.
  bool joins() const { return join_.active() || recovery_.active(); }
  /// Slip that the front or the rear axle exceeded in one of 200 steps [rad].
  double visited_slip() const { return tyres_.visited_slip(); }
  LapPlan plan_;

 private:
  static SetupOptions options(const Car& car, const LapParams& k, const Manner& manner) {
    return {.margin = k.margin * car.width,
            .spacing = k.spacing,
            .brakes = k.brakes,
            .use = {.combined = k.combined,
                    .slip_bound = k.slip_bound,
                    .sharing = manner.sharing,
                    .full_slip_until_speed = manner.full_slip_until_speed,
                    .small_slip_from_speed = manner.small_slip_from_speed}};
  }
  /// A fall of the friction counts at once, a rise at the rate `rise`.
  void approach(double target) {
    const double least = std::min(manner_.least_mu, std::max(low_mu_, least_friction));
    const double allowed = std::min(std::max(target, least), manner_.most_mu);
    mu_plan_ = std::min(allowed, mu_plan_ + k_.rise * dt_);
  }

  LapParams k_;
  Manner manner_;
  Car car_;
  double dt_, mu_init_;
  TyreBelief tyres_;
  Prediction* nominal_;
  CarBelief typical_;
  LapSetup setup_;
  PlanFollower line_;
  ResistanceFit resistance_;
  std::optional<Observation> before_;
  JoinPath join_;
  RecoveryPath recovery_;
  double mu_plan_;                                           // friction that is planned for
  double low_mu_ = std::numeric_limits<double>::infinity();  // that is believed, mu_lo at most; rises no faster
  PaceReserve reserve_;
  double relative_spread_ = 0;
  LapReferences references_;
};

}  // namespace gripline::time_optimal
