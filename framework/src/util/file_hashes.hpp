// SHA-256 of files, kept so that a file that nobody touched is read once.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "util/file_stamp.hpp"

namespace gripline {

class FileHashes {
 public:
  /// As the file was when it was first asked for, whatever became of it since. Throws InputError if it cannot be read.
  const std::string& of(const std::filesystem::path& file);
  /// As the file is: read again where its stamp is another, which of() and unchanged() then go by. Empty where it
  /// cannot be read.
  std::string now(const std::filesystem::path& file);
  /// Whether a file that was asked for has been left alone since.
  bool unchanged(const std::filesystem::path& file) const;

 private:
  struct Known {
    std::string hash;
    std::optional<FileStamp> stamp;
  };
  std::map<std::filesystem::path, Known> known_;
};

}  // namespace gripline
