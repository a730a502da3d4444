#include "controllers/mpc_ipopt/ipopt_nlp.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gripline::mpc_ipopt {

void IpoptNlp::set(const Ocp& ocp, Prediction& model) {
  const Layout fresh = {ocp.horizon(), ocp.states()};
  if (fresh.steps != layout_.steps || fresh.states != layout_.states) allocate(fresh);
  ocp_ = &ocp;
  model_ = &model;
  if (warm_)
    shift();
  else
    guess();
  evaluated_ = false;
}

bool IpoptNlp::get_nlp_info(Index& n, Index& m, Index& jacobian, Index& hessian, IndexStyleEnum& style) {
  n = layout_.variables();
  m = layout_.rows();
  jacobian = static_cast<Index>(jacobian_rows_.size());
  hessian = static_cast<Index>(hessian_rows_.size());
  style = C_STYLE;
  return true;
}

bool IpoptNlp::get_bounds_info(Index n, Number* lower, Number* upper, Index m, Number* row_lower, Number* row_upper) {
  constexpr double far = 2e19;
  std::fill_n(lower, n, -far);
  std::fill_n(upper, n, far);
  std::fill_n(row_lower, m, 0.0);
  std::fill_n(row_upper, m, 0.0);
  const Car& car = ocp_->car();
  for (int k = 0; k < layout_.steps; ++k) {
    const auto& stage = ocp_->stage(k + 1);
    const int u = layout_.input(k), delta = layout_.state(k + 1) + 6,
              row = k * layout_.rows_per_stage() + layout_.states;
    lower[u] = car.d_min, upper[u] = car.d_max;
    lower[u + 1] = -car.ddelta_max, upper[u + 1] = car.ddelta_max;
    lower[delta] = stage.delta_min, upper[delta] = stage.delta_max;
    lower[layout_.slack(k + 1)] = 0.0;
    row_lower[row] = -far, row_upper[row] = std::min(stage.edge_upper, far);
    row_lower[row + 1] = std::max(stage.edge_lower, -far), row_upper[row + 1] = far;
  }
  return true;
}

bool IpoptNlp::get_starting_point(Index n, bool, Number* x, bool init_z, Number* z_lower, Number* z_upper, Index m,
                                  bool init_lambda, Number* lambda) {
  std::copy_n(z_.begin(), n, x);
  if (init_z) {
    std::copy_n(bound_lower_.begin(), n, z_lower);
    std::copy_n(bound_upper_.begin(), n, z_upper);
  }
  if (init_lambda) std::copy_n(multipliers_.begin(), m, lambda);
  return true;
}

// Ipopt says only to the first of these calls at a point that the point is another one: where that call needs no
// predictions, those that are kept are void.
bool IpoptNlp::eval_f(Index, const Number* x, bool fresh, Number& value) {
  if (fresh) evaluated_ = false;
  value = cost_of(x);
  return std::isfinite(value);
}

bool IpoptNlp::eval_grad_f(Index n, const Number* x, bool fresh, Number* gradient) {
  if (fresh) evaluated_ = false;
  // The cost is a quadratic: gradient = H (x - where each residual vanishes), written out term by term.
  std::fill_n(gradient, n, 0.0);
  const auto& p = ocp_->params();
  double before = ocp_->throttle_before();
  for (int k = 0; k < layout_.steps; ++k) {
    const int u = layout_.input(k), s = layout_.state(k + 1), e = layout_.slack(k + 1);
    const auto& stage = ocp_->stage(k + 1);
    const double change = x[u] - before;
    gradient[u] += 2 * p.r_d * change + 2 * p.regularization * x[u];
    if (k > 0) gradient[layout_.input(k - 1)] -= 2 * p.r_d * change;
    before = x[u];
    gradient[u + 1] += 2 * ocp_->weight_ddelta() * x[u + 1];
    const auto tracking = stage.tracking_gradient(x + s);
    for (int i = 0; i < 4; ++i) gradient[s + i] += tracking[static_cast<std::size_t>(i)];
    gradient[e] += 2 * p.slack * x[e] + p.slack_linear;
  }
  return true;
}

