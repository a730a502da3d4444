// The results folder of an experiment: made, continued or refused, and locked while it is written.
#pragma once

#include <sys/types.h>

#include <exception>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "experiment/experiment.hpp"

namespace gripline {

/// One process at a time writes into a folder: an flock on OUT/.lock, released by the destructor or with the process.
/// The file says which it is: number and start of the process, and its machine.
/// Where its owner is left by an exception and a folder that this process made (made_folders.hpp) holds nothing but the
/// marker, the marker goes too, so that the folder can be removed.
class OutLock {
 public:
  /// Throws InputError when another process holds it. A file system that knows no locks is used without.
  explicit OutLock(const std::filesystem::path& folder);
  OutLock(OutLock&& other) noexcept
      : file_(std::move(other.file_)), handle_(std::exchange(other.handle_, -1)), exceptions_(other.exceptions_) {}
  /// The process of this machine that the lock of a folder names; none where it has ended, even if another process has
  /// its number now, and none where it is one of another machine.
  static std::optional<pid_t> holder_here(const std::filesystem::path& folder);
  /// For a fork of the process that locked: closes the inherited handle, so that the lock ends with the parent.
  static void leave_to_parent();
  OutLock(const OutLock&) = delete;
  OutLock& operator=(const OutLock&) = delete;
  ~OutLock();

 private:
  std::filesystem::path file_;
  int handle_ = -1;
  int exceptions_ = std::uncaught_exceptions();  // beyond these its owner is left by one
};

/// Whether a folder of results holds something of this name, whole or half written, besides the folders of its rows.
bool is_result_name(std::string_view name);

/// Two calls run the same experiment when these texts are equal: the experiment's tree without seeds and claims, which
/// say how many runs there are and what is asked of the result.
std::string experiment_identity(const Node& tree);

/// An experiment that somebody edits and runs again into the same folder.
struct EditedExperiment {
  const Node* tree = nullptr;            ///< kept in the folder, to say the next time what differs
  std::function<bool()> has_runs_there;  ///< whether any run in the folder is one of this experiment as it is now
  std::vector<std::string> changes;      ///< what differs from the experiment that the folder held (tree_diff.hpp)
};

struct OutFolderOptions {
  bool force = false;                  ///< removes all that gripline made there; everything else stays
  EditedExperiment* edited = nullptr;  ///< of an experiment whose finished runs are kept; null for others
};

/// Makes OUT ready for an experiment with this identity. A folder that is not empty is refused (InputError) unless it
/// holds the same experiment, also before it was edited (finished runs are then kept), or `force` is set. A folder that
/// gripline did not make is always refused.
OutLock open_out_folder(const std::filesystem::path& out, const std::string& identity,
                        const OutFolderOptions& options = {});

/// What the report needs to know once per experiment: scene.json, track.csv, provenance.json.
void write_scene(const std::filesystem::path& out, const RaceSpec& race, const Registry& registry);
/// write_scene() for experiments that are not a race: only scene.json, with the name, the kind and the note of `tree`.
void write_scene(const std::filesystem::path& out, const std::string& name, const std::string& kind, const Node& tree);

}  // namespace gripline
