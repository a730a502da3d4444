// What a sweep has finished so far, seen from outside.
#pragma once

#include <chrono>
#include <filesystem>
#include <thread>

namespace gripline::testing_support {

/// Records in the folder of a sweep; others may be writing there.
inline std::size_t records_in(const std::filesystem::path& out) {
  namespace fs = std::filesystem;
  std::size_t count = 0;
  std::error_code failed;
  for (auto at = fs::recursive_directory_iterator(out / "results", failed); at != fs::recursive_directory_iterator();
       at.increment(failed))
    count += at->path().extension() == ".json" ? 1 : 0;
  return count;
}

/// Whether there are `count` of them within a minute.
inline bool wait_for_records(const std::filesystem::path& out, std::size_t count) {
  for (int i = 0; i < 6000 && records_in(out) < count; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return records_in(out) >= count;
}

}  // namespace gripline::testing_support
