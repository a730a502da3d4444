#include "exports/runs.hpp"

#include <algorithm>

#include "config/errors.hpp"
#include "report/inputs.hpp"

namespace gripline::exports {
namespace {

bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Every name asked for must be there.
void require_known(const char* what, const std::vector<std::string>& asked, const std::vector<std::string>& known) {
  for (const std::string& name : asked)
    if (!has(known, name)) {
      std::string text = "the results have no ";
      text.append(what).append(" \"").append(name).append("\"").append(did_you_mean(name, known));
      throw InputError(text);
    }
}

}  // namespace

Results read_results(const std::filesystem::path& folder, const RunFilter& filter) {
  const report::Inputs inputs = report::read_inputs(folder);
  std::vector<std::string> stacks, seeds;
  for (const report::RunName& run : inputs.runs) {
    if (!has(stacks, run.stack)) stacks.push_back(run.stack);
    if (!has(seeds, run.seed)) seeds.push_back(run.seed);
  }
  require_known("row", filter.stacks, stacks);
  require_known("seed", filter.seeds, seeds);
  Results results;
  results.scene = inputs.scene;
  results.track = inputs.track;
  const bool name_seeds = filter.seeds.size() > 1;
  std::vector<std::string> taken;
  for (const report::RunName& run : inputs.runs) {
    if (!filter.stacks.empty() && !has(filter.stacks, run.stack)) continue;
    if (filter.seeds.empty() ? has(taken, run.stack) : !has(filter.seeds, run.seed)) continue;
    report::Columns steps = report::Columns::read(folder / run.stack / run.seed / "steps.csv");
    if (steps.empty()) continue;  // it was never begun
    taken.push_back(run.stack);
    std::string name = run.stack;
    if (name_seeds) name.append("/").append(run.seed);
    results.runs.push_back({std::move(name), std::move(steps)});
  }
  if (results.runs.empty())
    throw InputError(folder.string() + ": no run left a log (steps.csv) that could be exported");
  return results;
}

}  // namespace gripline::exports
