// gripline diagnose WORLD.json LOG.csv...: name the missing effect, add it, show the gap shrink.
// With --map, or a world without a road, logs are of a real car: diagnose_real.hpp.
// gripline diagnose --score CASES: cases with answers, all of them, and a scorecard.
#include <algorithm>
#include <boost/dll/runtime_symbol_info.hpp>
#include <cmath>
#include <iostream>

#include "cli/options.hpp"
#include "config/errors.hpp"
#include "config/files.hpp"
#include "config/json_file.hpp"
#include "config/shipped.hpp"
#include "diagnose/result/diagnosis_files.hpp"
#include "diagnose/result/report_data.hpp"
#include "diagnose/scoring/scorecard.hpp"
#include "experiment/out_folder.hpp"
#include "experiment/result_files.hpp"
#include "gripline/command.hpp"
#include "gripline/diagnose_real.hpp"
#include "plugin/registry.hpp"
#include "util/numbers.hpp"
#include "util/progress.hpp"
#include "util/signals.hpp"
#include "util/whole_file.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace fs = std::filesystem;
namespace {

constexpr const char* files_word = "world-and-logs";  // the positional words

fs::path existing(const std::string& file) {
  if (!fs::exists(file)) throw InputError(file + ": " + why_unopenable(file));
  return file;
}

/// worlds/diagnose_<vehicle>.json from the working folder up to where the program is installed.
fs::path world_of(const std::string& vehicle) {
  const std::string name = "diagnose_" + vehicle + ".json";
  std::string looked;
  const fs::path program = fs::path(boost::dll::program_location().string()).parent_path();
  for (const fs::path& folder :
       {fs::path("worlds"), program / ".." / "share" / "gripline" / "worlds", program / ".." / ".." / "worlds"}) {
    if (fs::is_regular_file(folder / name)) return folder / name;
    looked += " " + (folder / name).lexically_normal().string();
  }
  throw InputError("no world for vehicle \"" + vehicle + "\"; looked for" + looked);
}

/// The first of an error's lines: a case that cannot be read is told in one.
std::string one_line(const std::exception& e) {
  const std::string text = e.what();
  return text.substr(0, text.find('\n'));
}

/// What became of a folder's cases.
struct Scored {
  std::vector<diagnose::CaseScore> scores;
  std::vector<std::string> failed;  // why a case has no score, in words
  Exit code = good;                 // the largest of the failures'

