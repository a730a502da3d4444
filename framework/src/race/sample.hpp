// Algorithm 1, line 4: what a control step left unexplained.
#pragma once

#include "car/corrected_model.hpp"

namespace gripline {

/// e = x_{t+1} - f_nom(x_t, u_t) over the step from `before` to `after` under `u`, per second of dt, with how far the
/// acting commands were behind the given ones. Advances the nominal model's memory over the step.
Sample residual_sample(CorrectedModel& nominal, const Observation& before, const Input& u, const Observation& after);

}  // namespace gripline
