// gripline limit WORLD.json: the fastest flying laps of a world, over friction.
#include <algorithm>
#include <iostream>
#include <thread>

#include "cli/options.hpp"
#include "config/errors.hpp"
#include "config/hash.hpp"
#include "config/json_file.hpp"
#include "config/shipped.hpp"
#include "experiment/experiment.hpp"
#include "gripline/command.hpp"
#include "limit/limit_table.hpp"
#include "plugin/plugin_cache.hpp"
#include "util/numbers.hpp"
#include "util/progress.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace {

/// The friction factors of a list with commas, each once, in its order.
std::vector<double> read_factors(const std::string& text) {
  std::vector<double> factors;
  for (const double value :
       quantities_of("--factors", text, {"", "friction factors above 0 and up to 10 with commas between them", 10.0}))
    if (std::find(factors.begin(), factors.end(), value) == factors.end()) factors.push_back(value);
  return factors;
}

/// Everything that decides a lap: the world without what only a race needs, and the libraries of its car.
std::string key_of(Node tree, const WorldSpec& world, bool patches) {
  for (const char* key : {"friction", "sensors", "start", "laps", "timeout", "duration", "time_optimal_laps", "note",
                          "dt", "input_hold", "nominal_uncertainty"})
    tree.erase(key);
  std::string key = content_text(tree) + number_text(world.dt);
  for (const FrictionSpec::Patch& patch : world.friction.patches)
    if (patches)
      key += number_text(patch.from_s) + " " + number_text(patch.to_s) + " " + number_text(patch.factor) + " ";
  for (const std::filesystem::path& file : files_named(tree)) key += sha256_of_file(file);
  for (const std::filesystem::path& library : libraries_of(world, {})) key += sha256_of_file(library);
  return sha256_hex(key);
}

void print_limits(const std::vector<LapLimit>& limits) {
  std::cout << "factor      lap s    error s   nodes   inside\n";
  for (const LapLimit& lap : limits)
    std::cout << format("%6.4g %10.4f %10.4f %7d   %s%s\n", lap.factor, lap.lap_s, lap.error_s, lap.nodes,
                        lap.body ? "whole body" : "centre of gravity", lap.patches ? ", with patches" : "");
}

int jobs_of(const po::variables_map& given) {
  const std::optional<std::string> text = text_of(given, "jobs");
  return static_cast<int>(text ? whole_number("-j", *text, {1, 4096})
                               : std::max(1u, std::thread::hardware_concurrency()));
}

}  // namespace

int run_limit(Arguments args) {
  po::options_description visible("options");
  auto add = visible.add_options();
  add("factors", po::value<std::string>()->default_value("1,0.9,0.8,0.7,0.6,0.5"), "friction factors, with commas");
  add("body", "also with the whole body inside the edges, not only the centre of gravity");
  add("patches", "with the patches of the world's friction, from the start on; the factors multiply them");
  add("out", po::value<std::string>(), "the table as CSV; a world may name it as its time_optimal_laps");
  add("jobs,j", po::value<std::string>(), "laps at the same time (default: one per core)");
  add_plugins_option(visible);
  add("help,h", "this text");
  const auto given = parse_options(args, visible, "limit WORLD.json [options]", "world");
  if (!given) return good;
  Words words = words_of(*given, "world");
  if (words.size() != 1) throw InputError("limit needs one world: gripline limit WORLD.json --out TABLE.csv");
  words[0] = find_shipped(words[0], "worlds").string();
  LimitRequest request;
  request.factors = read_factors(*text_of(*given, "factors"));
  request.body = given->count("body") > 0;
  request.jobs = jobs_of(*given);
  request.cache = plugin_cache_folder();
  const std::optional<std::string> out = text_of(*given, "out");
  if (out) require_writable("--out", *out, words);

  const Registry registry(Registry::search_path(plugin_dirs_of(*given)));
  Node tree = load_world(words[0]);
  tree.erase("time_optimal_laps");  // what is looked for; it may name a table that is not there yet
  Errors errors;
  const WorldSpec world = read_world(tree, registry, errors);
  errors.throw_if_any();
  request.patches = given->count("patches") > 0;
  if (request.patches && world.friction.patches.empty())
    throw InputError("--patches: the friction of " + words[0] + " has no patches");
  request.key = key_of(tree, world, request.patches);
  std::optional<Progress> progress;
  const std::vector<LapLimit> limits = compute_limits(world, request, [&](std::size_t done, std::size_t total) {
    if (!progress) progress.emplace(std::cerr, "limit", total);
    progress->advance(done, "time-optimal laps");
  });
  if (progress) progress->finish();
  print_limits(limits);
  if (!world.plant.empty())
    std::cout << "the plant " << world.plant.id()
              << " is a black box: laps of the envelope that was measured by driving it\n";
  if (out) write_limits(*out, limits);
  return good;
}

}  // namespace gripline::tools
