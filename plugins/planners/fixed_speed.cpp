// The minimum-curvature line at the speed of one assumed friction, whatever was learned: the paper's row without an
// adaptive speed.   v_ref(s) = pace * v(s; mu)
//
// careful_until has to be given to this planner as it is to its stack: no planner is given the stack's, and in a stack
// without an estimator, which drives this planner too, Belief::trusted is never true.
#include <array>

#include "common/planning/line_planner.hpp"

namespace {

using namespace gripline;

class FixedSpeed final : public SpeedPlanner {
 public:
  struct Params : planning::LineParams {
    double mu = 0.0;
    double careful_until = 0.0;
  };
  static constexpr auto parameters() {
    return std::tuple_cat(planning::line_parameters<Params>(),
                          std::tuple{param("mu", &Params::mu, "1", {0, 5}, "assumed friction; 0: the stack's mu_init"),
                                     param("careful_until", &Params::careful_until, "s", {0, 1e6},
                                           "plan for mu_init until then, whatever mu is")});
  }

  FixedSpeed(const PluginContext& context, const Params& params)
      : mu_(params.mu > 0 ? params.mu : context.mu_init),
        mu_start_(params.careful_until > 0 ? context.mu_init : mu_),
        careful_until_(params.careful_until),
        planner_(context, params, std::array{std::min(mu_, mu_start_), std::max(mu_, mu_start_)}) {}

  void plan(const Observation& now, const Belief& /*belief*/, const TyreCurve* /*learned*/,
            std::span<RefPoint> horizon) override {
    planner_.plan(now, now.t > careful_until_ ? mu_ : mu_start_, horizon);
  }
  std::span<const LinePoint> line() const override { return planner_.line().samples(); }

 private:
  double mu_, mu_start_, careful_until_;
  planning::LinePlanner planner_;
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<FixedSpeed>("fixed_speed", "1.0",
                                                "minimum-curvature line at the speed of one assumed friction"))
