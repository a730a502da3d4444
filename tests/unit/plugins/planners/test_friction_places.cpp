#include "planners/time_optimal/friction_places.hpp"

#include <gtest/gtest.h>

#include <cstddef>

namespace gripline {
namespace {

using time_optimal::FrictionPlaces;

/// A car that goes round a road of 200 pieces, two a step, and believes what it is told with a delay of two steps.
class FrictionPlacesTest : public ::testing::Test {
 protected:
  template <class Friction>
  void laps(int count, const Friction& friction) {
    for (int i = 0; i < 100 * count; ++i) {
      delayed_[1] = delayed_[0];
      delayed_[0] = friction(piece_);
      piece_ = (piece_ + 2) % 200;
      changes_ += places_.step(piece_, delayed_[1], spread_);
    }
  }
  struct Believed {
    double mu, spread;
  };
  /// A lap in which the belief, with its spread, is that of a piece at once.
  template <class Belief>
  void lap_of(const Belief& belief) {
    for (int i = 0; i < 100; ++i) {
      piece_ = (piece_ + 2) % 200;
      const Believed here = belief(piece_);
      changes_ += places_.step(piece_, here.mu, here.spread);
    }
  }
  static double wet(std::size_t piece) { return piece >= 60 && piece < 100 ? 0.6 : 0.9; }
  static double dry(std::size_t /*piece*/) { return 0.9; }

  FrictionPlaces places_{200, 0.02};
  std::size_t piece_ = 0;
  double delayed_[2] = {0.9, 0.9}, spread_ = 0;
  int changes_ = 0;
};

TEST_F(FrictionPlacesTest, APlaceMetOnceIsKnownOnTheNextLap) {
  laps(1, dry);
  laps(1, wet);
  EXPECT_NEAR(places_.grip(80), 0.6 / 0.9, 0.02);
  EXPECT_LT(places_.grip(60), 1.0);  // where it begins, not where that was noticed
  for (const std::size_t piece : {40, 104, 150}) EXPECT_EQ(places_.grip(piece), 1.0) << piece;
  for (int i = 0; i < 40; ++i) {  // into it
    piece_ += 2;
    places_.step(piece_, wet(piece_));
  }
  EXPECT_TRUE(places_.holding());
  EXPECT_NEAR(places_.mu(), 0.9, 1e-9);  // the road ahead is dry
}

TEST_F(FrictionPlacesTest, FrictionThatFallsForGoodIsTheWholeRoads) {
  laps(1, dry);
  laps(2, [](std::size_t) { return 0.6; });
  EXPECT_EQ(changes_, 0);
  EXPECT_EQ(places_.mu(), 0.6);
}

TEST_F(FrictionPlacesTest, ABeliefThatFellTooFarAtFirstIsNoPlace) {
  laps(1, dry);
  int steps = 0;
  laps(2, [&](std::size_t) { return ++steps < 12 ? 0.4 : 0.6; });
  EXPECT_EQ(changes_, 0);
}

/// What a learner that has seen little believes of a stretch is no place.
TEST_F(FrictionPlacesTest, ABeliefThatIsNotSureIsNoPlace) {
  spread_ = 0.05;  // twice that is more than a fall of a tenth
  laps(2, wet);
  EXPECT_EQ(changes_, 0);
  spread_ = 0.025;
  laps(2, wet);
  EXPECT_LT(places_.grip(80), 1.0);
}

/// With noisy sensors a learner doubts itself while it finds the new friction, and is high again before it is sure.
TEST_F(FrictionPlacesTest, APlaceIsFoundWhereTheBeliefIsUnsureAtItsEnds) {
  laps(1, dry);
  lap_of([](std::size_t piece) {
    const bool begins = piece >= 62 && piece < 68, ends = piece >= 100 && piece < 108;
    return Believed{ends ? 0.85 : wet(piece), begins || ends ? 0.1 : 0.0};
  });
  EXPECT_NEAR(places_.grip(80), 0.6 / 0.9, 0.02);
  EXPECT_LT(places_.grip(106), 1.0);                                                      // until it was sure again
  for (const std::size_t piece : {52, 58}) EXPECT_LT(places_.grip(piece), 1.0) << piece;  // 0.1 s before it doubted
  for (const std::size_t piece : {44, 112, 150}) EXPECT_EQ(places_.grip(piece), 1.0) << piece;
}

TEST_F(FrictionPlacesTest, DoubtAloneIsNoPlace) {
  laps(1, dry);
  lap_of([](std::size_t piece) {
    const bool doubts = piece >= 60 && piece < 100;
    return Believed{doubts ? 0.6 : 0.9, doubts ? 0.1 : 0.0};
  });
  lap_of([](std::size_t piece) {  // sure for a moment
    const bool doubts = piece >= 60 && piece < 100 && piece != 80;
    return Believed{piece >= 60 && piece < 100 ? 0.6 : 0.9, doubts ? 0.1 : 0.0};
  });
  EXPECT_EQ(changes_, 0);
}

/// A long doubt joins no two places, and leaves one that is known as it is.
TEST_F(FrictionPlacesTest, DoubtBetweenTwoPlacesIsOfNeither) {
  laps(1, dry);
  lap_of([](std::size_t piece) { return Believed{piece >= 30 && piece < 60 ? 0.5 : 0.9, 0.0}; });
  ASSERT_NEAR(places_.grip(40), 0.5 / 0.9, 0.02);
  lap_of([](std::size_t piece) {
    const bool first = piece >= 30 && piece < 60, second = piece >= 100 && piece < 130;
    return Believed{first ? 0.5 : second ? 0.7 : 0.9, piece >= 60 && piece < 100 ? 0.1 : 0.0};
  });
  EXPECT_NEAR(places_.grip(40), 0.5 / 0.9, 0.02);
  EXPECT_EQ(places_.grip(80), 1.0);
}

TEST_F(FrictionPlacesTest, APlaceThatDriedIsForgotten) {
  laps(1, dry);
  laps(2, wet);
  ASSERT_LT(places_.grip(80), 1.0);
  laps(1, dry);
  for (std::size_t piece = 0; piece < 200; ++piece) EXPECT_EQ(places_.grip(piece), 1.0) << piece;
}

TEST_F(FrictionPlacesTest, LessThanAPlaceExplainsIsLessEverywhere) {
  laps(1, dry);
  laps(2, wet);
  for (int i = 0; i < 40; ++i) {
    piece_ += 2;
    places_.step(piece_, 0.7 * wet(piece_));
  }
  EXPECT_NEAR(places_.mu(), 0.7 * 0.9, 0.02);
}

}  // namespace
}  // namespace gripline
