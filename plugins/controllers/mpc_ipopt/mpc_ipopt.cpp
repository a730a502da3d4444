// Model predictive control by Ipopt: the problem of mpc/ocp.hpp, solved to convergence in every step.
//
// Multiple shooting. Variables, stage by stage: u_k, x_{k+1}, eps_{k+1}. Constraints, stage by stage: the defect
// x_{k+1} - f(x_k, u_k) = 0, and the two soft edges n . p - eps <= upper, n . p + eps >= lower. Constraint Jacobian
// exact (Prediction), Hessian of the Lagrangian by Gauss-Newton: the cost is a sum of squares of linear terms, so this
// is its exact Hessian and a constant; only the curvature of the dynamics is left out. Where the reference cannot be
// followed the residuals are large, the curvature left out is as large as what is kept, and the iterates oscillate
// around the solution: a solve that has not converged after `gauss_newton_iterations` goes on with the curvature added,
// from differences of the exact Jacobian.
// Source: Kalaria, Lin, Dolan, their optimal control problem; Waechter and Biegler (2006) for the method.
#include <IpIpoptApplication.hpp>
#include <IpSolveStatistics.hpp>
#include <algorithm>
#include <gripline/plugin.hpp>
#include <stdexcept>
#include <vector>

#include "controllers/mpc_ipopt/ipopt_nlp.hpp"

namespace {

using namespace gripline;
using mpc::Ocp;
using mpc_ipopt::IpoptNlp;

class MpcIpopt final : public Controller {
 public:
  struct Params : mpc::OcpParams {
    int gauss_newton_iterations = 25, max_iterations = 100;
    double tolerance = 1e-7;
  };
  static constexpr auto parameters() {
    return std::tuple_cat(
        mpc::ocp_parameters(),
        std::tuple{param("gauss_newton_iterations", &Params::gauss_newton_iterations, "1", {0, 10000},
                         "iterations before the curvature of the dynamics is added"),
                   param("max_iterations", &Params::max_iterations, "1", {1, 10000}, "iterations before a solve fails"),
                   param("tolerance", &Params::tolerance, "1", {1e-12, 1e-2}, "Ipopt's tolerance")});
  }

  MpcIpopt(const PluginContext& context, const Params& params)
      : ocp_(params, context.car, context.dt), params_(params), nlp_(new IpoptNlp) {
    const auto options = application_.Options();
    options->SetIntegerValue("print_level", 0);
    options->SetStringValue("sb", "yes");
    options->SetNumericValue("tol", params.tolerance);
    options->SetNumericValue("acceptable_tol", 100 * params.tolerance);
    options->SetStringValue("linear_solver", "mumps");
    options->SetStringValue("jac_d_constant", "yes");
    options->SetStringValue("option_file_name", "");
    // A warm start stays near where it begins: small pushes from the bounds, small barrier.
    options->SetNumericValue("warm_start_bound_push", 1e-6);
    options->SetNumericValue("warm_start_bound_frac", 1e-6);
    options->SetNumericValue("warm_start_slack_bound_push", 1e-6);
    options->SetNumericValue("warm_start_slack_bound_frac", 1e-6);
    options->SetNumericValue("warm_start_mult_bound_push", 1e-6);
    application_.RethrowNonIpoptException(true);  // of a plugin of the model: it ends the run
    if (application_.Initialize("") != Ipopt::Solve_Succeeded) throw std::runtime_error("Ipopt does not start");
  }

  int horizon() const noexcept override { return ocp_.horizon() + 1; }

  Command control(const Observation& now, std::span<const RefPoint> references, Prediction& model) override {
    ocp_.set(now, references, model);
    nlp_->set(ocp_, model);
    int iterations = 0;
    const int first = std::min(params_.gauss_newton_iterations, params_.max_iterations);
    bool solved = solve(nlp_->warm(), false, first, iterations);
    if (!solved) solved = solve(nlp_->warm(), true, params_.max_iterations - first, iterations);
    if (!solved) {  // once more from a cold start
      nlp_->forget();
      nlp_->set(ocp_, model);
      solved = solve(false, true, params_.max_iterations, iterations);
      if (!solved) nlp_->forget();
    }
    if (solved) {
      keep_plan(now);
    } else {
      plan_age_ = std::min(plan_age_ + 1, ocp_.horizon() - 1);
      predicted_.clear();
    }
    return {solved ? planned_input(0) : fallback(now), iterations, solved, nlp_->cost()};
  }

  std::span<const State> predicted() const override { return predicted_; }

 private:
  bool solve(bool warm, bool exact_hessian, int limit, int& iterations) {
    if (limit <= 0) return false;
    const auto options = application_.Options();
    nlp_->set_exact_hessian(exact_hessian);
    options->SetIntegerValue("max_iter", limit);
    options->SetStringValue("warm_start_init_point", warm ? "yes" : "no");
    options->SetNumericValue("mu_init", warm ? 1e-5 : 1e-2);
    const Ipopt::ApplicationReturnStatus status = application_.OptimizeTNLP(problem_);
    if (Ipopt::IsValid(application_.Statistics())) iterations += application_.Statistics()->IterationCount();
    return status == Ipopt::Solve_Succeeded || status == Ipopt::Solved_To_Acceptable_Level;
  }

  Input planned_input(int k) const {
    const auto z = nlp_->solution();
    const auto i = static_cast<std::size_t>(nlp_->layout().input(k));
    return {z[i], z[i + 1]};
  }

  void keep_plan(const Observation& now) {
    const auto z = nlp_->solution();
    plan_age_ = 0;
    plan_.clear();
    predicted_.assign(1, now.x);
    for (int k = 0; k < ocp_.horizon(); ++k) {
      plan_.push_back(planned_input(k));
      predicted_.push_back(state_of(z.data() + nlp_->layout().state(k + 1)));
    }
  }

  /// The last plan that was found, where it stands now; without one, straight on.
  Input fallback(const Observation& now) const {
    if (plan_.empty()) return {0.0, -now.x.delta / ocp_.dt()};
    return plan_[static_cast<std::size_t>(plan_age_)];
  }

  Ocp ocp_;
  Params params_;
  Ipopt::IpoptApplication application_;
  Ipopt::SmartPtr<IpoptNlp> nlp_;
  Ipopt::SmartPtr<Ipopt::TNLP> problem_{Ipopt::GetRawPtr(nlp_)};  // the same, as Ipopt wants it
  std::vector<Input> plan_;
  std::vector<State> predicted_;
  int plan_age_ = 0;
};

}  // namespace

GRIPLINE_PLUGINS(gripline::describe<MpcIpopt>("mpc_ipopt", "1.0",
                                              "model predictive control, solved to convergence by Ipopt"))
