#include "sweep/keys.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/sweep_rig.hpp"

namespace gripline::sweep {
namespace test_keys {

using namespace testing_support;

class Keys : public SweepRig {};

TEST_F(Keys, KeysDependOnWhatIsRacedAndOnNothingElse) {
  factors({"/base/planner/params/mu=0.3,0.4"});
  planned();
  const std::string keys = contents(out() / "keys.txt");
  EXPECT_EQ(keys.size(), 4u * 65);
  const std::string text = contents(file());
  const auto with = [&](const std::string& what, const std::string& by) {
    std::string changed = text;
    changed.replace(changed.find(what), what.size(), by);
    write_text(file(), changed);
    planned("other");
    return contents(out("other") / "keys.txt");
  };
  EXPECT_EQ(with("\"claims\": [\"slow.violation_s <= 1\"]", "\"note\": \"no claims\""), keys);
  EXPECT_EQ(with("\"claims\": [\"slow.violation_s <= 1\"]", "\"kind\": null, \"perturb\": null"), keys);
  EXPECT_EQ(with("{\"world\"", "{\"seeds\": {\"first\": 1, \"count\": 1}, \"world\""), keys);
  const std::string other = with("\"mu_init\": 0.9", "\"mu_init\": 0.95");  // of the row `fast` alone
  EXPECT_EQ(other.substr(0, 65), keys.substr(0, 65));
  EXPECT_NE(other.substr(65, 65), keys.substr(65, 65));
  EXPECT_NE(with("pure_pursuit", "mpc_sqp"), keys);
  write_text(file(), text);
  request_.assignments = {"/world/duration=0.25"};
  planned("other");
  EXPECT_NE(contents(out("other") / "keys.txt"), keys);
}

}  // namespace test_keys
}  // namespace gripline::sweep
