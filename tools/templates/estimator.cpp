// Learns resistance to driving from what the nominal model leaves unexplained of vx: change it to what you learn.
#include <gripline/equation.hpp>
#include <gripline/plugin.hpp>

namespace {

class NewPlugin final : public gripline::AutoDiffEffect<NewPlugin, gripline::Estimator> {
 public:
  struct Params {
    double rate = 0.05;  // the initializer is the default
  };
  static constexpr auto parameters() {  // JSON key, member, unit, range, one sentence
    return std::tuple{gripline::param("rate", &Params::rate, "1", {0, 2}, "step of normalised least mean squares")};
  }
  // context.truth is null unless .needs_truth() stands behind describe.
  NewPlugin(const gripline::PluginContext& context, const Params& params)
      : rate_(params.rate), v_ref_(context.car.v_ref), belief_{context.mu_init, context.mu_init} {}

  void update(const gripline::Sample& k) override {  // every step: what happened, what the nominal model missed
    if (k.x.vx <= 0.1) return;
    const double phi[] = {-1.0, -gripline::square(k.x.vx / v_ref_)};
    const double error = k.e_vx - phi[0] * c0_ - phi[1] * c1_;
    const double gain = rate_ * error / (1e-6 + phi[0] * phi[0] + phi[1] * phi[1]);
    c0_ += gain * phi[0];
    c1_ += gain * phi[1];
  }

  // What it believes of friction; here the stack's mu_init. `trusted` is the stack's to set.
  gripline::Belief belief() const override { return belief_; }

  // The correction of the nominal model. T is double, or carries derivatives.
  template <class T>
  void act(gripline::Point<T>& p) const {
    const T forward = gripline::clamp_value(p.q.vx * 10.0, 0.0, 1.0);  // a car at rest is not pushed
    p.q.ax -= forward * (c0_ + c1_ * gripline::square(p.q.vx / v_ref_));
  }

 private:
  double rate_, v_ref_, c0_ = 0, c1_ = 0;
  gripline::Belief belief_;
};

}  // namespace

GRIPLINE_EQUATIONS({"new_plugin",
                    "e_vx = phi c, phi = (-1, -(vx / v_ref)^2); c += rate (e - phi c) phi / (eps + phi phi)"})
GRIPLINE_PLUGINS(gripline::describe<NewPlugin>("new_plugin", "0.1", "resistance to driving, by NLMS"))
