#include "util/file_stamp.hpp"

#include <sys/stat.h>

namespace gripline {

std::optional<FileStamp> stamp_of(const std::filesystem::path& file) {
  struct stat found {};
  if (stat(file.c_str(), &found) != 0) return std::nullopt;
  return FileStamp{found.st_size, found.st_mtim.tv_sec, found.st_mtim.tv_nsec, found.st_ino};
}

}  // namespace gripline
