#include "util/progress.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>
#include <string>

namespace gripline {
namespace test_progress {

using testing::HasSubstr;
using testing::Not;

class Watch {
 public:
  Progress::Clock::time_point at(double seconds) const {
    return start + std::chrono::duration_cast<Progress::Clock::duration>(std::chrono::duration<double>(seconds));
  }
  Progress::Clock::time_point start = Progress::Clock::now();
};

std::size_t lines(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

/// What stands on the screen's line after the last redraw, without escape sequences.
std::string last_frame(const std::string& text) {
  std::string visible;
  for (std::size_t i = text.rfind('\r') + 1; i < text.size(); ++i) {
    if (text[i] == '\x1b') {
      while (i < text.size() && !std::isalpha(static_cast<unsigned char>(text[i]))) ++i;
    } else {
      visible += text[i];
    }
  }
  return visible;
}

TEST(Duration, IsReadable) {
  EXPECT_EQ(duration_text(0.4), "0 s");
  EXPECT_EQ(duration_text(59.4), "59 s");
  EXPECT_EQ(duration_text(59.6), "1 min 00 s");
  EXPECT_EQ(duration_text(125), "2 min 05 s");
  EXPECT_EQ(duration_text(3840), "1 h 04 min");
}

TEST(Progress, CountsInWholesOfItsUnits) {
  std::ostringstream out;
  const Watch watch;
  Progress progress(out, "table1", 4000, {}, watch.start);
  progress.count_in(1000);
  progress.advance_at(watch.at(3), 1500, "elm");
  progress.advance_at(watch.at(8), 4000, "");
  progress.finish_at(watch.at(8));
  EXPECT_EQ(out.str(), "table1: 1 of 4, 5 s left (elm)\ntable1: 4 of 4 in 8 s\n");
}

TEST(Progress, PipedPrintsPlainLinesPerTenth) {
  std::ostringstream out;
  const Watch watch;
  Progress progress(out, "table1", 100, {}, watch.start);
  for (std::size_t i = 0; i <= 100; ++i) progress.advance_at(watch.at(0.1 * static_cast<double>(i)), i, "elm");
  progress.finish_at(watch.at(10));
  EXPECT_THAT(out.str(), HasSubstr("table1: 20 of 100, 8 s left (elm)\n"));
  EXPECT_THAT(out.str(), HasSubstr("table1: 100 of 100 in 10 s\n"));
  EXPECT_THAT(out.str(), Not(HasSubstr("\x1b")));
  EXPECT_THAT(out.str(), Not(HasSubstr("\r")));
  EXPECT_LE(lines(out.str()), 11u);
  EXPECT_GE(lines(out.str()), 8u);
}

TEST(Progress, SlowPipedWorkIsHeardOf) {
  std::ostringstream out;
  const Watch watch;
  Progress progress(out, "sweep", 1000, {}, watch.start);
  for (int second = 0; second <= 120; ++second) progress.advance_at(watch.at(second), 1, "");
  EXPECT_GE(lines(out.str()), 4u);
  EXPECT_LE(lines(out.str()), 6u);
}

TEST(Progress, TimeLeftIsToldOnceEnoughIsDone) {
  std::ostringstream out;
  const Watch watch;
  Progress progress(out, "race", 2000, {}, watch.start);
  progress.count_in(1000);
  progress.advance_at(watch.at(4), 6, "elm");  // most of it was preparing: 22 min
  progress.advance_at(watch.at(20), 400, "elm");
  progress.finish_at(watch.at(60));
  EXPECT_EQ(out.str(),
            "race: 0 of 2, 4 s so far (elm)\nrace: 0 of 2, 1 min 20 s left (elm)\nrace: 0 of 2 in 1 min 00 s\n");
  std::ostringstream slow;
  Progress sweep(slow, "sweep", 1000, {}, watch.start);
  sweep.advance_at(watch.at(100), 10, "");
  EXPECT_EQ(slow.str(), "sweep: 10 of 1000, 2 h 45 min left\n") << "a long sweep is not waited for";
}

TEST(Progress, NoPlainLineIsPrintedTwice) {
  std::ostringstream out;
  const Watch watch;
  Progress progress(out, "race", 1000, {}, watch.start);
  progress.count_in(1000);
  progress.advance_at(watch.at(10), 500, "elm");
  progress.advance_at(watch.at(15), 600, "elm");
  progress.advance_at(watch.at(70.0 / 3.0), 700, "elm");
  EXPECT_EQ(out.str(), "race: 0 of 1, 10 s left (elm)\n");
}

TEST(Progress, ShortPipedWorkIsSilent) {
  std::ostringstream out;
  const Watch watch;
  Progress progress(out, "short", 3, {}, watch.start);
  progress.advance_at(watch.at(0.5), 1, "");
  progress.advance_at(watch.at(1.5), 3, "");
  progress.finish_at(watch.at(1.9));
  EXPECT_EQ(out.str(), "");
}

TEST(Progress, LiveLineFitsTheWindow) {
  for (const int width : {20, 40, 80, 200}) {
    std::ostringstream out;
    const Watch watch;
    Progress progress(out, "a title that is rather long", 7, {true, true, true, width}, watch.start);
    progress.advance_at(watch.at(3), 3, "a note with Ünïcode that is longer than most windows are wide, so it is cut");
    const std::string frame = last_frame(out.str());
    const auto shown = std::count_if(frame.begin(), frame.end(), [](char c) { return (c & 0xc0) != 0x80; });
    EXPECT_LT(shown, width) << frame;
    EXPECT_EQ(lines(out.str()), 0u);
  }
}

TEST(Progress, LiveLineSaysWhatIsLeft) {
  std::ostringstream out;
  const Watch watch;
  Progress progress(out, "table1", 4, {true, false, false, 80}, watch.start);
  progress.advance_at(watch.at(10), 1, "gp, seed 1");
  EXPECT_EQ(last_frame(out.str()), "table1  ######------------------  1 of 4, 30 s left  gp, seed 1");
  progress.advance_at(watch.at(10.05), 2, "too soon to redraw");
  EXPECT_THAT(out.str(), Not(HasSubstr("too soon")));
  progress.finish_at(watch.at(40));
  EXPECT_EQ(last_frame(out.str()), "table1: 2 of 4 in 40 s\n");
}

TEST(Progress, ControlCharactersCannotLeave) {
  std::ostringstream out;
  const Watch watch;
  Progress progress(out, "bad\x1b[2Jtitle", 4, {true, false, false, 80}, watch.start);
  progress.advance_at(watch.at(1), 1, "note\nwith\rbreaks");
  EXPECT_THAT(out.str(), Not(HasSubstr("\x1b[2J")));
  EXPECT_THAT(out.str(), HasSubstr("note with breaks"));
}

TEST(Progress, LeavesACleanLineWhenAbandoned) {
  std::ostringstream out;
  const Watch watch;
  { Progress(out, "table1", 4, {true, false, false, 80}, watch.start).advance_at(watch.at(5), 1, ""); }
  EXPECT_EQ(last_frame(out.str()), "table1: stopped at 1 of 4\n");
}

TEST(Progress, WorkThatTellsItsPartsIsCountedInThem) {
  std::ostringstream out;
  const auto begin = Progress::Clock::now() - std::chrono::seconds(30);
  CallbackProgress progress(out, "forces", {true, false, false, 80}, begin);
  progress.finish();
  EXPECT_EQ(out.str(), "") << "work that told nothing";
  progress.callback()(1.5, 4, "elm");
  EXPECT_EQ(last_frame(out.str()), "forces  #########---------------  1 of 4, 50 s left  elm");
  progress.finish();
  EXPECT_EQ(last_frame(out.str()), "forces: 4 of 4 in 30 s\n");
}

TEST(Terminal, AFileIsNotLive) {
  EXPECT_FALSE(detect_terminal(-1).live);
  EXPECT_FALSE(detect_terminal(-1).colour);
}

}  // namespace test_progress
}  // namespace gripline
