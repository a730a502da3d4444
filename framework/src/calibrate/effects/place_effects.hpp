// Effects that act by where on the road the car is: without a road they say nothing.
#pragma once

#include <string>
#include <vector>

#include "car/vehicle.hpp"

namespace gripline::calibrate {

/// Whether an effect changes anything when only the place does. `params` are its parameters.
bool depends_on_place(const Effect& effect, std::span<const double> params);

/// Takes such effects out of a car; gives their ids.
std::vector<std::string> leave_out_place_effects(VehicleSpec& vehicle, const Car& car);

}  // namespace gripline::calibrate
