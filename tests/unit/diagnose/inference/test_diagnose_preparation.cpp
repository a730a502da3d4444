#include "diagnose/inference/preparation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_preparation {

using test::DiagnoseRig;
constexpr std::size_t yaw_rate = 5;

/// What is assumed of the gyroscope's noise [rad/s] in a log whose yaw rate also swings by `swing` of its standard
/// deviations at 8 Hz, which is motion and not noise.
Prepared prepared_log(const DiagnoseRig& rig, double noise, double swing) {
  Channels stated{};
  for (std::size_t c = 0; c < channels; ++c) stated[c] = rig.world().sensors.channels[c].sigma;
  measured::LogFile file;
  file.stretches.push_back(rig.simulate(rig.catalogue().null_model(), {.seconds = 30, .seed = 61, .noise = noise}));
  measured::Log& log = file.stretches.front();
  for (std::size_t k = 0; k < log.size(); ++k)
    log.reading[k * channels + yaw_rate] += swing * stated[yaw_rate] * std::sin(50.3 * log.dt * static_cast<double>(k));
  return prepare(rig.catalogue(), rig.road(), {&file, 1}, stated);
}

TEST(Preparation, QuickMotionIsNoNoiseOfTheSensors) {
  const DiagnoseRig rig;
  const double stated = rig.world().sensors.channels[yaw_rate].sigma;
  const Prepared still = prepared_log(rig, 1.0, 0.0), quick = prepared_log(rig, 1.0, 20.0);
  EXPECT_EQ(still.problem.sensor[yaw_rate], stated);
  EXPECT_EQ(quick.problem.sensor[yaw_rate], stated);
  EXPECT_TRUE(std::ranges::any_of(quick.health, [](const measured::Finding& h) {
    return h.check == "noise of yaw rate" && h.found.ends_with("hidden by the car's own quick motion");
  }));
}

TEST(Preparation, NoiseThatIsLargerThanStatedIsAssumedBesideQuickMotionToo) {
  const DiagnoseRig rig;
  const double stated = rig.world().sensors.channels[yaw_rate].sigma;
  for (const double swing : {0.0, 60.0})
    EXPECT_NEAR(prepared_log(rig, 3.0, swing).problem.sensor[yaw_rate], 3.0 * stated, 0.3 * stated) << swing;
}

/// A log whose yaw rate stands in few of the samples only, prepared with this noise of it stated [rad/s].
Prepared sparse_log(const DiagnoseRig& rig, double stated, bool (*in)(std::size_t sample)) {
  measured::LogFile file;
  file.stretches.push_back(rig.simulate(rig.catalogue().null_model(), {.seconds = 30, .seed = 61}));
  measured::Log& log = file.stretches.front();
  for (std::size_t k = 0; k < log.size(); ++k)
    if (!in(k)) log.reading[k * channels + yaw_rate] = std::nan("");
  Channels all{};
  for (std::size_t c = 0; c < channels; ++c) all[c] = rig.world().sensors.channels[c].sigma;
  all[yaw_rate] = stated;
  return prepare(rig.catalogue(), rig.road(), {&file, 1}, all);
}

TEST(Preparation, NoiseOfAChannelThatIsReadLessOftenThanRowsIsMeasuredToo) {
  const DiagnoseRig rig;
  const double true_noise = rig.world().sensors.channels[yaw_rate].sigma;
  for (const auto in :
       {+[](std::size_t k) { return k % 2 == 1; }, +[](std::size_t k) { return k % 5 == 0 || k % 5 == 2; }})
    EXPECT_NEAR(sparse_log(rig, 0.0, in).problem.sensor[yaw_rate], true_noise, 0.3 * true_noise);
}

/// Digits of a log state nothing of its sensors.
TEST(Preparation, RoundingIsNoStatedNoise) {
  const DiagnoseRig rig;
  measured::LogFile file;
  file.stretches.push_back(rig.simulate(rig.catalogue().null_model(), {.seconds = 30, .seed = 61}));
  for (double& reading : file.stretches.front().reading) reading = 1e-6 * std::round(1e6 * reading);
  const Prepared prepared = prepare(rig.catalogue(), rig.road(), {&file, 1}, {});
  std::size_t told = 0;
  for (const measured::Finding& h : prepared.health)
    if (h.check.starts_with("noise of ")) {
      ++told;
      EXPECT_TRUE(h.found.ends_with(", not stated")) << h.check << " " << h.found;
      EXPECT_EQ(h.level, measured::Finding::Level::good) << h.check;
    }
  EXPECT_GT(told, 0u);
}

TEST(Preparation, ReadingsWhoseNoiseNothingTellsAreNotBelievedExact) {
  const DiagnoseRig rig;
  const auto level = [](const Prepared& of) {
    for (const measured::Finding& h : of.health)
      if (h.check == "noise of yaw rate") return h.level;
    return measured::Finding::Level::good;
  };
  const auto three = [](std::size_t k) { return k == 100 || k == 400 || k == 1300; };
  const Prepared unknown = sparse_log(rig, 0.0, three), stated = sparse_log(rig, 0.05, three);
  EXPECT_EQ(unknown.problem.sensor[yaw_rate], rig.catalogue().car().v_ref);
  EXPECT_EQ(level(unknown), measured::Finding::Level::bad);
  EXPECT_EQ(stated.problem.sensor[yaw_rate], 0.05);
  EXPECT_EQ(level(stated), measured::Finding::Level::note);
  const Prepared never = sparse_log(rig, 0.05, [](std::size_t) { return false; });
  EXPECT_EQ(level(never), measured::Finding::Level::good) << "nothing to say of what was not read";
}

}  // namespace test_diagnose_preparation
}  // namespace gripline::diagnose
