// The system's calls through which results are written, in one place: a test puts another disk here that loses power.
#pragma once

#include <filesystem>
#include <string_view>

namespace gripline {

class Disk {
 public:
  virtual ~Disk() = default;
  /// Makes the file, or empties the one that is there. Gives a handle, or -1 and errno.
  virtual int create(const std::filesystem::path& file);
  /// Makes a file where none is: what stood there under this name (a link is not followed) is removed first.
  virtual int create_anew(const std::filesystem::path& file);
  /// All bytes, or false and errno.
  virtual bool write(int handle, std::string_view bytes);
  /// Whether the file's bytes are on the disk now.
  virtual bool sync(int handle);
  virtual void close(int handle);
  /// Puts `from` in the place of `to`; folders only where nothing or an empty folder is.
  virtual bool rename(const std::filesystem::path& from, const std::filesystem::path& to);
  /// Whether the names in a folder are on the disk now.
  virtual bool sync_folder(const std::filesystem::path& folder);
  virtual bool make_folders(const std::filesystem::path& folder);
  virtual void remove_all(const std::filesystem::path& place);
};

/// The one in use.
Disk& disk();

/// Puts another one in use for as long as it lives.
class DiskInUse {
 public:
  explicit DiskInUse(Disk& other);
  ~DiskInUse();
  DiskInUse(const DiskInUse&) = delete;
  DiskInUse& operator=(const DiskInUse&) = delete;

 private:
  Disk* before_;
};

}  // namespace gripline
