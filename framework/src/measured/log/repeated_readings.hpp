// Values in a log that were not measured in their row: columns that stand still, and values that a logger repeats until there is a new one.
#pragma once

#include "measured/log/raw_log.hpp"

namespace gripline::measured {

/// A lateral speed that is the same in every row of a car that turns was not read: it becomes not_a_number.
void leave_out_constant_lateral_speed(RawLog& raw, std::vector<Finding>& health);

/// Readings that stand still for much longer than their channel usually does while the car moves become not_a_number,
/// but for the first of them; where commands and all channels stand, the rows are dropped. Coarsely rounded channels
/// may stay where they are: theirs count where both coordinates of the place stay, or where they leave by a jump.
/// `slowest`: what the car exceeds where it moves [m/s].
void leave_out_standing(RawLog& raw, double slowest, std::vector<Finding>& health);

/// Of channels that have a new value at a steady pace of two rows or more and repeat it in between, the repeats become
/// not_a_number (drop_held). A coarsely rounded channel repeats too, but at no steady pace, or by steps of its
/// resolution. `dt`: time between rows [s].
void leave_out_repeats(RawLog& raw, double dt, double slowest, std::vector<Finding>& health);

}  // namespace gripline::measured
