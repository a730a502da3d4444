#include "diagnose/real_logs/real_sessions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/errors.hpp"
#include "support/calibrate_rig.hpp"

namespace gripline::diagnose {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

measured::SessionFile driven(const std::string& name, unsigned seed) {
  const test::CalibrateRig rig;
  measured::SessionFile file;
  file.session = test::drive(rig.vehicle.car(), {.seconds = 2, .noise = 1, .seed = seed});
  file.session.name = name;
  return file;
}

TEST(RealSessions, ALogThatIsGivenTwiceIsUsedOnce) {
  std::list<measured::SessionFile> files = {driven("a", 1), driven("b", 2), driven("c", 1)}, held_out;
  files.front().session.reading[3] = files.back().session.reading[3] = NAN;  // missing in both
  std::vector<std::string> said;
  use_once(files, held_out, [&](const std::string& line) { said.push_back(line); });
  EXPECT_THAT(said, ElementsAre("c: holds the same rows as a, used once"));
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(files.back().session.name, "b");
}

TEST(RealSessions, ALogThatIsFittedIsNoJudgeOfTheFit) {
  std::list<measured::SessionFile> files = {driven("a", 1)}, held_out = {driven("b", 2), driven("c", 1)};
  try {
    use_once(files, held_out, [](const std::string&) {});
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("--held-out c holds the same rows as the log a that is fitted"));
  }
}

TEST(RealSessions, DelaysAreNotSoughtWithoutThrottle) {
  const test::CalibrateRig rig;
  std::list<measured::SessionFile> files = {driven("a", 1)};
  files.front().has_throttle = false;
  EXPECT_TRUE(channel_delays(files, measured::gripline_map(), rig.spec, "/nonexistent", [](const std::string&) {
                FAIL() << "nothing is written";
              }).empty());
}

}  // namespace
}  // namespace gripline::diagnose
