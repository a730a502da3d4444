#include "planners/time_optimal/lap_solver.hpp"

#include <IpIpoptApplication.hpp>
#include <IpSolveStatistics.hpp>
#include <IpTNLP.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>

namespace gripline::time_optimal {
namespace {

using Ipopt::Index;
using Ipopt::Number;

constexpr int V = lap_variables, S = lap_states;
constexpr double unbounded = 2e19;

template <class T>
T seed(double value, int direction) {
  if constexpr (std::is_same_v<T, double>)
    return value;
  else
    return T::variable(value, direction);
}

class LapNlp final : public Ipopt::TNLP {
 public:
  LapNlp(const LapProblem& problem, const LapSolution& guess)
      : p_(problem), guess_(guess), scales_(problem.typical_sizes()), n_(static_cast<Index>(problem.size())) {}

  LapSolution& solution() { return solution_; }

  bool get_nlp_info(Index& n, Index& m, Index& nnz_jac, Index& nnz_h, IndexStyleEnum& style) override {
    n = V * n_;
    m = rows() * n_;
    nnz_jac = n_ * (S * (2 * S + 2) + 8 + 4 * S + (p_.use.combined > 0 ? 2 * S + 1 : 0));
    nnz_h = n_ * hessian_entries;
    style = C_STYLE;
    return true;
  }

  bool get_bounds_info(Index, Number* x_l, Number* x_u, Index, Number* g_l, Number* g_u) override {
    for (Index k = 0; k < n_; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const double lo[V] = {p_.n_lo[i], -most_askew,       p_.least_speed(), -p_.top_speed,
                            -unbounded, -p_.car.delta_max, -unbounded,       -p_.car.ddelta_max};
      const double hi[V] = {p_.n_hi[i], most_askew,       1.1 * p_.top_speed, p_.top_speed,
                            unbounded,  p_.car.delta_max, unbounded,          p_.car.ddelta_max};
      for (int j = 0; j < V; ++j) {
        x_l[V * k + j] = lo[j] <= -unbounded ? -unbounded : lo[j] / scale(j);
        x_u[V * k + j] = hi[j] >= unbounded ? unbounded : hi[j] / scale(j);
      }
      Number *low = g_l + rows() * k, *high = g_u + rows() * k;
      for (int j = 0; j < S; ++j) low[j] = high[j] = 0.0;
      low[S] = -unbounded;  // a - drive(v) <= 0
      high[S] = 0.0;
      low[S + 1] = 0.0;  // a + brake(v) >= 0
      high[S + 1] = unbounded;
      low[S + 2] = low[S + 3] = -p_.use.slip_bound;
      high[S + 2] = high[S + 3] = p_.use.slip_bound;
      low[S + 4] = p_.mid_lo[i] / scales_[lap_n];
      high[S + 4] = p_.mid_hi[i] / scales_[lap_n];
      if (p_.use.combined > 0) {
        low[S + 5] = -unbounded;
        high[S + 5] = 1.0;
      }
    }
    return true;
  }

  bool get_starting_point(Index n, bool init_x, Number* x, bool init_z, Number* z_l, Number* z_u, Index m,
                          bool init_lambda, Number* lambda) override {
    if (init_x)
      for (Index k = 0; k < n_; ++k)
        for (int j = 0; j < V; ++j)
          x[V * k + j] = guess_.z[static_cast<std::size_t>(k)][static_cast<std::size_t>(j)] / scale(j);
    if (init_z) {
      std::copy_n(guess_.lower.begin(), n, z_l);
      std::copy_n(guess_.upper.begin(), n, z_u);
    }
    if (init_lambda) std::copy_n(guess_.lambda.begin(), m, lambda);
    return true;
  }

  bool eval_f(Index, const Number* x, bool, Number& f) override {
    f = 0;
    for (Index k = 0; k < n_; ++k) {
      double z[V];
      middle(x, k, z);
      f += cost(k, z, rates(k, z));
    }
    return std::isfinite(f);
  }

