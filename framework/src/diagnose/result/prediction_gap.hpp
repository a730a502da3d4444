// The gap between predictions of hold-out data and measurement: how large it is with the nominal model, and how much of
// it the found one closes.
#pragma once

#include "diagnose/inference/hold_out.hpp"
#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

/// The nominal model with its stated parameters: of `null_model`, to which they were fitted, it has the noise and what
/// is left of delays that were taken off, which is no part of the car.
Fit nominal_as_stated(const Catalogue& catalogue, const Fit& null_model);

/// Sets horizons, gap and named_gap: errors of the nominal model as stated, with its parameters refitted, and of d.fit,
/// which is taken for the nominal model as stated where nothing of it is fitted.
void measure_gap(const HoldOut& hold_out, const Catalogue& catalogue, Diagnosis& d);

/// d.fit is the nominal model as stated: what was measured before stays, and nothing is closed.
void leave_gap_open(Diagnosis& d);

/// Lets horizons and gap begin with the logs as they came, late channels in them; what they end with, of logs on time,
/// has been measured. Returns what taking the delays off does to the error, by itself.
ErrorChange begin_with_delays(const HoldOut& as_they_came, const HoldOut& on_time, const Catalogue& catalogue,
                              Diagnosis& d);

}  // namespace gripline::diagnose
