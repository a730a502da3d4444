#include "config/tree_diff.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/host_support.hpp"

namespace gripline {
namespace test_tree_diff {

using namespace testing_support;
using testing::ElementsAre;
using testing::IsEmpty;

TEST(TreeDiff, NamesWhatIsNewGoneAndOther) {
  const Node before =
      json(R"({"note": "x", "seeds": {"count": 2}, "stacks": {"a": {"mu": 0.3, "k": [1, 2]}, "c": {}}})");
  const Node after =
      json(R"({"note": "y", "seeds": {"count": 3}, "stacks": {"a": {"mu": "wet", "k": [1, 4]}, "b": {}}, "laps": 2})");
  EXPECT_THAT(differences(before, after),
              ElementsAre("/seeds/count: 2 -> 3", "/stacks/a/mu: 0.3 -> \"wet\"", "/stacks/a/k/1: 2 -> 4",
                          "/stacks/b: new", "/stacks/c: gone", "/laps: new, 2"));
}

TEST(TreeDiff, NotesNullsAndTheOrderOfMembersAreNoDifference) {
  EXPECT_THAT(differences(json(R"({"a": 1, "b": null, "note": "x"})"), json(R"({"note": "y", "c": null, "a": 1})")),
              IsEmpty());
}

TEST(TreeDiff, ArraysOfOtherLengthsAreToldWhole) {
  EXPECT_THAT(differences(json(R"({"k": [1]})"), json(R"({"k": [1, 2]})")), ElementsAre("/k: [1] -> [1,2]"));
}

}  // namespace test_tree_diff
}  // namespace gripline
