#include "util/whole_file.hpp"

#include <cerrno>
#include <utility>

#include "util/disk.hpp"

namespace gripline {
namespace fs = std::filesystem;
namespace {

/// The file that a chain of symbolic links names, whether it exists or not.
fs::path link_target(fs::path file) {
  constexpr int most_links = 40;  // the limit of Linux
  std::error_code failed;
  for (int i = 0; i < most_links && fs::is_symlink(file, failed); ++i) {
    const fs::path next = fs::read_symlink(file, failed);
    if (failed) break;
    file = next.is_absolute() ? next : file.parent_path() / next;
  }
  return file;
}

}  // namespace

WholeFile::WholeFile(const fs::path& file) : file_(file), place_(link_target(file)) {
  std::error_code failed;
  const fs::file_status status = fs::status(place_, failed);
  // Renaming a temporary file would replace a device, a pipe or a socket.
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    handle_ = disk().create(place_);
  } else {
    aside_ = place_;
    aside_ += ".partial";
    handle_ = disk().create_anew(aside_);
  }
  if (handle_ < 0) fail();
}

WholeFile::~WholeFile() {
  if (handle_ < 0) return;
  disk().close(handle_);
  std::error_code ignored;
  if (!aside_.empty()) fs::remove(aside_, ignored);
}

void WholeFile::write(std::string_view text) {
  if (!disk().write(handle_, text)) fail();
}

void WholeFile::finish() {
  const bool safe = aside_.empty() || disk().sync(handle_);
  const int why = errno;
  disk().close(std::exchange(handle_, -1));
  errno = why;
  if (aside_.empty()) return;
  if (!safe || !disk().rename(aside_, place_)) {
    const int reason = errno;
    std::error_code ignored;
    fs::remove(aside_, ignored);
    errno = reason;
    fail();
  }
  if (!disk().sync_folder(place_.parent_path())) fail();
}

void WholeFile::fail() const { fail_with_errno("cannot write " + file_.string()); }

void write_file(const fs::path& file, std::string_view text) {
  WholeFile whole(file);
  whole.write(text);
  whole.finish();
}

}  // namespace gripline
