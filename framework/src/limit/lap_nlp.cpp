#include "limit/lap_nlp.hpp"

#include <IpIpoptApplication.hpp>
#include <IpTNLP.hpp>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gripline {
namespace {

using Ipopt::Index;
using Ipopt::Number;

constexpr int V = lap_variables, S = lap_states, corners = 4;
constexpr double unbounded = 2e19;
constexpr double smoothing = 0.002;  // half width of d over which drive is blended into braking [-]

/// Typical sizes: Ipopt sees variables and constraints of order one.
struct Scales {
  double z[V];
  explicit Scales(const LapProblem& p) {
    double width = 0;
    for (std::size_t k = 0; k < p.mesh.size(); ++k) width = std::max(width, p.mesh.n_hi[k] - p.mesh.n_lo[k]);
    const Car& car = p.plant.car();
    const double v = car.v_ref;
    const double z0[V] = {width, 0.5,           v, 0.3 * v, std::sqrt(p.plant.mu() * gravity / width), car.delta_max,
                          1.0,   car.ddelta_max};
    std::copy(std::begin(z0), std::end(z0), std::begin(z));
  }
};

/// Time per metre and the states' rates per metre, with derivatives by the interval's eight numbers.
struct IntervalRates {
  Dual8 time, state[S];
};

class LapNlp final : public Ipopt::TNLP {
 public:
  LapNlp(const LapProblem& problem, const Lap& guess)
      : p_(problem),
        guess_(guess),
        scales_(problem),
        n_(static_cast<Index>(problem.mesh.size())),
        bounded_(problem.plant.bounded()) {}

  Lap& lap() { return lap_; }

  bool get_nlp_info(Index& n, Index& m, Index& nnz_jac, Index& nnz_h, IndexStyleEnum& style) override {
    n = V * n_;
    m = rows() * n_;
    nnz_jac = n_ * (S * (2 * S + 2) + 2 + (p_.body ? corners * 4 : 0) + (bounded_ ? 2 * S + 2 : 0));
    nnz_h = n_ * (2 * (S * (S + 1) / 2) + S * S + 2 * 2 * S + 3);
    style = C_STYLE;
    return true;
  }

  bool get_bounds_info(Index, Number* x_l, Number* x_u, Index, Number* g_l, Number* g_u) override {
    const Car& car = p_.plant.car();
    for (Index k = 0; k < n_; ++k) {
      const auto i = static_cast<std::size_t>(k);
      const double lo[V] = {p_.mesh.n_lo[i], -1.4,           0.1 * car.v_ref, -unbounded,
                            -unbounded,      -car.delta_max, car.d_min,       -car.ddelta_max};
      const double hi[V] = {p_.mesh.n_hi[i], 1.4,           unbounded, unbounded,
                            unbounded,       car.delta_max, car.d_max, car.ddelta_max};
      for (int j = 0; j < V; ++j) {
        x_l[V * k + j] = lo[j] <= -unbounded ? -unbounded : lo[j] / scales_.z[j];
        x_u[V * k + j] = hi[j] >= unbounded ? unbounded : hi[j] / scales_.z[j];
      }
      Number *low = g_l + rows() * k, *high = g_u + rows() * k;
      std::fill_n(low, S, 0.0);
      std::fill_n(high, S, 0.0);
      for (int r = S; r < rows(); ++r) {
        low[r] = p_.mesh.mid_lo[i] / scales_.z[lap_n];
        high[r] = p_.mesh.mid_hi[i] / scales_.z[lap_n];
      }
      if (bounded_) low[rows() - 1] = -unbounded, high[rows() - 1] = 1.0;
    }
    return true;
  }

  bool get_starting_point(Index, bool, Number* x, bool, Number*, Number*, Index, bool, Number*) override {
    for (Index k = 0; k < n_; ++k)
      for (int j = 0; j < V; ++j)
        x[V * k + j] = guess_.z[static_cast<std::size_t>(k)][static_cast<std::size_t>(j)] / scales_.z[j];
    return true;
  }

  bool eval_f(Index, const Number* x, bool fresh, Number& f) override {
    if (!evaluate(x, fresh)) return false;
    f = 0;
    for (Index k = 0; k < n_; ++k) f += cost(k, rates_[static_cast<std::size_t>(k)].time).v;
    return std::isfinite(f);
  }

  bool eval_grad_f(Index n, const Number* x, bool fresh, Number* grad) override {
    if (!evaluate(x, fresh)) return false;
    std::fill_n(grad, n, 0.0);
    for (Index k = 0; k < n_; ++k) {
      const Dual8 f = cost(k, rates_[static_cast<std::size_t>(k)].time);
      for (int j = 0; j < S; ++j) {
        grad[V * k + j] += 0.5 * f.d[j];
        grad[V * next(k) + j] += 0.5 * f.d[j];
      }
      for (int j = S; j < V; ++j) grad[V * k + j] += f.d[j];
    }
    return true;
  }

