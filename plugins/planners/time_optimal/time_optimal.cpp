// The line and the speed of the fastest lap at the friction that is believed, from the safe side.
//
//   lap(mu): the program of lap_solver.hpp on tyres F = D sin(C atan(B slip)), linear between the members of a library
//   mu_plan = factor (mu - sigma sigma_mu), rising by at most `rise` per second; start mu_init until mu is trusted
//   pace' = 1 - r (1 - pace + pace_fall v),   r = pace_kept + (1 - pace_kept) min(1, fall(mu_plan) / fall(pace_friction))
//   fall(mu) = E[max(0, mu - M)] / mu,   M ~ N(pace_friction, pace_spread^2)
//   v_driven = pace' v
//
// What is kept back of a speed is for friction that falls at once, which shows only when the car has begun to run wide.
// The less friction is believed, the less is left to lose; until it is trusted, r is 1.
//
// The library is computed offline on tyres of a generic shape. Once a tyre curve is learned, its fit per axle
// (tyre_fit.hpp) replaces the generic one, and the resistance that the nominal model lacks is learned too: members near
// mu_plan are solved anew (adaptive_laps.hpp). Speeds are stated along the car's axis, v cos(beta).
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>

#include <gripline/plugin.hpp>
#include <gripline/slip.hpp>

#include "common/planning/join_path.hpp"
#include "common/planning/planner_context.hpp"
#include "common/planning/recovery_path.hpp"
#include "planners/time_optimal/adaptive_laps.hpp"
#include "planners/time_optimal/friction_places.hpp"
#include "planners/time_optimal/receding_laps.hpp"
#include "planners/time_optimal/resistance_fit.hpp"
#include "planners/time_optimal/tyre_fit.hpp"

namespace {

using namespace gripline;
using namespace gripline::planning;
using namespace gripline::time_optimal;

/// What both planners have; the laps are solved in a library, or a window ahead of the car.
struct LapParams {
  double margin = 0.4, tighten = 0.0, tighten_sigma = 0.5;
  double factor = 0.97, sigma = 1.0, start = 0.6, rise = 0.1, pace = 1.0, pace_fall = 0.0;
  double pace_kept = 1.0, pace_friction = 1.0, pace_spread = 0.3;
  double mu_lo = 0.35, mu_hi = 1.15;
  double front_B = 4.0, front_C = 1.3, rear_B = 4.0, rear_C = 1.3, balance = 1.0;
  double slip_max = 0.7, combined = 0.0, spacing = 0.0, rolling = 0.0, drag = 0.0;
  bool replan = true, from_car_speed = true;
};

template <class P>
constexpr auto lap_parameters() {
  const auto number = [](const char* name, double LapParams::*member, const char* unit, Range range, const char* what) {
    return param(name, static_cast<double P::*>(member), unit, range, what);
  };
  return std::tuple{
      number("margin", &P::margin, "1", {0, 10}, "kept by the planned line from both edges, in widths of the car"),
      number("tighten", &P::tighten, "1", {0, 10},
             "taken from the room stated to the controller, in widths of the car"),
      number("tighten_sigma", &P::tighten_sigma, "1", {0, 100},
             "the same, per relative standard deviation of the friction"),
      number("factor", &P::factor, "1", {0.1, 1.5}, "planned over believed friction"),
      number("sigma", &P::sigma, "1", {0, 10},
             "standard deviations that the planned friction stays below the estimate"),
      number("start", &P::start, "1", {0.05, 2}, "planned over initially believed friction until it is trusted"),
      number("rise", &P::rise, "1/s", {0, 100}, "fastest rise of the planned friction"),
      number("pace", &P::pace, "1", {0.05, 2}, "factor on planned speeds"),
      number("pace_fall", &P::pace_fall, "s/m", {0, 0.1}, "by which that factor falls per m/s of the planned speed"),
      number("pace_kept", &P::pace_kept, "1", {0, 1},
             "share of what pace keeps back that is kept at every friction; the rest shrinks with how far friction can "
             "fall at once; 1: none does"),
      number("pace_friction", &P::pace_friction, "1", {0.05, 5}, "friction to which it changes at once: mean"),
      number("pace_spread", &P::pace_spread, "1", {1e-3, 5},
             "friction to which it changes at once: standard deviation"),
      number("mu_lo", &P::mu_lo, "1", {0.05, 5}, "least friction that is expected"),
      number("mu_hi", &P::mu_hi, "1", {0.05, 5}, "largest friction that is expected"),
      number("front_B", &P::front_B, "1/rad", {0.1, 1e3}, "stiffness factor of the generic front tyre"),
      number("front_C", &P::front_C, "1", {1, 3}, "shape factor of the generic front tyre"),
      number("rear_B", &P::rear_B, "1/rad", {0.1, 1e3}, "stiffness factor of the generic rear tyre"),
      number("rear_C", &P::rear_C, "1", {1, 3}, "shape factor of the generic rear tyre"),
      number("balance", &P::balance, "1", {0.3, 3}, "friction of the generic front over the rear axle"),
      number("slip_max", &P::slip_max, "rad", {0.05, 1.4}, "largest slip that is planned"),
      number("combined", &P::combined, "1", {0, 1}, "share of drive and brake forces in the friction circle"),
      number("spacing", &P::spacing, "m", {0, 100}, "of the program's nodes; 0: the wheelbase"),
      number("rolling", &P::rolling, "m/s2", {0, 100}, "rolling resistance over mass that the nominal model lacks"),
      number("drag", &P::drag, "1/m", {0, 10}, "drag over mass and squared speed that the nominal model lacks"),
      param("replan", static_cast<bool P::*>(&P::replan), "1", {0, 1}, "solve again for the learned tyres"),
      param("from_car_speed", static_cast<bool P::*>(&P::from_car_speed), "1", {0, 1},
            "references gain speed only as fast as the car can; false: they drive the plan at once")};
}

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
        setup_(context, options(context.car, params, manner.sharing), typical_),
        line_(setup_),
        resistance_(typical_.resistance, context.car.v_ref),
        join_(context.car, setup_.base().length(), manner.reach),
        recovery_(context.car, setup_.base()),
        mu_plan_(params.start * context.mu_init) {
    check_pace();
  }

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
    reserve_ = belief.trusted ? reserve_at(mu_plan_) : 1.0;
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

