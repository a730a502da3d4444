// tools/draw_road: a kind and a seed say everything of a road, and what it writes is one that a car can drive.
#include <gtest/gtest.h>

#include <string>

#include "support/paths.hpp"
#include "support/program.hpp"

namespace gripline {
namespace test_draw_road {

using namespace testing_support;

class DrawRoad : public testing::Test {
 protected:
  /// The text of the road, in a folder that is not there before.
  std::string draw(const std::string& kind, const std::string& seed, const std::string& into) {
    const std::filesystem::path file = folder_.path() / into / (kind + ".csv");
    const Outcome outcome = run_program({source_dir() / "tools/draw_road", kind, seed, file});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return contents(file);
  }
  Folder folder_;
};

TEST_F(DrawRoad, EveryKindIsARoadThatAFullSizeCarDrives) {
  for (const std::string kind : {"hairpins", "street", "narrow", "eight", "hills", "flowing", "fast"}) {
    ASSERT_FALSE(draw(kind, "3", "roads").empty()) << kind;
    const Outcome outcome = gripline_with({"track", folder_.path() / "roads" / (kind + ".csv"), "--bridges", "--car",
                                           source_dir() / "worlds/cars/full_size.json"});
    EXPECT_EQ(outcome.code, 0) << kind << outcome.err;
  }
}

TEST_F(DrawRoad, TheSameSeedDrawsTheSameRoadAndAnotherAnother) {
  const std::string one = draw("flowing", "7", "one");
  EXPECT_EQ(draw("flowing", "7", "again"), one);
  EXPECT_NE(draw("flowing", "8", "other"), one);
}

}  // namespace test_draw_road
}  // namespace gripline
