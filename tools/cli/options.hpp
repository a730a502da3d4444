// Reading what is given on a command line.
#pragma once

#include <boost/program_options.hpp>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cli/program.hpp"
#include "plugin/registry.hpp"

namespace gripline::tools {

using Words = std::vector<std::string>;

/// Parses; empty when --help was asked for and has been printed. `positional` names the words that belong to no option,
/// for words_of(). `usage` follows "usage: gripline ". Throws boost::program_options::error.
std::optional<boost::program_options::variables_map> parse_options(
    Arguments args, const boost::program_options::options_description& visible, const char* usage,
    const char* positional);
/// Every value of an option that may be repeated, or of the positional words; none when it was not given.
Words words_of(const boost::program_options::variables_map& given, const char* name);
/// The value of an option, if it was given.
std::optional<std::string> text_of(const boost::program_options::variables_map& given, const char* name);

/// Adds --plugins.
void add_plugins_option(boost::program_options::options_description& visible);
/// The folders of `--plugins`. Throws InputError when one is not there.
Words plugin_dirs_of(const boost::program_options::variables_map& given);
/// The registry of `--plugins` and the usual places; what the user should know of them is said on stderr.
Registry open_registry(const Words& plugin_dirs);
/// Both ends included.
struct WholeRange {
  std::int64_t least, most;
  const char* unit = "";  // "megabytes", for messages
};
/// The whole number of an option. Throws InputError that names the option, what was expected and what was given.
std::int64_t whole_number(const std::string& option, const std::string& text, const WholeRange& range);
/// What a number of an option has to be: above 0, in SI or with a unit ("90 s", "9m"), bare where `unit` is empty.
struct Expected {
  const char* unit;
  const char* words;  // "a time above 0 s", for messages
  double most = std::numeric_limits<double>::infinity();
};
/// The number of an option. Throws InputError that names the option, what was expected and what was given.
double quantity_of(const std::string& option, const std::string& text, const Expected& expected);
/// Every number of a list with commas ("0.5, 1 s"), at least one, in SI units. Throws as quantity_of().
std::vector<double> quantities_of(const std::string& option, const std::string& text, const Expected& expected);
/// The names between commas, without the blanks around them; `one` says what has a name ("stack"). Throws InputError
/// where there is none or one is empty.
Words names_of(const std::string& option, const std::string& text, const std::string& one);
/// A file to be written, asked before long work: refused (InputError) when it is one of the inputs or cannot be made.
/// Its folder is made.
void require_writable(const std::string& option, const std::filesystem::path& file,
                      std::span<const std::string> inputs);

}  // namespace gripline::tools
