#include "diagnose/result/channel_error.hpp"

#include <gtest/gtest.h>

namespace gripline::diagnose {
namespace test_diagnose_channel_error {

using measured::Channel;

/// Noise as measured with a model: of stated size on all channels, but for some.
struct Noisy {
  Noisy() {
    stated.fill(0.1);
    problem.sensor = stated;
    problem.colour.fill(0.9);
  }
  std::optional<ChannelError> wrong() const { return wrong_channel(problem, stated); }
  Problem problem;
  measured::Channels stated{};
};

TEST(WrongChannel, IsNoneWhereNoiseIsAsStatedOrTwiceThat) {
  Noisy log;
  EXPECT_FALSE(log.wrong());
  log.problem.sensor[Channel::vy] = 0.25;
  EXPECT_FALSE(log.wrong());
}

TEST(WrongChannel, IsTheOneThatIsWorstOverItsOwnNoise) {
  Noisy log;
  log.problem.sensor[Channel::vx] = 0.5;
  log.problem.sensor[Channel::yaw_rate] = 0.7;
  const auto wrong = log.wrong();
  ASSERT_TRUE(wrong);
  EXPECT_EQ(wrong->channel, Channel::yaw_rate);
  EXPECT_DOUBLE_EQ(wrong->ratio(), 7.0);
}

TEST(WrongChannel, ChangesSlowly) {
  Noisy log;
  log.problem.sensor[Channel::vx] = 0.5;
  log.problem.colour[Channel::vx] = 0.3;
  EXPECT_FALSE(log.wrong()) << "a sensor that is worse than stated";
}

TEST(WrongChannel, IsNotAskedForWhereNoNoiseIsStated) {
  Noisy log;
  log.problem.sensor[Channel::vx] = 0.5;
  log.stated[Channel::vx] = 0.0;
  EXPECT_FALSE(log.wrong());
}

}  // namespace test_diagnose_channel_error
}  // namespace gripline::diagnose
