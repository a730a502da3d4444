// The fastest lap at the friction that is believed, solved a few seconds ahead of the car in every control step
// (receding_laps.hpp), on a road whose slippery places it remembers (friction_places.hpp).
#pragma once

#include <algorithm>
#include <cmath>
#include <gripline/plugin.hpp>
#include <optional>
#include <span>
#include <stdexcept>

#include "planners/time_optimal/friction_places.hpp"
#include "planners/time_optimal/lap_dynamics.hpp"
#include "planners/time_optimal/lap_planner.hpp"
#include "planners/time_optimal/receding_laps.hpp"

namespace gripline::time_optimal {

class RecedingTime final : public LapPlanner {
 public:
  struct Params : LapParams {
    double ahead = 6.0, follow = 0.15;
    double ellipse = 0.0, drive_front = 0.5, brake_front = 0.5;
    double slip_bound_slow_car = 0.0;                                 // [rad]; slip_bound where that is larger
    double full_slip_until_speed = 0.0, small_slip_from_speed = 0.0;  // see TyreUse [m/s]
    int nodes = 200, iterations = 2;
    bool places = false, from_car_state = false;
  };
  static constexpr auto parameters() {
    using P = Params;
    return std::tuple_cat(
        lap_parameters<P>(),
        std::tuple{
            param("ahead", &P::ahead, "s", {0.5, 60}, "how far the program reaches"),
            param("follow", &P::follow, "1", {0.01, 1},
                  "share of the way to a new solution that the driven plan goes in 20 ms"),
            param("ellipse", &P::ellipse, "1", {0, 5},
                  "largest drive or brake force over largest side force of a tyre, for each axle at its load; 0: "
                  "what `combined` says"),
            param("slip_most", &P::slip_bound_slow_car, "rad", {0, 1.4},
                  "largest slip that is planned once the car has slipped nearly as far; below slip_max: slip_max"),
            param("slip_slow", &P::full_slip_until_speed, "m/s", {0, 300},
                  "up to this forward speed slips of slip_most are planned"),
            param("slip_fast", &P::small_slip_from_speed, "m/s", {0, 300},
                  "from this forward speed on slips of slip_max are planned, beyond slip_slow; 0: of slip_most at all "
                  "speeds"),
            param("drive_front", &P::drive_front, "1", {0, 1}, "front share of the drive force"),
            param("brake_front", &P::brake_front, "1", {0, 1}, "front share of the brake force"),
            param("places", &P::places, "1", {0, 1}, "keep a map of where the road is slippery"),
            param("from_car_state", &P::from_car_state, "1", {0, 1},
                  "a car that has left its plan, too fast for it or wide of it, begins another with its own state"),
            param("nodes", &P::nodes, "1", {30, 1000},
                  "of the program, at most; beyond 100 no more than half of the lap's"),
            param("iterations", &P::iterations, "1", {1, 100}, "Newton steps in a control step, at most")});
  }

  RecedingTime(const PluginContext& context, const Params& params)
      : LapPlanner(
            context, checked(params),
            {.least_mu = params.mu_lo,
             .most_mu = params.mu_hi,
             .reach = 1.0,
             .at_own_speed = true,
             .sharing = {.ratio = params.ellipse, .drive_front = params.drive_front, .brake_front = params.brake_front},
             .full_slip_until_speed = params.full_slip_until_speed,
             .small_slip_from_speed = params.small_slip_from_speed}),
        laps_(setup(), {scaled_to(typical().tyres, mu_lap()), typical().resistance},
              {.ahead = params.ahead,
               .nodes = params.nodes,
               .iterations = params.iterations,
               .follow = params.follow,
               .dt = context.dt}),
        slip_bound_slow_car_(params.slip_bound_slow_car),
        from_car_state_(params.from_car_state) {
    if (params.places) places_.emplace(setup().nodes().s.size(), context.dt, detection_time(context.car));
    plan_ = laps_.whole_plan();
    followed().set(plan_);
  }

  void plan(const Observation& now, const Belief& belief, const TyreCurve* learned,
            std::span<RefPoint> horizon) override {
    Believed believed = believe(now, belief, learned);
    if (places_ && believed.trusted) see_places(now.x, believed);
    solve(now.x, plan_for(believed));
    if (!places_) return drive(now, horizon);
    const auto ahead = [this](double station) { return grip_ahead(station); };
    drive(now, places_->grip(node_), ahead, horizon);
  }

