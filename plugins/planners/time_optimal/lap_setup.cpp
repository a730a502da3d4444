#include "planners/time_optimal/lap_setup.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "common/planning/planner_context.hpp"

namespace gripline::time_optimal {

using namespace planning;

namespace {

/// What the course, which knows metres alone, cannot say of a margin [m].
std::string in_widths(double margin, const Car& car) {
  std::ostringstream text;
  text.precision(4);
  text << "; this planner's \"margin\" is in widths of the car: " << margin / car.width << ", which are " << margin
       << " m from the centre of gravity to each edge";
  return text.str();
}

/// The minimum-curvature line with the part of the margin beyond 0.4 of the car's width, and with turns that can be
/// driven, so that every node has room on both sides.
ClosedLine compute_base(const PluginContext& context, double margin) {
  const Course& course = course_of(context);
  const Car& car = context.car;
  const double wheelbase = car.lf + car.lr;
  std::vector<LinePoint> samples(sample_count(std::ceil(6.0 * course.length() / wheelbase)));
  LineOptions options;
  options.margin = std::max(0.0, margin - 0.4 * car.width);
  options.max_curvature = drivable_curvature(car);
  try {
    course.minimum_curvature(options, samples);
  } catch (const std::exception& error) {
    if (!(options.margin > 0.0)) throw;
    throw std::runtime_error(error.what() + in_widths(margin, car));
  }
  return ClosedLine(std::move(samples));
}

DriveCurves tabulate(const DriveLimits& limits, double brakes) {
  constexpr int count = 41;
  const auto table = [&](auto&& f) {
    std::vector<double> values(count);
    for (int i = 0; i < count; ++i) values[static_cast<std::size_t>(i)] = f(limits.top_speed() * i / (count - 1));
    return CubicSpline(0.0, limits.top_speed(), values);
  };
  return {table([&](double v) { return limits.coast(v); }), table([&](double v) { return limits.drive(v); }),
          table([&](double v) { return brakes * limits.brake(v); })};
}

/// How the nominal model's axle loads follow drive and brakes.
AxleSharing with_loads(AxleSharing sharing, const PluginContext& context) {
  State x;
  x.vx = context.car.v_ref;
  Prediction& nominal = nominal_of(context);
  const auto driven = nominal.rates(x, {context.car.d_max, 0.0}, Place{});
  const auto braked = nominal.rates(x, {context.car.d_min, 0.0}, Place{});
  const double a = (driven.drive_force - braked.drive_force) / context.car.m;
  if (!(a > 0.0)) return sharing;
  sharing.load_front = (driven.load_front - braked.load_front) / a;
  sharing.load_rear = (driven.load_rear - braked.load_rear) / a;
  return sharing;
}

/// Nodes of a lap [m] at the spacing asked for [m], or, where that is 0, at the usual one as far as their number
/// allows.
std::size_t node_count(double lap, double asked, double usual) {
  constexpr double fewest = 20, most = 4000;
  if (asked > 0 && (std::ceil(lap / asked) < fewest || std::ceil(lap / asked) > most)) {
    std::ostringstream text;
    text << "\"spacing\" of " << asked << " m does not suit a lap of " << lap << " m; expected " << lap / most << " to "
         << lap / fewest << " m (" << most << " to " << fewest << " nodes), or 0 for the wheelbase";
    throw std::invalid_argument(text.str());
  }
  return static_cast<std::size_t>(std::clamp(std::ceil(lap / (asked > 0 ? asked : usual)), fewest, most));
}

}  // namespace

LapSetup::LapSetup(const PluginContext& context, const SetupOptions& options, const CarBelief& typical)
    : car_(context.car),
      options_(options),
      typical_(typical),
      limits_(nominal_of(context), context.car, typical.resistance.rolling, typical.resistance.drag),
      base_(compute_base(context, options.margin)),
      corner_(context.car, typical.tyres, limits_.top_speed()),
      curves_(tabulate(limits_, options.brakes)) {
  options_.use.sharing = with_loads(options.use.sharing, context);
  nodes_ = place_nodes(base_, profile(typical.tyres), *context.course, options.margin,
                       node_count(base_.length(), options.spacing, car_.lf + car_.lr));
  const std::vector<double>& s = nodes_.s;
  for (const double station : s) base_at_nodes_.push_back(base_.at(station));
  for (std::size_t i = 0; i < s.size(); ++i) {
    const double from = base_.length() * static_cast<double>(i) / static_cast<double>(s.size());
    first_node_.push_back(static_cast<std::size_t>(std::upper_bound(s.begin(), s.end(), from) - s.begin()) - 1);
  }
}

std::size_t LapSetup::node_at(double station) const {
  const double s = wrap_periodic(station, base_.length());
  const double part = s / base_.length() * static_cast<double>(first_node_.size());
  std::size_t k = first_node_[std::min(static_cast<std::size_t>(part), first_node_.size() - 1)];
  while (k + 1 < nodes_.s.size() && nodes_.s[k + 1] <= s) ++k;
  return k;
}

/// The tables of the typical tyres serve all that differ from them in friction only.
std::vector<double> LapSetup::profile(const AxleTyres& tyres) const {
  const AxleTyres& typical = typical_.tyres;
  const auto same_shape = [](const MagicFormula& a, const MagicFormula& b) { return a.B == b.B && a.C == b.C; };
  const double share = tyres.front.D / typical.front.D;  // of their friction
  if (same_shape(tyres.front, typical.front) && same_shape(tyres.rear, typical.rear) &&
      std::abs(tyres.rear.D - share * typical.rear.D) < 1e-9 * tyres.rear.D)
    return speed_profile(base_, limits_, corner_, share, 0.0);
  return speed_profile(base_, limits_, CornerLimits(car_, tyres, limits_.top_speed()), 1.0, 0.0);
}

LapProblem LapSetup::problem(const CarBelief& belief) const {
  DriveCurves curves = curves_;
  const std::span<const double> coast = curves_.coast.values();
  std::vector<double> learned(coast.begin(), coast.end());
  for (std::size_t i = 0; i < learned.size(); ++i) {
    const double v = limits_.top_speed() * static_cast<double>(i) / static_cast<double>(learned.size() - 1);
    learned[i] -= belief.resistance.at(v) - typical_.resistance.at(v);
  }
  curves.coast = CubicSpline(0.0, limits_.top_speed(), learned);
  return {.car = car_,
          .tyres = belief.tyres,
          .drive = curves,
          .top_speed = limits_.top_speed(),
          .use = options_.use,
          .places = nodes_.places,
          .ds = nodes_.ds,
          .n_lo = nodes_.n_lo,
          .n_hi = nodes_.n_hi,
          .mid_lo = nodes_.mid_lo,
          .mid_hi = nodes_.mid_hi};
}

LapSolution LapSetup::cold_guess(const AxleTyres& tyres) const {
  const std::vector<double> v = profile(tyres);
  LapSolution guess;
  for (const double s : nodes_.s) {
    const Bracket b = base_.bracket(s);
    const double speed = 0.95 * (v[b.first] + (v[b.second] - v[b.first]) * b.weight);
    const double kappa = base_.at(s).kappa, side = kappa < 0 ? -1.0 : 1.0;
    const double a = std::min(speed * speed * std::abs(kappa), 0.9 * lateral_limit(tyres, car_));
    SteadyTurn turn = steady_turn(car_, tyres, std::abs(kappa), a);
    if (!std::isfinite(turn.steering)) turn = {};
    const double delta = std::min(turn.steering, 0.98 * car_.delta_max);
    guess.z.push_back({0.0, -side * turn.beta, speed * std::cos(turn.beta), side * speed * std::sin(turn.beta),
                       speed * kappa, side * delta, 0.0, 0.0});
  }
  return guess;
}

std::vector<double> LapSetup::fingerprint() const {
  const Car& c = car_;
  std::vector<double> all{c.m,
                          c.Iz,
                          c.lf,
                          c.lr,
                          c.length,
                          c.width,
                          c.d_min,
                          c.d_max,
                          c.delta_max,
                          c.ddelta_max,
                          limits_.top_speed(),
                          options_.margin,
                          options_.use.combined,
                          options_.use.slip_bound};
  const auto add = [&](std::span<const double> values) { all.insert(all.end(), values.begin(), values.end()); };
  for (const CubicSpline* curve : {&curves_.coast, &curves_.drive, &curves_.brake}) add(curve->values());
  add(nodes_.s);
  add(nodes_.n_lo);
  add(nodes_.n_hi);
  add(nodes_.mid_lo);
  add(nodes_.mid_hi);
  for (const LapPlace& p : nodes_.places) add(std::array{p.kappa, p.grade, p.bank, p.curve});
  return all;
}

}  // namespace gripline::time_optimal
