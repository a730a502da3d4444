// Killed at seeded moments, a command comes to the same end when it is given again: byte for byte what it leaves when
// nobody disturbs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <map>
#include <random>
#include <thread>

#include "support/paths.hpp"
#include "support/program.hpp"

namespace gripline {
namespace test_crash {

using testing::AnyOf;
using testing::Contains;
using testing::Eq;
using namespace testing_support;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Files = std::map<std::string, std::string>;  // bytes, by the name below a folder

Files files_in(const fs::path& folder) {
  Files files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().filename() != ".lock")
      files[fs::relative(entry.path(), folder).generic_string()] = contents(entry.path());
  return files;
}

/// Processes that a process is the parent of.
std::vector<pid_t> children_of(pid_t pid) {
  std::vector<pid_t> all;
  std::ifstream in("/proc/" + std::to_string(pid) + "/task/" + std::to_string(pid) + "/children");
  for (pid_t child = 0; in >> child;) all.push_back(child);
  return all;
}

class Crash : public testing::Test {
 protected:
  Outcome call(std::vector<std::string> words, const std::string& out) const {
    words.insert(words.end(), {"--out", folder_ / out});
    return gripline_with(words);
  }

  /// What two undisturbed calls leave in common: times differ.
  Files undisturbed(const std::vector<std::string>& words) {
    const auto begin = Clock::now();
    const Outcome first = call(words, "first");
    duration_ = std::chrono::duration<double>(Clock::now() - begin).count();
    const Outcome second = call(words, "second");
    EXPECT_THAT(first.code, AnyOf(0, 1)) << first.err;
    EXPECT_EQ(first.code, second.code);
    code_ = first.code;
    Files stable = files_in(folder_ / "first");
    const Files other = files_in(folder_ / "second");
    for (auto at = stable.begin(); at != stable.end();) {
      const auto same = other.find(at->first);
      at = same != other.end() && same->second == at->second ? std::next(at) : stable.erase(at);
    }
    return stable;
  }

  /// Starts the command and kills it, or a run of it, after a share of its time.
  void disturb(std::vector<std::string> words, const std::string& out) {
    words.insert(words.begin(), gripline_program());
    words.insert(words.end(), {"--out", folder_ / out});
    const Process process(words, folder_.path());
    const double share = std::uniform_real_distribution<double>(0.0, 1.1)(random_);
    std::this_thread::sleep_for(std::chrono::duration<double>(share * duration_));
    const std::vector<pid_t> runs = children_of(process.pid());
    if (!runs.empty() && random_() % 3 == 0)
      kill(runs[random_() % runs.size()], SIGKILL);
    else
      process.signal(SIGKILL);
    process.wait();
    ++kills_;
  }

  /// `moments` kills, the command given to its end after every few of them.
  void survives(const std::vector<std::string>& words, int moments, const std::vector<std::string>& expected) {
    const Files stable = undisturbed(words);
    for (const std::string& name : expected) EXPECT_THAT(stable, Contains(testing::Key(Eq(name))));
    while (kills_ < moments) {
      const std::string out = "out" + std::to_string(kills_);
      for (std::uint64_t count = 1 + random_() % 10; count > 0 && kills_ < moments; --count) disturb(words, out);
      const Outcome end = call(words, out);
      EXPECT_EQ(end.code, code_) << end.err;
      const Files left = files_in(folder_ / out);
      for (const auto& [name, bytes] : stable) {
        const auto same = left.find(name);
        ASSERT_NE(same, left.end()) << name << " is missing after " << kills_ << " kills";
        EXPECT_EQ(same->second, bytes) << name << " after " << kills_ << " kills";
      }
      for (const auto& [name, bytes] : left) EXPECT_EQ(name.find(".partial"), std::string::npos) << name;
      fs::remove_all(folder_ / out);
    }
  }

  Folder folder_;
  std::mt19937_64 random_{13};
  double duration_ = 0;  // of an undisturbed call [s]
  int code_ = 0, kills_ = 0;
};

TEST_F(Crash, AComparisonKilledAtAnyMomentComesToTheSameEnd) {
  survives({"compare", "experiments/good.json", "-j", "2"}, 100,
           {"slow/1/steps.csv", "slow/1/summary.json", "told/2/steps.csv", "told/2/replay.csv", "claims.json",
            "scene.json", "experiment.json"});
}

TEST_F(Crash, ADiagnosisKilledAtAnyMomentComesToTheSameEnd) {
  const Outcome made = run_program(
      {build_dir() / "tests/blind_cases", folder_ / "blind", "--seed", "5", "--count", "1", "--only", "none_white"});
  ASSERT_EQ(made.code, 0) << made.err;
  const fs::path one = folder_ / "blind/cases/none_white_000";
  // The first eight seconds: time goes into being killed, not into the diagnosis.
  std::ifstream log(one / "measured.csv");
  std::ofstream brief(folder_ / "brief.csv");
  std::string line;
  for (int i = 0; i < 801 && std::getline(log, line); ++i) brief << line << '\n';
  brief.close();
  survives({"diagnose", (source_dir() / "worlds/diagnose_rc43.json").string(), folder_ / "brief.csv", "--case",
            (one / "case.json").string()},
           50, {"diagnosis.json", "augmented_world.json", "diagnosis_report.json"});
}

TEST_F(Crash, AReportKilledAtAnyMomentComesToTheSameEnd) {
  ASSERT_EQ(call({"compare", "experiments/good.json"}, "first").code, 0);
  const fs::path results = folder_ / "first";
  fs::remove_all(results / "figures");
  const std::vector<std::string> words = {gripline_program(), "report", results.string(), "--figures"};
  const auto begin = Clock::now();
  ASSERT_EQ(run_program(words).code, 0);
  duration_ = std::chrono::duration<double>(Clock::now() - begin).count();
  const Files whole = files_in(results);
  ASSERT_TRUE(whole.contains("report.html") && whole.contains("figures/speed.svg"));
  for (kills_ = 0; kills_ < 50; ++kills_) {
    const Process process(words, folder_.path());
    std::this_thread::sleep_for(
        std::chrono::duration<double>(std::uniform_real_distribution<double>(0.0, 1.1)(random_) * duration_));
    process.signal(SIGKILL);
    process.wait();
    // At every moment each file is whole: there is the old one or the new one, and they are the same.
    for (const auto& [name, bytes] : files_in(results))
      if (!name.ends_with(".partial")) {
        EXPECT_EQ(bytes, whole.at(name)) << name;
      }
  }
  ASSERT_EQ(run_program(words).code, 0);
  EXPECT_EQ(files_in(results), whole);
}

}  // namespace test_crash
}  // namespace gripline
