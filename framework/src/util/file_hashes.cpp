#include "util/file_hashes.hpp"

#include "config/errors.hpp"
#include "config/hash.hpp"

namespace gripline {
namespace fs = std::filesystem;

// A stamp is taken before its file is read: what is written meanwhile counts as a change.

const std::string& FileHashes::of(const fs::path& file) {
  auto known = known_.find(file);
  if (known == known_.end()) {
    const std::optional<FileStamp> stamp = stamp_of(file);
    known = known_.emplace(file, Known{sha256_of_file(file), stamp}).first;
  }
  return known->second.hash;
}

std::string FileHashes::now(const fs::path& file) {
  const std::optional<FileStamp> stamp = stamp_of(file);
  if (!stamp) return {};
  const auto known = known_.find(file);
  if (known != known_.end() && known->second.stamp == stamp) return known->second.hash;
  try {
    return (known_[file] = {sha256_of_file(file), stamp}).hash;
  } catch (const InputError&) {
    return {};
  }
}

bool FileHashes::unchanged(const fs::path& file) const {
  const auto known = known_.find(file);
  return known != known_.end() && known->second.stamp && known->second.stamp == stamp_of(file);
}

}  // namespace gripline