  bool eval_g(Index, const Number* x, bool fresh, Index, Number* g) override {
    if (!evaluate(x, fresh)) return false;
    for (Index k = 0; k < n_; ++k) {
      const IntervalRates& r = rates_[static_cast<std::size_t>(k)];
      Number* row = g + rows() * k;
      for (int j = 0; j < S; ++j) row[j] = x[V * next(k) + j] - x[V * k + j] - step(k, j) * r.state[j].v;
      row[S] = 0.5 * (x[V * k + lap_n] + x[V * next(k) + lap_n]);
      for (int c = 0; p_.body && c < corners; ++c) row[S + 1 + c] = corner(k, c, middle_.data() + V * k).v;
      if (bounded_) row[rows() - 1] = used(k, middle_.data() + V * k).v;
    }
    return true;
  }

  bool eval_jac_g(Index, const Number* x, bool fresh, Index, Index, Index* rows_out, Index* cols,
                  Number* values) override {
    if (values != nullptr && !evaluate(x, fresh)) return false;
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
      const Index row = rows() * k, here = V * k, there = V * next(k);
      for (int i = 0; i < S; ++i) {
        const auto slope = [&](int j) {
          return values != nullptr ? -step(k, i) * rates_[static_cast<std::size_t>(k)].state[i].d[j] : 0.0;
        };
        for (int j = 0; j < S; ++j) {
          put(row + i, here + j, -(i == j) + 0.5 * slope(j));
          put(row + i, there + j, (i == j) + 0.5 * slope(j));
        }
        for (int j = S; j < V; ++j) put(row + i, here + j, slope(j));
      }
      put(row + S, here + lap_n, 0.5);
      put(row + S, there + lap_n, 0.5);
      for (int c = 0; p_.body && c < corners; ++c) {
        const Dual8 o = values != nullptr ? corner(k, c, middle_.data() + V * k) : Dual8(0.0);
        for (const int j : {lap_n, lap_xi}) {
          put(row + S + 1 + c, here + j, 0.5 * o.d[j]);
          put(row + S + 1 + c, there + j, 0.5 * o.d[j]);
        }
      }
      if (bounded_) {
        const Dual8 share = values != nullptr ? used(k, middle_.data() + V * k) : Dual8(0.0);
        for (int j = 0; j < S; ++j) {
          put(row + rows() - 1, here + j, 0.5 * share.d[j]);
          put(row + rows() - 1, there + j, 0.5 * share.d[j]);
        }
        for (int j = S; j < V; ++j) put(row + rows() - 1, here + j, share.d[j]);
      }
    }
    return true;
  }