  /// The share of a planned speed [m/s] that is driven. What is kept back is for friction that falls unnoticed: the longer
  /// a car needs to slow down to what it then can, the wider it runs meanwhile, and that time grows with speed.
  double pace_at(double v) const { return pace_with(reserve_, v); }
  double driven_speed(double v) const { return pace_at(v) * v; }

  const LapParams& params() const { return k_; }
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
  static SetupOptions options(const Car& car, const LapParams& k, const AxleSharing& sharing) {
    return {k.margin * car.width, k.spacing, k.combined, k.slip_max, sharing};
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

  /// Mean of the fall from mu to a friction drawn from N(pace_friction, pace_spread^2), over mu; rises are none.
  double mean_fall(double mu) const {
    const double z = (mu - k_.pace_friction) / k_.pace_spread;
    const double density = std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi);
    const double below = 0.5 * std::erfc(-z / std::numbers::sqrt2);
    return k_.pace_spread * (density + z * below) / mu;
  }
  /// What is kept back of speeds at this friction over what is at pace_friction.
  double reserve_at(double mu) const {
    const double fall = mean_fall(std::max(mu, k_.mu_lo)) / mean_fall(k_.pace_friction);
    return k_.pace_kept + (1.0 - k_.pace_kept) * std::min(1.0, fall);
  }
  double pace_with(double reserve, double v) const { return 1.0 - reserve * (1.0 - k_.pace + k_.pace_fall * v); }
  /// Throws where driven speeds would not rise with planned ones, or with the friction that they are planned for, whose
  /// root they follow.
  void check_pace() const {
    const double top = setup_.top_speed();
    if (2.0 * k_.pace_fall * top > k_.pace)
      throw std::invalid_argument(
          "\"pace_fall\" is so large that faster plans would be driven more slowly: at most pace / (2 v) "
          "at the largest speed v, here " +
          std::to_string(0.5 * k_.pace / top) + " s/m");
    constexpr int count = 200;
    double last = 0;
    for (int i = 0; i <= count; ++i) {
      const double mu = std::lerp(k_.mu_lo, std::max(k_.mu_lo, k_.mu_hi), static_cast<double>(i) / count);
      const double driven = std::sqrt(mu) * pace_with(reserve_at(mu), top);
      if (driven < last)
        throw std::invalid_argument("\"pace_kept\" is so small that less friction would be driven faster, at " +
                                    std::to_string(mu) + ": larger, or a larger \"pace_spread\" or \"pace\"");
      last = driven;
    }
  }

