// The paper's planner: the minimum-curvature line at the speed that the estimated friction allows.
//
//   v_ref(s) = pace * v(s; mu),   mu = (mu_f lr + mu_r lf) / (lf + lr),   v(s; mu) linear between profiles of a grid
//
// Below the grid, v(s; mu) = sqrt(mu / mu_lo) v(s; mu_lo).
//
// With `sigma` above 0, which the paper does not have, mu is that many standard deviations below the estimate: 1.64
// plans for the friction that is there with 95 %.
//
// Source: Kalaria, Lin, Dolan, Algorithm 1 line 14. Each profile of the grid is computed from the car's own drive,
// brake and steering limits (speed_profile.hpp).
#include "common/planning/line_planner.hpp"
#include "common/planning/planned_friction.hpp"

namespace {

using namespace gripline;

class FrictionSpeed final : public SpeedPlanner {
 public:
  struct Params : planning::LineParams {
    double mu_lo = 0.3, mu_hi = 1.3, mu_step = 0.04, rise = 0.0, sigma = 0.0;
  };
  static constexpr auto parameters() {
    return std::tuple_cat(planning::line_parameters<Params>(),
                          std::tuple{param("mu_lo", &Params::mu_lo, "1", {0.01, 5},
                                           "least friction of the grid; for less, its speeds times sqrt(mu / mu_lo)"),
                                     param("mu_hi", &Params::mu_hi, "1", {0.01, 5}, "largest friction of the grid"),
                                     param("mu_step", &Params::mu_step, "1", {0.005, 1}, "step of the grid"),
                                     param("rise", &Params::rise, "1/s", {0, 100},
                                           "fastest rise of the planned friction; 0: at once, as published"),
                                     param("sigma", &Params::sigma, "1", {0, 10},
                                           "standard deviations that the planned friction stays below the estimate")});
  }

  FrictionSpeed(const PluginContext& context, const Params& params)
      : car_(context.car),
        step_(params.rise > 0 ? params.rise * context.dt : std::numeric_limits<double>::infinity()),
        sigma_(params.sigma),
        planner_(context, params, planning::friction_grid(params.mu_lo, params.mu_hi, params.mu_step)) {}

  void plan(const Observation& now, const Belief& belief, const TyreCurve* /*learned*/,
            std::span<RefPoint> horizon) override {
    // A fall of the friction counts at once, a rise at the rate `rise`: what was just learned may be wrong.
    const double mu = total_mu(belief, car_) - sigma_ * total_sigma(belief, car_);
    planned_ = std::min(mu, planned_ + step_);
    if (!std::isfinite(planned_)) planned_ = mu;
    planner_.plan(now, planned_, horizon);
  }
  std::span<const LinePoint> line() const override { return planner_.line().samples(); }

 private:
  Car car_;
  double step_, sigma_;
  double planned_ = std::numeric_limits<double>::infinity();
  planning::LinePlanner planner_;
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<FrictionSpeed>(
    "friction_speed", "1.0", "minimum-curvature line at the speed that the estimated friction allows"))
