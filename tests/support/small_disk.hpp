// Disks that are full or broken.
#pragma once

#include <algorithm>
#include <cerrno>

#include "util/disk.hpp"

namespace gripline::testing_support {

/// A disk that has no room for more than so many bytes, and may not know how to sync.
class SmallDisk final : public Disk {
 public:
  explicit SmallDisk(std::size_t room) : room_(room) {}
  bool write(int handle, std::string_view bytes) override {
    const std::size_t fits = std::min(bytes.size(), room_);
    room_ -= fits;
    if (Disk::write(handle, bytes.substr(0, fits)) && fits == bytes.size()) return true;
    errno = ENOSPC;
    return false;
  }
  bool sync(int) override {
    errno = EIO;
    return room_ > 0;
  }

 private:
  std::size_t room_;
};

/// A disk that makes no file of this name.
class DiskWithout final : public Disk {
 public:
  explicit DiskWithout(std::string name) : name_(std::move(name)) {}
  int create(const std::filesystem::path& file) override {
    if (file.filename() != name_) return Disk::create(file);
    errno = ENOSPC;
    return -1;
  }

 private:
  std::string name_;
};

}  // namespace gripline::testing_support
