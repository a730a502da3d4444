#include "race_options.hpp"

#include <iostream>

#include "config/errors.hpp"

namespace gripline::tools {
namespace po = boost::program_options;

void add_race_options(po::options_description& visible) {
  auto add = visible.add_options();
  add("set", po::value<std::vector<std::string>>()->composing(), "/json/pointer=VALUE in the expanded experiment");
  add("plugins", po::value<std::vector<std::string>>()->composing(), "a folder of plugins, searched first");
  add("out", po::value<std::string>(), "folder for results (default: out/<experiment>)");
  add("force", "replace another experiment's results in that folder");
  add("help,h", "this text");
}

std::optional<po::variables_map> parse_options(Arguments args, const po::options_description& visible,
                                               const char* usage) {
  po::options_description all;
  all.add(visible);
  all.add_options()("experiment", po::value<std::vector<std::string>>());
  po::positional_options_description positional;
  positional.add("experiment", -1);
  po::variables_map given;
  const std::vector<std::string> words(args.begin(), args.end());
  const auto style = po::command_line_style::unix_style & ~po::command_line_style::allow_guessing;
  po::store(po::command_line_parser(words).options(all).positional(positional).style(style).run(), given);
  po::notify(given);
  if (given.count("help") > 0) {
    std::cout << "usage: gripline " << usage << "\n\n" << visible;
    return std::nullopt;
  }
  return given;
}

std::vector<std::string> plugin_dirs_of(const po::variables_map& given) {
  std::vector<std::string> dirs;
  if (given.count("plugins") > 0) dirs = given["plugins"].as<std::vector<std::string>>();
  for (const std::string& dir : dirs)
    if (!std::filesystem::is_directory(dir)) throw InputError("--plugins " + dir + ": no such folder");
  return dirs;
}

RaceOptions read_race_options(const po::variables_map& given) {
  RaceOptions options;
  if (given.count("experiment") == 0) throw InputError("which experiment? For example experiments/table1.json");
  const auto& files = given["experiment"].as<std::vector<std::string>>();
  if (files.size() > 1) throw InputError("one experiment at a time; found " + files[0] + " and " + files[1]);
  options.experiment = files.front();
  if (given.count("set") > 0) options.assignments = given["set"].as<std::vector<std::string>>();
  options.plugin_dirs = plugin_dirs_of(given);
  if (given.count("out") > 0) options.out = given["out"].as<std::string>();
  options.force = given.count("force") > 0;
  return options;
}

std::filesystem::path out_of(const RaceOptions& options) {
  return options.out.empty() ? std::filesystem::path("out") / options.experiment.stem() : options.out;
}

}  // namespace gripline::tools
