// What fit and predict share: a world for logs, its road, and the logs through a map.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/fit/calibrated_world.hpp"
#include "cli/options.hpp"
#include "measured/session/session_file.hpp"

namespace gripline::tools {

/// Adds --map and --track.
void add_log_options(boost::program_options::options_description& visible);

/// The road that --track names: a .json or .csv file, or both edges of a road ("left.csv,right.csv", or one of them
/// when the other's name differs by inner/outer or left/right alone). Empty when it was not given.
std::optional<Node> track_option(const boost::program_options::variables_map& given);

/// A world read for comparison with logs.
struct LogWorld {
  Node tree;
  WorldSpec spec;
  std::vector<std::string> left_out;  // effects of place, where there is no road
};
/// Throws InputError; says on stderr what is left out.
LogWorld read_log_world(const std::filesystem::path& file, const boost::program_options::variables_map& given,
                        const Registry& registry);

/// The map that --map names; says on stderr where its commands are linear between rows and the world's are not, and the
/// map does not say so. Without it a gripline log's, whose commands act between rows as the world's input_hold
/// says.
measured::LogMap map_option(const boost::program_options::variables_map& given, const WorldSpec& world);

/// Says on stderr what a log lacks, what is taken in its place and what is left out of it, in the words of import's
/// table.
void warn_of_findings(const std::string& log, const measured::SessionFile& file);
/// Warns of commands that stay where they are and of channels that hardly fit the others.
void warn_of_inconsistencies(const std::string& log, const measured::SessionFile& file);

}  // namespace gripline::tools
