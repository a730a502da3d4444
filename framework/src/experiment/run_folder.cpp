#include "experiment/run_folder.hpp"

#include "util/disk.hpp"

namespace gripline {
namespace fs = std::filesystem;
namespace {

void replace_folder(const fs::path& partial, const fs::path& folder) {
  disk().remove_all(folder);
  if (!disk().rename(partial, folder)) fail_with_errno("cannot write " + folder.string());
}

}  // namespace

fs::path run_folder(const fs::path& out, const RunId& id) { return out / id.stack / std::to_string(id.seed); }

fs::path partial_folder(const fs::path& out, const RunId& id) {
  return out / id.stack / ("." + std::to_string(id.seed) + ".partial");
}

std::string broken_key(const std::string& key) { return "broken " + key; }

void keep_run(const RunSummary& summary, const std::string& key, const fs::path& out, MachineUse use) {
  const RunId id = {summary.stack, summary.seed};
  const fs::path partial = partial_folder(out, id), folder = run_folder(out, id);
  write_summary(partial, summary, key, use == MachineUse::exclusive);
  if (!disk().sync_folder(partial)) fail_with_errno("cannot write " + partial.string());
  replace_folder(partial, folder);
  (void)disk().sync_folder(folder.parent_path());  // if the rename is lost by a power failure, the run is raced again
}

void keep_copied_run(const RunResult& driven, std::uint64_t seed, const std::string& key, const fs::path& out) {
  const RunId id = {driven.summary.stack, seed};
  const fs::path partial = partial_folder(out, id), folder = run_folder(out, id);
  disk().remove_all(partial);
  disk().make_folders(partial);
  write_copied_summary(partial, driven, seed, key);
  replace_folder(partial, folder);
}

void keep_broken_run(const RaceSpec& race, const RunId& id, const fs::path& out, const std::string& key,
                     const std::string& why) {
  disk().make_folders(partial_folder(out, id));
  RunSummary summary;
  summary.stack = id.stack;
  summary.seed = id.seed;
  summary.status = Status::error;
  summary.message = why;
  for (const StackSpec& stack : race.stacks)
    if (stack.name == id.stack) summary.needs_truth = stack.needs_truth();
  keep_run(summary, broken_key(key), out);
}

}  // namespace gripline
