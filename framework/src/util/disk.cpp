#include "util/disk.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

namespace gripline {
namespace {

Disk*& place() {
  static Disk system;
  static Disk* used = &system;
  return used;
}

/// File systems that cannot sync (some network ones, pipes) return EINVAL, ENOTSUP or EROFS: that is no failure.
bool done(int result) { return result == 0 || errno == EINVAL || errno == ENOTSUP || errno == EROFS; }

}  // namespace

int Disk::create(const std::filesystem::path& file) {
  return open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
}

int Disk::create_anew(const std::filesystem::path& file) {
  if (unlink(file.c_str()) != 0 && errno != ENOENT) return -1;
  return open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
}

bool Disk::write(int handle, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(handle, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

bool Disk::sync(int handle) { return done(fsync(handle)); }

void Disk::close(int handle) { ::close(handle); }

bool Disk::rename(const std::filesystem::path& from, const std::filesystem::path& to) {
  return std::rename(from.c_str(), to.c_str()) == 0;
}

bool Disk::sync_folder(const std::filesystem::path& folder) {
  const int handle = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (handle < 0) return errno == EACCES;  // writable but not readable: cannot be synced
  const bool good = done(fsync(handle));
  ::close(handle);
  return good;
}

bool Disk::make_folders(const std::filesystem::path& folder) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  errno = failed.value();
  return !failed;
}

void Disk::remove_all(const std::filesystem::path& where) {
  std::error_code ignored;
  std::filesystem::remove_all(where, ignored);
}

Disk& disk() { return *place(); }

void fail_with_errno(const std::string& what) {
  const int why = errno;
  const std::string text = what + ": " + std::strerror(why);
  for (const int of_disk : {ENOSPC, EDQUOT, EIO, EROFS, ESTALE})
    if (why == of_disk) throw DiskError(text);
  throw std::runtime_error(text);
}

ScopedDisk::ScopedDisk(Disk& other) : before_(std::exchange(place(), &other)) {}
ScopedDisk::~ScopedDisk() { place() = before_; }

}  // namespace gripline
