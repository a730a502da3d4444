#include "planners/time_optimal/interval_program.hpp"

#include <algorithm>
#include <limits>

namespace gripline::time_optimal {
namespace {

constexpr int V = lap_variables, S = lap_states;
using Value = CubicSpline::Value;  // of one variable, with two derivatives
using Gradient = std::array<double, V>;

/// Slip angle of a tyre's largest force [rad]; infinite where its force always grows.
double peak_slip(const MagicFormula& tyre) {
  return tyre.C > 1.0 ? std::tan(0.5 * std::numbers::pi / tyre.C) / tyre.B : std::numeric_limits<double>::infinity();
}

/// A function of x = vx, y, the lateral speed at an axle, and d, the steering angle: value, first and second
/// derivatives.
struct AxleFunction {
  double f = 0, x = 0, y = 0, d = 0;
  double xx = 0, xy = 0, yy = 0, xd = 0, yd = 0, dd = 0;

  /// Adds a multiple of another's second derivatives to these.
  void add_hessian_of(double weight, const AxleFunction& by) {
    xx += weight * by.xx;
    xy += weight * by.xy;
    yy += weight * by.yy;
    xd += weight * by.xd;
    yd += weight * by.yd;
    dd += weight * by.dd;
  }
  /// Adds a multiple of the second derivatives of another's square to these.
  void add_hessian_of_square(double weight, const AxleFunction& by) {
    const double w = 2.0 * weight;
    add_hessian_of(w * by.f, by);
    xx += w * by.x * by.x;
    xy += w * by.x * by.y;
    yy += w * by.y * by.y;
    xd += w * by.x * by.d;
    yd += w * by.y * by.d;
    dd += w * by.d * by.d;
  }
};

/// Slip angle of an axle, steered delta - atan(y / vx) [rad]; `steered` is 1 in front and 0 at the rear.
AxleFunction slip_of(double vx, double y, double delta, double steered) {
  const double u = 1.0 / (vx * vx + y * y), twist = 2.0 * vx * y * u * u;
  AxleFunction s;
  s.f = steered * delta - std::atan(y / vx);
  s.x = y * u;
  s.y = -vx * u;
  s.d = steered;
  s.xx = -twist;
  s.xy = (vx * vx - y * y) * u * u;
  s.yy = twist;
  return s;
}

/// load(vx) times the tyre's force at a slip.
AxleFunction force_of(const MagicFormula& tyre, const AxleFunction& s, const Value& load) {
  const double q = tyre.B * s.f, rise = tyre.B / (1.0 + q * q), angle = tyre.C * std::atan(q);
  const double sine = std::sin(angle), cosine = std::cos(angle);
  const double f = tyre.D * sine, slope = tyre.D * tyre.C * cosine * rise;
  const double curvature = -tyre.D * tyre.C * rise * rise * (2.0 * q * cosine + tyre.C * sine);
  const double n = load.f, first = n * slope, second = n * curvature, more = load.slope * slope;
  AxleFunction r;
  r.f = n * f;
  r.x = first * s.x + load.slope * f;
  r.y = first * s.y;
  r.d = first * s.d;
  r.xx = second * s.x * s.x + first * s.xx + 2.0 * more * s.x + load.curvature * f;
  r.xy = second * s.x * s.y + first * s.xy + more * s.y;
  r.yy = second * s.y * s.y + first * s.yy;
  r.xd = (second * s.x + more) * s.d;
  r.yd = second * s.y * s.d;
  r.dd = second * s.d * s.d;
  return r;
}

/// relative_load() times grip, with its derivatives by vx.
Value load_at(const LapPlace& place, double vx) {
  if (place.plain()) return {1.0, 0.0, 0.0};
  using Dual = SecondOrderDual<1>;
  const Dual load = place.grip * relative_load(place, Dual::variable(vx, 0));
  return {load.v, load.g[0], load.h[0]};
}

/// The gradient by z of a function of an axle that is `arm` in front of the centre of gravity.
Gradient by_z(double weight, const AxleFunction& f, double arm) {
  Gradient g{};
  g[lap_vx] = weight * f.x;
  g[lap_vy] = weight * f.y;
  g[lap_omega] = weight * arm * f.y;
  g[lap_delta] = weight * f.d;
  return g;
}

/// A symmetric matrix by z, its lower triangle.
struct Hessian {
  std::array<double, SecondOrderDual<V>::entries>& h;
  double& at(int row, int column) { return h[static_cast<std::size_t>(SecondOrderDual<V>::entry(row, column))]; }
  void add(const AxleFunction& f, double arm) {
    at(lap_vx, lap_vx) += f.xx;
    at(lap_vy, lap_vx) += f.xy;
    at(lap_vy, lap_vy) += f.yy;
    at(lap_omega, lap_vx) += arm * f.xy;
    at(lap_omega, lap_vy) += arm * f.yy;
    at(lap_omega, lap_omega) += arm * arm * f.yy;
    at(lap_delta, lap_vx) += f.xd;
    at(lap_delta, lap_vy) += f.yd;
    at(lap_delta, lap_omega) += arm * f.yd;
    at(lap_delta, lap_delta) += f.dd;
  }
  /// weight times u v' + v u'.
  void add_products(double weight, const Gradient& u, const Gradient& v) {
    for (int a = 0, e = 0; a < V; ++a)
      for (int b = 0; b <= a; ++b, ++e) {
        const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
        h[static_cast<std::size_t>(e)] += weight * (u[i] * v[j] + v[i] * u[j]);
      }
  }
};

std::size_t curved(int row) { return static_cast<std::size_t>(row - first_curved_row); }

}  // namespace

struct IntervalProgram::Parts {
  Value load;
  AxleFunction slip_front, slip_rear, front, rear;
  AxleFunction hessian_front, hessian_rear;  // of the weighted sum by each axle's variables: second derivatives only
};

IntervalProgram::IntervalProgram(const LapProblem& problem)
    : p_(problem), slip_bound_slow_car_(problem.use.slip_bound), scale_(problem.typical_sizes()) {
  set_car(p_.tyres, {});
}

void IntervalProgram::set_car(const AxleTyres& tyres, const SpecificResistance& more) {
  p_.tyres = tyres;
  more_ = more;
  const auto bound = [&](const MagicFormula& tyre) {
    const double slow_car = shares_friction() ? std::min(slip_bound_slow_car_, peak_slip(tyre)) : slip_bound_slow_car_;
    return SlipBound{.when_slow = slow_car,
                     .when_fast = p_.use.slip_bound,
                     .slow_until = p_.use.full_slip_until_speed,
                     .fast_from = p_.use.small_slip_from_speed};
  };
  slip_front_ = bound(tyres.front);
  slip_rear_ = bound(tyres.rear);
}

void IntervalProgram::differentiate(std::size_t i, const double (&z)[V], const std::array<double, S>& rate_weight,
                                    const std::array<double, curved_rows>& row_weight, IntervalDerivatives& out) const {
  const double vx = z[lap_vx], vy = z[lap_vy], omega = z[lap_omega], lf = p_.car.lf, lr = p_.car.lr;
  Parts parts;
  parts.load = load_at(p_.places[i], vx);
  parts.slip_front = slip_of(vx, vy + lf * omega, z[lap_delta], 1.0);
  parts.slip_rear = slip_of(vx, vy - lr * omega, z[lap_delta], 0.0);
  parts.front = force_of(p_.tyres.front, parts.slip_front, parts.load);
  parts.rear = force_of(p_.tyres.rear, parts.slip_rear, parts.load);
  out.lagrangian_by.fill(0.0);
  differentiate_rates(i, z, rate_weight, parts, out);
  differentiate_rows(i, z, row_weight, parts, out);
  Hessian h{out.lagrangian_by};
  h.add(parts.hessian_front, lf);
  h.add(parts.hessian_rear, -lr);
}

/// What rates and their curvature share. Cost and rates are each `time` times something by time.
struct IntervalProgram::Motion {
  double sine, cosine;   // of the steering angle
  double turn;           // what a moment over the mass accelerates
  double along, across;  // speed along the line and across it
  Gradient along_by;     // of `along`: by xi, vx and vy
  double time;           // per metre
  Gradient time_by;
  Value coast;
  std::array<double, S> by_time;  // d(state)/dt
  double sum;                     // weighted, of cost and rates, over `time`
  Gradient sum_by;
};

IntervalProgram::Motion IntervalProgram::motion_at(std::size_t i, const double (&z)[V], const Parts& parts) const {
  const LapPlace& place = p_.places[i];
  const AxleFunction &F = parts.front, &R = parts.rear;
  const double vx = z[lap_vx], vy = z[lap_vy], omega = z[lap_omega], lf = p_.car.lf, lr = p_.car.lr;
  const double sine = std::sin(z[lap_xi]), cosine = std::cos(z[lap_xi]);
  const double s = std::sin(z[lap_delta]), c = std::cos(z[lap_delta]), turn = p_.car.m / p_.car.Iz;
  const double along = vx * cosine - vy * sine, across = vx * sine + vy * cosine;
  Motion m{s, c, turn, along, across, {0.0, -across, cosine, -sine}, 0.0, {}, p_.drive.coast.at(vx), {}, 0.0, {}};
  m.time = (1.0 - place.kappa * z[lap_n]) / along;
  m.time_by[lap_n] = -place.kappa / along;
  for (std::size_t j = lap_xi; j <= lap_vy; ++j) m.time_by[j] = -m.time * m.along_by[j] / along;
  m.by_time = {
      across,
      omega,
      z[lap_a] + m.coast.f - more_.rolling - more_.drag * vx * vx - F.f * s + vy * omega - slope_pull(place.grade),
      R.f + F.f * c - vx * omega + slope_pull(place.bank),
      (F.f * c * lf - R.f * lr) * turn,
      z[lap_rate]};
  return m;
}

/// The gradients of `by_time`.
std::array<std::array<double, V>, S> IntervalProgram::gradients_by_time(const double (&z)[V], const Parts& parts,
                                                                        const Motion& m) const {
  const AxleFunction &F = parts.front, &R = parts.rear;
  const double vx = z[lap_vx], vy = z[lap_vy], omega = z[lap_omega], lf = p_.car.lf, lr = p_.car.lr;
  std::array<Gradient, S> by{};
  by[lap_n] = {0.0, m.along, -m.along_by[lap_vy], m.along_by[lap_vx]};
  by[lap_xi][lap_omega] = 1.0;
  by[lap_vx] = by_z(-m.sine, F, lf);
  by[lap_vx][lap_vx] += m.coast.slope - 2.0 * more_.drag * vx;
  by[lap_vx][lap_vy] += omega;
  by[lap_vx][lap_omega] += vy;
  by[lap_vx][lap_delta] -= m.cosine * F.f;
  by[lap_vx][lap_a] = 1.0;
  const Gradient front_across = by_z(m.cosine, F, lf), rear_across = by_z(1.0, R, -lr);
  for (std::size_t j = lap_vx; j <= lap_delta; ++j) {
    by[lap_vy][j] = front_across[j] + rear_across[j];
    by[lap_omega][j] = m.turn * (lf * front_across[j] - lr * rear_across[j]);
  }
  by[lap_vy][lap_vx] -= omega;
  by[lap_vy][lap_omega] -= vx;
  by[lap_vy][lap_delta] -= m.sine * F.f;
  by[lap_omega][lap_delta] -= m.turn * lf * m.sine * F.f;
  by[lap_delta][lap_rate] = 1.0;
  return by;
}

void IntervalProgram::differentiate_rates(std::size_t i, const double (&z)[V], const std::array<double, S>& w,
                                          Parts& parts, IntervalDerivatives& out) const {
  Motion m = motion_at(i, z, parts);
  const std::array<Gradient, S> by = gradients_by_time(z, parts, m);
  const double ds = p_.ds[i], smooth = smoothness();
  const double base = ds * (1.0 + smooth * z[lap_rate] * z[lap_rate]), base_by_rate = 2.0 * ds * smooth * z[lap_rate];
  m.sum = base;
  m.sum_by[lap_rate] = base_by_rate;
  for (std::size_t j = 0; j < w.size(); ++j) {
    m.sum += w[j] * m.by_time[j];
    for (std::size_t n = 0; n < m.sum_by.size(); ++n) {
      out.rate_by[j][n] = m.by_time[j] * m.time_by[n] + m.time * by[j][n];
      m.sum_by[n] += w[j] * by[j][n];
    }
    out.rate[j] = m.by_time[j] * m.time;
  }
  out.rate[lap_xi] -= p_.places[i].kappa;
  out.cost = base * m.time;
  for (std::size_t n = 0; n < out.cost_by.size(); ++n) out.cost_by[n] = base * m.time_by[n];
  out.cost_by[lap_rate] += m.time * base_by_rate;
  add_hessian_of_rates(i, w, m, parts, out);
}

/// Second derivatives of the weighted sum of cost and rates.
void IntervalProgram::add_hessian_of_rates(std::size_t i, const std::array<double, S>& w, const Motion& m, Parts& parts,
                                           IntervalDerivatives& out) const {
  const double kappa = p_.places[i].kappa, time = m.time, along = m.along;
  Hessian h{out.lagrangian_by};
  h.add_products(1.0, m.time_by, m.sum_by);
  const double spread = m.sum / along;  // second derivatives of the time
  for (int a = lap_xi; a <= lap_vy; ++a) {
    const double by_a = m.along_by[static_cast<std::size_t>(a)];
    h.at(a, lap_n) += spread * kappa * by_a / along;
    for (int b = lap_xi; b <= a; ++b)
      h.at(a, b) += 2.0 * spread * time * by_a * m.along_by[static_cast<std::size_t>(b)] / along;
  }
  const double st = spread * time, sine = -m.along_by[lap_vy], cosine = m.along_by[lap_vx];
  h.at(lap_xi, lap_xi) += st * along - time * w[lap_n] * m.across;
  h.at(lap_vx, lap_xi) += st * sine + time * w[lap_n] * cosine;
  h.at(lap_vy, lap_xi) += st * cosine - time * w[lap_n] * sine;
  h.at(lap_vx, lap_vx) += time * w[lap_vx] * (m.coast.curvature - 2.0 * more_.drag);
  h.at(lap_omega, lap_vx) -= time * w[lap_vy];
  h.at(lap_omega, lap_vy) += time * w[lap_vx];
  h.at(lap_rate, lap_rate) += 2.0 * time * p_.ds[i] * smoothness();
  // The front force counts by a share that turns with the steering angle.
  const AxleFunction &F = parts.front, &R = parts.rear;
  const double push = w[lap_vy] + w[lap_omega] * m.turn * p_.car.lf;
  const double share = push * m.cosine - w[lap_vx] * m.sine, share_by = -push * m.sine - w[lap_vx] * m.cosine;
  parts.hessian_front.add_hessian_of(time * share, F);
  parts.hessian_front.xd += time * share_by * F.x;
  parts.hessian_front.yd += time * share_by * F.y;
  parts.hessian_front.dd += time * (2.0 * share_by * F.d - share * F.f);
  parts.hessian_rear.add_hessian_of(time * (w[lap_vy] - w[lap_omega] * m.turn * p_.car.lr), R);
}

void IntervalProgram::differentiate_rows(std::size_t i, const double (&z)[V], const std::array<double, curved_rows>& w,
                                         Parts& parts, IntervalDerivatives& out) const {
  const double unit = 1.0 / scale_[lap_a];
  const Value drive = p_.drive.drive.at(z[lap_vx]), brake = p_.drive.brake.at(z[lap_vx]);
  Hessian h{out.lagrangian_by};
  const auto of_speed = [&](int row, double sign, const Value& most) {
    out.row[curved(row)] = unit * (sign * z[lap_a] - most.f);
    out.row_by[curved(row)][lap_vx] = -unit * most.slope;
    out.row_by[curved(row)][lap_a] = unit * sign;
    h.at(lap_vx, lap_vx) -= w[curved(row)] * unit * most.curvature;
  };
  of_speed(drive_most, 1.0, drive);
  of_speed(brake_most, -1.0, brake);
  const auto one_way = [&](int row, double sign, const AxleFunction& slip, double arm, const SlipBound& bound,
                           AxleFunction& hessian) {
    const Value most = bound.at(z[lap_vx]);
    out.row[curved(row)] = sign * slip.f - most.f;
    out.row_by[curved(row)] = by_z(sign, slip, arm);
    out.row_by[curved(row)][lap_vx] -= most.slope;
    h.at(lap_vx, lap_vx) -= w[curved(row)] * most.curvature;
    hessian.add_hessian_of(sign * w[curved(row)], slip);
  };
  const auto both_ways = [&](int row, const AxleFunction& slip, double arm, const SlipBound& bound,
                             AxleFunction& hessian) {
    const double per = 1.0 / (bound.when_slow * bound.when_slow), unit = 1.0 / bound.when_slow;
    const Value most = bound.at(z[lap_vx]);
    const double share = most.f / bound.when_slow, slope = unit * most.slope, curvature = unit * most.curvature;
    out.row[curved(row)] = per * slip.f * slip.f - share * share;
    out.row_by[curved(row)] = by_z(2.0 * per * slip.f, slip, arm);
    out.row_by[curved(row)][lap_vx] -= 2.0 * share * slope;
    h.at(lap_vx, lap_vx) -= 2.0 * w[curved(row)] * (slope * slope + share * curvature);
    hessian.add_hessian_of_square(per * w[curved(row)], slip);
  };
  const double lf = p_.car.lf, lr = p_.car.lr;
  if (p_.use.sharing.ratio > 0) {
    both_ways(front_both_ways, parts.slip_front, lf, slip_front_, parts.hessian_front);
    both_ways(rear_both_ways, parts.slip_rear, -lr, slip_rear_, parts.hessian_rear);
    differentiate_sharing(i, z, w, parts, out);
    return;
  }
  one_way(front_most, 1.0, parts.slip_front, lf, slip_front_, parts.hessian_front);
  one_way(front_least, -1.0, parts.slip_front, lf, slip_front_, parts.hessian_front);
  if (p_.use.combined > 0) {
    both_ways(rear_both_ways, parts.slip_rear, -lr, slip_rear_, parts.hessian_rear);
    differentiate_circle(z, w, parts, out);
  } else {
    one_way(rear_most, 1.0, parts.slip_rear, -lr, slip_rear_, parts.hessian_rear);
    one_way(rear_least, -1.0, parts.slip_rear, -lr, slip_rear_, parts.hessian_rear);
  }
}

/// (combined a)^2 + (Ff + Fr)^2 <= (N (Df + Dr))^2, over (Df + Dr)^2.
void IntervalProgram::differentiate_circle(const double (&z)[V], const std::array<double, curved_rows>& w, Parts& parts,
                                           IntervalDerivatives& out) const {
  const double most = p_.tyres.front.D + p_.tyres.rear.D, per = 1.0 / (most * most), weight = w[curved(car_shared)];
  const double along = p_.use.combined * z[lap_a], across = parts.front.f + parts.rear.f;
  Gradient across_by = by_z(1.0, parts.front, p_.car.lf);
  const Gradient rear_by = by_z(1.0, parts.rear, -p_.car.lr);
  for (std::size_t m = 0; m < across_by.size(); ++m) across_by[m] += rear_by[m];
  const Value& load = parts.load;
  Gradient& by = out.row_by[curved(car_shared)];
  out.row[curved(car_shared)] = per * (along * along + across * across) - load.f * load.f;
  for (std::size_t m = 0; m < by.size(); ++m) by[m] = 2.0 * per * across * across_by[m];
  by[lap_vx] -= 2.0 * load.f * load.slope;
  by[lap_a] += 2.0 * per * p_.use.combined * along;
  Hessian h{out.lagrangian_by};
  h.add_products(weight * per, across_by, across_by);
  h.at(lap_vx, lap_vx) -= 2.0 * weight * (load.slope * load.slope + load.f * load.curvature);
  h.at(lap_a, lap_a) += 2.0 * weight * per * p_.use.combined * p_.use.combined;
  parts.hessian_front.add_hessian_of(2.0 * weight * per * across, parts.front);
  parts.hessian_rear.add_hessian_of(2.0 * weight * per * across, parts.rear);
}

/// (F / D)^2 + (share a / (ratio D))^2 <= (N + load a)^2 of both axles, whose right side has no sign: share_friction().
void IntervalProgram::differentiate_sharing(std::size_t i, const double (&z)[V],
                                            const std::array<double, curved_rows>& w, Parts& parts,
                                            IntervalDerivatives& out) const {
  const AxleSharing& own = p_.use.sharing;
  const double a = z[lap_a], mean = 0.5 * (own.drive_front + own.brake_front);
  const double rise = (own.drive_front - own.brake_front) / std::numbers::pi, per = 1.0 / from_brake_to_drive;
  const double fall = 1.0 / (1.0 + per * per * a * a);
  const Value front{mean + rise * std::atan(per * a), rise * per * fall,
                    -2.0 * rise * per * per * per * a * fall * fall};
  const Value rear{1.0 - front.f, -front.slope, -front.curvature};
  Hessian h{out.lagrangian_by};
  const auto axle = [&](int row, const AxleFunction& force, double arm, const Value& share, double load, double D,
                        AxleFunction& hessian) {
    const double weight = w[curved(row)], across = 1.0 / (D * D), unit = 1.0 / (own.ratio * D);
    const double along = unit * share.f * a, slope = unit * (share.f + share.slope * a);
    const double curvature = unit * (2.0 * share.slope + share.curvature * a);
    const double rises = p_.places[i].grip * load, carried = parts.load.f + rises * a;
    out.row[curved(row)] = across * force.f * force.f + along * along - carried * carried;
    Gradient& by = out.row_by[curved(row)] = by_z(2.0 * across * force.f, force, arm);
    by[lap_vx] -= 2.0 * carried * parts.load.slope;
    by[lap_a] = 2.0 * (along * slope - carried * rises);
    hessian.add_hessian_of_square(weight * across, force);
    h.at(lap_vx, lap_vx) -= 2.0 * weight * (parts.load.slope * parts.load.slope + carried * parts.load.curvature);
    h.at(lap_a, lap_vx) -= 2.0 * weight * rises * parts.load.slope;
    h.at(lap_a, lap_a) += 2.0 * weight * (slope * slope + along * curvature - rises * rises);
  };
  axle(front_shared, parts.front, p_.car.lf, front, own.load_front, p_.tyres.front.D, parts.hessian_front);
  axle(rear_shared, parts.rear, -p_.car.lr, rear, own.load_rear, p_.tyres.rear.D, parts.hessian_rear);
}

}  // namespace gripline::time_optimal
