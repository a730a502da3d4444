#include "diagnose/real_logs/effect_search.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "diagnose/real_logs/forward_selection.hpp"
#include "support/calibrate_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_effect_search {

using calibrate::Trial;
using calibrate::Unknown;
using test::CalibrateRig;
using test::small_car_world;

/// The search in a log of a car whose steering is off, from a world that does not know of it.
class EffectSearchOf : public testing::Test {
 protected:
  EffectSearchOf() {
    options_.fit.slowest = 0.5;
    options_.fit.starts = 60;
    const CalibrateRig truth(
        small_car_world(R"({"plant": {"effects": [{"plugin": "steer_offset", "params": {"d0": 0.03}}]}})"));
    measured::SessionFile file;
    file.session = test::drive(truth.vehicle.car(), {.seconds = 60, .noise = 1});
    file.row_step = 0.02;
    logs_ = {file};
    search_.emplace(nominal_.tree, nominal_.spec, testing_support::plugins(), map_, logs_, none_, options_);
  }
  /// The observer's parameters of a world of this search, in the order of its unknowns.
  std::vector<double> observer_of(const Trial& trial) const {
    std::vector<double> values;
    for (const Unknown& u : search_->worlds.observer)
      values.push_back(
          trial.params[u.index - search_->worlds.calibrated->forecaster.car_params() + trial.forecaster.car_params()]);
    return values;
  }
  CalibrateRig nominal_{small_car_world(R"({"plant": {"effects": []}, "unknowns": {
      "/plant/params/Cm1": {"group": "drive", "sigma": 0.3, "scale": "log"}}})")};
  measured::LogMap map_ = measured::gripline_map();
  MissingOptions options_;
  std::list<measured::SessionFile> logs_, none_;
  std::optional<EffectSearch> search_;
};

TEST_F(EffectSearchOf, AWorldWithEffectsHasTheObserverOfTheCalibratedOne) {
  const auto calibrated = with_disturbances(*search_, *search_->worlds.calibrated);
  Selection selection = nothing_added(*search_);
  extend_forward(*search_, selection, {});
  ASSERT_FALSE(selection.added.empty());
  const auto own = with_disturbances(*search_, *selection.trial);
  const auto found = with_observer_of(*search_, *calibrated, *selection.trial);
  ASSERT_FALSE(search_->worlds.observer.empty());
  ASSERT_GT(found->forecaster.car_params(), calibrated->forecaster.car_params());
  EXPECT_EQ(observer_of(*found), observer_of(*calibrated));
  EXPECT_NE(observer_of(*own), observer_of(*calibrated));
  EXPECT_TRUE(std::ranges::none_of(found->unknowns, &Unknown::observer));
  EXPECT_TRUE(std::ranges::any_of(calibrated->unknowns, &Unknown::observer));
}

}  // namespace test_diagnose_effect_search
}  // namespace gripline::diagnose