  bool eval_h(Index, const Number* x, bool fresh, Number factor, Index, const Number* lambda, bool, Index,
              Index* rows_out, Index* cols, Number* values) override {
    if (values != nullptr && !second_derivatives(x, fresh, factor, lambda)) return false;
    std::size_t e = 0;
    for (Index k = 0; k < n_; ++k) {
      const auto put = [&](Index row, Index col, int i, int j, double share) {
        if (values != nullptr) {
          values[e] = share * hessian_[static_cast<std::size_t>(k)][static_cast<std::size_t>(V * i + j)];
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

  void finalize_solution(Ipopt::SolverReturn status, Index, const Number* x, const Number*, const Number*, Index,
                         const Number*, const Number*, Number, const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override {
    lap_.solved = status == Ipopt::SUCCESS || status == Ipopt::STOP_AT_ACCEPTABLE_POINT;
    lap_.z.resize(static_cast<std::size_t>(n_));
    for (Index k = 0; k < n_; ++k)
      for (int j = 0; j < V; ++j)
        lap_.z[static_cast<std::size_t>(k)][static_cast<std::size_t>(j)] = x[V * k + j] * scales_.z[j];
    lap_.time = 0;
    if (!evaluate(x, true)) {
      lap_.solved = false;
      return;
    }
    for (std::size_t k = 0; k < rates_.size(); ++k) lap_.time += rates_[k].time.v * p_.mesh.ds[k];
  }

 private:
  int rows() const { return S + 1 + (p_.body ? corners : 0) + (bounded_ ? 1 : 0); }
  Index next(Index k) const { return k + 1 < n_ ? k + 1 : 0; }
  double step(Index k, int j) const { return p_.mesh.ds[static_cast<std::size_t>(k)] / scales_.z[j]; }

  /// The cost of an interval by the scaled variables.
  Dual8 cost(Index k, const Dual8& time) const {
    const auto i = static_cast<std::size_t>(k);
    const Dual8 rate = Dual8::variable(middle_[static_cast<std::size_t>(V) * i + lap_rate], lap_rate);
    return p_.mesh.ds[i] * time * (1.0 + p_.smoothness * rate * rate);
  }

  /// Offset of a corner half-way through an interval, over the scale of n, by the scaled variables.
  Dual8 corner(Index k, int c, const double* z) const {
    const Car& car = p_.plant.car();
    const Dual8 n = scales_.z[lap_n] * Dual8::variable(z[lap_n], lap_n);
    const Dual8 xi = scales_.z[lap_xi] * Dual8::variable(z[lap_xi], lap_xi);
    const double forward = (c & 1) != 0 ? 0.5 * car.length : -0.5 * car.length;
    const double left = (c & 2) != 0 ? 0.5 * car.width : -0.5 * car.width;
    return offset_of_corner(n, xi, p_.mesh.kappa[static_cast<std::size_t>(k)], forward, left) *
           (1.0 / scales_.z[lap_n]);
  }

  /// What an interval asks of the tyres, by the scaled variables.
  Dual8 used(Index k, const double* z) const {
    const auto variable = [&](int j) { return scales_.z[j] * Dual8::variable(z[j], j); };
    const Dual8 d = variable(lap_d), throttle = 0.5 * (d + sqrt(d * d + smoothing * smoothing));
    return p_.plant.used(variable(lap_vx), variable(lap_omega), throttle, d - throttle,
                         p_.mesh.places[static_cast<std::size_t>(k)]);
  }

  /// Scaled variables half-way through every interval.
  void set_middles(const Number* x) {
    middle_.resize(static_cast<std::size_t>(V * n_));
    for (Index k = 0; k < n_; ++k) {
      double* z = middle_.data() + V * k;
      for (int j = 0; j < S; ++j) z[j] = 0.5 * (x[V * k + j] + x[V * next(k) + j]);
      for (int j = S; j < V; ++j) z[j] = x[V * k + j];
    }
  }

  /// Rates of all intervals at the scaled variables `z`; false where a car goes backwards along the road.
  bool rates_at(const std::vector<double>& z, std::vector<IntervalRates>& out) {
    const auto count = static_cast<std::size_t>(n_);
    motion_.resize(3 * count * motion_size);
    motion_rate_.resize(motion_.size());
    command_.resize(3 * count);
    at_.resize(3 * count);
    out.resize(count);
    const auto variable = [&](std::size_t k, int j) {
      Dual8 value = Dual8::variable(z[static_cast<std::size_t>(V) * k + static_cast<std::size_t>(j)], j);
      return scales_.z[j] * value;
    };
    for (std::size_t k = 0; k < count; ++k) {
      const Dual8 d = variable(k, lap_d), drive = 0.5 * (d + sqrt(d * d + smoothing * smoothing));
      const Dual8 throttles[] = {drive, d - drive, Dual8(0.0)};
      for (std::size_t part = 0; part < 3; ++part) {
        const std::size_t row = part * count + k;
        Dual8* const m = motion_.data() + row * motion_size;
        m[0] = m[1] = Dual8(0.0);
        m[2] = p_.mesh.places[k].yaw_line + variable(k, lap_xi);
        m[3] = variable(k, lap_vx);
        m[4] = variable(k, lap_vy);
        m[5] = variable(k, lap_omega);
        command_[row] = {throttles[part], variable(k, lap_delta), variable(k, lap_rate)};
        at_[row] = p_.mesh.places[k];
      }
    }
    p_.plant.lap_rates(motion_, command_, at_, motion_rate_);
    for (std::size_t k = 0; k < count; ++k) {
      const Dual8 n = variable(k, lap_n), xi = variable(k, lap_xi), vx = variable(k, lap_vx), vy = variable(k, lap_vy);
      const Dual8 cosine = cos(xi), sine = sin(xi), along = vx * cosine - vy * sine;
      if (!(along.v > 1e-3 * scales_.z[lap_vx])) return false;
      IntervalRates& r = out[k];
      r.time = (1.0 - p_.mesh.kappa[k] * n) / along;
      r.state[lap_n] = (vx * sine + vy * cosine) * r.time;
      r.state[lap_xi] = variable(k, lap_omega) * r.time - p_.mesh.kappa[k];
      for (std::size_t j = 3; j < motion_size; ++j) {
        const auto part = [&](std::size_t i) { return motion_rate_[(i * count + k) * motion_size + j]; };
        r.state[j - 1] = (part(0) + part(1) - part(2)) * r.time;
      }
      r.state[lap_delta] = variable(k, lap_rate) * r.time;
    }
    return true;
  }

  bool evaluate(const Number* x, bool fresh) {
    if (!fresh && evaluated_) return good_;
    set_middles(x);
    good_ = rates_at(middle_, rates_);
    evaluated_ = true;
    return good_;
  }

  /// Gradient of an interval's part of the Lagrangian, by the scaled variables at `z`.
  void gradient(Index k, const double* z, const IntervalRates& r, double factor, const Number* lambda,
                double (&out)[V]) const {
    const auto i = static_cast<std::size_t>(k);
    const Dual8 rate = Dual8::variable(z[lap_rate], lap_rate);
    Dual8 l = factor * p_.mesh.ds[i] * r.time * (1.0 + p_.smoothness * rate * rate);
    for (int j = 0; j < S; ++j) l -= (lambda[j] * step(k, j)) * r.state[j];
    for (int c = 0; p_.body && c < corners; ++c) l += lambda[S + 1 + c] * corner(k, c, z);
    if (bounded_) l += lambda[rows() - 1] * used(k, z);
    std::copy_n(l.d, V, out);
  }

  /// Second derivatives as differences of exact first ones, all intervals at once.
  bool second_derivatives(const Number* x, bool fresh, double factor, const Number* lambda) {
    constexpr double h = 1e-6;
    if (!evaluate(x, fresh)) return false;
    const auto count = static_cast<std::size_t>(n_);
    hessian_.resize(count);
    std::vector<std::array<double, V>> here(count);
    const auto all = [&](const std::vector<double>& z, const std::vector<IntervalRates>& r, auto&& use) {
      for (Index k = 0; k < n_; ++k) {
        double g[V];
        gradient(k, z.data() + V * k, r[static_cast<std::size_t>(k)], factor, lambda + rows() * k, g);
        use(static_cast<std::size_t>(k), g);
      }
    };
    all(middle_, rates_, [&](std::size_t k, const double* g) { std::copy_n(g, V, here[k].begin()); });
    std::vector<double> moved;
    for (int j = 0; j < V; ++j) {
      moved = middle_;
      for (std::size_t k = 0; k < count; ++k) moved[V * k + static_cast<std::size_t>(j)] += h;
      if (!rates_at(moved, moved_rates_)) return false;
      all(moved, moved_rates_, [&](std::size_t k, const double* g) {
        for (std::size_t i = 0; i < V; ++i) hessian_[k][V * i + static_cast<std::size_t>(j)] = (g[i] - here[k][i]) / h;
      });
    }
    for (auto& one : hessian_)
      for (std::size_t i = 0; i < V; ++i)
        for (std::size_t j = 0; j < i; ++j) one[V * i + j] = one[V * j + i] = 0.5 * (one[V * i + j] + one[V * j + i]);
    return true;
  }

  const LapProblem& p_;
  const Lap& guess_;
  Scales scales_;
  Index n_;
  bool bounded_;
  Lap lap_;
  bool evaluated_ = false, good_ = false;
  std::vector<double> middle_;
  std::vector<IntervalRates> rates_, moved_rates_;
  std::vector<std::array<double, V * V>> hessian_;
  std::vector<Dual8> motion_, motion_rate_;
  std::vector<ActingCommand<Dual8>> command_;
  std::vector<Place> at_;
};

}  // namespace

Lap solve_lap(const LapProblem& problem, const Lap& guess, LapStart start, int max_iterations) {
  const Ipopt::SmartPtr<LapNlp> nlp = new LapNlp(problem, guess);
  const Ipopt::SmartPtr<Ipopt::IpoptApplication> app = IpoptApplicationFactory();
  Ipopt::OptionsList& options = *app->Options();
  options.SetIntegerValue("print_level", 0);
  options.SetStringValue("sb", "yes");
  options.SetStringValue("linear_solver", "mumps");
  options.SetIntegerValue("max_iter", max_iterations);
  options.SetNumericValue("tol", 1e-6);
  options.SetNumericValue("acceptable_tol", 1e-4);
  if (start == LapStart::warm) {
    options.SetNumericValue("mu_init", 1e-4);
    options.SetNumericValue("bound_push", 1e-6);
    options.SetNumericValue("bound_frac", 1e-6);
  }
  // "": no ipopt.opt of the working directory, which would change what is solved.
  if (app->Initialize("") != Ipopt::Solve_Succeeded) throw std::runtime_error("Ipopt does not start");
  app->OptimizeTNLP(nlp);
  return nlp->lap();
}

}  // namespace gripline
