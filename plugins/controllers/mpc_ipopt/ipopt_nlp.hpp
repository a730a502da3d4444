// The problem of mpc/ocp.hpp as Ipopt asks for it (mpc_ipopt.cpp has the equations).
#pragma once

#include <IpTNLP.hpp>
#include <span>
#include <vector>

#include "common/mpc/ocp.hpp"

namespace gripline::mpc_ipopt {

using Ipopt::Index;
using Ipopt::Number;
using mpc::Ocp;

/// Where inputs, states and slacks stand in the vector of variables.
struct Layout {
  int steps, states;
  int block() const { return states + 3; }
  int variables() const { return steps * block(); }
  int rows_per_stage() const { return states + 2; }
  int rows() const { return steps * rows_per_stage(); }
  int input(int k) const { return k * block(); }
  int state(int k) const { return (k - 1) * block() + 2; }  // k = 1 .. steps
  int slack(int k) const { return state(k) + states; }
};

/// The nonlinear program of one instant, with what a warm start needs of the last one.
class IpoptNlp final : public Ipopt::TNLP {
 public:
  void set(const Ocp& ocp, Prediction& model);
  bool warm() const { return warm_; }
  void forget() { warm_ = false; }
  const Layout& layout() const { return layout_; }
  std::span<const double> solution() const { return z_; }
  double cost() const { return cost_; }
  /// Whether the Hessian holds the curvature of the dynamics, or is Gauss-Newton's.
  void set_exact_hessian(bool exact) { exact_hessian_ = exact; }

  bool get_nlp_info(Index& n, Index& m, Index& jacobian, Index& hessian, IndexStyleEnum& style) override;
  bool get_bounds_info(Index n, Number* lower, Number* upper, Index m, Number* row_lower, Number* row_upper) override;
  bool get_starting_point(Index n, bool, Number* x, bool init_z, Number* z_lower, Number* z_upper, Index m,
                          bool init_lambda, Number* lambda) override;
  bool eval_f(Index, const Number* x, bool, Number& value) override;
  bool eval_grad_f(Index n, const Number* x, bool, Number* gradient) override;
  bool eval_g(Index, const Number* x, bool fresh, Index, Number* rows) override;
  bool eval_jac_g(Index, const Number* x, bool fresh, Index, Index, Index* rows, Index* columns,
                  Number* values) override;
  bool eval_h(Index, const Number* x, bool fresh, Number factor, Index, const Number* lambda, bool, Index, Index* rows,
              Index* columns, Number* values) override;
  void finalize_solution(Ipopt::SolverReturn status, Index n, const Number* x, const Number* z_lower,
                         const Number* z_upper, Index m, const Number*, const Number* lambda, Number value,
                         const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override;

 private:
  void allocate(const Layout& layout);
  void fix_structure();

  // The variables of a step in which the dynamics curve: the state from yaw on (nothing depends on the position), then
  // the two inputs. The first state is given, not a variable.
  int curved_count() const { return layout_.states; }
  int first_curved(int k) const { return k == 0 ? layout_.states - 2 : 0; }
  int curved_variable(int k, int i) const;

  /// d(lambda' f)/d(variable i of step k) from the Jacobians given.
  double slope(const double* a, const double* b, int k, int i, const Number* lambda) const;
  /// -lambda' f'' of every step, column by column from Jacobians at points moved a little, all steps at once.
  bool add_curvature(const Number* lambda, Number* values);
  /// A first guess: on the references, at their speed or the present one if that is higher, steered as now.
  void guess();
  /// The last solution one step on, its end repeated.
  void shift();
  double cost_of(const Number* x) const;
  /// All steps and their derivatives in one call; kept until Ipopt says that x is new.
  bool predict(const Number* x, bool fresh);

  const Ocp* ocp_ = nullptr;
  Prediction* model_ = nullptr;
  Layout layout_ = {0, 0};
  bool warm_ = false, evaluated_ = false;
  std::vector<double> z_, bound_lower_, bound_upper_, multipliers_;
  bool exact_hessian_ = false;
  std::vector<double> x_, u_, next_, A_, B_;
  std::vector<double> moved_x_, moved_u_, moved_next_, moved_A_, moved_B_, block_;
  std::vector<Index> jacobian_rows_, jacobian_columns_, hessian_rows_, hessian_columns_;
  double cost_ = 0.0;
};

}  // namespace gripline::mpc_ipopt
