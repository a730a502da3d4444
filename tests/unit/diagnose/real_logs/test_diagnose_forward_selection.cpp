#include "diagnose/real_logs/forward_selection.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/calibrate_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_forward_selection {

using test::CalibrateRig;
using test::small_car_world;

/// A log of a car whose steering is off, and a world that does not know of it.
class ForwardSelectionOf : public testing::Test {
 protected:
  std::list<measured::SessionFile> files() const {
    const CalibrateRig truth(
        small_car_world(R"({"plant": {"effects": [{"plugin": "steer_offset", "params": {"d0": 0.03}}]}})"));
    measured::SessionFile file;
    file.session = test::drive(truth.vehicle.car(), {.seconds = 60, .noise = 1});
    file.row_step = 0.02;
    return {file};
  }
  std::vector<std::string> added(std::span<const std::string> without) const {
    const std::list<measured::SessionFile> logs = files(), none;
    const EffectSearch search(nominal_.tree, nominal_.spec, testing_support::plugins(), map_, logs, none, options_);
    Selection selection = nothing_added(search);
    extend_forward(search, selection, without);
    std::vector<std::string> names;
    for (const calibrate::Addition& one : selection.added) names.push_back(one.name);
    return names;
  }

  ForwardSelectionOf() {
    options_.fit.slowest = 0.5;
    options_.fit.starts = 60;
  }
  CalibrateRig nominal_{small_car_world(R"({"plant": {"effects": []}, "unknowns": {
      "/plant/params/Cm1": {"group": "drive", "sigma": 0.3, "scale": "log"}}})")};
  measured::LogMap map_ = measured::gripline_map();
  MissingOptions options_;
};

TEST_F(ForwardSelectionOf, TheFirstIsWhatIsMissing) {
  const std::vector<std::string> names = added({});
  ASSERT_FALSE(names.empty());
  EXPECT_EQ(names.front(), "steer_offset");
}

TEST_F(ForwardSelectionOf, GoesOnWithoutWhatWasTakenOut) {
  const std::vector<std::string> gone = {"steer_offset", "steer_map"};
  const std::vector<std::string> names = added(gone);
  EXPECT_FALSE(names.empty()) << "something else stands in its place";
  for (const std::string& one : gone) EXPECT_THAT(names, testing::Not(testing::Contains(one)));
}

/// It may have been taken out before the curve was there, beside which it is another.
TEST_F(ForwardSelectionOf, AnOffsetThatWasTakenOutComesBackWithACurve) {
  const std::vector<std::string> gone = {"steer_offset"};
  const std::vector<std::string> names = added(gone);
  ASSERT_THAT(names, testing::Contains("steer_map"));
  EXPECT_EQ(*(std::ranges::find(names, "steer_map") + 1), "steer_offset");
}

}  // namespace test_diagnose_forward_selection
}  // namespace gripline::diagnose
