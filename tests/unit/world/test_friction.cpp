#include "world/friction.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "config/json_file.hpp"
#include "support/paths.hpp"
#include "support/reference_data.hpp"
#include "util/csv.hpp"
#include "world/friction_file.hpp"

namespace gripline {
namespace test_friction {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kDt = 0.02;

FrictionSpec parse(const char* text) {
  Errors errors;
  const FrictionSpec spec = read_friction(parse_text(text), errors);
  errors.throw_if_any();
  return spec;
}

std::string refusal(const char* text) {
  try {
    parse(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

FrictionSpec shipped(const std::string& name) {
  Errors errors;
  const FrictionSpec spec =
      read_friction(load_json(testing_support::source_dir() / "worlds/friction" / (name + ".json")), errors);
  errors.throw_if_any();
  return spec;
}

class PublishedSchedules : public testing_support::WithReference {};

TEST_F(PublishedSchedules, EveryColumnIsReproduced) {
  const CsvTable table = read_csv(reference("friction_schedules.csv"));
  ASSERT_EQ(table.rows(), 1800U);
  ASSERT_EQ(table.columns, 10U);
  for (std::size_t column = 1; column < table.columns; ++column) {
    const FrictionSchedule schedule(shipped(table.header[column]), kDt);
    for (std::size_t row = 0; row < table.rows(); ++row) {
      const double t = table.at(row, 0);
      ASSERT_NEAR(schedule.factor(static_cast<std::int64_t>(row), t, 0.0), table.at(row, column), 1e-8)
          << table.header[column] << " at " << t << " s";
    }
  }
}

TEST(Friction, FreshByDefault) { EXPECT_EQ(FrictionSchedule().factor(1000, 20.0, 3.0), 1.0); }

TEST(Friction, PointsAreLinearAndHold) {
  const FrictionSchedule schedule(parse(R"([{"t": 10, "factor": 1}, {"t": "20 s", "factor": 0.6}])"), kDt);
  EXPECT_DOUBLE_EQ(schedule.factor(0, 0.0, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(schedule.factor(0, 15.0, 0.0), 0.8);
  EXPECT_DOUBLE_EQ(schedule.factor(0, 20.0, 0.0), 0.6);
  EXPECT_DOUBLE_EQ(schedule.factor(0, 99.0, 0.0), 0.6);
}

TEST(Friction, TwoPointsAtOneTimeAreAStep) {
  const FrictionSchedule schedule(parse(R"([{"t": 0, "factor": 1}, {"t": 5, "factor": 1}, {"t": 5, "factor": 0.7}])"),
                                  kDt);
  EXPECT_DOUBLE_EQ(schedule.factor(0, 4.999, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(schedule.factor(0, 5.0, 0.0), 0.7);
}

TEST(Friction, PerStepCountsStepsAndStops) {
  const FrictionSchedule schedule(parse(R"({"per_step": {"start_step": 10, "divide": 4, "end_step": 11}})"), kDt);
  EXPECT_DOUBLE_EQ(schedule.factor(9, 0.18, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(schedule.factor(10, 0.2, 0.0), 0.75);
  EXPECT_DOUBLE_EQ(schedule.factor(11, 0.22, 0.0), 0.5625);
  EXPECT_DOUBLE_EQ(schedule.factor(12, 0.24, 0.0), 0.5625);
}

TEST(Friction, PatchesMultiplyBetweenStationsFromTheirTimeOn) {
  const FrictionSchedule schedule(parse(R"({"points": [{"t": 0, "factor": 0.9}],
      "patches": [{"from_s": 2, "to_s": 5, "factor": 0.5, "from_t": "15 s"}, {"from_s": 9, "to_s": 1, "factor": 0.8}]})"),
                                  kDt);
  EXPECT_DOUBLE_EQ(schedule.factor(0, 14.0, 3.0), 0.9);
  EXPECT_DOUBLE_EQ(schedule.factor(0, 15.0, 3.0), 0.45);
  EXPECT_DOUBLE_EQ(schedule.factor(0, 15.0, 5.0), 0.9);
  EXPECT_DOUBLE_EQ(schedule.factor(0, 0.0, 9.5), 0.72);  // over the start line
  EXPECT_DOUBLE_EQ(schedule.factor(0, 0.0, 0.5), 0.72);
  EXPECT_DOUBLE_EQ(schedule.base(0, 15.0), 0.9);
}

TEST(Friction, SeedsShiftTheDrop) {
  const FrictionSpec spec = shipped("ethz_drop_times");
  const FrictionSchedule first(spec, kDt, 1), third(spec, kDt, 3);
  for (std::int64_t step = 600; step < 1000; ++step) {
    EXPECT_EQ(third.factor(step, kDt * static_cast<double>(step), 0.0),
              first.factor(step - 80, kDt * static_cast<double>(step - 80), 0.0));
  }
  EXPECT_LT(third.factor(900, 18.0, 0.0), 0.66);
  FrictionSpec points = parse(R"({"points": [{"t": 4, "factor": 1}, {"t": 4, "factor": 0.5}], "shift_per_seed": 1,
      "patches": [{"from_s": 0, "to_s": 1, "factor": 0.5, "from_t": 2}]})");
  const FrictionSchedule second(points, kDt, 2);
  EXPECT_DOUBLE_EQ(second.base(0, 4.5), 1.0);
  EXPECT_DOUBLE_EQ(second.base(0, 5.0), 0.5);
  EXPECT_DOUBLE_EQ(second.factor(0, 2.5, 0.5), 1.0);
  EXPECT_DOUBLE_EQ(second.factor(0, 3.0, 0.5), 0.5);
}

/// 0.1 s times 3 is more than 15 steps of 0.02 s by rounding: what changes then changes with that step.
TEST(Friction, RoundingDelaysNothing) {
  const FrictionSpec spec = parse(R"({"points": [{"t": 0, "factor": 1}, {"t": 0, "factor": 0.8}],
      "patches": [{"from_s": 0, "to_s": 1, "factor": 0.5}], "shift_per_seed": 0.1})");
  for (std::uint64_t seed = 2; seed < 60; ++seed) {
    const FrictionSchedule schedule(spec, kDt, seed);
    const auto step = static_cast<std::int64_t>(5 * (seed - 1));
    const auto at = [&](std::int64_t k) { return schedule.factor(k, kDt * static_cast<double>(k), 0.5); };
    EXPECT_EQ(at(step - 1), 1.0) << seed;
    EXPECT_EQ(at(step), 0.4) << seed;
  }
}

TEST(Friction, AShiftThatIsNoWholeNumberOfStepsIsRefused) {
  FrictionSpec spec = shipped("ethz_drop_times");
  spec.shift_per_seed = 0.81;
  EXPECT_NO_THROW(FrictionSchedule(spec, kDt, 1));
  EXPECT_THROW(FrictionSchedule(spec, kDt, 2), std::invalid_argument);
  EXPECT_THAT(check_shift_per_seed(spec, kDt), HasSubstr("0.81 s is not a multiple of the control step of 0.02 s"));
  EXPECT_EQ(check_shift_per_seed(spec, 0.01), "");
  spec.per_step.reset();
  EXPECT_EQ(check_shift_per_seed(spec, kDt), "");
}

TEST(Friction, RefusalsSayWhatAndWhere) {
  EXPECT_THAT(refusal(R"([{"t": 5, "factor": 1}, {"t": 4, "factor": 0.9}])"),
              HasSubstr("/1/t: the schedule goes back in time"));
  EXPECT_THAT(refusal(R"([{"t": 5, "factor": 0}])"), HasSubstr("/0/factor"));
  EXPECT_THAT(refusal(R"([{"t": 5, "factor": -1}])"), HasSubstr("/0/factor"));
  EXPECT_THAT(refusal(R"([{"t": "5 m", "factor": 1}])"), HasSubstr("is a length, expected a time"));
  EXPECT_THAT(refusal(R"([{"t": 5, "factor": 1}, {"t": "12.2 m", "factor": 1}, {"t": 6, "factor": 1}])"),
              AllOf(HasSubstr("/1/t: "), Not(HasSubstr("goes back in time"))));
  EXPECT_THAT(refusal(R"({"per_step": {"start_step": 9, "divide": 22, "end_step": 8}})"),
              HasSubstr("goes back in time"));
  EXPECT_THAT(refusal(R"({"per_step": {"start_step": 9, "divide": 1}})"), HasSubstr("/per_step/divide"));
  EXPECT_THAT(refusal(R"({"per_step": {"start_step": 9.5, "divide": 22}})"), HasSubstr("/per_step/start_step"));
  EXPECT_THAT(refusal(R"({"patches": [{"from_s": 1, "to_s": 1, "factor": 0.5}]})"), HasSubstr("same station"));
  EXPECT_THAT(refusal(R"({"patch": []})"), HasSubstr("patches"));
  EXPECT_THAT(refusal("3"), HasSubstr("expected a friction schedule"));
}

TEST(Friction, StructsAreCheckedAsWell) {
  FrictionSpec spec;
  spec.patches.push_back({.from_s = 1.0, .to_s = 30.0, .factor = 0.5});
  EXPECT_EQ(check_friction(spec), "");
  EXPECT_THAT(check_friction(spec, 17.8), HasSubstr("expected 0 to the track's length 17.8 m"));
  spec = {};
  spec.points = {{2.0, 1.0}, {1.0, 1.0}};
  EXPECT_THAT(check_friction(spec), HasSubstr("goes back in time"));
  EXPECT_THROW(FrictionSchedule(spec, kDt), std::invalid_argument);
}

TEST(Friction, EveryShippedScheduleReads) {
  int read = 0;
  for (const auto& file : std::filesystem::directory_iterator(testing_support::source_dir() / "worlds/friction")) {
    if (file.path().extension() != ".json") continue;
    const FrictionSchedule schedule(shipped(file.path().stem().string()), kDt);
    EXPECT_LT(schedule.factor(3000, 60.0, 0.0), 1.0) << file.path();
    EXPECT_EQ(schedule.factor(0, 0.0, 0.0), 1.0) << file.path();
    ++read;
  }
  ASSERT_GT(read, 0);
}

}  // namespace test_friction
}  // namespace gripline
