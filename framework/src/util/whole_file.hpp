// Files that are there whole or as they were before.
#pragma once

#include <filesystem>
#include <string_view>

namespace gripline {

/// A file that is written piece by piece beside its place; finish() syncs it to the disk and renames it, so that the
/// file is complete or unchanged, even after a power failure. If it is a symbolic link, the file it names is replaced;
/// a device or a pipe is written to directly. Of one that is not finished nothing is left. All throw as
/// fail_with_errno() does.
class WholeFile {
 public:
  explicit WholeFile(const std::filesystem::path& file);
  ~WholeFile();
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;
  void write(std::string_view text);
  void finish();

 private:
  [[noreturn]] void fail() const;
  std::filesystem::path file_, place_;
  std::filesystem::path aside_;  // empty: it is written to directly
  int handle_ = -1;
};

/// A file that is written at once.
void write_file(const std::filesystem::path& file, std::string_view text);

}  // namespace gripline
