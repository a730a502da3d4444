// Model-predictive control in real time: the problem of mpc/ocp.hpp, the paper's, by the sequential quadratic
// programming of sqp.hpp.
//
// With `front_slip` the commanded steering angle stays where the front axle, with its wheels as commanded, slips no
// further than its tyres gain force, along the plan of the step before.
//
// The plan of the step before, shifted by one, is the start. A solve that does not converge is counted as failed; its
// best iterate, in the worst case the shifted plan, is driven. After a quadratic program that could not be solved, or a
// number that is none, the next step starts anew.
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "common/mpc/ocp.hpp"
#include "common/mpc/saturation_slip.hpp"
#include "controllers/mpc_sqp/sqp.hpp"

namespace {

using namespace gripline;

class MpcSqp final : public Controller {
 public:
  struct Params : mpc::OcpParams {
    int iterations = mpc_sqp::SqpOptions{}.max_iter;
    double tolerance = mpc_sqp::SqpOptions{}.tol_step;
    double front_slip = 0, rear_slip = 0;
  };
  static constexpr auto parameters() {
    return std::tuple_cat(
        mpc::ocp_parameters(),
        std::tuple{
            param("iterations", &Params::iterations, "1", {1, 1000}, "quadratic programs per step at most"),
            param("tolerance", &Params::tolerance, "1", {1e-9, 1},
                  "largest last change of an input, as a share of its range; the first one is known ten times as well"),
            param("front_slip", &Params::front_slip, "1", {0, 10},
                  "largest slip of the front axle over that at 99 % of its largest predicted force; 0: no bound"),
            param("rear_slip", &Params::rear_slip, "1", {0, 10},
                  "slip of the rear axle, over that at 99 % of its largest predicted force, from which on front_slip "
                  "is lowered on the side that turns the car in; 0: it is not")});
  }

  MpcSqp(const PluginContext& context, const Params& params)
      : ocp_(params, context.car, context.dt),
        options_{.max_iter = params.iterations, .tol_step = params.tolerance, .qp_solver = {}},
        front_slip_(params.front_slip),
        rear_slip_(params.rear_slip) {}

  int horizon() const noexcept override { return ocp_.horizon() + 1; }

  Command control(const Observation& now, std::span<const RefPoint> horizon, Prediction& model) override {
    ocp_.set(now, horizon, model);
    if (sqp_ == nullptr || sqp_->states() != ocp_.states()) {
      sqp_ = std::make_unique<mpc_sqp::Sqp>(ocp_.horizon(), ocp_.states(), options_);
      predicted_.resize(static_cast<std::size_t>(ocp_.horizon()) + 1);
      start_anew_ = true;
    }
    if (start_anew_) {
      sqp_->initialize(ocp_, model);
    } else {
      sqp_->shift();
    }
    bound_front_slip(now, model);
    const mpc_sqp::SqpStatistics statistics = sqp_->solve(ocp_, model);
    const bool solved = statistics.status == mpc_sqp::SqpStatus::converged;
    start_anew_ =
        statistics.status == mpc_sqp::SqpStatus::qp_failure || statistics.status == mpc_sqp::SqpStatus::nan_detected;
    for (std::size_t k = 0; k < predicted_.size(); ++k) predicted_[k] = state_at(k);
    predicts_ = statistics.status != mpc_sqp::SqpStatus::nan_detected;

    Command command;
    const Car& car = ocp_.car();
    const double d = sqp_->u()[0], ddelta = sqp_->u()[1];
    command.u.d = std::isfinite(d) ? std::clamp(d, car.d_min, car.d_max) : 0.0;
    command.u.ddelta = std::isfinite(ddelta) ? std::clamp(ddelta, -car.ddelta_max, car.ddelta_max) : 0.0;
    command.iterations = statistics.sqp_iter;
    command.solved = solved;
    command.cost = std::isfinite(statistics.cost) ? statistics.cost : 0.0;
    return command;
  }

  std::span<const State> predicted() const override {
    return predicts_ ? std::span<const State>(predicted_) : std::span<const State>();
  }

 private:
  /// Bounds the commanded steering angle by the front axle's slip where the car moves as the shifted plan says
  /// (`front_slip`).
  void bound_front_slip(const Observation& now, Prediction& model) {
    if (!(front_slip_ > 0.0)) return;
    const Car& car = ocp_.car();
    const double vx = std::max(now.x.vx, 3.0 * car.v_min), none = std::numeric_limits<double>::infinity();
    const double front = mpc::front_saturation_slip(model, car, vx);
    const double rear = rear_slip_ > 0.0 ? rear_slip_ * mpc::rear_saturation_slip(model, car, vx) : none;
    if (std::isfinite(front)) ocp_.bound_front_slip(sqp_->x(), front_slip_ * front, rear);
  }
  State state_at(std::size_t k) const {
    return state_of(sqp_->x().data() + k * static_cast<std::size_t>(sqp_->states()));
  }

  mpc::Ocp ocp_;
  mpc_sqp::SqpOptions options_;
  double front_slip_, rear_slip_;
  std::unique_ptr<mpc_sqp::Sqp> sqp_;
  std::vector<State> predicted_;
  bool start_anew_ = true;
  bool predicts_ = false;
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<MpcSqp>("mpc_sqp", "1.0", "model-predictive control by real-time SQP"))
