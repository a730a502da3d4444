// The gap between predictions of hold-out data and measurement: how large it is with the nominal model, and how much of
// it the found one closes.
#pragma once

#include "diagnose/inference/hold_out.hpp"
#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

/// The nominal model with its stated parameters: of `null_model`, to which they were fitted, it has the noise and what
/// is left of delays that were taken off, which is not part of the car.
Fit nominal_as_stated(const Catalogue& catalogue, const Fit& null_model);

/// Errors of the nominal model as stated, with its parameters refitted (`null_model`), and of what was found, which is
/// taken for the nominal model as stated where nothing of it is fitted.
PredictionGaps measure_gaps(const HoldOut& hold_out, const Catalogue& catalogue, const Fit& null_model,
                            const Fit& found);

/// The nominal model as stated is returned: what was measured before stays, and nothing is closed.
PredictionGaps left_open(const PredictionGaps& measured);

/// What predictions say where delays were taken off.
struct GapsFromDelays {
  PredictionGaps gaps;    // horizons and gap begin with the logs as they came, late channels in them
  ErrorChange by_delays;  // what taking the delays off does to the error, by itself
};

/// `found`: on the logs on time; what its gaps end with stays.
GapsFromDelays gaps_from_delays(const HoldOut& as_they_came, const HoldOut& on_time, const Catalogue& catalogue,
                                const Findings& found);

}  // namespace gripline::diagnose
