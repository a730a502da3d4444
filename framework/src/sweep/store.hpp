// Records of finished runs, found by their keys: whole or absent, whoever writes them and however often.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace gripline::sweep {

using Values = std::vector<std::pair<std::string, double>>;

/// What is kept of a run.
struct Record {
  std::string key;
  std::string status;   // as in runs.csv of a race; "done" of other kinds; "error" and "plugin_error" broke
  std::string message;  // why
  Values values;        // the same at every repetition
  Values times;         // not the same: CPU time and the like
  std::string node;     // the machine
  std::string drive;    // hash of what a race did: two that have the same are equal to the last bit; empty: not known
  bool broken() const { return status == "error" || status == "plugin_error"; }
};

/// OUT/results/<first two digits of the key>/<key>.json, <key>.broken.json of runs that broke, and <key>.missing.txt of
/// runs that were tried and are to be had by another try.
class Store {
 public:
  explicit Store(const std::filesystem::path& out) : results_(out / "results") {}
  /// Whether the run is there: finished, or broken when `broken_counts`.
  bool has(const std::string& key, bool broken_counts) const;
  /// A finished record before a broken one. One that is not as it was written is removed and counts as absent.
  std::optional<Record> read(const std::string& key) const;
  /// Written aside under a name of this process's own, synced, then renamed: two that write the same run do no harm.
  /// Throws std::runtime_error.
  void write(const Record& record) const;
  /// Why a run has no record, for missing.csv, until it has one. A note that cannot be written is no loss.
  void note_missing(const std::string& key, const std::string& why) const;
  /// Empty where nobody knows.
  std::string why_missing(const std::string& key) const;
  /// What processes that were killed left half written.
  void remove_partial() const;

 private:
  std::filesystem::path place(const std::string& key, bool broken) const;
  std::filesystem::path note_of(const std::string& key) const;
  std::filesystem::path results_;
};

}  // namespace gripline::sweep