 private:
  /// Refused before the first lap is solved.
  static const Params& checked(const Params& params) {
    if (params.mu_lo > params.mu_hi)
      throw std::invalid_argument(
          "\"mu_lo\" is above \"mu_hi\"; expected the least friction that is planned for to be no "
          "more than the largest");
    if (params.small_slip_from_speed > 0 && params.small_slip_from_speed <= params.full_slip_until_speed)
      throw std::invalid_argument("\"slip_fast\" is not above \"slip_slow\"; expected a higher speed, or 0");
    return params;
  }
  /// Learns where the road is slippery. In such a place, and until the belief has come back behind it, the road ahead
  /// is believed to be as it was before the place.
  void see_places(const State& x, Believed& believed) {
    believed_here_ = mu_of(believed.tyres);
    node_ = setup().node_at(followed().locate(x.x, x.y, x.yaw));
    if (places_->step(node_, believed_here_, believed.spread))
      for (std::size_t i = 0; i < setup().nodes().s.size(); ++i) laps_.set_grip(i, places_->grip(i));
    if (places_->holding()) {
      believed.tyres = scaled_to(outside_, places_->mu());
      believed.spread = spread_outside_;
      believed.friction = places_->mu();
    } else {
      outside_ = believed.tyres;
      spread_outside_ = believed.spread;
    }
  }
  /// The friction of the road without its places times the grip of the place ahead, over what is believed: right also
  /// on the first steps into a place, when the belief is still that of the road before it. Just behind a place no more
  /// than is believed is expected ahead, as the place may have grown.
  double grip_ahead(double station) const {
    if (!(believed_here_ > 0.0)) return 1.0;
    const double ahead = places_->mu() * places_->grip(setup().node_at(station)) / believed_here_;
    return places_->holding() && places_->grip(node_) == 1.0 ? std::min(1.0, ahead) : ahead;
  }
  /// Solves the lap ahead of the car and shows it to followed(). `learned`: as of plan_for().
  void solve(const State& x, const std::optional<CarBelief>& learned) {
    const CarBelief car = learned.value_or(typical());
    // What is known of tyres ends where they have slipped; a curve fitted up to there holds a little further.
    constexpr double beyond = 1.4;
    laps_.set_slip_bound_slow_car(std::min(slip_bound_slow_car_, beyond * visited_slip()));
    const double station = followed().locate(x.x, x.y, x.yaw);
    const bool may_begin_at_car = from_car_state_ && learned;
    if (may_begin_at_car) update_off_plan(x, station);
    laps_.step({scaled_to(car.tyres, mu_lap()), car.resistance}, learned ? relative_spread() : 0.0, station, plan_,
               may_begin_at_car && is_off_plan() ? &x : nullptr);
    if (laps_.changed_count() > 0) followed().set(plan_, laps_.changed_first(), laps_.changed_count());
  }
  /// How long an estimator may take to detect a new friction [s]: some of the time in which a car at the limit of grip
  /// loses its typical speed, which is what slips large enough to show it take to build up.
  static double detection_time(const Car& car) { return 1.5 * car.v_ref / gravity; }
  /// Whether the car has left its plan, now or a moment ago.
  bool is_off_plan() const { return off_plan_for_ > 0; }
  /// Once per step in which a plan may begin at the car, which has left its plan where it is much faster than that
  /// beside it or runs wide of it. A plan that began at the car is as fast as the car, beyond `pace`: until the car has
  /// slowed down to what is asked of it, only one that is faster than that plan itself is too fast for it. A car that
  /// joins the line, recovers, drives slowly or slides far off its heading is led by its own path.
  void update_off_plan(const State& x, double station) {
    constexpr double fast = 1.05, faster_than_plan = 1.01;  // of the speed asked for, of the planned speed
    constexpr double wide = 0.4, slow = 0.8;                // of the car's width, of the speed asked for
    constexpr double least = 2.5;                           // speed over the car's least
    constexpr double lasts = 0.3, furthest = 1.0;           // [s, rad]
    const PlanPoint plan = followed().at(station);
    const double asked = driven_speed(plan.v), v = std::hypot(x.vx, x.vy);
    const double beside = std::cos(plan.yaw) * (x.y - plan.y) - std::sin(plan.yaw) * (x.x - plan.x);
    if (v <= fast * asked) slowed_down_ = true;
    const bool too_fast = v > (slowed_down_ ? fast * asked : std::max(fast * asked, faster_than_plan * plan.v));
    const bool left = too_fast || (std::abs(beside) > wide * setup().car().width && v > slow * asked);
    if (left) slowed_down_ = false;
    const bool slides = std::abs(std::atan2(x.vy, x.vx)) > furthest || std::cos(x.yaw - plan.yaw) < std::cos(furthest);
    if (joins() || slides || v < least * setup().car().v_min)
      off_plan_for_ = 0;
    else
      off_plan_for_ = left ? lasts : off_plan_for_ - dt();
  }

  RecedingLaps laps_;
  double slip_bound_slow_car_;
  bool from_car_state_;
  double off_plan_for_ = 0;  // [s] that the plan still begins at the car
  bool slowed_down_ = true;  // since it left its plan
  std::optional<FrictionPlaces> places_;
  AxleTyres outside_;  // believed where the car was last in no such place
  double spread_outside_ = 0;
  double believed_here_ = 0;  // friction
  std::size_t node_ = 0;      // below the car
};

}  // namespace gripline::time_optimal
