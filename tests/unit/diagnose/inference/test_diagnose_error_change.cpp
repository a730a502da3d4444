#include "diagnose/inference/error_change.hpp"

#include <gtest/gtest.h>

#include <random>

#include "diagnose/thresholds.hpp"

namespace gripline::diagnose {
namespace test_diagnose_error_change {

/// Squares of errors whose mean is `mean`, scattered as those of a handful of independent readings are.
StartErrors errors(std::uint64_t seed, std::size_t starts, double mean) {
  std::mt19937_64 random(seed);
  std::chi_squared_distribution<double> scatter(10.0);
  StartErrors out;
  for (std::size_t i = 0; i < starts; ++i) {
    out.square.push_back(mean * 30.0 * scatter(random));
    out.readings.push_back(300.0);
  }
  return out;
}

TEST(ErrorChange, TellsHelpFromHarmFromNeither) {
  const StartErrors base = errors(801, 60, 4.0);
  const ErrorChange helps = compare(errors(802, 60, 1.0), base), harms = compare(errors(803, 60, 9.0), base);
  EXPECT_NEAR(helps.change, -0.5, 0.1);
  EXPECT_EQ(helps.in_words(), "helps");
  EXPECT_NEAR(harms.change, 0.5, 0.2);
  EXPECT_EQ(harms.in_words(), "harms");
  int told = 0;
  for (std::uint64_t seed = 810; seed < 850; ++seed)
    told += compare(errors(seed, 60, 4.0), errors(seed + 1000, 60, 4.0)).in_words() != "cannot tell";
  EXPECT_LE(told, 6);
}

TEST(ErrorChange, AFewStartsTellNothing) {
  EXPECT_EQ(compare(errors(804, 6, 1.0), errors(805, 6, 9.0)).in_words(), "cannot tell");
  EXPECT_EQ(compare({}, {}).in_words(), "cannot tell");
  EXPECT_EQ(compare({}, {}).change, 0.0);
}

/// Of four to six seconds there is an interval, too. In nearly all of many such pairs it covers the true change.
TEST(ErrorChange, AFewSecondsHaveAWiderInterval) {
  int covered = 0, helps = 0;
  constexpr int pairs = 200;
  for (std::uint64_t seed = 0; seed < pairs; ++seed) {
    const ErrorChange half = compare(errors(2000 + seed, 9, 1.0), errors(3000 + seed, 9, 4.0));
    covered += half.low < -0.5 && -0.5 < half.high;
    helps += half.helps();
  }
  EXPECT_GE(covered, pairs * 90 / 100);
  EXPECT_GE(helps, pairs * 90 / 100);
  const auto width = [](std::size_t starts) {
    const ErrorChange half = compare(errors(4001, starts, 1.0), errors(4002, starts, 4.0));
    return half.high - half.low;
  };
  EXPECT_GT(width(8), width(20));
  EXPECT_FALSE(compare(errors(804, 6, 1.0), errors(805, 6, 9.0)).measured());
  EXPECT_TRUE(compare(errors(804, 7, 1.0), errors(805, 7, 9.0)).measured());
}

/// Errors of one block that stay the same: as many pieces of evidence as blocks.
StartErrors errors_in_blocks(std::uint64_t seed, std::size_t blocks) {
  StartErrors out;
  const StartErrors one_each = errors(seed, blocks, 4.0);
  for (std::size_t i = 0; i < blocks * thresholds::rollout_block; ++i) {
    out.square.push_back(one_each.square[i / thresholds::rollout_block]);
    out.readings.push_back(300.0);
  }
  return out;
}

/// Of models that predict equally well, one pair in twenty may be told apart. Resampled blocks alone tell more apart, the
/// more so the fewer there are.
TEST(ErrorChange, EqualModelsAreRarelyToldApart) {
  constexpr int pairs = 400;
  for (const std::size_t blocks : {4, 6, 10, 20}) {
    int told = 0;
    for (std::uint64_t seed = 0; seed < pairs; ++seed)
      told += compare(errors_in_blocks(5000 + seed, blocks), errors_in_blocks(6000 + seed, blocks)).in_words() !=
              "cannot tell";
    EXPECT_LE(told, pairs * 8 / 100) << blocks << " blocks";
  }
}

/// Errors that stay the same for seconds are one piece of evidence, not many.
TEST(ErrorChange, StartsOfOneBlockCountAsOne) {
  StartErrors with = errors(806, 40, 1.0), without = with;
  for (std::size_t i = 0; i < 40; ++i) with.square[i] = 300.0;
  for (std::size_t i = 0; i < 40; ++i) without.square[i] = i < 4 ? 9000.0 : 300.0;
  EXPECT_EQ(compare(with, without).in_words(), "cannot tell");
  EXPECT_LT(compare(with, without).change, -0.3);
}

}  // namespace test_diagnose_error_change
}  // namespace gripline::diagnose
