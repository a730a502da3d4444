#include "gripline/race_options.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <iostream>

#include "config/errors.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace {

constexpr std::int64_t most_jobs = 4096;

}  // namespace

void add_race_options(po::options_description& visible) {
  auto add = visible.add_options();
  add("set", po::value<std::vector<std::string>>()->composing(),
      "/json/pointer=VALUE in the expanded experiment, in the order given; VALUE is JSON, else text; file names in it "
      "are relative to the current folder: --set '/world=\"worlds/mobil.json\"'");
  add("plugins", po::value<std::vector<std::string>>()->composing(), "a folder of plugins, searched first");
  add("out", po::value<std::string>(), "folder for results (default: out/<experiment>)");
  add("jobs,j", po::value<std::string>()->default_value("1"), "runs at the same time");
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
    if (!std::filesystem::is_directory(dir))
      throw InputError(
          "--plugins " + dir +
          (std::filesystem::exists(dir) ? ": is a file, expected a folder of plugins" : ": no such folder"));
  return dirs;
}

std::int64_t whole_number(const po::variables_map& given, const char* name, const std::string& shown) {
  const std::string& text = given[name].as<std::string>();
  std::int64_t value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size())
    throw InputError(shown + " " + text + ": expected a whole number");
  return value;
}

void require_writable(const std::string& option, const std::filesystem::path& file,
                      std::span<const std::string> inputs) {
  const auto refuse = [&](const std::string& why) { throw InputError(option + " " + file.string() + ": " + why); };
  if (file.empty()) throw InputError(option + " names no file");
  std::error_code failed;
  for (const std::string& input : inputs)
    if (std::filesystem::equivalent(file, input, failed)) refuse("is what is read; choose another file");
  const bool there = std::filesystem::exists(file, failed);
  const int handle = open(file.c_str(), O_WRONLY | O_CREAT | O_NONBLOCK, 0644);
  // A pipe that nobody reads from yet is no obstacle.
  if (handle < 0 && errno != ENXIO) refuse(std::string("cannot be written: ") + std::strerror(errno));
  if (handle >= 0) close(handle);
  if (!there) std::filesystem::remove(std::filesystem::canonical(file, failed), failed);
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
  if (given.count("out") > 0 && options.out.empty()) throw InputError("--out names no folder");
  const std::int64_t jobs = whole_number(given, "jobs", "-j");
  if (jobs < 1 || jobs > most_jobs)
    throw InputError("-j " + std::to_string(jobs) +
                     (jobs < 1 ? ": at least one run at a time" : ": at most " + std::to_string(most_jobs)));
  options.jobs = static_cast<int>(jobs);
  options.force = given.count("force") > 0;
  return options;
}

std::filesystem::path out_of(const RaceOptions& options) {
  return options.out.empty() ? std::filesystem::path("out") / options.experiment.stem() : options.out;
}

}  // namespace gripline::tools
