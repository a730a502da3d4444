#include "limit/plant_envelope.hpp"

#include <functional>
#include <initializer_list>
#include <numbers>
#include <optional>
#include <stdexcept>

namespace gripline {
namespace {

constexpr std::size_t grid = 24;     // speeds of a curve
constexpr double slowest = 0.25;     // of v_ref, where curves begin
constexpr double longest_run = 300;  // [s]
constexpr double averaged = 0.1;     // [s] over which accelerations are averaged
constexpr double turn_time = 1.5,
                 peak_slip = 0.12;       // a turn tightens to gravity across, and this slip [rad], in this time
constexpr double most_lost = 0.1;        // of the speed, by rolling while a turn tightens
constexpr double weakest_brakes = 0.01;  // of what tyres hold across: less is no braking

/// A plane of one friction factor.
class Plane final : public Ground {
 public:
  explicit Plane(double factor) : factor_(factor) {}
  Patch at(double, double, double) const override { return {0.0, 0.0, factor_}; }

 private:
  double factor_;
};

struct Moment {
  double t = 0, v = 0;                        // [s], [m/s]
  double along = 0, across = 0, turning = 0;  // v', v course', v yaw rate [m/s2]
  double delta = 0, sideslip = 0;             // [rad]
};
using Drive = std::vector<Moment>;

/// What the driver of a test run does: share of throttle or brakes, and steering angle [rad].
struct DriverInput {
  double d = 0, delta = 0;
};

class Dynamometer {
 public:
  Dynamometer(Plant& plant, const Car& car, double dt, double factor)
      : plant_(plant), car_(car), dt_(dt > 0 ? dt : 0.02), ground_(factor) {}

  /// From a speed straight on, until `ended` says so: every step.
  Drive steps(double v, const std::function<DriverInput(double)>& input,
              const std::function<bool(const Drive&)>& ended) {
    State x;
    x.vx = v;
    plant_.reset(x, ground_);
    Drive out;
    double course = 0;
    for (double t = 0; t < longest_run;) {
      const DriverInput u = input(t);
      x = plant_.advance(u.d, u.delta, dt_, ground_);
      t += dt_;
      Moment now{t, std::hypot(x.vx, x.vy), 0, 0, 0, u.delta, std::atan2(x.vy, x.vx)};
      if (!std::isfinite(now.v)) throw std::runtime_error("the plant's speed is not a number");
      const double turned = std::remainder(x.yaw + now.sideslip - course, 2.0 * std::numbers::pi);
      const double before = out.empty() ? v : out.back().v;
      course = x.yaw + now.sideslip;
      now.along = (now.v - before) / dt_;
      now.across = now.v * turned / dt_;
      now.turning = now.v * x.omega;
      out.push_back(now);
      if (ended(out)) break;
    }
    return out;
  }
  /// The same with accelerations averaged: begins later and ends earlier than the steps, by half of what is averaged.
  Drive drive(double v, const std::function<DriverInput(double)>& input,
              const std::function<bool(const Drive&)>& ended) {
    return averages(steps(v, input, ended));
  }
  const Car& car() const { return car_; }
  double dt() const { return dt_; }

 private:
  Drive averages(const Drive& raw) const {
    const auto window = static_cast<std::size_t>(std::max(1.0, std::round(averaged / dt_)));
    Drive out;
    for (std::size_t i = window; i <= raw.size(); ++i) {
      Moment mean = raw[i - 1 - window / 2];
      mean.along = mean.across = mean.turning = 0;
      for (std::size_t k = i - window; k < i; ++k) {
        mean.along += raw[k].along / static_cast<double>(window);
        mean.across += raw[k].across / static_cast<double>(window);
        mean.turning += raw[k].turning / static_cast<double>(window);
      }
      out.push_back(mean);
    }
    return out;
  }

