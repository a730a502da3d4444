// Parameters that the two planners of this folder share, with units, ranges and what they say.
#pragma once

#include <gripline/plugin.hpp>
#include <tuple>

namespace gripline::time_optimal {

/// What both planners have; the laps are solved in a library, or a window ahead of the car.
struct LapParams {
  double margin = 0.4, tighten = 0.0, tighten_sigma = 0.5;
  double factor = 0.97, sigma = 1.0, start = 0.6, rise = 0.1, pace = 1.0, pace_fall = 0.0;
  double pace_kept = 1.0, pace_friction = 1.0, pace_spread = 0.3;
  double mu_lo = 0.35, mu_hi = 1.15;
  double front_B = 4.0, front_C = 1.3, rear_B = 4.0, rear_C = 1.3, balance = 1.0;
  double slip_bound = 0.7, combined = 0.0, spacing = 0.0, rolling = 0.0, drag = 0.0, brakes = 1.0;
  bool replan = true, from_car_speed = true;
};

template <class P>
constexpr auto lap_parameters() {
  const auto number = [](const char* name, double LapParams::*member, const char* unit, Range range, const char* what) {
    return param(name, static_cast<double P::*>(member), unit, range, what);
  };
  return std::tuple{
      number("margin", &P::margin, "1", {0, 10},
             "widths of the car kept by the planned line from both edges (fixed_speed: metres)"),
      number("tighten", &P::tighten, "1", {0, 10},
             "widths of the car taken from the room stated to the controller (its own tighten: metres)"),
      number("tighten_sigma", &P::tighten_sigma, "1", {0, 100},
             "widths of the car taken from that room for each relative standard deviation of the friction"),
      number("factor", &P::factor, "1", {0.1, 1.5}, "planned over estimated friction"),
      number("sigma", &P::sigma, "1", {0, 10},
             "standard deviations that the planned friction stays below the estimate"),
      number("start", &P::start, "1", {0.05, 2}, "planned friction over mu_init until the estimate is trusted"),
      number("rise", &P::rise, "1/s", {0, 100}, "fastest rise of the friction that is planned for or driven"),
      number("pace", &P::pace, "1", {0.05, 2}, "factor on planned speeds"),
      number("pace_fall", &P::pace_fall, "s/m", {0, 0.1}, "by which that factor falls per m/s of the planned speed"),
      number("pace_kept", &P::pace_kept, "1", {0, 1},
             "share of what pace keeps back that is kept at every friction; the rest shrinks with how far friction can "
             "fall at once; 1: none does"),
      number("pace_friction", &P::pace_friction, "1", {0.05, 5}, "friction to which it changes at once: mean"),
      number("pace_spread", &P::pace_spread, "1", {1e-3, 5},
             "friction to which it changes at once: standard deviation"),
      number("mu_lo", &P::mu_lo, "1", {0.05, 5},
             "least friction that is expected; at less, laps for it are driven more slowly"),
      number("mu_hi", &P::mu_hi, "1", {0.05, 5}, "largest friction that is expected"),
      number("front_B", &P::front_B, "1/rad", {0.1, 1e3}, "stiffness factor of the generic front tyre"),
      number("front_C", &P::front_C, "1", {1, 3}, "shape factor of the generic front tyre"),
      number("rear_B", &P::rear_B, "1/rad", {0.1, 1e3}, "stiffness factor of the generic rear tyre"),
      number("rear_C", &P::rear_C, "1", {1, 3}, "shape factor of the generic rear tyre"),
      number("balance", &P::balance, "1", {0.3, 3}, "friction of the generic front over the rear axle"),
      number("slip_max", &P::slip_bound, "rad", {0.05, 1.4}, "largest slip that is planned"),
      number("combined", &P::combined, "1", {0, 1}, "share of drive and brake forces in the friction circle"),
      number("brakes", &P::brakes, "1", {0.05, 1}, "share of the brakes that is planned with"),
      number("spacing", &P::spacing, "m", {0, 100},
             "of the program's nodes, 20 to 4000 in a lap; 0: the wheelbase, as far as their number allows"),
      number("rolling", &P::rolling, "m/s2", {0, 100}, "rolling resistance over mass that the nominal model lacks"),
      number("drag", &P::drag, "1/m", {0, 10}, "drag over mass and squared speed that the nominal model lacks"),
      param("replan", static_cast<bool P::*>(&P::replan), "1", {0, 1}, "solve again for the learned tyres"),
      param("from_car_speed", static_cast<bool P::*>(&P::from_car_speed), "1", {0, 1},
            "references gain speed only as fast as the car can; false: they drive the plan at once")};
}

}  // namespace gripline::time_optimal
