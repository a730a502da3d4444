// Whether anybody stated what drives a car: a vehicle model's defaults are those of a car of its author's.
#pragma once

#include "car/vehicle.hpp"

namespace gripline {

/// Refuses, where the car's known_params are written, a car that full throttle at `v_min` on a level road accelerates
/// by less than 0.05 m/s2, straight ahead and without effects, while every parameter that this depends on besides m,
/// Iz, lf and lr is the model's default. A drive that is stated, be it none, is meant. Does nothing without
/// CarFile::known_at. The model is called in a process of its own: one that throws, or ends it, is reported by the run.
void check_drive(const PluginSpec& model, const CarFile& car, Errors& errors);

}  // namespace gripline