  bool eval_grad_f(Index n, const Number* x, bool, Number* grad) override {
    std::fill_n(grad, n, 0.0);
    for (Index k = 0; k < n_; ++k) {
      Dual8 z[V];
      middle(x, k, z);
      const Dual8 f = cost(k, z, rates(k, z));
      for (int j = 0; j < S; ++j) {
        grad[V * k + j] += 0.5 * f.d[j] * scale(j);
        grad[V * next(k) + j] += 0.5 * f.d[j] * scale(j);
      }
      for (int j = S; j < V; ++j) grad[V * k + j] += f.d[j] * scale(j);
    }
    return true;
  }

  bool eval_g(Index, const Number* x, bool, Index, Number* g) override {
    for (Index k = 0; k < n_; ++k) {
      double z[V];
      middle(x, k, z);
      const LapRates<double> r = rates(k, z);
      Number* row = g + rows() * k;
      for (int j = 0; j < S; ++j) row[j] = x[V * next(k) + j] - x[V * k + j] - step(k, j) * r.state[j];
      row[S] = (z[lap_a] - apply(p_.drive.drive, z[lap_vx])) / scales_[lap_a];
      row[S + 1] = (z[lap_a] + apply(p_.drive.brake, z[lap_vx])) / scales_[lap_a];
      row[S + 2] = r.slip_front;
      row[S + 3] = r.slip_rear;
      row[S + 4] = 0.5 * (x[V * k + lap_n] + x[V * next(k) + lap_n]);
      if (p_.use.combined > 0) row[S + 5] = circle(z, r);
    }
    return true;
  }

  bool eval_jac_g(Index, const Number* x, bool, Index, Index, Index* rows_out, Index* cols, Number* values) override {
    std::size_t e = 0;
    const auto put = [&](Index row, Index col, double value) {
      if (values != nullptr) {
        values[e] = value;
      } else {
        rows_out[e] = row;
        cols[e] = col;
      }
      ++e;
    };
    for (Index k = 0; k < n_; ++k) {
      Dual8 z[V];
      LapRates<Dual8> r;
      if (values != nullptr) {
        middle(x, k, z);
        r = rates(k, z);
      }
      jacobian_of_defects(k, r, put);
      jacobian_of_limits(k, z, r, put);
    }
    return true;
  }

  bool eval_h(Index, const Number* x, bool, Number factor, Index, const Number* lambda, bool, Index, Index* rows_out,
              Index* cols, Number* values) override {
    std::size_t e = 0;
    for (Index k = 0; k < n_; ++k) {
      SecondOrderDual<V> l;
      if (values != nullptr) l = lagrangian(k, x, factor, lambda + rows() * k);
      const auto put = [&](Index row, Index col, int i, int j, double share) {
        if (values != nullptr) {
          const int entry = i >= j ? SecondOrderDual<V>::entry(i, j) : SecondOrderDual<V>::entry(j, i);
          values[e] = share * l.h[entry] * scale(i) * scale(j);
        } else {
          rows_out[e] = std::max(row, col);
          cols[e] = std::min(row, col);
        }
        ++e;
      };
      const Index here = V * k, there = V * next(k);
      for (int i = 0; i < S; ++i) {
        for (int j = 0; j <= i; ++j) put(here + i, here + j, i, j, 0.25);
        for (int j = 0; j <= i; ++j) put(there + i, there + j, i, j, 0.25);
        for (int j = 0; j < S; ++j) put(there + i, here + j, i, j, 0.25);
      }
      for (int i = S; i < V; ++i) {
        for (int j = 0; j < S; ++j) put(here + i, here + j, i, j, 0.5);
        for (int j = 0; j < S; ++j) put(here + i, there + j, i, j, 0.5);
        for (int j = S; j <= i; ++j) put(here + i, here + j, i, j, 1.0);
      }
    }
    return true;
  }

