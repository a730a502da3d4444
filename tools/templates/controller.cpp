// Steers back to the line and holds the speed of the reference: change it to your law.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <gripline/equation.hpp>
#include <gripline/plugin.hpp>

namespace {

using std::numbers::pi;

class NewPlugin final : public gripline::Controller {
 public:
  struct Params {
    double k_n = 3, k_v = 1, d_hold = 0.25;  // the initializers are the defaults
    int ahead = 4;
  };
  static constexpr auto parameters() {  // JSON key, member, unit, range, one sentence
    using gripline::param;
    return std::tuple{param("k_n", &Params::k_n, "1/s", {0, 100}, "how hard it steers back to the line"),
                      param("k_v", &Params::k_v, "s/m", {0, 100}, "throttle per error of speed"),
                      param("d_hold", &Params::d_hold, "1", {0, 1}, "throttle at the right speed"),
                      param("ahead", &Params::ahead, "1", {1, 500}, "how many steps ahead it looks")};
  }
  NewPlugin(const gripline::PluginContext& context, const Params& params)
      : car_(context.car), dt_(context.dt), k_(params) {}

  int horizon() const noexcept override { return k_.ahead + 1; }  // reference points it wants, the first for now

  // model: x_{k+1} = f(x_k, u_k) with exact derivatives, for those that optimise. Must not allocate.
  gripline::Command control(const gripline::Observation& now, std::span<const gripline::RefPoint> horizon,
                            gripline::Prediction& /*model*/) override {
    const gripline::RefPoint &here = horizon.front(), &there = horizon.back();
    const double n = -(now.x.x - here.x) * std::sin(here.yaw) + (now.x.y - here.y) * std::cos(here.yaw);
    const double e_yaw = std::remainder(there.yaw - now.x.yaw, 2 * pi), v = std::max(0.0, now.x.vx);
    const double delta = std::clamp(e_yaw - std::atan(k_.k_n * n / (v + 0.1)), -car_.delta_max, car_.delta_max);
    gripline::Command command;
    command.u.ddelta = std::clamp((delta - now.x.delta) / dt_, -car_.ddelta_max, car_.ddelta_max);
    command.u.d = std::clamp(k_.d_hold + k_.k_v * (there.v - now.x.vx), car_.d_min, car_.d_max);
    return command;
  }

 private:
  gripline::Car car_;
  double dt_;
  Params k_;
};

}  // namespace

GRIPLINE_EQUATIONS({"new_plugin",
                    "delta = e_yaw - atan(k_n n / (v + 0.1 m/s)), n to the left of the line (Thrun et al. "
                    "2006, Stanley); d = d_hold + k_v (v_ref - v)"})
GRIPLINE_PLUGINS(gripline::describe<NewPlugin>("new_plugin", "0.1", "steers back to the line, holds its speed"))
