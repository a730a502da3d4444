#include "util/started_program.hpp"

#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <optional>
#include <string>

#include "util/pipe.hpp"

namespace gripline {
namespace test_started_program {

std::optional<int> exit_code_of(const std::string& script) {
  return StartedProgram({"sh", "-c", script}, {}).exit_code();
}

/// By default, and as `env --ignore-signal=CHLD` leaves it.
class Programs : public testing::TestWithParam<void (*)(int)> {
 protected:
  void SetUp() override { before_ = std::signal(SIGCHLD, GetParam()); }
  void TearDown() override { EXPECT_EQ(std::signal(SIGCHLD, before_), GetParam()); }

 private:
  void (*before_)(int) = SIG_DFL;
};

TEST_P(Programs, SayHowTheyEnded) {
  EXPECT_EQ(exit_code_of("exit 0"), 0);
  EXPECT_EQ(exit_code_of("exit 3"), 3);
  EXPECT_EQ(exit_code_of("kill -KILL $$"), std::nullopt);
  EXPECT_EQ(StartedProgram({"/no/such/program"}, {}).exit_code(), 127);
}

TEST_P(Programs, AreKilledWithTheirObject) {
  { const StartedProgram sleeps({"sleep", "1000"}, {}); }
  { const StartedProgram sleeps({"sh", "-c", "sleep 1000 & wait"}, {.own_group = true}); }
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

INSTANTIATE_TEST_SUITE_P(EndOfChildren, Programs, testing::Values(SIG_DFL, SIG_IGN),
                         [](const auto& info) { return std::string(info.param == SIG_IGN ? "ignored" : "usual"); });

/// Handles arrive under the program's numbers, whatever numbers they have here, and no others of a pipe do.
TEST(StartedProgram, HasTheHandlesItWasGiven) {
  Pipe to, back;
  StartedProgram copies({"sh", "-c", "cat <&3 >&4"},
                        {.handles = {{3, to.read.number()}, {4, back.write.number()}}, .own_group = true});
  to.read.close();
  back.write.close();
  ASSERT_EQ(write(to.write.number(), "over", 4), 4);
  to.write.close();
  std::string text;
  char byte = 0;
  while (read(back.read.number(), &byte, 1) == 1) text += byte;
  EXPECT_EQ(text, "over");
  EXPECT_EQ(copies.exit_code(), 0);
}

TEST(StartedProgram, MayHaveSignalsThatAreIgnoredHere) {
  const auto before = std::signal(SIGTERM, SIG_IGN);
  StartedProgram ignores({"sh", "-c", "kill -TERM $$; exit 5"}, {});
  StartedProgram ends({"sh", "-c", "kill -TERM $$; exit 5"}, {.usual_signals = {SIGTERM}});
  EXPECT_EQ(ends.exit_code(), std::nullopt);
  EXPECT_EQ(ignores.exit_code(), 5);
  std::signal(SIGTERM, before);
}

}  // namespace test_started_program
}  // namespace gripline
