// What a sweep consists of, and the manifest that says so before anything runs.
//
// Runs are numbered: experiment files in the order given, settings, rows (stacks of a race, cases of a diagnosis,
// estimators of a validation), seeds; the last changes fastest. A run's number is found from the manifest alone.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "plugin/registry.hpp"
#include "sweep/design.hpp"

namespace gripline::sweep {

/// Libraries of plugins: by file name the SHA-256 of each, as several folders may hold one of that name.
using Libraries = std::map<std::string, std::set<std::string>>;

/// One experiment file.
struct Part {
  std::filesystem::path file;  // absolute
  std::string name;            // of the file, without its ending
  std::string kind;            // "race", ...
  std::vector<std::string> rows;
  std::vector<std::uint64_t> seeds;
  std::size_t first = 0;  // number of its first run
};

/// What is asked for; files and folders as given.
struct Request {
  std::vector<std::filesystem::path> files;
  std::vector<std::string> assignments;  // in their order (assignments_of)
  Design design;
  std::optional<std::vector<std::uint64_t>> seeds;  // else the experiments' own
  std::string seeds_from;                           // as many seeds drawn from this text; empty: none
  std::vector<std::string> only;                    // rows; empty: all
  std::vector<std::string> plugin_dirs;
  double timeout_s = 0;       // of one run; 0: from its world
  std::size_t memory_mb = 0;  // of one run; 0: no limit
  bool keep_files = false;    // everything that a run writes, not its record alone
};

/// Number, place and seed of one run.
struct RunAt {
  std::size_t index = 0, part = 0, setting = 0, row = 0;
  std::uint64_t seed = 0;
};

struct Sweep {
  std::string name;
  std::filesystem::path folder;  // that relative files of assignments start from
  std::vector<Part> parts;
  std::vector<std::string> assignments;  // in their order (assignments_of)
  Design design;
  std::string seeds_from;
  std::vector<std::string> plugin_dirs;  // absolute
  double timeout_s = 0;
  std::size_t memory_mb = 0;
  bool keep_files = false;
  std::string version, program;  // of gripline, and the SHA-256 of the program that planned
  Libraries libraries;           // of the plugins in use
  std::string keys_sha256;       // of keys.txt; empty where it is not known

  std::size_t size() const;
  RunAt at(std::size_t index) const;
  const std::string& row_of(const RunAt& run) const { return parts[run.part].rows[run.row]; }
};

/// Reads every experiment, tries every value of every factor, and says what would run. Throws InputError with all
/// that is wrong, at the assignment that causes it; PluginError.
Sweep plan(const Request& request, const Registry& registry);

/// Makes the folder; throws InputError when it holds something that is no sweep.
void require_sweep_folder(const std::filesystem::path& out);

/// OUT/sweep.json, and OUT/keys.txt: the key of run i on line i, each 64 digits. Makes the folder. Throws
/// std::runtime_error when the disk refuses.
void write_manifest(const std::filesystem::path& out, const Sweep& sweep, const Registry& registry);
/// Throws InputError when OUT holds no sweep.
Sweep read_manifest(const std::filesystem::path& out);
bool holds_sweep(const std::filesystem::path& out);

/// Keys of a manifest, read where they are asked for.
class KeyFile {
 public:
  /// Throws InputError where OUT/keys.txt is not the one that this sweep's manifest was written with.
  KeyFile(const std::filesystem::path& out, const Sweep& sweep);
  std::size_t size() const { return size_; }
  std::string key(std::size_t index) const;

 private:
  struct OpenFile {
    explicit OpenFile(int opened) : handle(opened) {}
    ~OpenFile();
    OpenFile(const OpenFile&) = delete;
    OpenFile& operator=(const OpenFile&) = delete;
    int handle;
  };
  std::filesystem::path file_;
  OpenFile in_;  // closed also where the constructor refuses
  std::size_t size_ = 0;
};

/// Refuses (PluginError) a program or plugins other than those that planned: what a node has in places of its own must
/// be the same bytes.
void require_same_versions(const Sweep& sweep, const Registry& registry);

/// A JSON array of texts.
Node texts_node(std::span<const std::string> texts);

}  // namespace gripline::sweep
