// Whether a file is still the one it was, without reading it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

namespace gripline {

/// Size, time of the last change and place on the disk: a file that is written to or replaced has another.
struct FileStamp {
  std::int64_t size = 0, seconds = 0, nanoseconds = 0;
  std::uint64_t node = 0;
  bool operator==(const FileStamp&) const = default;
};

/// None where there is no such file.
std::optional<FileStamp> stamp_of(const std::filesystem::path& file);

}  // namespace gripline
