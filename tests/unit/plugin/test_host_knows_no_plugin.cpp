// The host works with plugins that nobody has written yet: it names none of those that come with it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "support/host_support.hpp"

namespace gripline {
namespace {

using testing::IsEmpty;
using namespace testing_support;
namespace fs = std::filesystem;

/// Ids that are also words of file formats, by the folder whose code may hold them: keys of a track, what people write
/// for null in JSON, what a case's answer says when nothing is hidden.
struct FormatWord {
  const char* id;
  const char* folder;
};
constexpr FormatWord format_words[] = {{"grade", "framework/src/geometry"},
                                       {"bank", "framework/src/geometry"},
                                       {"none", "framework/src/config"},
                                       {"none", "framework/src/diagnose"}};

std::string without_comment(const std::string& line) {
  const std::size_t at = line.find("//");
  return at != std::string::npos && line.find_first_not_of(' ') == at ? "" : line;
}

/// Every place in the sources below a folder of the repository where an id stands as a text of its own.
std::vector<std::string> ids_in(const std::string& folder, const std::vector<std::string>& ids) {
  std::vector<std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(source_dir() / folder)) {
    if (entry.path().extension() != ".cpp" && entry.path().extension() != ".hpp") continue;
    const std::string file = fs::relative(entry.path(), source_dir()).string();
    const std::vector<std::string> text = lines(entry.path());
    for (std::size_t i = 0; i < text.size(); ++i)
      for (const std::string& id : ids) {
        if (without_comment(text[i]).find('"' + id + '"') == std::string::npos) continue;
        const bool is_format_word =
            std::any_of(std::begin(format_words), std::end(format_words),
                        [&](const auto& word) { return id == word.id && file.starts_with(word.folder); });
        if (!is_format_word) found.push_back(file + ":" + std::to_string(i + 1) + ": " + id);
      }
  }
  return found;
}

std::vector<std::string> shipped_ids() {
  const Registry registry({plugin_dir()});
  std::vector<std::string> ids;
  for (const PluginEntry& entry : registry.entries()) ids.emplace_back(entry.decl->id);
  return ids;
}

TEST(Host, NamesNoPluginThatComesWithIt) {
  const std::vector<std::string> ids = shipped_ids();
  ASSERT_GT(ids.size(), 40u);
  for (const char* folder : {"framework/src", "tools/gripline", "tools/cli"})
    EXPECT_THAT(ids_in(folder, ids), IsEmpty()) << "in " << folder;
}

/// The search finds what it looks for: the benchmark, a program of its own, names what it compares.
TEST(Host, TheSearchFindsTheIdsOfTheBenchmark) {
  EXPECT_THAT(ids_in("tools/bench", {"mpc_ipopt"}), testing::Not(IsEmpty()));
}

}  // namespace
}  // namespace gripline