  Plant& plant_;
  Car car_;
  double dt_;
  Plane ground_;
};

/// Mean acceleration while the speed goes from one value to another: changes of gear included. Empty where it does not.
std::optional<double> between(const Drive& drive, double from, double to) {
  const double sign = to > from ? 1.0 : -1.0;
  const auto crossing = [&](double v) -> std::optional<double> {
    for (std::size_t i = 1; i < drive.size(); ++i) {
      const Moment &a = drive[i - 1], &b = drive[i];
      if (sign * (a.v - v) < 0 && sign * (b.v - v) >= 0) return a.t + (b.t - a.t) * (v - a.v) / (b.v - a.v);
    }
    return std::nullopt;
  };
  const auto begin = crossing(from), end = crossing(to);
  if (!begin || !end || *end <= *begin) return std::nullopt;
  return (to - from) / (*end - *begin);
}

SpeedCurve empty_curve(const Car& car, double top) {
  const double v0 = slowest * car.v_ref;
  return {v0, (top - v0) / static_cast<double>(grid - 1), std::vector<double>(grid, 0.0)};
}

/// Half of the speeds over which a curve's value at one is taken: no further than a drive reached below it.
double half_around(const SpeedCurve& curve, double v, double reached) {
  return std::min(0.5 * curve.dv, 0.99 * (v - reached));
}

double speed_of(const SpeedCurve& curve, std::size_t i) { return curve.v0 + static_cast<double>(i) * curve.dv; }

/// Full throttle until the speed rises no more.
Drive full_throttle(Dynamometer& dyno) {
  const auto steps = static_cast<std::size_t>(std::ceil(2.0 / dyno.dt()));
  const auto ended = [&](const Drive& d) {
    return d.size() > 2 * steps && d.back().v - d[d.size() - 1 - steps].v < 1e-3 * d.back().v;
  };
  const double start = 0.5 * slowest * dyno.car().v_ref;
  return dyno.steps(
      start,
      [&](double) {
        return DriverInput{dyno.car().d_max, 0};
      },
      ended);
}

/// Acceleration of the car that rolls at a speed, by its second half second, when lags have settled.
double rolling_at(Dynamometer& dyno, double v) {
  double start = v, along = 0;
  for (int i = 0; i < 2; ++i) {
    const Drive rolls = dyno.drive(
        start, [](double) { return DriverInput{}; }, [](const Drive& d) { return d.back().t > 1.0; });
    const std::size_t half = rolls.size() / 2;
    const auto count = static_cast<double>(rolls.size() - half);
    double speed = along = 0;
    for (std::size_t k = half; k < rolls.size(); ++k) {
      along += rolls[k].along / count;
      speed += rolls[k].v / count;
    }
    start += v - speed;  // so that it has this speed then
  }
  return along;
}

/// What full throttle gives, and rolling.
void set_throttle(Dynamometer& dyno, PlantEnvelope& e) {
  const Car& car = dyno.car();
  const Drive drive = full_throttle(dyno);
  e.top = drive.empty() ? 0.0 : drive.back().v;
  if (!(e.top > 2.0 * slowest * car.v_ref)) throw std::runtime_error("the plant does not gain speed at full throttle");
  e.throttle = e.rolling = e.brakes = empty_curve(car, e.top);
  double gain = 0;
  for (std::size_t i = grid; i-- > 0;) {
    const double v = speed_of(e.throttle, i);
    e.rolling.control[i] = rolling_at(dyno, v);
    const double half = half_around(e.throttle, v, drive.front().v);
    if (half > 0)  // else it began faster, and gains what it then gained
      gain = between(drive, v - half, std::min(v + half, 0.999 * e.top)).value_or(0.0);
    e.throttle.control[i] = std::max(0.0, gain - e.rolling.control[i]);
  }
}

/// What full brakes lose, or weaker ones where that is more: wheels that lock may hold less.
void set_brakes(Dynamometer& dyno, PlantEnvelope& e) {
  const double least = 0.5 * e.brakes.v0;
  for (const double share : {1.0, 0.85, 0.7, 0.55, 0.4}) {
    const double d = share * dyno.car().d_min;
    const Drive stop = dyno.steps(
        1.1 * e.top + 2.0 * e.brakes.dv,
        [&](double) {
          return DriverInput{d, 0};
        },
        [&](const Drive& run) { return run.back().v < least; });
    for (std::size_t i = 0; i < grid; ++i) {
      const double v = speed_of(e.brakes, i);
      const double half = half_around(e.brakes, v, stop.back().v);
      if (half <= 0) continue;  // it did not come to be so slow
      const double loss = -between(stop, v + half, v - half).value_or(0.0) + e.rolling.control[i];
      e.brakes.control[i] = std::max(e.brakes.control[i], loss);
    }
  }
}

/// The most that a turn held: at which speed, across, and along.
struct Turn {
  double share = 0;  // of throttle or brakes
  double v = 0, across = 0, along = 0;
  double bend = 0;  // of its looser part
};

double held(const Moment& x) { return std::min(x.across, x.turning); }

/// Whether a turn ended before the tyres gave their most: at full lock, or while the force still rose.
bool unfinished(const Drive& drive, Drive::const_iterator most, double delta_max) {
  const auto left = static_cast<std::size_t>(drive.end() - most);
  const Moment& late = drive[drive.size() - std::max<std::size_t>(1, drive.size() / 5)];
  return most->delta > 0.95 * delta_max || (left < drive.size() / 10 && held(*most) > 1.02 * held(late));
}

/// Whether the path's curvature still rose as the steering did: then the speed fell, and tyres held less for that.
bool follows(const Drive& drive, Drive::const_iterator most) {
  const Moment& before = drive[static_cast<std::size_t>(most - drive.begin()) * 4 / 5];
  const auto curvature = [](const Moment& x) { return x.across / (x.v * x.v); };
  return 1.0 - curvature(before) / curvature(*most) > 0.8 * (1.0 - before.delta / most->delta);
}

/// Whether a car that rolls loses much of its speed in the time of a turn, as small ones do.
bool soon_slow(const SpeedCurve& rolling, double top) {
  const double v = std::sqrt(rolling.v0 * top);
  return -rolling.at(v) * turn_time > most_lost * v;
}

/// Drives a turn that tightens, from a speed at a constant throttle or brake: to gravity across in this time, and on to
/// more than twice of it, until the car is slow or slides.
Drive tightening_turn(Dynamometer& dyno, double v, double d, double time) {
  const Car& car = dyno.car();
  const double wheelbase = car.lf + car.lr;
  const double rate = std::min(car.ddelta_max, (wheelbase * gravity / (v * v) + peak_slip) / time);
  const auto input = [&](double t) { return DriverInput{d, std::min(rate * t, car.delta_max)}; };
  const auto ended = [&](const Drive& drive) {
    const Moment& now = drive.back();
    return now.t > 2.5 * time || now.v < 0.2 * v || std::abs(now.sideslip) > 0.5;
  };
  return dyno.drive(v, input, ended);
}

/// Whether the tyres gave their most in a turn, at this moment of it.
bool tyres_gave_most(const Drive& drive, Drive::const_iterator most, const Car& car, bool brisk) {
  // Less than half of what was steered for came of it.
  if (brisk && held(*most) < 0.5 * most->v * most->v * most->delta / (car.lf + car.lr)) return true;
  return !unfinished(drive, most, car.delta_max) && !(brisk && follows(drive, most));
}

/// What turning costs beside rolling, over the square of the acceleration across [s2/m]: the sums of both over the
/// looser part of a turn up to a moment at which it held this much across.
double bend_before(const Drive& drive, Drive::const_iterator most, double across, const SpeedCurve& rolling) {
  double bend = 0, weight = 0;
  for (auto x = drive.begin(); x != most; ++x) {
    if (x->across < 0.3 * across || x->across > 0.85 * across) continue;
    bend += rolling.at(x->v) - x->along;
    weight += x->across * x->across;
  }
  return weight > 0 ? std::max(0.0, bend / weight) : 0.0;
}

/// The most that a turn holds which tightens from a speed at a constant share of throttle or brakes; empty where the
/// steering ends before the tyres do. `brisk`: in less time, so that the speed is not lost.
std::optional<Turn> tightest(Dynamometer& dyno, double v, double share, const SpeedCurve& rolling, bool brisk) {
  const Car& car = dyno.car();
  const double d = share > 0 ? share * car.d_max : -share * car.d_min;
  const double loss = std::max(-rolling.at(v), 1e-9);
  const double time = brisk ? std::min(turn_time, most_lost * v / loss) : turn_time;
  const Drive drive = tightening_turn(dyno, v, d, time);
  const auto most =
      std::max_element(drive.begin(), drive.end(), [](const Moment& a, const Moment& b) { return held(a) < held(b); });
  if (most == drive.end() || held(*most) <= 0 || !tyres_gave_most(drive, most, car, brisk)) return std::nullopt;
  return Turn{share, most->v, held(*most), most->along, bend_before(drive, most, held(*most), rolling)};
}

/// Least squares over v^2, neither part below zero.
TyreHold fitted(const std::vector<std::pair<double, double>>& points) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const auto& [v, a] : points) {
    const double q = v * v;
    n += 1, x += q, y += a, xx += q * q, xy += q * a;
  }
  const double slope = std::max(0.0, (n * xy - x * y) / std::max(n * xx - x * x, 1e-12));
  const double weight = (y - slope * x) / n;
  return weight >= 0 ? TyreHold{weight, slope} : TyreHold{0.0, xy / xx};
}

