// A folder for files that nobody keeps.
#pragma once

#include <filesystem>
#include <string>

namespace gripline {

/// A new folder in the system's place for temporary files, gone with all that is in it when this ends.
class TemporaryFolder {
 public:
  /// Makes a folder called gripline_<purpose>_ and six characters that no other folder has. Throws std::runtime_error
  /// with the system's reason.
  explicit TemporaryFolder(const std::string& purpose);
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace gripline