bool IpoptNlp::eval_g(Index, const Number* x, bool fresh, Index, Number* rows) {
  if (!predict(x, fresh)) return false;
  for (int k = 0; k < layout_.steps; ++k) {
    const int row = k * layout_.rows_per_stage(), s = layout_.state(k + 1);
    for (int i = 0; i < layout_.states; ++i) rows[row + i] = x[s + i] - next_.data()[k * layout_.states + i];
    const auto& stage = ocp_->stage(k + 1);
    const double across = stage.across(x + s);
    rows[row + layout_.states] = across - x[layout_.slack(k + 1)];
    rows[row + layout_.states + 1] = across + x[layout_.slack(k + 1)];
  }
  return true;
}

bool IpoptNlp::eval_jac_g(Index, const Number* x, bool fresh, Index, Index, Index* rows, Index* columns,
                          Number* values) {
  if (values == nullptr) {
    std::copy(jacobian_rows_.begin(), jacobian_rows_.end(), rows);
    std::copy(jacobian_columns_.begin(), jacobian_columns_.end(), columns);
    return true;
  }
  if (!predict(x, fresh)) return false;
  Number* v = values;
  const int nx = layout_.states;
  for (int k = 0; k < layout_.steps; ++k) {
    const double* const a = A_.data() + static_cast<std::ptrdiff_t>(k) * nx * nx;
    const double* const b = B_.data() + static_cast<std::ptrdiff_t>(k) * nx * 2;
    for (int i = 0; i < nx; ++i) {
      *v++ = 1.0;
      *v++ = -b[2 * i];
      *v++ = -b[2 * i + 1];
      if (k == 0) continue;
      for (int j = 0; j < nx; ++j) *v++ = -a[i * nx + j];
    }
    const auto& stage = ocp_->stage(k + 1);
    for (const double sign : {-1.0, 1.0}) {
      *v++ = stage.normal_x;
      *v++ = stage.normal_y;
      *v++ = sign;
    }
  }
  return true;
}

bool IpoptNlp::eval_h(Index, const Number* x, bool fresh, Number factor, Index, const Number* lambda, bool, Index,
                      Index* rows, Index* columns, Number* values) {
  if (values == nullptr) {
    std::copy(hessian_rows_.begin(), hessian_rows_.end(), rows);
    std::copy(hessian_columns_.begin(), hessian_columns_.end(), columns);
    return true;
  }
  if (fresh) evaluated_ = false;
  Number* v = values;
  const auto& p = ocp_->params();
  for (int k = 0; k < layout_.steps; ++k) {
    const auto& stage = ocp_->stage(k + 1);
    const double followers = k + 1 < layout_.steps ? 2.0 : 1.0;
    *v++ = factor * 2 * (p.r_d * followers + p.regularization);
    if (k > 0) *v++ = factor * -2 * p.r_d;
    for (const double weight :
         {ocp_->weight_ddelta(), stage.q_xx, stage.q_xy, stage.q_yy, stage.q_yaw, stage.q_v, p.slack})
      *v++ = factor * 2 * weight;
  }
  if (!exact_hessian_) {
    std::fill(v, values + hessian_rows_.size(), 0.0);
    return true;
  }
  return predict(x, fresh) && add_curvature(lambda, v);
}

void IpoptNlp::finalize_solution(Ipopt::SolverReturn status, Index n, const Number* x, const Number* z_lower,
                                 const Number* z_upper, Index m, const Number*, const Number* lambda, Number value,
                                 const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) {
  cost_ = value;
  const bool solved = status == Ipopt::SUCCESS || status == Ipopt::STOP_AT_ACCEPTABLE_POINT;
  if (!solved && status != Ipopt::MAXITER_EXCEEDED) return;
  std::copy_n(x, n, z_.begin());
  std::copy_n(z_lower, n, bound_lower_.begin());
  std::copy_n(z_upper, n, bound_upper_.begin());
  std::copy_n(lambda, m, multipliers_.begin());
  warm_ = true;
}