  void fail(Exit with, std::string why) {
    failed.push_back(std::move(why));
    code = std::max(code, with);
  }
};

/// Scores one case. What goes wrong in it costs no other case its score.
void score_one(const fs::path& folder, const fs::path& out, const Registry& registry, Scored& scored) {
  const std::string name = folder.filename().string();
  try {
    scored.scores.push_back(diagnose::score_case(folder, registry, world_of, out / name));
  } catch (const InputError& e) {
    scored.fail(bad_input, one_line(e));
  } catch (const PluginError& e) {
    scored.fail(plugin_unusable, name + ": " + escape_control(one_line(e)));
  } catch (const std::exception& e) {
    scored.fail(run_broke, name + ": " + escape_control(one_line(e)));
  }
}

void write_scores(const std::vector<diagnose::CaseScore>& scores, std::size_t cases, const fs::path& out) {
  fs::create_directories(out);
  write_file(out / result_files::score, diagnose::score_csv(scores));
  const std::string card = diagnose::scorecard(scores);
  write_file(out / result_files::scorecard, card);
  std::cout << card;
  if (scores.size() < cases) std::cout << scores.size() << " of " << cases << " cases are in these figures\n";
  std::cout << "scores: " << (out / result_files::score).string() << '\n';
}

int score(const fs::path& cases, const fs::path& out, const Registry& registry) {
  if (!fs::is_directory(cases)) throw InputError(cases.string() + ": no such folder");
  const std::vector<fs::path> folders = diagnose::case_folders(cases);
  if (folders.empty()) throw InputError(cases.string() + ": no folder in it holds a case.json");
  if (std::none_of(folders.begin(), folders.end(), [](const fs::path& f) { return fs::exists(f / "answer.json"); }))
    throw InputError(cases.string() + ": none of its " + std::to_string(folders.size()) +
                     " cases has an answer.json, so there is nothing to score; diagnose them one by one");
  Scored scored;
  const StopSignal stop(StopSignal::Reaction::note_then_end, run_broke);
  Progress progress(std::cerr, "diagnose", folders.size());
  std::size_t tried = 0;
  for (const fs::path& folder : folders) {
    if (StopSignal::seen()) break;
    progress.advance(tried++, folder.filename().string());
    score_one(folder, out, registry, scored);
  }
  progress.finish();
  for (const std::string& why : scored.failed) std::cerr << "not scored: " << why << '\n';
  if (StopSignal::seen()) std::cerr << "interrupted: " << tried << " of " << folders.size() << " cases are diagnosed\n";
  const int code = StopSignal::seen() ? run_broke : scored.code;
  if (scored.scores.empty()) {  // an earlier scorecard there stays
    std::cerr << "no case has a score: no scorecard is written\n";
    return code;
  }
  write_scores(scored.scores, folders.size(), out);
  return code;
}

void print(const diagnose::Diagnosis& d) {
  for (const measured::Finding& h : d.health)
    if (h.level != measured::Finding::Level::good)
      std::cout << "log: " << h.check << ": " << h.found << "; " << h.done << '\n';
  std::cout << diagnose::verdict_names[static_cast<std::size_t>(d.verdict)] << ": " << d.sentence << '\n';
  std::cout << "\neffect              evidence   error with it   wins   predictions\n";
  std::size_t shown = 0;
  for (const diagnose::RankedEffect& r : d.ranking) {
    if (++shown > 6) break;
    const bool tried = !std::isnan(r.held_out);
    const std::string error = tried ? format("%.3f", r.held_out) : "not tried", says(tried ? r.rollout.in_words() : "");
    std::cout << format("%-18s %9.1f   %13s   %4.2f   %s\n", r.effect.c_str(), r.gain.value_or(NAN), error.c_str(),
                        r.selected_fraction, says.c_str());
  }
  if (d.verdict == diagnose::Verdict::unknown && !d.ranking.empty())
    std::cout << "wins compare the effects of the catalogue with each other; here none of them is enough\n";
  std::cout << "\nhorizon    before     after   (sensor standard deviations, data not fitted)\n";
  for (const diagnose::PredictionError& h : d.horizons)
    std::cout << format("%5.1f s %9.3f %9.3f\n", h.seconds, h.before, h.after);
}

struct DiagnoseOptions {
  fs::path world;
  Words logs, held_out;
  std::optional<fs::path> case_file, track;
  bool mapped = false;  // logs are a logger's tables; then the road is read with the world
  fs::path out;
  bool force = false;
};

void refuse_beside_score(const po::variables_map& given) {
  for (const char* other : {files_word, "held-out", "case", "track", "map"}) {
    if (given.count(other) == 0) continue;
    const std::string found =
        other == files_word ? "\"" + words_of(given, other).front() + "\"" : std::string("--") + other;
    throw InputError("--score takes a folder of cases and nothing else; found " + found + " beside it");
  }
}

DiagnoseOptions read_options(const po::variables_map& given) {
  DiagnoseOptions o;
  const Words words = words_of(given, files_word);
  if (words.size() < 2) throw InputError("diagnose needs a world and a log: gripline diagnose WORLD.json LOG.csv");
  o.world = existing(find_shipped(words.front(), "worlds"));
  for (std::size_t i = 1; i < words.size(); ++i) o.logs.push_back(existing(words[i]).string());
  for (const std::string& file : words_of(given, "held-out")) o.held_out.push_back(existing(file).string());
  if (const auto file = text_of(given, "case")) o.case_file = existing(*file);
  o.mapped = given.count("map") > 0;
  if (const Words road = words_of(given, "track"); !road.empty() && !o.mapped) o.track = existing(road.front());
  o.out = text_of(given, "out").value_or(fs::path("out") / ("diagnose_" + fs::path(o.logs.front()).stem().string()));
  if (o.out.empty()) throw InputError("--out names no folder");
  o.force = given.count("force") > 0;
  return o;
}

/// Whether logs are of a real car: a logger's tables, or of a world without a road.
bool of_real_car(const DiagnoseOptions& options) {
  return options.mapped || (!options.track && !options.case_file && load_world(options.world).find("track") == nullptr);
}

int diagnose_logs(DiagnoseOptions options, const Registry& registry) {
  diagnose::CaseFile given;
  if (options.case_file) given = diagnose::read_case(*options.case_file);
  if (!options.track) options.track = given.track;
  const Node node = load_world(options.world, options.track);
  Errors errors;
  diagnose::read_uncertainty_of_world(node, given.options, errors);
  const WorldSpec world = read_world(node, registry, errors);
  errors.throw_if_any();
  diagnose::Diagnoser diagnoser(world, registry, given.options);
  const measured::LogExpectations expected{world.car.car.v_ref, &diagnoser.road(), world.car.car.delta_max};
  const auto read = [&](const Words& files) {
    std::vector<measured::LogFile> logs;
    for (const std::string& file : files) logs.push_back(measured::read_log_file(file, expected));
    return logs;
  };
  const std::vector<measured::LogFile> logs = read(options.logs), held_out = read(options.held_out);
  const OutLock lock = open_out_folder(options.out, "diagnosis", {.force = options.force});
  const diagnose::Diagnosis d = [&] {
    const StopSignal stop(StopSignal::Reaction::end, run_broke);
    CallbackProgress progress(std::cerr, "diagnose");
    diagnose::Diagnosis found = diagnoser.run(logs, held_out, progress.callback());
    progress.finish();
    return found;
  }();
  print(d);
  diagnose::write_diagnosis(options.out, d, diagnoser, world, options.world, options.track);
  std::string names;
  for (const std::string& file : options.logs)
    names += (names.empty() ? "" : ", ") + fs::path(file).filename().string();
  write_file(options.out / result_files::diagnosis_report,
             to_json_text(diagnose::report_data(d, diagnoser, names, options.world.filename().string(),
                                                diagnose::world_patch(d, diagnoser, world))));
  std::cout << "\ndiagnosis: " << (options.out / result_files::diagnosis).string()
            << "\nworld with what was found: " << (options.out / result_files::augmented_world).string() << '\n';
  if (!report_results(options.out)) return run_broke;
  const bool decided = d.verdict == diagnose::Verdict::named || d.verdict == diagnose::Verdict::nothing_missing;
  return decided ? good : claim_failed;
}

}  // namespace

