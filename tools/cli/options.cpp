#include "cli/options.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iostream>

#include "config/ascii.hpp"
#include "config/errors.hpp"
#include "config/units.hpp"
#include "util/made_folders.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace {

/// What stands between commas, without the blanks around it. `part` is what each is called, `none` is said of a list
/// without any.
Words parts_of(const std::string& option, const std::string& text, const std::string& part, const std::string& none) {
  constexpr const char* blanks = " \t\n\r\f\v";
  Words parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t comma = std::min(text.find(',', begin), text.size());
    const std::string one = text.substr(begin, comma - begin);
    parts.emplace_back(trim(one, blanks));
    begin = comma + 1;
  }
  const auto missing = std::ranges::count(parts, std::string());
  if (missing == std::ssize(parts)) throw InputError(none);
  if (missing > 0) throw InputError(option + " " + text + ": a " + part + " is missing between commas");
  return parts;
}

/// The message about an option that there is none of, with the nearest of those that there are.
std::string unknown_option(const po::unknown_option& error, const po::options_description& visible) {
  Words names;
  for (const auto& option : visible.options()) names.push_back("--" + option->long_name());
  const auto near = nearest(error.get_option_name(), names);
  return error.what() + (near ? "; did you mean \"" + *near + "\"?" : std::string());
}

}  // namespace

void add_plugins_option(po::options_description& visible) {
  visible.add_options()("plugins", po::value<Words>()->composing(), "a folder of plugins, searched first");
}

std::optional<po::variables_map> parse_options(Arguments args, const po::options_description& visible,
                                               const char* usage, const char* positional) {
  po::options_description all;
  all.add(visible);
  all.add_options()(positional, po::value<Words>());
  po::positional_options_description places;
  places.add(positional, -1);
  po::variables_map given;
  const Words words(args.begin(), args.end());
  const auto style = po::command_line_style::unix_style & ~po::command_line_style::allow_guessing;
  try {
    po::store(po::command_line_parser(words).options(all).positional(places).style(style).run(), given);
  } catch (const po::unknown_option& error) {
    throw po::error(unknown_option(error, visible));
  }
  po::notify(given);
  if (given.count("help") > 0) {
    std::cout << "usage: gripline " << usage << "\n\n" << visible;
    return std::nullopt;
  }
  return given;
}

Words words_of(const po::variables_map& given, const char* name) {
  return given.count(name) > 0 ? given[name].as<Words>() : Words{};
}

std::optional<std::string> text_of(const po::variables_map& given, const char* name) {
  if (given.count(name) == 0) return std::nullopt;
  return given[name].as<std::string>();
}

Words plugin_dirs_of(const po::variables_map& given) {
  Words dirs = words_of(given, "plugins");
  for (const std::string& dir : dirs)
    if (!std::filesystem::is_directory(dir))
      throw InputError(
          "--plugins " + dir +
          (std::filesystem::exists(dir) ? ": is a file, expected a folder of plugins" : ": no such folder"));
  return dirs;
}

Registry open_registry(const Words& plugin_dirs) {
  Registry registry(Registry::search_path(plugin_dirs));
  for (const std::string& warning : registry.warnings()) std::cerr << "warning: " << escape_control(warning) << '\n';
  return registry;
}

std::int64_t whole_number(const std::string& option, const std::string& text, const WholeRange& range) {
  std::int64_t value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error != std::errc::invalid_argument && stop == text.data() + text.size();
  if (!whole) throw InputError(option + " " + text + ": expected a whole number");
  if (error != std::errc() || value < range.least || value > range.most)
    throw InputError(option + " " + text + ": expected " + std::to_string(range.least) + " to " +
                     std::to_string(range.most) + (*range.unit == '\0' ? "" : " ") + range.unit);
  return value;
}

double quantity_of(const std::string& option, const std::string& text, const Expected& expected) {
  double value = 0.0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size()) {
    if (*expected.unit == '\0') throw InputError(option + " " + text + ": expected " + expected.words);
    try {
      value = to_si(text, expected.unit);
    } catch (const UnitError& refused) {
      throw InputError(option + " " + text + ": " + refused.what());
    }
  }
  if (!(value > 0) || !std::isfinite(value) || value > expected.most)
    throw InputError(option + " " + text + ": expected " + expected.words);
  return value;
}

std::vector<double> quantities_of(const std::string& option, const std::string& text, const Expected& expected) {
  std::vector<double> values;
  for (const std::string& part :
       parts_of(option, text, "number", option + " has no number; expected " + expected.words))
    values.push_back(quantity_of(option, part, expected));
  return values;
}

Words names_of(const std::string& option, const std::string& text, const std::string& one) {
  return parts_of(option, text, "name", option + " names no " + one + "; expected names with commas between them");
}

void require_writable(const std::string& option, const std::filesystem::path& file,
                      std::span<const std::string> inputs) {
  const auto refuse = [&](const std::string& why) { throw InputError(option + " " + file.string() + ": " + why); };
  if (file.empty()) throw InputError(option + " names no file");
  std::error_code failed;
  for (const std::string& input : inputs)
    if (std::filesystem::equivalent(file, input, failed))
      refuse("is an input of this command and would be overwritten; choose another file");
  if (file.has_parent_path() && !std::filesystem::exists(file.parent_path(), failed)) {
    make_folders(file.parent_path(), failed);
    if (failed) refuse("cannot be written: " + failed.message());
  }
  const bool there = std::filesystem::exists(file, failed);
  const int handle = open(file.c_str(), O_WRONLY | O_CREAT | O_NONBLOCK, 0644);
  // ENXIO: a pipe without a reader yet can be written later.
  if (handle < 0 && errno != ENXIO) refuse(std::string("cannot be written: ") + std::strerror(errno));
  if (handle >= 0) close(handle);
  if (!there) std::filesystem::remove(std::filesystem::canonical(file, failed), failed);
}

}  // namespace gripline::tools
