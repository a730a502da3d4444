#include "report/inputs.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <utility>

#include "config/errors.hpp"
#include "config/json_file.hpp"
#include "util/statistics.hpp"

namespace gripline::report {
namespace {

namespace fs = std::filesystem;

/// Brackets within brackets, at most; those inside texts do not count.
int nesting(std::string_view json) {
  int depth = 0, deepest = 0;
  bool inside = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (inside && c == '\\') ++i;
    if (c == '"') inside = !inside;
    if (inside) continue;
    if (c == '[' || c == '{') deepest = std::max(deepest, ++depth);
    if (c == ']' || c == '}') --depth;
  }
  return deepest;
}

std::string text_or(const nlohmann::json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

/// A cell of a table that is the name of a folder beside it.
void require_folder_name(const fs::path& table, std::size_t row, const std::string& name) {
  constexpr std::size_t longest = 255;  // of Linux's file systems
  const bool plain = name.find('/') == name.npos && name.find('\0') == name.npos && name != "." && name != "..";
  if (!plain || name.size() > longest)
    throw InputError(table.string() + ": row " + std::to_string(row + 1) + ": " + Node(name).describe() +
                     " is not a folder's name; the table was edited, compare writes it again");
}

std::vector<fs::path> folders_in(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code failed;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, failed))
    // Hidden ones are runs that were cut short.
    if (entry.is_directory(failed) && !entry.path().filename().string().starts_with(".")) found.push_back(entry.path());
  std::sort(found.begin(), found.end());
  return found;
}

/// The runs of runs.csv; without one, every <stack>/<seed>/ that holds steps.csv.
std::vector<RunName> find_runs(const Inputs& inputs) {
  std::vector<RunName> runs;
  const Columns& table = inputs.runs_table;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    runs.push_back({table.text("stack", i), table.text("seed", i), table.text("status", i), ""});
    for (const std::string* name : {&runs.back().stack, &runs.back().seed})
      require_folder_name(inputs.folder / "runs.csv", i, *name);
  }
  // The drives beside a diagnosis are what it was made from, not a race.
  if (!runs.empty() || !inputs.diagnoses.empty() || !inputs.diagnosis.is_null()) return runs;
  // Folders with drives may stand anywhere; those of one race stand beside what compare and run say of it first.
  if (inputs.scene.is_null()) return runs;
  for (const fs::path& stack : folders_in(inputs.folder))
    for (const fs::path& seed : folders_in(stack))
      if (std::error_code failed; fs::exists(seed / "steps.csv", failed))
        runs.push_back({stack.filename().string(), seed.filename().string(), "", ""});
  return runs;
}

std::vector<StackEntry> find_stacks(const Inputs& inputs) {
  std::vector<StackEntry> stacks;
  std::set<std::string, std::less<>> known;
  const auto add = [&](const std::string& name, bool truth) {
    if (known.insert(name).second) stacks.push_back({name, truth});
  };
  for (const Columns* table : {&inputs.table, &inputs.runs_table})
    for (std::size_t i = 0; i < table->rows(); ++i) add(table->text("stack", i), table->number("needs_truth", i) == 1);
  const nlohmann::json told =
      inputs.scene.is_object() ? inputs.scene.value("told", nlohmann::json()) : nlohmann::json();
  for (const RunName& run : inputs.runs) add(run.stack, std::find(told.begin(), told.end(), run.stack) != told.end());
  return stacks;
}

std::vector<double> sorted_numbers(std::span<const double> values) {
  std::vector<double> sorted;
  std::copy_if(values.begin(), values.end(), std::back_inserter(sorted), [](double v) { return std::isfinite(v); });
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

}  // namespace

nlohmann::json read_json(const fs::path& file) {
  const std::string text = read_whole_file(file);
  if (text.empty()) return nullptr;
  // nlohmann writes trees by recursion: deep nesting would overflow the stack.
  if (nesting(text) > max_depth)
    throw InputError(file.string() + ": nested deeper than " + std::to_string(max_depth) + " levels");
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::exception&) {
    (void)parse_file(file);  // says the same with line and column
    throw InputError(file.string() + ": is not JSON; the results were cut short or edited, race them again");
  }
}

Inputs read_inputs(const fs::path& folder) {
  std::error_code failed;
  if (!fs::is_directory(folder, failed))
    throw InputError(folder.string() + ": no such folder; expected the results of compare, run or diagnose");
  Inputs in;
  in.folder = folder;
  in.scene = read_json(folder / "scene.json");
  in.claims = read_json(folder / "claims.json");
  in.diagnosis = read_json(folder / "diagnosis.json");
  in.diagnosis_report = read_json(folder / "diagnosis_report.json");
  in.augmented_world = read_json(folder / "augmented_world.json");
  in.provenance = read_json(folder / "provenance.json");
  in.measured = read_json(folder / "measured.json");
  in.runs_table = Columns::read(folder / "runs.csv", true);
  in.table = Columns::read(folder / "table.csv", true);
  in.pairs = Columns::read(folder / "pairs.csv", true);
  in.track = Columns::read(folder / "track.csv");
  in.validation = Columns::read(folder / "validation.csv", true);
  in.validation_traces = Columns::read(folder / "validation_traces.csv", true);
  in.diagnoses = Columns::read(folder / "diagnoses.csv", true);
  for (std::size_t i = 0; i < in.diagnoses.rows(); ++i)
    require_folder_name(folder / "diagnoses.csv", i, in.diagnoses.text("case", i));
  in.runs = find_runs(in);
  for (const RunName& run : in.runs)
    if (in.line.empty()) in.line = Columns::read(folder / run.stack / run.seed / "line.csv");
  for (RunName& run : in.runs) {
    if (run.status == "finished") continue;
    const nlohmann::json summary = read_json(folder / run.stack / run.seed / "summary.json");
    if (!summary.is_object()) continue;
    if (run.status.empty()) run.status = text_or(summary, "status");
    run.message = text_or(summary, "message");
  }
  in.stacks = find_stacks(in);
  if (in.runs.empty() && in.validation.empty() && in.diagnosis.is_null() && in.diagnoses.empty() &&
      !in.measured.is_object())
    throw InputError(folder.string() +
                     ": nothing to report; expected the folder that compare, run, sweep or diagnose wrote: runs.csv, "
                     "scene.json with <stack>/<seed>/steps.csv, validation.csv, diagnosis.json, measured.json or "
                     "sweep_report.json");
  return in;
}

std::string sentence_of(const fs::path& folder) {
  const nlohmann::json told = read_json(folder / "diagnosis_report.json");
  return told.is_object() ? text_or(told, "sentence") : std::string();
}

Run read_run(const Inputs& inputs, const RunName& name) {
  const fs::path folder = inputs.folder / name.stack / name.seed;
  return {Columns::read(folder / "steps.csv"), Columns::read(folder / "replay.csv"),
          Columns::read(folder / "tyres.csv", true), Columns::read(folder / "timing.csv")};
}

double median_of_numbers(std::span<const double> values) { return median(sorted_numbers(values)); }

}  // namespace gripline::report
