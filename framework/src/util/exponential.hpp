// Weights of exponential integrators: of what drives z' = a z + c(t) over a step h, with z = a h.
#pragma once

#include <cmath>

namespace gripline {

/// (e^z - 1) / z: z after the step by a constant c, over c h.
inline double phi1(double z) { return std::abs(z) < 1e-4 ? 1.0 + 0.5 * z : std::expm1(z) / z; }
/// (e^z - 1 - z) / z^2: the same by c that grows linearly from 0, over its last value; also z's mean over the step by a
/// constant c.
inline double phi2(double z) { return std::abs(z) < 1e-3 ? 0.5 + z / 6.0 : (std::expm1(z) - z) / (z * z); }

}  // namespace gripline
