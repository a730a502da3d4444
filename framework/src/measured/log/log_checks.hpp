// Units, signs and places of a log, judged by medians so that outliers do not matter. Each throws InputError.
#pragma once

#include "measured/log/log_expectations.hpp"
#include "measured/log/raw_log.hpp"

namespace gripline::measured {

/// A yaw in radians jumps by about a turn where it wraps; one in degrees jumps by anything in every quick bend.
void check_yaw_is_radians(const CsvTable& table, const RawLog& raw);
/// Compares channels with each other over windows of half a second: a ratio of 3.6, 57.3 or 1000 is a wrong unit, a
/// negative one a wrong frame.
void check_units(const CsvTable& table, const RawLog& raw, const LogExpectations& expected,
                 std::vector<Finding>& health);
/// Refuses logs of which more than half lies outside the road by more than half its width.
void check_place(const CsvTable& table, const RawLog& raw, const Road& road);

}  // namespace gripline::measured
