// gripline sweep EXPERIMENT...: thousands of runs, here or on a cluster. `sweep status`, `sweep cancel`, `sweep
// merge` and `sweep task` take the folder of one.
#include <optional>

#include "config/errors.hpp"
#include "config/shipped.hpp"
#include "gripline/command.hpp"
#include "gripline/race_options.hpp"
#include "gripline/sweep_work.hpp"
#include "sweep/sweep.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace fs = std::filesystem;
namespace {

constexpr const char* usage =
    "sweep EXPERIMENT... --set /json/pointer=a,b,c --seeds 1..50 [options]\n"
    "       gripline sweep --resume --out DIR\n"
    "       gripline sweep status|cancel|merge DIR";

void add_sweep_options(po::options_description& visible) {
  auto add = visible.add_options();
  add("set", po::value<Words>()->composing(),
      "/json/pointer=a,b,c: a factor with these values; with one value the same in all runs; lo..hi with --latin");
  add("seeds", po::value<std::string>(), "1..50 or 1,2,7 (default: the experiments' own)");
  add("seeds-from", po::value<std::string>(), "draws as many seeds from the hash of this text");
  add("latin", po::value<std::string>(), "COUNT settings of a latin hypercube over the factors (default: all)");
  add("latin-seed", po::value<std::string>()->default_value("1"), "which latin hypercube");
  add("list", po::value<std::string>(), "settings from a CSV file, JSON pointers in its first row");
  add("only", po::value<std::string>(), "rows (stacks, cases, estimators) to run, a,b,c (default: all)");
  add_plugins_option(visible);
  add("out", po::value<std::string>(), "folder of the sweep (default: out/sweep_<experiment>)");
  add("dry-run", "runs nothing that is kept: prints how many runs, estimated time and disk");
  add("engine", po::value<std::string>()->default_value("local"), "local: processes here; slurm: array jobs");
  add("jobs,j", po::value<std::string>(), "runs at the same time (default: one per core); of Slurm, tasks");
  add("chunk", po::value<std::string>(), "runs of one task (default: 50 for Slurm, else by the number of runs)");
  add("wait", "slurm: returns when all is over (Ctrl-C leaves the jobs alone)");
  add("resume", "does what is missing and repeats what broke; needs no experiment where --out holds a sweep");
  add("timeout", po::value<std::string>(), "time that one run may take, \"90 s\" or \"2 h\"");
  add("memory", po::value<std::string>(), "megabytes of data that one run may have (default: no limit)");
  add("keep-files", "keeps all files of every run in OUT/files, not its row alone");
  add("partition", po::value<std::string>(), "slurm: sbatch --partition");
  add("time", po::value<std::string>(), "slurm: sbatch --time of one task");
  add("mem", po::value<std::string>(), "slurm: sbatch --mem of one task");
  add("sbatch", po::value<Words>()->composing(), "slurm: another option of sbatch, \"--account=x\"");
  add("scratch", po::value<std::string>(), "folder for files of running runs, such as a node's own disk");
  add("help,h", "this text");
}

std::size_t count_of(const po::variables_map& given, const char* name, std::int64_t most) {
  return static_cast<std::size_t>(whole_number(std::string("--") + name, given[name].as<std::string>(), {1, most}));
}

/// Assignments with several values, or a range, are factors: their pointers keep their places among the others.
void read_settings(const po::variables_map& given, sweep::Request& request) {
  std::vector<sweep::Factor> factors;
  for (const std::string& assignment : words_of(given, "set")) {
    sweep::Factor factor = sweep::parse_factor(assignment);
    const bool varies = factor.range() || factor.levels.size() > 1;
    request.assignments.push_back(varies ? factor.pointer : assignment);
    if (varies) factors.push_back(std::move(factor));
  }
  const bool latin = given.count("latin") > 0, list = given.count("list") > 0;
  if (list && (latin || !factors.empty()))
    throw InputError("--list has all settings: it goes with neither --latin nor factors at --set");
  if (list)
    request.design = sweep::Design::list(given["list"].as<std::string>());
  else if (latin)
    request.design = sweep::Design::latin(std::move(factors), count_of(given, "latin", 10'000'000),
                                          count_of(given, "latin-seed", 1'000'000'000));
  else
    request.design = sweep::Design::factorial(std::move(factors));
}

sweep::Request read_sweep(const po::variables_map& given) {
  sweep::Request request;
  for (const std::string& file : words_of(given, experiment_word))
    request.files.push_back(find_shipped(file, "experiments"));
  if (request.files.empty()) throw InputError("which experiment? For example experiments/table1.json");
  read_settings(given, request);
  if (given.count("seeds") > 0) request.seeds = sweep::parse_seeds(given["seeds"].as<std::string>());
  request.seeds_from = text_of(given, "seeds-from").value_or("");
  if (given.count("seeds-from") > 0 && request.seeds_from.empty()) throw InputError("--seeds-from has no text");
  if (const auto only = text_of(given, "only")) request.only = names_of("--only", *only, "row");
  request.plugin_dirs = plugin_dirs_of(given);
  if (const auto timeout = text_of(given, "timeout")) request.timeout_s = seconds_of("--timeout", *timeout);
  if (given.count("memory") > 0) request.memory_mb = count_of(given, "memory", std::int64_t{1} << 30);
  request.keep_files = given.count("keep-files") > 0;
  return request;
}

SweepWork read_work(const po::variables_map& given) {
  SweepWork work;
  work.engine = given["engine"].as<std::string>();
  if (work.engine != "local" && work.engine != "slurm") {
    const std::vector<std::string> known = {"local", "slurm"};
    throw InputError("--engine " + work.engine + ": no such engine" + did_you_mean(work.engine, known));
  }
  if (given.count("jobs") > 0) work.jobs = static_cast<int>(count_of(given, "jobs", 4096));
  if (given.count("chunk") > 0) work.chunk = count_of(given, "chunk", 1'000'000);
  work.wait = given.count("wait") > 0;
  work.resume = given.count("resume") > 0;
  // Absolute: a resumed sweep is done in the folder that it was planned in.
  const std::string scratch = text_of(given, "scratch").value_or("");
  if (!scratch.empty()) work.scratch = fs::absolute(scratch).lexically_normal();
  work.partition = text_of(given, "partition").value_or("");
  work.time = text_of(given, "time").value_or("");
  work.mem = text_of(given, "mem").value_or("");
  work.sbatch = words_of(given, "sbatch");
  return work;
}

/// `sweep status DIR` and its like; empty when the words are none of these.
std::optional<int> run_on_folder(Arguments args) {
  if (args.empty()) return std::nullopt;
  const std::string& word = args[0];
  const auto folder = [&](std::size_t words, const char* form) {
    if (args.size() != words) throw InputError(std::string("expected: gripline sweep ") + form);
    return fs::path(args[1]);
  };
  if (word == "status") return sweep_status(folder(2, "status DIR"));
  if (word == "cancel") return sweep_cancel(folder(2, "cancel DIR"));
  if (word == "merge") return sweep_merge(folder(2, "merge DIR"));
  if (word == "task") return sweep_task(folder(4, "task DIR BATCH TASK"), args[2], args[3]);
  return std::nullopt;
}

}  // namespace

int run_sweep(Arguments args) {
  if (const std::optional<int> code = run_on_folder(args)) return *code;
  po::options_description visible("options");
  add_sweep_options(visible);
  const auto given = parse_options(args, visible, usage, experiment_word);
  if (!given) return good;
  SweepWork work = read_work(*given);
  if (work.resume && words_of(*given, experiment_word).empty()) {
    if (given->count("out") == 0) throw InputError("--resume without an experiment needs --out DIR");
    for (const char* option : {"set", "seeds", "seeds-from", "latin", "list", "only", "timeout", "memory"})
      if (given->count(option) > 0)
        throw InputError(std::string("--") + option + " is the sweep's own; with it name the experiment too");
    work.out = (*given)["out"].as<std::string>();
    return continue_sweep(work);
  }
  const sweep::Request request = read_sweep(*given);
  work.out = text_of(*given, "out").value_or(fs::path("out") / ("sweep_" + request.files.front().stem().string()));
  if (work.out.empty()) throw InputError("--out names no folder");
  return given->count("dry-run") > 0 ? plan_sweep(request, work) : start_sweep(request, work);
}

}  // namespace gripline::tools
