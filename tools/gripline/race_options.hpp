// Options that compare and run share.
#pragma once

#include <boost/program_options.hpp>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "experiment/experiment.hpp"
#include "gripline/command.hpp"

namespace gripline::tools {

struct RaceOptions {
  std::filesystem::path experiment;
  std::vector<std::string> assignments, plugin_dirs;
  std::filesystem::path out;
  int jobs = 1;
  bool force = false;
};

/// Adds the shared options and the positional EXPERIMENT.
void add_race_options(boost::program_options::options_description& visible);
/// Parses; empty when --help was asked for and has been printed. Throws InputError without an experiment.
std::optional<boost::program_options::variables_map> parse_options(
    Arguments args, const boost::program_options::options_description& visible, const char* usage);
/// The folders of `--plugins`. Throws InputError when one is not there.
std::vector<std::string> plugin_dirs_of(const boost::program_options::variables_map& given);
/// The whole number of an option given as text. Throws InputError that names it as `shown`.
std::int64_t whole_number(const boost::program_options::variables_map& given, const char* name,
                          const std::string& shown);
/// A file to be written, asked before long work: refused (InputError) when it is one of the inputs or cannot be made.
void require_writable(const std::string& option, const std::filesystem::path& file,
                      std::span<const std::string> inputs);
RaceOptions read_race_options(const boost::program_options::variables_map& given);

/// The one at `--out`, else out/<experiment>.
std::filesystem::path out_of(const RaceOptions& options);

}  // namespace gripline::tools
