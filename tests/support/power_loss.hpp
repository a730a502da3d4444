// A disk that records all calls and computes what would be left if the power had failed after any of them.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "util/disk.hpp"

namespace gripline::testing_support {

/// What survives of data that was not synced. File systems differ: each of these is the behaviour of one.
enum class Survives {
  everything,  ///< the process died, not the machine
  names,       ///< renames come through at once, the bytes of files that were not synced never do
  synced       ///< a rename comes through when its folder was synced, bytes when their file was
};

/// Does everything on the real disk, and remembers it.
class RecordingDisk final : public Disk {
 public:
  explicit RecordingDisk(std::filesystem::path root) : root_(std::move(root)) {}

  int create(const std::filesystem::path& file) override { return made(Disk::create(file), file); }
  int create_anew(const std::filesystem::path& file) override { return made(Disk::create_anew(file), file); }
  bool write(int handle, std::string_view bytes) override {
    calls_.push_back({Call::write, handle_ids_.at(handle), std::string(bytes), {}, {}});
    return Disk::write(handle, bytes);
  }
  bool sync(int handle) override {
    calls_.push_back({Call::sync, handle_ids_.at(handle), {}, {}, {}});
    return true;  // the machine of the test keeps its power
  }
  bool rename(const std::filesystem::path& from, const std::filesystem::path& to) override {
    calls_.push_back({Call::rename, 0, {}, below_root(from), below_root(to)});
    return Disk::rename(from, to);
  }
  bool sync_folder(const std::filesystem::path& folder) override {
    calls_.push_back({Call::sync_folder, 0, {}, below_root(folder), {}});
    return true;
  }
  bool make_folders(const std::filesystem::path& folder) override {
    calls_.push_back({Call::make_folders, 0, {}, below_root(folder), {}});
    return Disk::make_folders(folder);
  }
  void remove_all(const std::filesystem::path& place) override {
    calls_.push_back({Call::remove, 0, {}, below_root(place), {}});
    Disk::remove_all(place);
  }

  std::size_t calls() const { return calls_.size(); }

  using Files = std::map<std::string, std::string>;  // bytes, by their names seen from the root

  /// What would be left after the first `count` calls and a failure of the power.
  Files left_after(std::size_t count, Survives survives) const {
    Files files;
    for (const auto& [name, file] : state_after(count, survives))
      files[name] = survives == Survives::everything ? file->bytes : file->safe;
    return files;
  }
  /// What differs of all that would be left after any number of calls from `first` on.
  std::set<Files> all_left(std::size_t first, Survives survives) const {
    std::set<Files> all;
    for (std::size_t count = first; count <= calls_.size(); ++count) all.insert(left_after(count, survives));
    return all;
  }

 private:
  struct Call {
    enum Kind { create, write, sync, rename, sync_folder, make_folders, remove } kind;
    int file;
    std::string bytes;
    std::string from, to;  // seen from the root
  };
  struct File {
    std::string bytes, safe;
  };
  using Names = std::map<std::string, std::shared_ptr<File>>;  // of files, seen from the root

  int made(int handle, const std::filesystem::path& file) {
    if (handle < 0) return handle;
    handle_ids_[handle] = ++last_id_;
    calls_.push_back({Call::create, last_id_, {}, below_root(file), {}});
    return handle;
  }
  std::string below_root(const std::filesystem::path& place) const {
    return place.lexically_relative(root_).generic_string();
  }
  static void move(Names& names, const std::string& from, const std::string& to) {
    Names moved;
    for (auto at = names.begin(); at != names.end();) {
      const bool inside = at->first == from || at->first.starts_with(from + "/");
      if (inside) moved[to + at->first.substr(from.size())] = at->second;
      at = inside ? names.erase(at) : std::next(at);
    }
    for (auto& [name, file] : moved) names[name] = file;
  }
  static void erase(Names& names, const std::string& place) {
    std::erase_if(names, [&](const auto& one) { return one.first == place || one.first.starts_with(place + "/"); });
  }

  Names state_after(std::size_t count, Survives survives) const {
    Names names;
    std::map<int, std::shared_ptr<File>> files;
    std::vector<std::pair<std::string, std::string>> pending;  // renames whose folder was not synced
    const auto place_now = [&](std::string name) {             // where a name of the program stands on the disk
      for (auto at = pending.rbegin(); at != pending.rend(); ++at)
        if (name == at->second || name.starts_with(at->second + "/")) name = at->first + name.substr(at->second.size());
      return name;
    };
    for (std::size_t i = 0; i < count; ++i) {
      const Call& call = calls_[i];
      switch (call.kind) {
        case Call::create:
          names[place_now(call.from)] = files[call.file] = std::make_shared<File>();
          break;
        case Call::write:
          files.at(call.file)->bytes += call.bytes;
          break;
        case Call::sync:
          files.at(call.file)->safe = files.at(call.file)->bytes;
          break;
        case Call::rename:
          if (survives == Survives::synced)
            pending.emplace_back(call.from, call.to);
          else
            move(names, call.from, call.to);
          break;
        case Call::sync_folder:
          for (auto at = pending.begin(); at != pending.end();) {
            const bool here = folder_of(at->second) == (call.from == "." ? "" : call.from);
            if (here) move(names, at->first, at->second);
            at = here ? pending.erase(at) : std::next(at);
          }
          break;
        case Call::make_folders:
          break;
        case Call::remove:
          erase(names, place_now(call.from));
          break;
      }
    }
    return names;
  }
  static std::string folder_of(const std::string& name) {
    const std::size_t slash = name.rfind('/');
    return slash == std::string::npos ? "" : name.substr(0, slash);
  }

  std::filesystem::path root_;
  std::vector<Call> calls_;
  std::map<int, int> handle_ids_;
  int last_id_ = 0;
};

}  // namespace gripline::testing_support
