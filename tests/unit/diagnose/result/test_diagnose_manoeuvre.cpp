#include <gtest/gtest.h>

#include <map>

#include "diagnose/result/manoeuvre.hpp"
#include "support/diagnose_rig.hpp"

namespace gripline::diagnose {
namespace test_diagnose_manoeuvre {

using test::DiagnoseRig;
using Sets = std::vector<std::vector<std::string>>;

TEST(Manoeuvre, IsTheManoeuvreThatMostEffectsInQuestionShare) {
  const DiagnoseRig rig;
  EXPECT_EQ(distinguishing_manoeuvre(Sets{{"drive_gain"}, {"back_emf"}}, rig.catalogue()),
            "full throttle from a quarter of top speed to top speed");
  EXPECT_EQ(distinguishing_manoeuvre(Sets{{"input_delay"}, {"motor_lag"}}, rig.catalogue()),
            "steps of throttle on a straight");
  // Two share what the first lists first, all three the second only.
  EXPECT_EQ(distinguishing_manoeuvre(Sets{{"front_grip"}, {"rear_grip"}}, rig.catalogue()),
            "a slow ramp of steering into saturation, twice");
  EXPECT_EQ(distinguishing_manoeuvre(Sets{{"front_grip"}, {"rear_grip"}, {"diff_yaw"}}, rig.catalogue()),
            "power on and lift off in a steady corner, then brake in a turn");
}

/// An effect in all sets is not in question, whatever it shares with the others.
TEST(Manoeuvre, LeavesOutWhatIsCertain) {
  const DiagnoseRig rig;
  EXPECT_EQ(distinguishing_manoeuvre(Sets{{"aero_drag", "drive_gain"}, {"aero_drag", "rolling_res"}}, rig.catalogue()),
            "drive the same lap in the other direction, and coast down once");
}

TEST(Manoeuvre, IsGeneralWhereNothingIsShared) {
  const DiagnoseRig rig;
  EXPECT_EQ(distinguishing_manoeuvre(Sets{{"mass"}, {"brake_fade"}}, rig.catalogue()),
            "three laps or more at two different paces, and the same lap in the other direction");
}

/// The host knows no effect by name: one that declares its manoeuvres is treated like those that are shipped.
TEST(Manoeuvre, IsTheSameForAStrangersEffect) {
  const DiagnoseRig rig({}, {testing_support::build_dir() / "tests/plugins/stranger"});
  ASSERT_LT(rig.catalogue().find("stranger.drag_place"), rig.catalogue().candidates().size());
  EXPECT_EQ(distinguishing_manoeuvre(Sets{{"stranger.drag_place"}, {"aero_drag"}}, rig.catalogue()),
            "coast down from top speed to half of it on a level straight");
  EXPECT_EQ(distinguishing_manoeuvre(Sets{{"stranger.drag_place"}, {"friction_patch"}}, rig.catalogue()),
            "the same place at two speeds, for three laps or more");
}

/// Manoeuvres are matched word for word: one that a single shipped effect declares is misspelt.
TEST(Manoeuvre, ShippedEffectsShareTheirManoeuvres) {
  const DiagnoseRig rig;
  std::map<std::string, int> uses;
  for (const Candidate& c : rig.catalogue().candidates()) {
    const std::string text = c.entry->decl->advice;
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = std::min(text.find("; ", at), text.size());
      ++uses[text.substr(at, end - at)];
      at = end + 2;
    }
  }
  EXPECT_EQ(uses.size(), 12U);
  for (const auto& [manoeuvre, effects] : uses) EXPECT_GT(effects, 1) << manoeuvre;
}

}  // namespace test_diagnose_manoeuvre
}  // namespace gripline::diagnose
