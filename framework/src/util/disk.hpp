// The system calls through which results are written, in one place, so that tests can simulate a loss of power.
#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

namespace gripline {

class Disk {
 public:
  virtual ~Disk() = default;
  /// Makes the file, or empties an existing one. Returns a handle, or -1 and errno.
  virtual int create(const std::filesystem::path& file);
  /// Makes a new file; a file or a symbolic link of this name is removed first.
  virtual int create_anew(const std::filesystem::path& file);
  /// Writes all bytes, or returns false with errno set.
  virtual bool write(int handle, std::string_view bytes);
  /// Waits until the file's bytes are on the disk; whether that succeeded.
  virtual bool sync(int handle);
  virtual void close(int handle);
  /// Renames `from` to `to`. An existing file is replaced, of folders only an empty one.
  virtual bool rename(const std::filesystem::path& from, const std::filesystem::path& to);
  /// Waits until the names of a folder's entries are on the disk; whether that succeeded.
  virtual bool sync_folder(const std::filesystem::path& folder);
  virtual bool make_folders(const std::filesystem::path& folder);
  virtual void remove_all(const std::filesystem::path& place);
};

/// The one in use.
Disk& disk();

/// The disk refused: it is full, broken, gone or may not be written to. Another try may succeed. A file that was closed
/// or taken away, or may not grow, is an error of another class: plugins can do that.
class DiskError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Throws std::runtime_error, "cannot write x.csv: No space left on device", with the reason that errno holds; a
/// DiskError where that is the disk's.
[[noreturn]] void fail_with_errno(const std::string& what);

/// Replaces the disk in use for as long as it lives.
class ScopedDisk {
 public:
  explicit ScopedDisk(Disk& other);
  ~ScopedDisk();
  ScopedDisk(const ScopedDisk&) = delete;
  ScopedDisk& operator=(const ScopedDisk&) = delete;

 private:
  Disk* before_;
};

}  // namespace gripline
