// The published 1:43 car (Liniger, Domahidi, Morari 2015; the paper's plant), which worlds/cars/orca_1_43.json is too.
// Tests take it from here; those of tests/independent have it written out again, apart on purpose.
#pragma once

#include <gripline/types.hpp>

namespace gripline::conformance::published {

inline constexpr Car car{.m = 0.041,
                         .Iz = 27.8e-6,
                         .lf = 0.029,
                         .lr = 0.033,
                         .length = 0.06,
                         .width = 0.03,
                         .d_min = -0.1,
                         .d_max = 1.0,
                         .delta_max = 0.35,
                         .ddelta_max = 5.0,
                         .v_ref = 2.0,
                         .v_min = 0.3};

// Lateral force of an axle: D sin(C atan(B slip)), B [1/rad], D [N].
inline constexpr double Bf = 2.579, Cf = 1.2, Df = 0.192;
inline constexpr double Br = 3.3852, Cr = 1.2691, Dr = 0.1737;
// Drive (Cm1 - Cm2 vx) d, resistance Cr0 + Cd vx^2.
inline constexpr double Cm1 = 0.287;   // [N]
inline constexpr double Cm2 = 0.0545;  // [N s/m]
inline constexpr double Cr0 = 0.0518;  // [N]
inline constexpr double Cd = 0.00035;  // [N s2/m2]

}  // namespace gripline::conformance::published
