#include <gtest/gtest.h>

#include "diagnose/inference/adequacy.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace {

using test::DiagnoseRig;

constexpr std::array<double, 3> smooth = {0, 0, 0}, everywhere = {1, 1, 1};

/// A filter free to call anything random explains an oscillation by noise; it is told all the same, with its frequency.
TEST(Remainder, TellsARhythmFromNoise) {
  DiagnoseRig rig;
  Measured log = rig.simulate(rig.catalogue().bare(), {40, 45, 1});
  // What a yaw acceleration of 6 rad/s2 at 0.7 Hz adds to the readings of yaw and yaw rate.
  const double rate = 2.0 * M_PI * 0.7;
  for (std::size_t k = 0; k < log.size(); ++k) {
    const double t = static_cast<double>(k) * log.dt;
    log.reading[k * channels + 2] -= 6.0 / (rate * rate) * std::sin(rate * t);
    log.reading[k * channels + 5] -= 6.0 / rate * std::cos(rate * t);
  }
  Problem problem = rig.problem({log});
  Fit f = fit(problem, rig.catalogue().bare(), rig.noise(problem, 5.0), 8);
  renew_reference(problem, rig.road(), f);
  f = fit(problem, f.model, f.noise, 8);
  double excess = 0.0, frequency = 0.0;
  for (const BasisTest& test : remainder(problem, f))
    if (test.quantity == "frequency") excess = test.excess, frequency = test.from;
  EXPECT_GT(excess, structured);
  EXPECT_NEAR(frequency, 0.7, 0.03);
}

/// A yaw acceleration that is random while nothing else is: no road does that.
TEST(Remainder, TellsARoughRoadFromWhatOneDirectionLacks) {
  DiagnoseRig rig;
  const auto uneven = [&](const std::array<double, 3>& rough) {
    Problem problem = rig.problem({rig.simulate(rig.catalogue().bare(), {.seconds = 40, .seed = 87, .rough = rough})});
    Fit f = fit(problem, rig.catalogue().bare(), rig.noise(problem, 5.0), 8);
    renew_reference(problem, rig.road(), f);
    f = fit(problem, f.model, f.noise, 8);
    double excess = 0.0;
    for (const BasisTest& test : remainder(problem, f))
      if (test.quantity == "noise") excess = test.excess;
    return excess;
  };
  EXPECT_LT(uneven(smooth), structured);
  EXPECT_LT(uneven(everywhere), structured);
  EXPECT_LT(uneven({0.25, 0.25, 0.25}), structured);
  EXPECT_GT(uneven({1, 0, 0}), structured);
  EXPECT_GT(uneven({0, 0, 2}), structured);
}

/// The spectrum of a rough road has lines of its own: those are no spectral line.
TEST(Remainder, HearsNoRhythmInARoughRoad) {
  DiagnoseRig rig;
  for (const std::uint64_t seed : {81, 82, 83, 84, 85}) {
    Problem problem =
        rig.problem({rig.simulate(rig.catalogue().bare(), {.seconds = 40, .seed = seed, .rough = everywhere})});
    Fit f = fit(problem, rig.catalogue().bare(), rig.noise(problem, 5.0), 8);
    renew_reference(problem, rig.road(), f);
    f = fit(problem, f.model, f.noise, 8);
    ASSERT_TRUE(rough_road(problem, f.noise));
    for (const BasisTest& test : remainder(problem, f)) EXPECT_LT(test.excess, structured) << test.quantity << seed;
  }
}

TEST(Remainder, SeesAPushOfTheRoadAndWhereItIs) {
  // friction_patch may not be named: what it does is then a remainder in one place.
  DiagnoseRig rig({"friction_patch", "bank", "grade"});
  const ModelSpec truth = rig.with("friction_patch", {-0.3, 0.25, 0.15});
  Problem problem = rig.problem({rig.simulate(truth, {40, 43, 1})});
  Fit f = fit(problem, rig.catalogue().bare(), rig.noise(problem, 5.0), 8);
  settle_reference(problem, rig.road(), f);
  f = fit(problem, f.model, f.noise, 8);
  const BasisTest place = remainder(problem, f).front();
  ASSERT_EQ(place.where, Where::position);
  EXPECT_GT(place.excess, structured);
  EXPECT_NEAR(0.5 * (place.from + place.to), 0.25, 0.075) << "outside the patch";
}

}  // namespace
}  // namespace gripline::diagnose