void IpoptNlp::allocate(const Layout& layout) {
  layout_ = layout;
  const auto n = static_cast<std::size_t>(layout.variables());
  const auto steps = static_cast<std::size_t>(layout.steps), nx = static_cast<std::size_t>(layout.states);
  z_.assign(n, 0.0);
  bound_lower_.assign(n, 1.0);
  bound_upper_.assign(n, 1.0);
  multipliers_.assign(static_cast<std::size_t>(layout.rows()), 0.0);
  x_.resize(steps * nx);
  u_.resize(steps * 2);
  next_.resize(steps * nx);
  A_.resize(steps * nx * nx);
  B_.resize(steps * nx * 2);
  moved_next_.resize(steps * nx);
  moved_A_.resize(steps * nx * nx);
  moved_B_.resize(steps * nx * 2);
  warm_ = false;
  fix_structure();
}

void IpoptNlp::fix_structure() {
  const auto entry = [](std::vector<Index>& rows, std::vector<Index>& columns, Index row, Index column) {
    rows.push_back(row);
    columns.push_back(column);
  };
  jacobian_rows_.clear(), jacobian_columns_.clear(), hessian_rows_.clear(), hessian_columns_.clear();
  for (int k = 0; k < layout_.steps; ++k) {
    const int row = k * layout_.rows_per_stage(), u = layout_.input(k), s = layout_.state(k + 1);
    for (int i = 0; i < layout_.states; ++i) {
      entry(jacobian_rows_, jacobian_columns_, row + i, s + i);
      entry(jacobian_rows_, jacobian_columns_, row + i, u);
      entry(jacobian_rows_, jacobian_columns_, row + i, u + 1);
      if (k == 0) continue;
      for (int j = 0; j < layout_.states; ++j) entry(jacobian_rows_, jacobian_columns_, row + i, layout_.state(k) + j);
    }
    for (const int edge : {0, 1})
      for (const int column : {s, s + 1, layout_.slack(k + 1)})
        entry(jacobian_rows_, jacobian_columns_, row + layout_.states + edge, column);
    entry(hessian_rows_, hessian_columns_, u, u);
    if (k > 0) entry(hessian_rows_, hessian_columns_, u, layout_.input(k - 1));
    entry(hessian_rows_, hessian_columns_, u + 1, u + 1);
    entry(hessian_rows_, hessian_columns_, s, s);
    entry(hessian_rows_, hessian_columns_, s + 1, s);
    entry(hessian_rows_, hessian_columns_, s + 1, s + 1);
    entry(hessian_rows_, hessian_columns_, s + 2, s + 2);
    entry(hessian_rows_, hessian_columns_, s + 3, s + 3);
    entry(hessian_rows_, hessian_columns_, layout_.slack(k + 1), layout_.slack(k + 1));
  }
  for (int k = 0; k < layout_.steps; ++k)
    for (int i = first_curved(k); i < curved_count(); ++i)
      for (int j = first_curved(k); j <= i; ++j)
        entry(hessian_rows_, hessian_columns_, curved_variable(k, i), curved_variable(k, j));
}

int IpoptNlp::curved_variable(int k, int i) const {
  const int of_state = layout_.states - 2;
  return i < of_state ? layout_.state(k) + 2 + i : layout_.input(k) + i - of_state;
}

double IpoptNlp::slope(const double* a, const double* b, int k, int i, const Number* lambda) const {
  const int nx = layout_.states, of_state = nx - 2;
  const Number* const row = lambda + static_cast<std::ptrdiff_t>(k) * layout_.rows_per_stage();
  double sum = 0.0;
  for (int r = 0; r < nx; ++r)
    sum += row[r] * (i < of_state ? a[(k * nx + r) * nx + 2 + i] : b[(k * nx + r) * 2 + i - of_state]);
  return sum;
}

