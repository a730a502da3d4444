// The name of a run: a hash of everything that its results depend on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "experiment/experiment.hpp"
#include "util/file_stamp.hpp"

namespace gripline {

struct RunId {
  std::string stack;
  std::uint64_t seed;
};

/// SHA-256 of files, each read once.
class FileHashes {
 public:
  const std::string& of(const std::filesystem::path& file);
  /// Whether a file that of() was asked for has been left alone since.
  bool unchanged(const std::filesystem::path& file) const;

 private:
  struct Known {
    std::string hash;
    std::optional<FileStamp> stamp;
  };
  std::map<std::filesystem::path, Known> known_;
};

/// SHA-256 over the run's expanded JSON, the files that it names, the libraries of its plugins and the running program.
std::string run_key(const RaceSpec& race, const RunId& id, FileHashes& hashes);

}  // namespace gripline
