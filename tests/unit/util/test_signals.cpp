#include "util/signals.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

namespace gripline {
namespace test_signals {

constexpr const char* said = "interrupted: what was not finished is not written";
using Reaction = StopSignal::Reaction;

TEST(StopSignal, NotesEverySignalWhileItLives) {
  const StopSignal stop(Reaction::note);
  EXPECT_FALSE(StopSignal::seen());
  std::raise(SIGINT);
  std::raise(SIGTERM);
  EXPECT_TRUE(StopSignal::seen());
}

TEST(StopSignal, ANewOneBeginsUnseen) {
  {
    const StopSignal stop(Reaction::note);
    std::raise(SIGTERM);
  }
  const StopSignal stop(Reaction::note);
  EXPECT_FALSE(StopSignal::seen());
}

TEST(StopSignal, OneThatIsForgottenIsUnseen) {
  {
    const StopSignal stop(Reaction::note);
    std::raise(SIGTERM);
  }
  EXPECT_TRUE(StopSignal::seen());
  StopSignal::forget();
  EXPECT_FALSE(StopSignal::seen());
}

TEST(StopSignal, PutsBackWhatWasThereBefore) {
  std::signal(SIGINT, SIG_IGN);
  { const StopSignal stop(Reaction::note); }
  EXPECT_EQ(std::signal(SIGINT, SIG_DFL), SIG_IGN);
}

TEST(StopSignalDeathTest, EndsTheProcessWithTheCodeGiven) {
  EXPECT_EXIT(
      {
        const StopSignal stop(Reaction::end, 4);
        std::raise(SIGINT);
        _exit(0);
      },
      testing::ExitedWithCode(4), said);
}

TEST(StopSignalDeathTest, ASecondSignalEndsTheProcess) {
  EXPECT_EXIT(
      {
        const StopSignal stop(Reaction::note_then_end, 3);
        std::raise(SIGINT);
        if (!StopSignal::seen()) _exit(0);
        std::raise(SIGTERM);
        _exit(0);
      },
      testing::ExitedWithCode(3), said);
}

}  // namespace test_signals
}  // namespace gripline
