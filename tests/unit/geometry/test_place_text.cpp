#include "geometry/place_text.hpp"

#include <gtest/gtest.h>

namespace gripline {
namespace test_place_text {

TEST(PlaceText, WhatIsZeroButForRoundingIsZero) {
  EXPECT_EQ(place_text(79.78, -2.086e-49), "(79.78, 0)");
  EXPECT_EQ(place_text(-1e-17, 3e-13), "(0, 0)");
  EXPECT_EQ(place_text(3e-3, 5e6), "(0, 5e+06)") << "a millimetre beside thousands of kilometres";
}

TEST(PlaceText, SmallPlacesAreWritten) {
  EXPECT_EQ(place_text(0.0123456, -0.002), "(0.01235, -0.002)");
  EXPECT_EQ(place_text(1234.5678, 0.01, 6), "(1234.57, 0.01)");
}

}  // namespace test_place_text
}  // namespace gripline
