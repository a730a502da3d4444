// Options that compare and run share.
#pragma once

#include <functional>

#include "cli/options.hpp"

namespace gripline::tools {

struct RaceOptions {
  std::filesystem::path experiment;
  Words assignments, plugin_dirs;
  std::filesystem::path out;  // the one at --out, else out/<experiment>
  int jobs = 1;
  bool force = false;
  double timeout_s = 0;       // 0: from the world
  std::size_t memory_mb = 0;  // 0: no limit
};

/// The positional word of both commands, for parse_options().
inline constexpr const char* experiment_word = "experiment";
void add_race_options(boost::program_options::options_description& visible);
/// Throws InputError, also without an experiment.
RaceOptions read_race_options(const boost::program_options::variables_map& given);

/// A time with its unit, or a bare number of seconds. Throws InputError at the option.
double seconds_of(const std::string& option, const std::string& text);

/// Calls read(assignments); an error that one of the assignments makes is reported at it. Throws what `read` throws.
void read_telling_assignments(const RaceOptions& options,
                              const std::function<void(std::span<const std::string>)>& read);

}  // namespace gripline::tools
