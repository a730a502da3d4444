// Parameters of the full-size car, with where each number comes from.
//
// "Published" is the car the authors of the adaptive-ELM paper describe to their stack for the simulator's Audi TT
// (APACRace, carla_params.py). Its tyres, with a peak of 2.58 times the weight, are not used. "Data sheet" is Audi's
// for the second-generation TT coupe. The books: Pacejka, Tyre and Vehicle Dynamics; Milliken and Milliken, Race Car
// Vehicle Dynamics; Gillespie, Fundamentals of Vehicle Dynamics; Mitschke and Wallentowitz, Dynamik der Kraftfahrzeuge.
#pragma once

#include <array>
#include <tuple>

#include <gripline/plugin.hpp>

namespace gripline::double_track {

struct Params {
  // body
  double m = 1265, Iz = 2093, lf = 1.34, lr = 1.30, h = 0.46, track_front = 1.572, track_rear = 1.558;
  double roll_centre_front = 0.06, roll_centre_rear = 0.10, roll_front = 0.52, load_lag = 0.08;
  // air and rolling
  double drag = 0.5, downforce_front = 0.10, downforce_rear = 0.18, rolling = 0.00403;
  // wheels and tyres
  double radius = 0.34, wheel_inertia = 1.5;
  double mu_y = 1.05, mu_x = 1.15, load_sensitivity = 0.06;
  double stiffness_front = 17.0, stiffness_rear = 19.5, stiffness_load = 2.75, stiffness_x = 25.0;
  double C_y = 1.5, E_y = -0.5, C_x = 1.65, E_x = 0.3;
  double relaxation_x = 0.25, relaxation_y = 0.50, contact_damping = 2000;
  // engine, brakes, steering
  double drive_front = 0.4, final_drive = 3.45, engine_lag = 0.06, shift_time = 0.15;
  double brake_torque = 2800, brake_bias = 0.62, brake_lag = 0.04;
  bool slip_control = true;
  double slip_start = 0.07, slip_end = 0.15;
  double steer_lag = 0.04, steer_rate = 1.2, ackermann = 0.6;
  double step = 0.0005;
  Table engine_torque, gears;
};

/// Engine of the car when the world gives none: [rad/s, N m at full throttle, N m of drag at closed throttle].
inline constexpr std::array<double, 27> default_engine{84,  230, 25,  // idle
                                                       157, 430, 28,  //
                                                       209, 550, 31,  // the published peak
                                                       471, 550, 46,  // then 259 kW
                                                       550, 471, 52,  //
                                                       620, 418, 57,  //
                                                       680, 381, 62,  //
                                                       720, 330, 66,  //
                                                       740, 260, 68};
/// Gears when the world gives none: [gear, ratio, from m/s, to m/s].
inline constexpr std::array<double, 24> default_gears{1, 2.75,  0,   9,   //
                                                      2, 1.80,  7.5, 14,  //
                                                      3, 1.25,  12,  30,  //
                                                      4, 0.919, 26,  48,  // the published gear
                                                      5, 0.72,  44,  70,  //
                                                      6, 0.60,  65,  200};

inline constexpr auto declare_body() {
  using P = Params;
  return std::tuple{
      param("m", &P::m, "kg", {100, 1e5}, "mass (published)"),
      param("Iz", &P::Iz, "kg m2", {10, 1e6}, "yaw inertia (published)"),
      param("lf", &P::lf, "m", {0.1, 10}, "centre of gravity to front axle (published)"),
      param("lr", &P::lr, "m", {0.1, 10}, "centre of gravity to rear axle (published)"),
      param("h", &P::h, "m", {0, 3}, "height of the centre of gravity (Mitschke: about a third of a coupe's 1.35 m)"),
      param("track_front", &P::track_front, "m", {0.1, 5}, "distance of the front wheels (data sheet)"),
      param("track_rear", &P::track_rear, "m", {0.1, 5}, "distance of the rear wheels (data sheet)"),
      param("roll_centre_front", &P::roll_centre_front, "m", {0, 1}, "roll centre's height, strut axle (Milliken 17)"),
      param("roll_centre_rear", &P::roll_centre_rear, "m", {0, 1}, "roll centre's height, multi-link (Milliken 17)"),
      param("roll_front", &P::roll_front, "1", {0, 1}, "front share of the roll stiffness (Milliken 18)"),
      param("load_lag", &P::load_lag, "s", {0.001, 1},
            "lag of load transfer: roll near 2 Hz, well damped (Gillespie 6)"),
      param("drag", &P::drag, "N s2/m2", {0, 100}, "drag over speed squared (published)"),
      param("downforce_front", &P::downforce_front, "N s2/m2", {-10, 100},
            "front downforce over speed squared; cl A = 0.17 m2, a road car with spoilers (Milliken 15)"),
      param("downforce_rear", &P::downforce_rear, "N s2/m2", {-10, 100},
            "rear downforce over speed squared; cl A = 0.30 m2 (Milliken 15)"),
      param("rolling", &P::rolling, "1", {0, 0.2}, "rolling resistance over load (published: 50 N)")};
}

inline constexpr auto declare_tyres() {
  using P = Params;
  return std::tuple{
      param("radius", &P::radius, "m", {0.01, 2}, "rolling radius (published)"),
      param("wheel_inertia", &P::wheel_inertia, "kg m2", {1e-3, 100},
            "spin inertia of a wheel with brake disc and its share of the shafts (Gillespie 2)"),
      param("mu_y", &P::mu_y, "1", {0.05, 5}, "peak lateral force over load at static load (sport tyre, Milliken 2)"),
      param("mu_x", &P::mu_x, "1", {0.05, 5}, "peak longitudinal force over load at static load (Pacejka app. 3)"),
      param("load_sensitivity", &P::load_sensitivity, "1", {0, 1},
            "loss of mu when the load doubles (Pacejka app. 3: 0.03 along, 0.15 across)"),
      param("stiffness_front", &P::stiffness_front, "1/rad", {1, 100},
            "front cornering stiffness over static load (Pacejka app. 3: 11.5; low sport tyres to 20)"),
      param("stiffness_rear", &P::stiffness_rear, "1/rad", {1, 100},
            "rear cornering stiffness over static load; the difference is 0.4 deg/g of understeer (Milliken 5)"),
      param("stiffness_load", &P::stiffness_load, "1", {0.5, 100},
            "load of the largest cornering stiffness over static load (Pacejka app. 3: 2.13 times 4000 N)"),
      param("stiffness_x", &P::stiffness_x, "1", {1, 200}, "slip stiffness over load (Pacejka app. 3: 21.5)"),
      param("C_y", &P::C_y, "1", {1.01, 1.99}, "lateral shape factor (Pacejka 4.3: 1.2 to 1.6)"),
      param("E_y", &P::E_y, "1", {-10, 0.9}, "lateral curvature factor (Pacejka app. 3: -1.0)"),
      param("C_x", &P::C_x, "1", {1.01, 1.99}, "longitudinal shape factor (Pacejka app. 3: 1.69)"),
      param("E_x", &P::E_x, "1", {-10, 0.9}, "longitudinal curvature factor (Pacejka app. 3: 0.34)"),
      param("relaxation_x", &P::relaxation_x, "m", {0.01, 5}, "longitudinal relaxation length (Pacejka 5.4)"),
      param("relaxation_y", &P::relaxation_y, "m", {0.01, 5}, "lateral relaxation length (Pacejka 5.4)"),
      param("contact_damping", &P::contact_damping, "N s/m", {0, 1e5},
            "damping of a standing tyre, about half critical for the wheel (Pacejka 8.6)")};
}

inline constexpr auto declare_drive() {
  using P = Params;
  return std::tuple{
      param("drive_front", &P::drive_front, "1", {0, 1}, "front share of the engine's torque (data sheet: quattro)"),
      param("final_drive", &P::final_drive, "1", {0.1, 20}, "ratio behind the gearbox (published)"),
      param("engine_lag", &P::engine_lag, "s", {0.001, 2}, "lag of the engine's torque (Mitschke)"),
      param("shift_time", &P::shift_time, "s", {0, 2}, "duration of a change of gear (data sheet: double clutch)"),
      param("brake_torque", &P::brake_torque, "N m", {0, 1e5}, "torque of all brakes at d = -1 (published)"),
      param("brake_bias", &P::brake_bias, "1", {0, 1}, "front share of the brake torque (Gillespie 3)"),
      param("brake_lag", &P::brake_lag, "s", {0.001, 2}, "lag of the brakes (Gillespie 3)"),
      param("slip_control", &P::slip_control, "1", {0, 1}, "whether anti-lock brakes and traction control work"),
      param("slip_start", &P::slip_start, "1", {0.01, 1}, "slip where slip control begins to take torque away"),
      param("slip_end", &P::slip_end, "1", {0.02, 2}, "slip where slip control has taken all torque away"),
      param("steer_lag", &P::steer_lag, "s", {0.001, 1}, "lag of the steering actuator (Mitschke)"),
      param("steer_rate", &P::steer_rate, "rad/s", {0.01, 100},
            "largest rate of the road wheels (1100 deg/s at the steering wheel over a ratio of 16)"),
      param("ackermann", &P::ackermann, "1", {0, 1}, "0: front wheels parallel, 1: Ackermann's angles (Milliken 19)"),
      param("step", &P::step, "s", {1e-5, 1e-3}, "integration step, at most; a control step holds a whole number"),
      param("engine_torque", &P::engine_torque, "1", {0, 1e5},
            "rows [engine speed rad/s, torque at full throttle N m, drag torque at closed throttle N m], from idle up; "
            "default: the published peak of 550 N m, 259 kW"),
      param("gears", &P::gears, "1", {0, 1e4},
            "rows [gear, ratio, from m/s, to m/s]; up at `to`, down at `from`; default: six gears around the published "
            "fourth")};
}

inline constexpr auto declare_parameters() { return std::tuple_cat(declare_body(), declare_tyres(), declare_drive()); }

}  // namespace gripline::double_track