  void finalize_solution(Ipopt::SolverReturn status, Index n, const Number* x, const Number* z_l, const Number* z_u,
                         Index m, const Number*, const Number* lambda, Number, const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override {
    solution_.solved = status == Ipopt::SUCCESS || status == Ipopt::STOP_AT_ACCEPTABLE_POINT;
    solution_.z.resize(static_cast<std::size_t>(n_));
    solution_.time = 0;
    for (Index k = 0; k < n_; ++k) {
      for (int j = 0; j < V; ++j)
        solution_.z[static_cast<std::size_t>(k)][static_cast<std::size_t>(j)] = x[V * k + j] * scale(j);
      double z[V];
      middle(x, k, z);
      solution_.time += rates(k, z).time * p_.ds[static_cast<std::size_t>(k)];
    }
    solution_.lower.assign(z_l, z_l + n);
    solution_.upper.assign(z_u, z_u + n);
    solution_.lambda.assign(lambda, lambda + m);
  }

 private:
  static constexpr Index hessian_entries = 2 * (S * (S + 1) / 2) + S * S + 2 * 2 * S + 3;

  Index rows() const { return S + 5 + (p_.use.combined > 0 ? 1 : 0); }
  Index next(Index k) const { return k + 1 < n_ ? k + 1 : 0; }
  double scale(int j) const { return scales_[static_cast<std::size_t>(j)]; }
  double step(Index k, int j) const { return p_.ds[static_cast<std::size_t>(k)] / scale(j); }

  template <class T>
  void middle(const Number* x, Index k, T (&z)[V]) const {
    const Number *here = x + V * k, *there = x + V * next(k);
    for (int j = 0; j < S; ++j) z[j] = seed<T>(0.5 * (here[j] + there[j]) * scale(j), j);
    for (int j = S; j < V; ++j) z[j] = seed<T>(here[j] * scale(j), j);
  }
  template <class T>
  LapRates<T> rates(Index k, const T (&z)[V]) const {
    return lap_rates(p_.car, p_.tyres, p_.drive.coast, p_.places[static_cast<std::size_t>(k)], z);
  }
  template <class T>
  T cost(Index k, const T (&z)[V], const LapRates<T>& r) const {
    return interval_cost(p_, static_cast<std::size_t>(k), z, r);
  }
  template <class T>
  T circle(const T (&z)[V], const LapRates<T>& r) const {
    return friction_used(p_, z, r) + (1.0 - r.load * r.load);
  }

  template <class Put>
  void jacobian_of_defects(Index k, const LapRates<Dual8>& r, const Put& put) const {
    for (int i = 0; i < S; ++i) {
      const Index row = rows() * k + i;
      for (int j = 0; j < S; ++j) {
        const double slope = 0.5 * step(k, i) * r.state[i].d[j] * scale(j);
        put(row, V * k + j, -(i == j) - slope);
        put(row, V * next(k) + j, (i == j) - slope);
      }
      for (int j = S; j < V; ++j) put(row, V * k + j, -step(k, i) * r.state[i].d[j] * scale(j));
    }
  }
  template <class Put>
  void jacobian_of_limits(Index k, const Dual8 (&z)[V], const LapRates<Dual8>& r, const Put& put) const {
    const Index row = rows() * k + S;
    const double share = 0.5 * scales_[lap_vx] / scales_[lap_a];
    const double drive = p_.drive.drive.at(z[lap_vx].v).slope, brake = p_.drive.brake.at(z[lap_vx].v).slope;
    put(row, V * k + lap_a, 1.0);
    put(row, V * k + lap_vx, -share * drive);
    put(row, V * next(k) + lap_vx, -share * drive);
    put(row + 1, V * k + lap_a, 1.0);
    put(row + 1, V * k + lap_vx, share * brake);
    put(row + 1, V * next(k) + lap_vx, share * brake);
    const auto states = [&](Index at, const Dual8& c) {
      for (int j = 0; j < S; ++j) {
        put(at, V * k + j, 0.5 * c.d[j] * scale(j));
        put(at, V * next(k) + j, 0.5 * c.d[j] * scale(j));
      }
    };
    states(row + 2, r.slip_front);
    states(row + 3, r.slip_rear);
    put(row + 4, V * k + lap_n, 0.5);
    put(row + 4, V * next(k) + lap_n, 0.5);
    if (!(p_.use.combined > 0)) return;
    const Dual8 c = circle(z, r);
    states(row + 5, c);
    put(row + 5, V * k + lap_a, c.d[lap_a] * scales_[lap_a]);
  }

  SecondOrderDual<V> lagrangian(Index k, const Number* x, double factor, const Number* lambda) const {
    SecondOrderDual<V> z[V];
    middle(x, k, z);
    const LapRates<SecondOrderDual<V>> r = rates(k, z);
    SecondOrderDual<V> l = factor * cost(k, z, r);
    for (int j = 0; j < S; ++j) l -= lambda[j] * step(k, j) * r.state[j];
    const double share = 1.0 / scales_[lap_a];
    l -= (lambda[S] * share) * apply(p_.drive.drive, z[lap_vx]);
    l += (lambda[S + 1] * share) * apply(p_.drive.brake, z[lap_vx]);
    l += lambda[S + 2] * r.slip_front;
    l += lambda[S + 3] * r.slip_rear;
    if (p_.use.combined > 0) l += lambda[S + 5] * circle(z, r);
    return l;
  }

  const LapProblem& p_;
  const LapSolution& guess_;
  std::array<double, V> scales_;
  Index n_;
  LapSolution solution_;
};

}  // namespace

std::array<double, lap_variables> LapProblem::typical_sizes() const {
  double width = 0;
  for (std::size_t k = 0; k < size(); ++k) width = std::max(width, n_hi[k] - n_lo[k]);
  const double v = 0.5 * top_speed, grip = tyres.front.D + tyres.rear.D;
  return {width, 0.5, v, 0.3 * v, std::sqrt(grip / width), car.delta_max, grip, car.ddelta_max};
}

LapSolution solve_lap(const LapProblem& problem, const LapSolution& guess, int max_iterations) {
  if (problem.use.sharing.ratio > 0 || problem.use.small_slip_from_speed > 0)
    throw std::invalid_argument(
        "solve_lap() has no friction that each axle shares and no slips bounded by speed; expected a ratio of sharing "
        "and a small_slip_from_speed of 0, or a WindowSolver");
  const Ipopt::SmartPtr<LapNlp> nlp = new LapNlp(problem, guess);
  const Ipopt::SmartPtr<Ipopt::IpoptApplication> app = IpoptApplicationFactory();
  Ipopt::OptionsList& options = *app->Options();
  options.SetIntegerValue("print_level", 0);
  options.SetStringValue("sb", "yes");
  options.SetStringValue("linear_solver", "mumps");
  options.SetIntegerValue("max_iter", max_iterations);
  options.SetNumericValue("tol", 1e-6);
  if (!guess.lambda.empty()) {
    options.SetStringValue("warm_start_init_point", "yes");
    for (const char* push : {"warm_start_bound_push", "warm_start_bound_frac", "warm_start_slack_bound_push",
                             "warm_start_slack_bound_frac", "warm_start_mult_bound_push"})
      options.SetNumericValue(push, 1e-4);
    // Learned tyres may be far from those of the guess: the adaptive strategy lets the barrier grow again. A tolerance
    // of 1e-4 suffices for a line that is followed.
    options.SetStringValue("mu_strategy", "adaptive");
    options.SetNumericValue("tol", 1e-4);
    options.SetNumericValue("acceptable_tol", 1e-3);
    options.SetIntegerValue("acceptable_iter", 4);
  }
  // "": no ipopt.opt of the working directory, which would change what is solved.
  if (app->Initialize("") != Ipopt::Solve_Succeeded) throw std::runtime_error("Ipopt does not start");
  app->OptimizeTNLP(nlp);
  LapSolution solution = nlp->solution();
  if (Ipopt::IsValid(app->Statistics())) solution.iterations = app->Statistics()->IterationCount();
  return solution;
}

}  // namespace gripline::time_optimal
