// The line and the speed of the fastest lap at a friction somewhat below the estimate.
//
//   lap(mu): the program of lap_solver.hpp on tyres F = D sin(C atan(B slip)), linear between the members of a library
//
// What is planned for, and how a plan is driven: lap_planner.hpp. The library is computed offline on tyres of a generic
// shape. Once a tyre curve is learned, its fit per axle (tyre_fit.hpp) replaces the generic one, and the resistance
// that the nominal model lacks is learned too: members near mu_plan are solved anew (adaptive_laps.hpp), within plan()
// of the step in which that is due. Such a step allocates and lasts as long as a solve of Ipopt: a simulated race
// waits.
#include <algorithm>
#include <cmath>
#include <gripline/plugin.hpp>
#include <optional>
#include <span>

#include "common/planning/planned_friction.hpp"
#include "common/reference_step.hpp"
#include "planners/time_optimal/adaptive_laps.hpp"
#include "planners/time_optimal/lap_library.hpp"
#include "planners/time_optimal/lap_planner.hpp"
#include "planners/time_optimal/receding_time.hpp"

namespace {

using namespace gripline;
using namespace gripline::time_optimal;

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
                                           "steps of 20 ms that a solve takes at least, on another core, and so does "
                                           "the change to its lap")});
  }

  TimeOptimal(const PluginContext& context, const Params& params)
      : LapPlanner(context, params, {}),
        laps_(setup(),
              build_library(setup(), typical(), friction_grid(params.mu_lo, params.mu_hi, params.mu_step),
                            context.cache_dir, {context.progress, context.progress_context}),
              {.tolerance = params.tolerance,
               .slip_range = params.slip_bound,
               .latency = control_steps(params.latency, context.dt),
               .work_per_step = params.solver_rate * context.dt,
               .transition = std::max(1, control_steps(params.latency, context.dt))}) {
    laps_.step(nullptr, mu_lap(), plan_);
    followed().set(plan_);
  }

  void plan(const Observation& now, const Belief& belief, const TyreCurve* learned,
            std::span<RefPoint> horizon) override {
    const std::optional<CarBelief> car = plan_for(believe(now, belief, learned));
    laps_.step(car ? &*car : nullptr, mu_lap(), plan_);
    followed().set(plan_);
    drive(now, horizon);
  }
  double latency() const noexcept override { return laps_.longest_wait() * dt(); }

 private:
  /// Those of dt [s] that last as long as so many reference steps, at least.
  static int control_steps(int reference_steps, double dt) {
    constexpr double rounding = 1e-6;  // of a step
    return static_cast<int>(std::ceil(reference_steps * (reference_step / dt) - rounding));
  }

  AdaptiveLaps laps_;
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<TimeOptimal>("time_optimal", "1.0",
                                                 "the fastest lap at a friction somewhat below the estimate"),
                 gripline::describe<RecedingTime>("receding_time", "1.0",
                                                  "the fastest lap at a friction somewhat below the estimate, solved a "
                                                  "few seconds ahead of the car in every step"))
