// Outliers: readings and rows of a log that no motion of a car explains.
#pragma once

#include "measured/log/raw_log.hpp"
#include "measured/session/session.hpp"

namespace gripline::measured {

/// Rows whose readings are all exactly zero, which several sensors with noise never show at once, are dropped where
/// they are less than half of all.
void drop_blank_rows(RawLog& raw, std::vector<Finding>& health);
/// Gross outliers, whatever the units: readings far from all their neighbours become not_a_number; rows with three of
/// them or more are dropped unless their commands are continuous.
void drop_gross_outliers(RawLog& raw, std::vector<Finding>& health);
/// Readings of a session ten times as far from their neighbours; rows and commands stay. Returns how many.
std::size_t drop_gross_outliers(Session& session);
/// Spikes of single samples beyond seven robust standard deviations of the residual of a local cubic become
/// not_a_number. Returns how many.
std::size_t drop_outliers(RawLog& raw);
/// Spikes of a session's places, x or y by itself: single readings that drop_outliers() finds among those of the
/// channel, where the seven around lie within 0.35 s and the jumps there and back, beyond the motion between the
/// readings around, are opposite and twice as far as the car goes between two readings. A slower log shows too little
/// of the motion between. They become not_a_number; rows and commands stay. Returns how many.
std::size_t drop_place_spikes(Session& session);
/// Makes yaw continuous over whole turns.
void unwrap_yaw(RawLog& raw, std::vector<Finding>& health);

}  // namespace gripline::measured
