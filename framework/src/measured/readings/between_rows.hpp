// What a logged column does between rows: what the map states, what is used, and what the log shows.
#pragma once

namespace gripline::measured {

struct BetweenRows {
  enum class Kind {
    linear,  // a straight line from row to row
    held,    // stays until the next new value
    paced    // read `every` so often and repeated in between: moves evenly from one reading to the next
  };
  Kind used = Kind::linear;
  double every = 0;     // [s] of `paced`, else 0: read in every row
  bool stated = false;  // by the map, or by gripline of its own logs; else `used` is what goes without saying
  double repeats = 1;   // rows that show each value, as the log has them (rows_between_new); of commands only

  bool held() const { return used == Kind::held; }
  /// Whether the log repeats its values in step, and nobody said what that means: each row is taken for new.
  bool is_unexplained() const { return !stated && repeats > 1.0; }
};

}  // namespace gripline::measured
