// Trees and keys of runs: what a run is, as JSON, and the hash that names it.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "config/node.hpp"
#include "plugin/registry.hpp"
#include "sweep/kinds.hpp"
#include "sweep/sweep.hpp"
#include "util/file_hashes.hpp"

namespace gripline::sweep {

/// Expanded trees, one setting at a time; runs should be asked for in their order.
class Trees {
 public:
  /// Reads every experiment file of the sweep, which must outlive this. Relative files of assignments start from the
  /// working folder. Throws InputError.
  explicit Trees(const Sweep& sweep);
  /// The experiment of a part in a setting, with all rows. Valid until the next call.
  const Node& setting(std::size_t part, std::size_t setting);
  /// The experiment of a run: its setting with these rows only, one seed, and without claims.
  Node run_tree(const RunAt& run, const std::vector<std::string>& rows);
  const SweptKind& kind(std::size_t part) const { return *kinds_[part]; }
  /// Members of the experiments that may differ between settings.
  const std::set<std::string>& changing() const { return changing_; }

 private:
  const Sweep& sweep_;
  std::size_t fixed_ = 0;  // assignments that are carried out once, before the first factor
  std::set<std::string> changing_;
  std::vector<Node> trees_;
  std::vector<Node> untouched_;  // the changing members of each, as they were before the first setting
  std::vector<const SweptKind*> kinds_;
  std::vector<std::size_t> at_;  // which setting each tree stands at
};

/// SHA-256 of a run's expanded JSON (its row merged with the base, no notes, no claims), the files it names and those
/// that they name or extend, the libraries of its plugins (of a diagnosis also of all effects, which it may find) and
/// the program: 64 hexadecimal digits. Paths and names of folders are no part of it. Runs of one setting cost one hash
/// each.
class Keys {
 public:
  Keys(const Sweep& sweep, const Registry& registry);
  std::string key(const RunAt& run);
  Trees& trees() { return trees_; }
  /// File names and SHA-256 of every library that the keys asked for so far include.
  const Libraries& libraries() const { return libraries_; }
  FileHashes& hashes() { return hashes_; }
  /// Whether the files that the keys asked for so far include are still those that were hashed. Libraries do not
  /// count: a process goes on with those that it has loaded.
  bool files_unchanged() const;

 private:
  /// A file's bytes and, of JSON, what it is with all it extends.
  struct NamedFile {
    std::string text;
    std::vector<std::filesystem::path> names;  // files that it names in turn
  };

  std::string part_text(const std::string& member, const Node& node);
  std::string node_text(const std::string& member, const Node& node);
  std::string effects_text();
  std::string library_text(const std::set<std::filesystem::path>& used);
  const NamedFile& named_file(const std::filesystem::path& file);
  void add_file(const std::filesystem::path& file, std::set<std::filesystem::path>& all);
  const std::string& common_text(std::size_t part, std::size_t setting);

  const Sweep& sweep_;
  Trees trees_;
  FileHashes hashes_;
  const Registry& registry_;
  Libraries libraries_;                                        // in use
  std::map<std::filesystem::path, NamedFile> files_;           // read so far
  std::multimap<std::string, const PluginEntry*> plugins_;     // by id, which several kinds may share
  std::vector<std::map<std::string, std::string>> unchanged_;  // texts of members that no setting changes
  std::string common_, row_;                                   // of the last run asked for
  std::size_t part_ = ~std::size_t{0}, setting_ = 0, row_index_ = ~std::size_t{0};
};

}  // namespace gripline::sweep
