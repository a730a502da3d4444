// The components of framework/src and of plugins know each other as their READMEs say, and small trees with one fault
// each show that the check can fail.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "layers/layers.hpp"
#include "support/paths.hpp"

namespace gripline::layers {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;

using Files = std::map<std::string, std::string>;  // path from the root -> text

/// Two components, of which `race` knows `util`, with files changed or added.
std::vector<std::string> faults_with(const Files& changes) {
  Files files = {{"race/README.md", "# race\n\nMay know: util.\n"},
                 {"race/stack.hpp", "#include <vector>\n#include <gripline/abi.h>\n#include \"util/csv.hpp\"\n"},
                 {"race/stack.cpp", "#include \"race/stack.hpp\"\n"},
                 {"util/README.md", "# util\n\nMay know: nothing.\n"},
                 {"util/csv.hpp", "#include <string>\n"}};
  for (const auto& [name, text] : changes) files[name] = text;
  const fs::path root = fs::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
  fs::remove_all(root);
  for (const auto& [name, text] : files) {
    fs::create_directories((root / name).parent_path());
    std::ofstream(root / name) << text;
  }
  const std::vector<std::string> found = faults(root);
  fs::remove_all(root);
  return found;
}

TEST(Layers, ComponentsOfTheHostAreAsTheirReadmesSay) {
  for (const std::string& fault : faults(testing_support::source_dir() / "framework/src")) ADD_FAILURE() << fault;
}

TEST(Layers, ComponentsOfThePluginsAreAsTheirReadmesSay) {
  for (const std::string& fault : faults(testing_support::source_dir() / "plugins")) ADD_FAILURE() << fault;
}

TEST(Layers, GoodTreeHasNoFault) { EXPECT_THAT(faults_with({}), IsEmpty()); }

TEST(Layers, ForbiddenArrow) {
  EXPECT_THAT(faults_with({{"util/csv.hpp", "#include <string>\n#include \"race/stack.hpp\"\n"}}),
              ElementsAre("util/csv.hpp:2: component util may not know race (its README allows nothing)",
                          "circle: race/stack.hpp -> util/csv.hpp -> race/stack.hpp"));
}

TEST(Layers, KnowingAComponentIsNotKnowingTheComponentsInIt) {
  EXPECT_THAT(faults_with({{"util/text/README.md", "May know: nothing.\n"},
                           {"util/text/words.hpp", ""},
                           {"race/stack.cpp", "#include \"util/text/words.hpp\"\n"}}),
              ElementsAre("race/stack.cpp:1: component race may not know util/text (its README allows util)"));
}

TEST(Layers, CircleOfComponentsThatReadmesAllow) {
  EXPECT_THAT(faults_with({{"util/README.md", "May know: race.\n"}}), ElementsAre("circle: race -> util -> race"));
}

TEST(Layers, CircleOfFilesInOneComponent) {
  EXPECT_THAT(
      faults_with({{"util/csv.hpp", "#include \"util/row.hpp\"\n"}, {"util/row.hpp", "#include \"util/csv.hpp\"\n"}}),
      ElementsAre("circle: util/csv.hpp -> util/row.hpp -> util/csv.hpp"));
}

TEST(Layers, IncludeThatIsNotWrittenFromTheRoot) {
  EXPECT_THAT(
      faults_with({{"race/stack.cpp",
                    "#include \"stack.hpp\"\n#include \"../util/csv.hpp\"\n#include <util/csv.hpp>\n"
                    "#include \"gripline/abi.h\"\n#include \"util/absent.hpp\"\n"}}),
      ElementsAre(
          "race/stack.cpp:1: \"stack.hpp\" is not a file from the root of the tree; write \"race/stack.hpp\"",
          "race/stack.cpp:2: \"../util/csv.hpp\" is not a file from the root of the tree; write \"util/csv.hpp\"",
          "race/stack.cpp:3: <util/csv.hpp> is a file of this tree; write it in quotes",
          "race/stack.cpp:4: \"gripline/abi.h\" is not a file from the root of the tree; write <gripline/abi.h>",
          "race/stack.cpp:5: \"util/absent.hpp\" is not a file from the root of the tree"));
}

TEST(Layers, ReadmeMissingOrWithoutItsSentence) {
  EXPECT_THAT(faults_with({{"track/line.hpp", ""}, {"util/README.md", "# util\n"}}),
              ElementsAre("track/README.md: missing; each component says what it may know",
                          "util/README.md: no sentence of the form 'May know: config, util.' or 'May know: nothing.'"));
}

TEST(Layers, ReadmeTooLongOrWithAnUnknownComponent) {
  EXPECT_THAT(faults_with({{"race/README.md", "May know: utils,\nutil.\n" + std::string(14, '\n')}}),
              ElementsAre("race/README.md: 16 lines, at most 15", "race/README.md: there is no component 'utils'"));
}

TEST(Layers, FlatFileHasNoComponent) {
  EXPECT_THAT(faults_with({{"main.cpp", "#include \"util/csv.hpp\"\n"}}),
              ElementsAre("README.md: missing; each component says what it may know",
                          "main.cpp:1: component . may not know util (its README allows nothing)"));
}

}  // namespace
}  // namespace gripline::layers