  /// The sideslip angle at the pace that is driven. A car that is slower than its plan needs less side force, and slips
  /// less: as far as its rear tyres say, in a steady turn.
  double sideslip(const PlanPoint& p) const {
    const double pace = pace_at(p.v);
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
  double reserve_ = 1;  // reserve_at() what is planned for, once that is trusted
  double relative_spread_ = 0;
  MagicFormula rear_;  // that is planned for, up to its friction
  SlipRange front_seen_, rear_seen_;
};

class TimeOptimal final : public LapPlanner {
 public:
  struct Params : LapParams {
    double mu_step = 0.1, tolerance = 0.03, solver_rate = 12500;
    int latency = 100;
  };
  static constexpr auto parameters() {
    using P = Params;
    return std::tuple_cat(lap_parameters<P>(),
                          std::tuple{param("mu_step", &P::mu_step, "1", {0.01, 1}, "step of the library's friction"),
                                     param("tolerance", &P::tolerance, "1", {1e-3, 1},
                                           "difference of tyre force over its peak that asks for a new solve"),
                                     param("solver_rate", &P::solver_rate, "1/s", {100, 1e9},
                                           "nodes times iterations that another core solves in a second"),
                                     param("latency", &P::latency, "1", {0, 10000},
                                           "control steps that a solve takes at least, on another core")});
  }

  TimeOptimal(const PluginContext& context, const Params& params)
      : LapPlanner(context, params, {}),
        laps_(setup(),
              build_library(setup(), typical(), friction_grid(params.mu_lo, params.mu_hi, params.mu_step),
                            context.cache_dir, {context.progress, context.progress_context}),
              {params.tolerance, params.slip_max, params.latency, params.solver_rate * context.dt,
               std::max(1, params.latency)}) {
    laps_.step(nullptr, mu_plan(), plan_);
    followed().set(plan_);
  }
  double latency() const noexcept override { return laps_.longest_wait() * dt(); }

 protected:
  void update(const CarBelief* learned, const Observation& /*now*/) override {
    laps_.step(learned, mu_plan(), plan_);
    followed().set(plan_);
  }