double middle(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// Turns at these shares of throttle and brakes, from so many speeds over the whole range.
std::vector<Turn> turns_at(Dynamometer& dyno, const PlantEnvelope& e, std::initializer_list<double> shares,
                           int speeds = 8) {
  const bool brisk = soon_slow(e.rolling, e.top);
  std::vector<Turn> turns;
  for (const double share : shares)
    for (int i = 0; i < speeds; ++i) {
      const double v = e.throttle.v0 * std::pow(e.top / e.throttle.v0, (i + 0.5) / speeds);
      if (const auto turn = tightest(dyno, v, share, e.rolling, brisk)) turns.push_back(*turn);
    }
  return turns;
}

void set_side(Dynamometer& dyno, PlantEnvelope& e) {
  constexpr std::size_t fewest = 3;
  std::vector<Turn> rolling = turns_at(dyno, e, {0.0});
  // Steering may reach what tyres hold near top speed only.
  if (rolling.size() < fewest) rolling = turns_at(dyno, e, {0.0}, 32);
  std::vector<std::pair<double, double>> side;
  std::vector<double> bends;
  for (const Turn& turn : rolling) {
    side.emplace_back(turn.v, turn.across);
    bends.push_back(turn.bend);
  }
  if (side.size() < fewest) throw std::runtime_error("the plant's tyres hold more than its steering can ask of them");
  e.side = fitted(side);
  e.bend = middle(bends);
}

/// Squares of how far turns on the brakes lie from a boundary of exponent p.
double shape_error(const PlantEnvelope& e, const std::vector<Turn>& turns, double p) {
  double error = 0;
  for (const Turn& turn : turns) {
    const double x = e.rolling.at(turn.v) - e.bend * turn.across * turn.across - turn.along;
    const double used =
        std::pow(turn.across / e.side.at(turn.v, 1.0), p) + std::pow(std::max(0.0, x) / e.brake.at(turn.v, 1.0), p);
    error += std::pow(std::pow(used, 1.0 / p) - 1.0, 2);
  }
  return error;
}

/// The exponent with which turns on the brakes lie nearest to the boundary; a circle's where too few say anything.
double fitted_shape(const PlantEnvelope& e, const std::vector<Turn>& turns) {
  constexpr std::size_t fewest = 3;
  double best = 2, least = INFINITY;
  if (turns.size() < fewest) return best;
  double p = 1.2;
  while (p < 4.0) {
    const double error = shape_error(e, turns, p);
    if (error < least) least = error, best = p;
    p += 0.02;
  }
  return best;
}

/// Mean over the lower half of the speeds of a curve over what the sides of the tyres hold.
double over_side(const PlantEnvelope& e, const SpeedCurve& curve) {
  constexpr std::size_t lower = grid / 2;
  double sum = 0;
  for (std::size_t i = 0; i < lower; ++i) sum += curve.control[i] / e.side.at(speed_of(curve, i), 1.0);
  return sum / static_cast<double>(lower);
}

PlantEnvelope straights_and_side(Dynamometer& dyno) {
  PlantEnvelope e;
  set_throttle(dyno, e);
  set_brakes(dyno, e);
  set_side(dyno, e);
  // Not at every speed: a motor that brakes may give nothing near top speed.
  if (!(over_side(e, e.brakes) > weakest_brakes)) throw std::runtime_error("the plant does not stop when it brakes");
  return e;
}

/// Brakes may be too weak for the tyres: what these hold along is measured where the road is so slippery that brakes
/// lose with the friction what the sides lose. `e` was measured at `factor`. A plant that cannot be driven on a road so
/// slippery is taken by the last one on which it could: then its tyres hold along what its brakes gave there.
PlantEnvelope slippery(Plant& plant, const Car& car, double dt, double factor, PlantEnvelope e) {
  constexpr double finer = 0.6;
  for (int i = 0; i < 6; ++i) {
    Dynamometer dyno(plant, car, dt, finer * factor);
    PlantEnvelope next;
    try {
      next = straights_and_side(dyno);
    } catch (const std::exception&) {
      break;
    }
    const bool limited = over_side(next, next.brakes) < 1.1 * over_side(e, e.brakes);
    e = next;
    factor *= finer;
    if (limited) break;
  }
  const double brake = over_side(e, e.brakes);
  e.brake = {brake * e.side.weight, brake * e.side.downforce};
  Dynamometer dyno(plant, car, dt, factor);
  std::vector<Turn> turns;
  try {
    turns = turns_at(dyno, e, {-0.05, -0.1, -0.15, -0.2, -0.3, -0.4, -0.5, -0.7});
  } catch (const std::exception&) {  // none: a circle
  }
  e.shape = fitted_shape(e, turns);
  return e;
}

}  // namespace

PlantEnvelope measure_envelope(Plant& plant, const Car& car, double dt, double factor) {
  Dynamometer dyno(plant, car, dt, factor);
  PlantEnvelope e = straights_and_side(dyno);
  const PlantEnvelope wet = slippery(plant, car, dt, factor, e);
  const double brake = over_side(wet, wet.brakes);
  // Wheels that are driven may carry less: as far as full throttle shows it, fast or slow.
  double drive = 0;
  for (const PlantEnvelope* one : std::initializer_list<const PlantEnvelope*>{&e, &wet})
    for (std::size_t i = 0; i < grid; ++i)
      drive = std::max(drive, one->throttle.control[i] / one->side.at(speed_of(one->throttle, i), 1.0));
  e.shape = wet.shape;
  e.brake = {brake * e.side.weight, brake * e.side.downforce};
  e.drive = {drive * e.side.weight, drive * e.side.downforce};
  return e;
}

}  // namespace gripline
