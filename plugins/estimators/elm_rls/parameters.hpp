// Parameters of elm_rls and elm_rls_told, with units, ranges and what they say.
#pragma once

#include <gripline/plugin.hpp>
#include <tuple>

#include "common/learning/friction_ellipse.hpp"

namespace gripline::elm_rls {

struct Params {
  // tyres that are expected
  int hidden = 40;
  double stiffness = 6.0, stiffness_spread = 0.7, shape = 1.4, shape_spread = 0.2;
  double friction = 0, friction_spread = 0.3, common = 0;
  // drive and brakes
  double most_drive = 10, sharing_spread = 0, sharing_lasts = 1;
  double drive_spread = 0, brake_spread = 0, arm_spread = 0;
  // change of friction
  double drift = 0.015, axle_drift = 0.005, shape_memory = 1000;
  double alarm = 4.5, change = 0.3;
  // readings and equations
  double sigma_v = 0.02, sigma_omega = 0.05, misfit = 0.02;
  double slowest = 0;
  double ellipse = 0, drive_front = 0, brake_front = 0;

  bool learns_gains() const { return drive_spread > 0 || brake_spread > 0; }
  bool learns_arm() const { return arm_spread > 0; }
};

constexpr auto declare_parameters() {
  using P = Params;
  return std::tuple_cat(
      std::tuple{
          param("hidden", &P::hidden, "1", {2, 400}, "hidden nodes per axle: generic tyres"),
          param("stiffness", &P::stiffness, "1/rad", {0.1, 100}, "stiffness factor B of a tyre: median of the prior"),
          param("stiffness_spread", &P::stiffness_spread, "1", {0.01, 2}, "standard deviation of log B"),
          param("shape", &P::shape, "1", {1.05, 2}, "shape factor C of a tyre: mean of the prior"),
          param("shape_spread", &P::shape_spread, "1", {0.001, 1}, "standard deviation of C"),
          param("friction", &P::friction, "1", {0, 5}, "friction that the prior expects; 0: the stack's mu_init"),
          param("friction_spread", &P::friction_spread, "1", {0.01, 2}, "standard deviation of that, relative to it"),
          param("common", &P::common, "1", {0, 1},
                "share of that variance which both axles have in common, as they drive one road"),
          param("most_drive", &P::most_drive, "1", {0, 10},
                "drive or brake force, as a share of friction, above which a sample updates neither drive nor "
                "tyres, but for what sharing_spread leaves"),
          param("sharing_spread", &P::sharing_spread, "1", {0, 10},
                "standard deviation of what drive and brakes take off the square of a side force, relative to it; "
                "above 0 side forces beyond 0.4 of what brakes leave update tyres under braking beyond most_drive "
                "too, and all do after a change"),
          param("sharing_lasts", &P::sharing_lasts, "1", {1, 1e4},
                "consecutive samples of 20 ms whose errors of sharing are correlated, so that they weigh as one"),
          param("drive_spread", &P::drive_spread, "1", {0, 1},
                "standard deviation of the drive force, relative to what the model says; 0: it is known"),
          param("brake_spread", &P::brake_spread, "1", {0, 1},
                "standard deviation of the brake force, relative to what the model says; 0: it is known"),
          param("arm_spread", &P::arm_spread, "m", {0, 1},
                "standard deviation of the arm at which drive turns the car into a turn, under a side force as large "
                "as its weight: between 0 (left and right wheels push alike) and the height of the centre of gravity "
                "(as they carry); 0: there is none"),
          param("drift", &P::drift, "1/s^0.5", {0, 1}, "random walk of friction, both axles together"),
          param("axle_drift", &P::axle_drift, "1/s^0.5", {0, 1}, "random walk of each axle's friction"),
          param("shape_memory", &P::shape_memory, "s", {1, 1e9}, "time in which the prior's uncertainty returns"),
          param("alarm", &P::alarm, "1", {1, 100}, "score above which friction is taken to have changed suddenly"),
          param("change", &P::change, "1", {0, 2}, "relative uncertainty of friction after such a change"),
          param("sigma_v", &P::sigma_v, "m/s", {1e-6, 10}, "initial noise of vx and vy, a standard deviation"),
          param("sigma_omega", &P::sigma_omega, "rad/s", {1e-6, 10},
                "initial noise of the yaw rate, a standard deviation"),
          param("misfit", &P::misfit, "m/s2", {1e-6, 10},
                "least model error of the equations over 20 ms, a standard deviation"),
          param("slowest", &P::slowest, "m/s", {0, 100}, "speed below which samples are not used")},
      learning::ellipse_parameters<P>());
}

}  // namespace gripline::elm_rls
