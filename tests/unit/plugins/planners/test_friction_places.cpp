#include "planners/time_optimal/friction_places.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>

namespace gripline {
namespace test_friction_places {

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

  FrictionPlaces places_{200, 0.02, 0.3};
  std::size_t piece_ = 0;
  double delayed_[2] = {0.9, 0.9}, spread_ = 0;
  int changes_ = 0;
};

TEST_F(FrictionPlacesTest, APlaceMetOnceIsKnownOnTheNextLap) {
  laps(1, dry);
  laps(1, wet);
  EXPECT_NEAR(places_.grip(80), 0.6 / 0.9, 0.02);
  EXPECT_LT(places_.grip(62), 1.0);  // before it was noticed
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
    const bool begins = piece >= 60 && piece < 68, ends = piece >= 100 && piece < 108;
    return Believed{ends ? 0.85 : wet(piece), begins || ends ? 0.1 : 0.0};
  });
  EXPECT_NEAR(places_.grip(80), 0.6 / 0.9, 0.02);
  EXPECT_LT(places_.grip(106), 1.0);  // until it was sure again
  EXPECT_LT(places_.grip(50), 1.0);   // as long before it doubted as it took to be sure
  for (const std::size_t piece : {44, 112, 150}) EXPECT_EQ(places_.grip(piece), 1.0) << piece;
}

/// A learner that finds less friction within tenths of a second, and more within seconds, tells the grip all the same.
TEST_F(FrictionPlacesTest, AGripIsThatOfASettledBelief) {
  laps(1, dry);
  lap_of([](std::size_t piece) {
    const double x = static_cast<double>(piece);
    const double falls = 0.9 - 0.3 * (x - 60) / 16, rises = 0.6 + 0.3 * (x - 100) / 50;
    return Believed{piece < 60 ? 0.9 : piece < 76 ? falls : piece < 100 ? 0.6 : std::min(0.9, rises), 0.0};
  });
  EXPECT_NEAR(places_.grip(80), 0.6 / 0.85, 0.04);
  EXPECT_LT(places_.grip(130), 1.0);
}

TEST_F(FrictionPlacesTest, AFallOverALongWayIsTheWholeRoads) {
  laps(1, dry);
  lap_of([](std::size_t piece) {  // a fifth less, over nearly a second, and back at once
    const double x = static_cast<double>(piece);
    return Believed{piece < 20 || piece >= 110 ? 0.9 : 0.9 - 0.2 * (x - 20) / 90, 0.0};
  });
  EXPECT_EQ(changes_, 0);
}

