// What checks of a log found.
#pragma once

#include <string>

namespace gripline::measured {

/// Something that was found about a log and what was done about it: a row of the tables of health.
struct Finding {
  enum class Level { good, note, bad } level = Level::good;
  std::string check, found, done;
};

}  // namespace gripline::measured
