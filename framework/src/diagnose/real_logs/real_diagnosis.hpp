// What the search for missing effects says of a real car, as a diagnosis: the verdict is always `unknown`, because
// nothing shows that a real car lacks no more than was named.
#pragma once

#include <span>

#include "diagnose/inference/channel_delays.hpp"
#include "diagnose/real_logs/cornering.hpp"
#include "diagnose/result/diagnosis.hpp"

namespace gripline::diagnose {

ErrorChange error_change(const calibrate::ForecastChange& change);

/// How much of the normalised error beyond what sensor noise leaves is closed, by calibration and effects together.
Gap real_gap(const MissingEffects& found);

Diagnosis real_diagnosis(const MissingEffects& found, std::span<const ChannelDelay> delays, const Cornering& corners);

/// Whether something was found: something is named and the error is smaller with it, or nothing is left beside noise.
bool is_answer(const Diagnosis& d, const MissingEffects& found);

}  // namespace gripline::diagnose
