#include "experiment/run_key.hpp"

#include <algorithm>
#include <span>

#include "config/hash.hpp"
#include "config/json_file.hpp"
#include "config/shipped.hpp"

namespace gripline {
namespace fs = std::filesystem;

std::string run_key(const RaceSpec& race, const RunId& id, FileHashes& hashes) {
  Node tree = race.run_tree(id.stack, id.seed);
  tree.erase("claim_share");  // judges results, does not change them
  std::string text = content_text(tree);
  text += "\n" + hashes.of(program_file()) + "\n";
  for (const fs::path& file : files_named(tree)) text += hashes.of(file);
  const auto stack =
      std::find_if(race.stacks.begin(), race.stacks.end(), [&](const auto& s) { return s.name == id.stack; });
  for (const fs::path& library : libraries_of(race.world, std::span(&*stack, 1)))
    text += library.filename().string() + hashes.of(library);
  return sha256_hex(text);
}

}  // namespace gripline
