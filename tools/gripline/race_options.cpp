#include "gripline/race_options.hpp"

#include "config/assignment_errors.hpp"
#include "config/errors.hpp"
#include "config/shipped.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace {

constexpr std::int64_t most_jobs = 4096;
constexpr std::int64_t most_memory = std::int64_t{1} << 30;  // MB

}  // namespace

double seconds_of(const std::string& option, const std::string& text) {
  return quantity_of(option, text, {"s", "a time above 0 s"});
}

void add_race_options(po::options_description& visible) {
  auto add = visible.add_options();
  add("set", po::value<Words>()->composing(),
      "/json/pointer=VALUE in the expanded experiment, in the order given; VALUE is JSON, else text; file names in it "
      "are relative to the current folder: --set '/world=\"worlds/mobil.json\"'");
  add_plugins_option(visible);
  add("out", po::value<std::string>(), "folder for results (default: out/<experiment>)");
  add("jobs,j", po::value<std::string>()->default_value("1"), "runs at the same time");
  add("force", "replace another experiment's results in that folder");
  add("timeout", po::value<std::string>(),
      "time that one run may take, \"90 s\" or \"2 h\" (default: 10 min and 1 min per second that is driven)");
  add("memory", po::value<std::string>(), "megabytes of data that one run may have (default: no limit)");
  add("help,h", "this text");
}

RaceOptions read_race_options(const po::variables_map& given) {
  RaceOptions options;
  options.assignments = words_of(given, "set");
  for (const std::string& one : options.assignments)
    if (one.find('=') == std::string::npos)
      throw InputError("--set " + one + ": expected /json/pointer=VALUE, as one word");
  const Words files = words_of(given, experiment_word);
  if (files.empty()) throw InputError("which experiment? For example experiments/table1.json");
  if (files.size() > 1) throw InputError("one experiment at a time; found " + files[0] + " and " + files[1]);
  options.experiment = find_shipped(files.front(), "experiments");
  options.plugin_dirs = plugin_dirs_of(given);
  options.out = text_of(given, "out").value_or(std::filesystem::path("out") / options.experiment.stem());
  if (options.out.empty()) throw InputError("--out names no folder");
  options.jobs = static_cast<int>(whole_number("-j", given["jobs"].as<std::string>(), {1, most_jobs}));
  options.force = given.count("force") > 0;
  if (given.count("timeout") > 0) options.timeout_s = seconds_of("--timeout", given["timeout"].as<std::string>());
  if (const auto memory = text_of(given, "memory"))
    options.memory_mb = static_cast<std::size_t>(whole_number("--memory", *memory, {1, most_memory, "megabytes"}));
  return options;
}

void read_telling_assignments(const RaceOptions& options,
                              const std::function<void(std::span<const std::string>)>& read) {
  try {
    read(options.assignments);
  } catch (const InputError& error) {
    throw attribute_to_assignments(error, options.assignments, read);
  }
}

}  // namespace gripline::tools
