#include "util/family_mark.hpp"

#include <gtest/gtest.h>

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <string>

#include "util/child_process.hpp"
#include "util/pipe.hpp"

namespace gripline {
namespace test_family_mark {

TEST(FamilyMark, IsOnWhoPutItOnUntilThatIsCollected) {
  const FamilyMark mark, other;
  const pid_t child = fork_process();
  if (child == 0) {
    mark.put_on();
    _exit(0);
  }
  siginfo_t ended{};
  ASSERT_EQ(waitid(P_PID, static_cast<id_t>(child), &ended, WEXITED | WNOWAIT), 0);
  EXPECT_TRUE(mark.is_on(child));
  EXPECT_FALSE(other.is_on(child));
  EXPECT_FALSE(mark.is_on(getpid()));
  wait_for_end(child);
  EXPECT_FALSE(mark.is_on(child));
}

/// Another session, another program and another parent change nothing.
TEST(FamilyMark, IsOnADaemonThatItStarts) {
  const FamilyMark mark;
  Pipe words;
  const pid_t child = fork_process();
  if (child == 0) {
    mark.put_on();
    if (fork() != 0) _exit(0);
    setsid();
    dup2(words.write.number(), STDOUT_FILENO);
    execlp("sh", "sh", "-c", "echo $$; exec sleep 1000 >&-", nullptr);
    _exit(1);
  }
  wait_for_end(child);
  words.write.close();
  std::string text;
  char byte = 0;
  while (read(words.read.number(), &byte, 1) == 1) text += byte;
  ASSERT_NE(text, "");
  const pid_t daemon = std::stoi(text);
  EXPECT_TRUE(mark.is_on(daemon));
  kill(daemon, SIGKILL);
}

}  // namespace test_family_mark
}  // namespace gripline