 private:
  AdaptiveLaps laps_;
};

class RecedingTime final : public LapPlanner {
 public:
  struct Params : LapParams {
    double ahead = 6.0, follow = 0.15;
    double ellipse = 0.0, drive_front = 0.5, brake_front = 0.5, slip_most = 0.0;
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
                  "share of the way to a new solution that the driven plan goes in a control step"),
            param("ellipse", &P::ellipse, "1", {0, 5},
                  "largest drive or brake force over largest side force of a tyre, for each axle at its load; 0: "
                  "what `combined` says"),
            param("slip_most", &P::slip_most, "rad", {0, 1.4},
                  "largest slip that is planned once the car has slipped nearly as far; below slip_max: slip_max"),
            param("drive_front", &P::drive_front, "1", {0, 1}, "front share of the drive force"),
            param("brake_front", &P::brake_front, "1", {0, 1}, "front share of the brake force"),
            param("places", &P::places, "1", {0, 1}, "remember where the road is slippery"),
            param("from_car_state", &P::from_car_state, "1", {0, 1},
                  "a car that has left its plan, too fast for it or wide of it, begins another with its own state"),
            param("nodes", &P::nodes, "1", {30, 1000}, "of the program, at most"),
            param("iterations", &P::iterations, "1", {1, 100}, "Newton steps in a control step, at most")});
  }

  RecedingTime(const PluginContext& context, const Params& params)
      : LapPlanner(context, params,
                   {.least_mu = params.mu_lo,
                    .most_mu = params.mu_hi,
                    .reach = 1.0,
                    .at_own_speed = true,
                    .sharing = {params.ellipse, params.drive_front, params.brake_front}}),
        laps_(setup(), {scaled_to(typical().tyres, mu_plan()), typical().resistance},
              {params.ahead, params.nodes, params.iterations, params.follow}),
        slip_most_(params.slip_most),
        from_car_state_(params.from_car_state) {
    if (params.places) places_.emplace(setup().nodes().s.size(), context.dt);
    plan_ = laps_.whole_plan();
    followed().set(plan_);
  }

 protected:
  void update(const CarBelief* learned, const Observation& now) override {
    const CarBelief& car = learned != nullptr ? *learned : typical();
    // What is known of tyres ends where they have slipped; a curve fitted up to there holds a little further.
    constexpr double beyond = 1.4;
    laps_.set_slip_max(std::min(slip_most_, beyond * visited_slip()));
    const double station = followed().locate(now.x.x, now.x.y);
    const bool astray = from_car_state_ && learned != nullptr && has_left_plan(now.x, station);
    laps_.step({scaled_to(car.tyres, mu_plan()), car.resistance}, learned != nullptr ? relative_spread() : 0.0, station,
               plan_, astray ? &now.x : nullptr);
    if (laps_.changed_count() > 0) followed().set(plan_, laps_.changed_first(), laps_.changed_count());
  }

  void see(const Observation& now, AxleTyres& tyres, double& spread) override {
    if (!places_) return;
    believed_here_ = mu_of(tyres);
    node_ = laps_.node_at(followed().locate(now.x.x, now.x.y));
    if (places_->step(node_, mu_of(tyres), spread))
      for (std::size_t i = 0; i < setup().nodes().s.size(); ++i) laps_.set_grip(i, places_->grip(i));
    if (places_->holding()) {
      tyres = scaled_to(outside_, places_->mu());
      spread = spread_outside_;
    } else {
      outside_ = tyres;
      spread_outside_ = spread;
    }
  }
  double grip_here() const override { return places_ ? places_->grip(node_) : 1.0; }
  /// Of the road without its places, times the place's: also right on the first steps into a place, while the road
  /// behind the car is believed. Behind a place it is not more than believed: the place may have grown.
  double grip_ahead(double station) const override {
    if (!places_ || !(believed_here_ > 0.0)) return 1.0;
    const double ahead = places_->mu() * places_->grip(laps_.node_at(station)) / believed_here_;
    return places_->holding() && places_->grip(node_) == 1.0 ? std::min(1.0, ahead) : ahead;
  }

 private:
  /// Whether the car is much faster than the plan beside it or runs wide of it, or did a moment ago. A plan that began at
  /// the car is as fast as the car, beyond `pace`: until the car has slowed down to what is asked of it, only one that is
  /// faster than that plan itself is too fast for it. A car that joins the line, recovers, drives slowly or slides far off its
  /// heading is led by its own path.
  bool has_left_plan(const State& x, double station) {
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
      astray_for_ = 0;
    else
      astray_for_ = left ? lasts : astray_for_ - dt();
    return astray_for_ > 0;
  }

  RecedingLaps laps_;
  double slip_most_;
  bool from_car_state_;
  double astray_for_ = 0;    // [s] that the plan still begins at the car
  bool slowed_down_ = true;  // since it left its plan
  std::optional<FrictionPlaces> places_;
  AxleTyres outside_;  // believed where the car was last in no such place
  double spread_outside_ = 0;
  double believed_here_ = 0;  // friction
  std::size_t node_ = 0;      // below the car
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<TimeOptimal>(
                     "time_optimal", "1.0", "the fastest lap at the friction that is believed, from the safe side"),
                 gripline::describe<RecedingTime>("receding_time", "1.0",
                                                  "the same, solved a few seconds ahead of the car in every step"))