bool IpoptNlp::add_curvature(const Number* lambda, Number* values) {
  constexpr double h = 1e-6;
  const int nx = layout_.states, count = curved_count();
  const auto rows = static_cast<std::size_t>(count);
  block_.resize(static_cast<std::size_t>(layout_.steps) * rows * rows);
  for (int j = 0; j < count; ++j) {
    moved_x_ = x_;
    moved_u_ = u_;
    for (int k = 0; k < layout_.steps; ++k) {
      if (j < nx - 2)
        moved_x_.data()[k * nx + 2 + j] += h;
      else
        moved_u_.data()[2 * k + j - (nx - 2)] += h;
    }
    model_->step(static_cast<std::size_t>(layout_.steps), moved_x_, moved_u_, ocp_->places(), moved_next_, moved_A_,
                 moved_B_);
    for (int k = 0; k < layout_.steps; ++k)
      for (int i = 0; i < count; ++i)
        block_.data()[(k * count + i) * count + j] =
            -(slope(moved_A_.data(), moved_B_.data(), k, i, lambda) - slope(A_.data(), B_.data(), k, i, lambda)) / h;
  }
  for (int k = 0; k < layout_.steps; ++k)
    for (int i = first_curved(k); i < count; ++i)
      for (int j = first_curved(k); j <= i; ++j) {
        const auto at = [&](int a, int b) { return block_.data()[(k * count + a) * count + b]; };
        *values++ = 0.5 * (at(i, j) + at(j, i));
      }
  return std::all_of(block_.begin(), block_.end(), [](double v) { return std::isfinite(v); });
}

void IpoptNlp::guess() {
  const auto start = ocp_->start();
  std::fill(z_.begin(), z_.end(), 0.0);
  for (int k = 1; k <= layout_.steps; ++k) {
    const auto& stage = ocp_->stage(k);
    double* const s = z_.data() + layout_.state(k);
    std::copy(start.begin(), start.end(), s);
    s[0] = stage.x, s[1] = stage.y, s[2] = stage.yaw, s[3] = std::max(stage.v, start[3]);
    s[4] = s[5] = 0.0;
  }
}

void IpoptNlp::shift() {
  const auto move = [](std::vector<double>& all, int block) { std::copy(all.begin() + block, all.end(), all.begin()); };
  move(z_, layout_.block());
  move(bound_lower_, layout_.block());
  move(bound_upper_, layout_.block());
  move(multipliers_, layout_.rows_per_stage());
  // Yaw is unwrapped near the car's; a plan from before a jump of 2 pi is brought along.
  const double jump = 2.0 * std::numbers::pi *
                      std::round((ocp_->start()[2] - z_.data()[layout_.state(1) + 2]) / (2.0 * std::numbers::pi));
  for (int k = 1; k <= layout_.steps; ++k) z_.data()[layout_.state(k) + 2] += jump;
}

double IpoptNlp::cost_of(const Number* x) const {
  double total = 0.0, before = ocp_->throttle_before();
  for (int k = 0; k < layout_.steps; ++k) {
    const int u = layout_.input(k);
    const double inputs = ocp_->input_cost(before, x[u], x[u + 1]);
    total += ocp_->stage(k + 1).add_tracking_cost(inputs, x + layout_.state(k + 1)) +
             ocp_->slack_cost(x[layout_.slack(k + 1)]);
    before = x[u];
  }
  return total;
}

bool IpoptNlp::predict(const Number* x, bool fresh) {
  if (fresh || !evaluated_) {
    const auto nx = static_cast<std::size_t>(layout_.states);
    const auto start = ocp_->start();
    for (int k = 0; k < layout_.steps; ++k) {
      const double* const from = k == 0 ? start.data() : x + layout_.state(k);
      std::copy_n(from, nx, x_.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(k) * nx));
      std::copy_n(x + layout_.input(k), 2, u_.begin() + 2 * static_cast<std::ptrdiff_t>(k));
    }
    model_->step(static_cast<std::size_t>(layout_.steps), x_, u_, ocp_->places(), next_, A_, B_);
    evaluated_ = true;
  }
  return std::all_of(next_.begin(), next_.end(), [](double v) { return std::isfinite(v); });
}

}  // namespace gripline::mpc_ipopt
