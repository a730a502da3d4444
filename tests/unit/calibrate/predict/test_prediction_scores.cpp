#include "calibrate/predict/prediction_scores.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "calibrate/forecast/baselines.hpp"
#include "support/circling_session.hpp"
#include "util/numbers.hpp"

namespace gripline::calibrate {
namespace test_prediction_scores {

using measured::Channel;

constexpr double fast = 7.9;  // [m/s] a little slower than the car

struct Bench {
  Bench()
      : session(test::circling_session(0.02)),
        log(session, 0.01, {0.2, 0.4}, 0.2, 0.0, FitLog::Speed::own),
        judged(log),
        predicted(judged.log().truth) {}
  /// Moves the places that are predicted at one horizon by (3, 4) m.
  void move(std::size_t horizon) {
    for (std::size_t i = 0; i < log.starts.time.size(); ++i) {
      predicted[log.starts.reading_index(i, horizon) + Channel::x] += 3.0;
      predicted[log.starts.reading_index(i, horizon) + Channel::y] += 4.0;
    }
  }

  Session session;
  FitLog log;
  JudgedLog judged;
  std::vector<double> predicted;
};

TEST(PredictionScores, DisplacementsAreMeansOfAllHorizonsAndOfTheLast) {
  Bench bench;
  bench.move(1);
  const Displacement last = displacement_of(bench.judged, bench.predicted, fast);
  EXPECT_EQ(last.starts, bench.log.starts.time.size());
  EXPECT_NEAR(last.average, 2.5, 1e-9);
  EXPECT_NEAR(last.last, 5.0, 1e-9);
  bench.move(0);
  const Displacement both = displacement_of(bench.judged, bench.predicted, fast);
  EXPECT_NEAR(both.average, 5.0, 1e-9);
  EXPECT_NEAR(both.last, 5.0, 1e-9);
}

TEST(PredictionScores, AStartCountsWhereEveryPlaceIsKnown) {
  Bench bench;
  bench.move(0);
  bench.predicted[bench.log.starts.reading_index(3, 1) + Channel::y] = not_a_number;
  const Displacement found = displacement_of(bench.judged, bench.predicted, fast);
  EXPECT_EQ(found.starts, bench.log.starts.time.size() - 1);
  EXPECT_NEAR(found.average, 2.5, 1e-9);
  EXPECT_NEAR(found.last, 0.0, 1e-9);
  EXPECT_EQ(displacement_of(bench.judged, bench.predicted, 100.0).starts, 0u);
}

TEST(PredictionScores, TheWorldStandsBelowTheBaselines) {
  Bench bench;
  bench.move(1);
  const auto models = beside_baselines(bench.judged, bench.predicted, 2.0);
  ASSERT_EQ(models.size(), baseline_names.size() + 1);
  for (const std::size_t horizon : {0u, 1u}) {
    const auto rows = errors_at(bench.judged, models, horizon, bench.judged.counted(horizon, fast));
    ASSERT_EQ(rows.size(), models.size());
    for (std::size_t b = 0; b < baseline_names.size(); ++b) EXPECT_EQ(rows[b].name, baseline_names[b]);
    EXPECT_EQ(rows.back().name, "this world");
    EXPECT_NEAR(rows.back().error[0].rms, horizon == 0 ? 0.0 : 5.0, 1e-9) << horizon;  // of position
    EXPECT_EQ(rows.back().error[0].count, bench.log.starts.time.size());
    // Straight on at the same speed leaves the circle: by v^2 t^2 / 2 r, and the noise of the place it starts from.
    const double t = bench.log.starts.horizons[horizon];
    EXPECT_NEAR(rows[static_cast<std::size_t>(Baseline::constant_speed)].error[0].rms, 8.0 * 8.0 * t * t / 40.0, 0.02);
  }
}

}  // namespace test_prediction_scores
}  // namespace gripline::calibrate
