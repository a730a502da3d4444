// Learns one drag coefficient from what the nominal model leaves unexplained: vx' -= c vx^2, c by normalised least mean
// squares.
#include <gripline/plugin.hpp>

class LearnedDrag final : public gripline::AutoDiffEffect<LearnedDrag, gripline::Estimator> {
 public:
  struct Params {
    double rate = 0.05;
  };
  static constexpr auto parameters() {
    return std::tuple{gripline::param("rate", &Params::rate, "1", {0, 2}, "step of normalised LMS")};
  }
  LearnedDrag(const gripline::PluginContext& context, const Params& params)
      : rate_(params.rate), belief_{context.mu_init, context.mu_init, 0, 0, false} {}

  void update(const gripline::Sample& k) override {
    const double regressor = -k.x.vx * k.x.vx;
    c_ += rate_ * (k.e_vx - c_ * regressor) * regressor / (1e-6 + regressor * regressor);
  }
  gripline::Belief belief() const override { return belief_; }

  template <class T>  // written once: T is double, or a number that carries its derivatives
  void act(gripline::Point<T>& p) const {
    p.q.ax -= c_ * gripline::square(p.q.vx);
  }

 private:
  double rate_, c_ = 0;
  gripline::Belief belief_;
};

GRIPLINE_PLUGINS(gripline::describe<LearnedDrag>("demo.learned_drag", "1.0", "one drag coefficient by NLMS"));
