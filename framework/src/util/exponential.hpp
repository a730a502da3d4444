// Weights of exponential integrators for y' = a y + c(t) over a step h from y = 0, as functions of z = a h.
#pragma once

#include <cmath>

namespace gripline {

/// (e^z - 1) / z: y after the step over c h, for constant c.
inline double phi1(double z) { return std::abs(z) < 1e-4 ? 1.0 + 0.5 * z : std::expm1(z) / z; }
/// (e^z - 1 - z) / z^2: y after the step over c(h) h, for c that grows linearly from 0; also the mean of y over the
/// step over c h, for constant c.
inline double phi2(double z) { return std::abs(z) < 1e-3 ? 0.5 + z / 6.0 : (std::expm1(z) - z) / (z * z); }

}  // namespace gripline