TEST_F(FrictionPlacesTest, DoubtAloneIsNoPlace) {
  laps(1, dry);
  lap_of([](std::size_t piece) {
    const bool doubts = piece >= 60 && piece < 100;
    return Believed{doubts ? 0.6 : 0.9, doubts ? 0.15 : 0.0};
  });
  lap_of([](std::size_t piece) {  // sure for a moment
    const bool doubts = piece >= 60 && piece < 100 && piece != 80;
    return Believed{piece >= 60 && piece < 100 ? 0.6 : 0.9, doubts ? 0.15 : 0.0};
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

/// As above, but the learner believed too much before, comes back to less, and is not sure for long in between.
TEST_F(FrictionPlacesTest, ABeliefNeedNotComeBackToWhatItWas) {
  laps(1, dry);
  lap_of([](std::size_t piece) {
    const double mu = piece < 30 ? 0.9 : piece < 40 ? 1.05 : piece < 70 ? 0.6 : 0.92;
    return Believed{mu, piece >= 70 && piece < 110 ? 0.06 : 0.0};
  });
  EXPECT_NEAR(places_.grip(60), 0.6 / 0.92, 0.02);
  EXPECT_EQ(places_.grip(90), 1.0);
}

TEST_F(FrictionPlacesTest, APlaceIsMeasuredAnewInEveryLap) {
  laps(1, dry);
  laps(1, wet);
  laps(1, wet);
  EXPECT_EQ(changes_, 1);  // told once
  const auto more = [](std::size_t piece) { return piece >= 40 && piece < 120 ? 0.5 : 0.9; };
  laps(1, more);
  for (const std::size_t piece : {42, 80, 118}) EXPECT_NEAR(places_.grip(piece), 0.5 / 0.9, 0.02) << piece;
  laps(1, wet);
  for (const std::size_t piece : {42, 118}) EXPECT_EQ(places_.grip(piece), 1.0) << piece;
  EXPECT_NEAR(places_.grip(80), 0.6 / 0.9, 0.02);
}

/// Known from where it was met; on the next lap the belief falls before that, and is the place's at once.
TEST_F(FrictionPlacesTest, APlaceThatBeginsEarlierThanWasKnownBeginsThere) {
  laps(1, dry);
  laps(1, wet);
  ASSERT_EQ(places_.grip(46), 1.0);
  int steps = 0;
  for (; piece_ < 70; ++steps) {
    piece_ += 2;
    const bool changed = places_.step(piece_, piece_ >= 44 ? 0.6 : 0.9);
    EXPECT_EQ(changed, piece_ == 44);
    EXPECT_NEAR(places_.mu(), 0.9, 1e-9) << piece_;
  }
  for (const std::size_t piece : {44, 52, 80}) EXPECT_NEAR(places_.grip(piece), 0.6 / 0.9, 0.02) << piece;
  EXPECT_EQ(places_.grip(36), 1.0);
}

/// As above, but the learner is not sure of the fall yet when the car is on the known place.
TEST_F(FrictionPlacesTest, OnAPlaceAnUnsureFallBeforeItIsThePlaces) {
  laps(1, dry);
  laps(1, wet);
  for (; piece_ < 70; piece_ += 2) places_.step(piece_ + 2, piece_ >= 50 ? 0.6 : 0.9, piece_ >= 50 ? 0.1 : 0.0);
  ASSERT_LT(places_.grip(piece_), 1.0);
  EXPECT_EQ(places_.grip(52), 1.0);
  EXPECT_NEAR(places_.mu(), 0.9, 1e-9);
}

TEST_F(FrictionPlacesTest, FrictionThatFallsForGoodBeforeAPlaceIsTheWholeRoads) {
  laps(1, dry);
  laps(1, wet);
  lap_of([](std::size_t piece) { return Believed{piece >= 44 ? 0.6 : 0.9, 0.0}; });
  lap_of([](std::size_t piece) { return Believed{piece >= 60 && piece < 100 ? 0.4 : 0.6, 0.0}; });
  EXPECT_NEAR(places_.mu(), 0.6, 1e-9);
  for (const std::size_t piece : {44, 50}) EXPECT_EQ(places_.grip(piece), 1.0) << piece;
  EXPECT_NEAR(places_.grip(80), 0.6 / 0.9, 0.02);
}

/// Two steps are no evidence.
TEST_F(FrictionPlacesTest, AMomentOfLessBeforeAPlaceIsNotThePlaces) {
  laps(1, dry);
  laps(1, wet);
  lap_of([](std::size_t piece) {
    const bool moment = piece >= 42 && piece < 46, place = piece >= 70 && piece < 100;
    return Believed{moment || place ? 0.6 : 0.9, 0.0};
  });
  for (const std::size_t piece : {40, 44, 50}) EXPECT_EQ(places_.grip(piece), 1.0) << piece;
  EXPECT_NEAR(places_.grip(80), 0.6 / 0.9, 0.02);
}

/// Far from what the place explains, or far before it.
TEST_F(FrictionPlacesTest, AnotherFallBeforeAPlaceIsNotThePlaces) {
  laps(1, dry);
  laps(1, wet);
  for (; piece_ < 50; piece_ += 2) places_.step(piece_ + 2, piece_ >= 42 ? 0.45 : 0.9);
  EXPECT_EQ(places_.grip(48), 1.0);
  EXPECT_NEAR(places_.mu(), 0.45, 1e-9);
  for (piece_ = 50; piece_ < 200; piece_ += 2) places_.step((piece_ + 2) % 200, wet(piece_));
  laps(1, wet);
  for (piece_ = 0; piece_ < 40; piece_ += 2) places_.step(piece_ + 2, piece_ >= 20 ? 0.6 : 0.9);
  EXPECT_EQ(places_.grip(30), 1.0);
}

TEST_F(FrictionPlacesTest, NeighbouringPlacesAreLearnedOneByOne) {
  laps(1, dry);
  const auto two = [](std::size_t piece) {
    return Believed{piece >= 40 && piece < 70 ? 0.5 : piece >= 94 && piece < 130 ? 0.7 : 0.9, 0.0};
  };
  for (int lap = 0; lap < 2; ++lap) {
    lap_of(two);
    EXPECT_NEAR(places_.grip(60), 0.5 / 0.9, 0.02);
    EXPECT_EQ(places_.grip(84), 1.0);
    EXPECT_NEAR(places_.grip(110), 0.7 / 0.9, 0.02);
  }
}

/// A car that spins back across the begin of a stretch and goes on elsewhere leaves no place behind it.
TEST_F(FrictionPlacesTest, ACarThatIsCarriedElsewhereLearnsNoPlace) {
  laps(1, dry);
  for (std::size_t piece = 2; piece <= 80; piece += 2) places_.step(piece, wet(piece));
  int changes = 0;
  for (std::size_t piece = 150; piece < 190; piece += 2) changes += places_.step(piece, 0.9);
  EXPECT_EQ(changes, 0);
}

/// What was believed where it was before is no evidence of where a place begins.
TEST_F(FrictionPlacesTest, APlaceBehindAJumpBeginsBehindIt) {
  laps(1, dry);
  places_.step(20, 0.9);
  places_.step(60, 0.9);
  for (std::size_t piece = 62; piece <= 98; piece += 2) places_.step(piece, 0.6);
  for (std::size_t piece = 100; piece < 130; piece += 2) places_.step(piece, 0.9);
  EXPECT_LT(places_.grip(80), 1.0);
  for (std::size_t piece = 0; piece < 60; ++piece) EXPECT_EQ(places_.grip(piece), 1.0) << piece;
}

/// A car that was carried away from the begin of a place says nothing of whether it dried.
TEST_F(FrictionPlacesTest, ACarThatIsCarriedAwayForgetsNoPlace) {
  laps(1, dry);
  laps(2, wet);
  ASSERT_LT(places_.grip(80), 1.0);
  std::size_t first = 0;
  while (places_.grip(first) == 1.0) ++first;
  places_.step(first - 2, 0.9);
  places_.step(first, 0.9);
  for (std::size_t piece = 150; piece < 190; piece += 2) places_.step(piece, 0.9);
  EXPECT_LT(places_.grip(80), 1.0);
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

}  // namespace test_friction_places
}  // namespace gripline