int run_diagnose(Arguments args) {
  po::options_description visible("options");
  auto add = visible.add_options();
  add("held-out", po::value<Words>()->multitoken()->composing(), "logs to measure the gap on (default: the last laps)");
  add("case", po::value<std::string>(), "CASE.json: effects to exclude, standard deviations of nominal parameters");
  add("out", po::value<std::string>(), "folder for results (default: out/diagnose_<log>)");
  add("force", "replace another experiment's results in that folder");
  add("score", po::value<std::string>(), "a folder of cases with answers: diagnose all and print the scorecard");
  add_log_options(visible);
  add_plugins_option(visible);
  add("help,h", "this text");
  const auto given = parse_options(args, visible, "diagnose WORLD.json LOG.csv... [options]", files_word);
  if (!given) return good;
  const Registry registry = open_registry(plugin_dirs_of(*given));
  if (const auto cases = text_of(*given, "score")) {
    refuse_beside_score(*given);
    return score(*cases, text_of(*given, "out").value_or(fs::path("out") / "score"), registry);
  }
  const DiagnoseOptions options = read_options(*given);
  if (!of_real_car(options)) return diagnose_logs(options, registry);
  if (options.case_file)
    throw InputError("--case does not go with --map: a logger's table is judged by predictions, not by a case");
  const LogWorld world = read_log_world(options.world, *given, registry);
  const auto map = map_option(*given, world.spec);
  // A world of a real car seldom has a road of its own (--track gives one): this may be a simulated log.
  if (options.mapped && world.tree.find("track") != nullptr)
    std::cerr << "--map: taken for logs of a real car, whose verdict is always unknown; of a simulated one, gripline "
                 "import it and diagnose what that writes without --map\n";
  return diagnose_real({options.world.filename().string(), options.logs, options.held_out, options.out, options.force},
                       world, map, registry);
}

}  // namespace gripline::tools
