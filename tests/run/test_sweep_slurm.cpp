// A sweep on a real Slurm of three nodes on this machine (tools/slurm-local): a task, a whole node and the controller
// are killed in the middle, and the merged table is that of the local engine, byte for byte.
//
// Where Slurm cannot be started the tests say why and are skipped, unless GRIPLINE_REQUIRE_SLURM=1.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

#include "support/paths.hpp"
#include "support/program.hpp"
#include "support/sweep_records.hpp"

namespace gripline {
namespace test_sweep_slurm {

namespace fs = std::filesystem;
using namespace testing_support;
using Clock = std::chrono::steady_clock;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

class Slurm : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = fs::temp_directory_path() / "slurm_XXXXXX";  // short: names of sockets are bounded
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    dir_ = name;
    const Outcome started = local({"start"});
    if (started.code == 0) {
      ASSERT_TRUE(started.out.starts_with("export SLURM_CONF=")) << started.out;
      configuration_ = started.out.substr(18, started.out.find('\n') - 18);
      return;
    }
    const char* const required = std::getenv("GRIPLINE_REQUIRE_SLURM");
    if (required != nullptr && std::string(required) == "1") FAIL() << started.err;
    GTEST_SKIP() << "no Slurm here: " << started.err;
  }
  void TearDown() override {
    const Outcome stopped = local({"stop"});
    EXPECT_EQ(stopped.code, 0) << stopped.err;
    EXPECT_FALSE(fs::exists(dir_));
  }

  Outcome local(std::vector<std::string> words) const {
    words.insert(words.begin(), source_dir() / "tools/slurm-local");
    return run_program(words, {.folder = source_dir(), .environment = {{"GRIPLINE_SLURM_DIR", dir_.string()}}});
  }
  Outcome gripline(std::vector<std::string> words) const {
    return gripline_with(std::move(words), {.folder = fixture_dir(), .environment = {{"SLURM_CONF", configuration_}}});
  }
  Outcome sweep(const std::string& name, const std::vector<std::string>& more) const {
    std::vector<std::string> words = {"sweep",   "experiments/good.json",
                                      "--set",   "/base/planner/params/mu=0.3,0.35",
                                      "--set",   "/world/duration=4",
                                      "--seeds", "1..9",
                                      "--out",   out(name)};
    words.insert(words.end(), more.begin(), more.end());
    return gripline(words);
  }
  std::string out(const std::string& name) const { return folder_ / name; }

  /// Until the words of `sweep status` have no batch under way; what it says then.
  Outcome wait_until_over(const std::string& name) const {
    Outcome status;
    for (const auto begin = Clock::now(); Clock::now() - begin < std::chrono::seconds(240);) {
      status = gripline({"sweep", "status", out(name)});
      if (status.out.find(" running, ") == std::string::npos && status.out.find("does not answer") == std::string::npos)
        return status;
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
    }
    ADD_FAILURE() << "the jobs do not end: " << status.out;
    return status;
  }
  /// Processes `gripline sweep task` of a sweep, without the runs that they started.
  std::vector<pid_t> tasks_of(const std::string& name) const {
    std::vector<pid_t> found;
    std::error_code failed;
    for (const auto& entry : fs::directory_iterator("/proc", failed)) {
      std::string words = contents(entry.path() / "cmdline");
      std::replace(words.begin(), words.end(), '\0', ' ');
      if (words.find("sweep task " + out(name)) != std::string::npos)
        found.push_back(std::stoi(entry.path().filename().string()));
    }
    const std::vector<pid_t> all = found;
    std::erase_if(found, [&](pid_t pid) {
      std::istringstream stat(contents("/proc/" + std::to_string(pid) + "/stat"));
      std::string number, program, state;
      pid_t parent = 0;
      stat >> number >> program >> state >> parent;
      return std::find(all.begin(), all.end(), parent) != all.end();
    });
    return found;
  }

  Folder folder_;
  fs::path dir_;  // of slurm-local
  std::string configuration_;
};

TEST_F(Slurm, ATaskANodeAndTheControllerAreKilledAndNoRunIsLostOrDoubled) {
  const Outcome here = sweep("here", {"-j", "2"});
  ASSERT_EQ(here.code, 0) << here.err;
  const Outcome submitted = sweep("there", {"--engine", "slurm", "--chunk", "3", "--partition", "all"});
  ASSERT_EQ(submitted.code, 0) << submitted.err;
  EXPECT_THAT(submitted.out, AllOf(HasSubstr("12 Slurm tasks of at most 3 runs, and a merge job after them"),
                                   HasSubstr("gripline sweep status")));
  EXPECT_EQ(gripline({"sweep", "--resume", "--engine", "slurm", "--out", out("there")}).code, 2) << "it is under way";
  ASSERT_TRUE(wait_for_records(out("there"), 2));
  std::vector<pid_t> tasks;
  // Between two tasks a node has none.
  for (int i = 0; i < 1000 && (tasks = tasks_of("there")).empty(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  ASSERT_FALSE(tasks.empty());
  kill(tasks.front(), SIGKILL);
  ASSERT_EQ(local({"kill-node", "2"}).code, 0);
  ASSERT_EQ(local({"kill-controller"}).code, 0);
  ASSERT_LT(records_in(out("there")), 36u);
  ASSERT_EQ(local({"start"}).code, 0);
  const Outcome over = wait_until_over("there");
  EXPECT_THAT(over.code, testing::AnyOf(75, 0)) << over.out;  // 75: the killed task's runs, had it any left
  const Outcome resumed = gripline({"sweep", "--resume", "--engine", "slurm", "--wait", "--out", out("there")});
  EXPECT_EQ(resumed.code, 0) << resumed.out << resumed.err;
  EXPECT_THAT(resumed.out, HasSubstr("36 of 36 runs finished"));
  EXPECT_EQ(contents(out("there") + "/table.csv"), contents(out("here") + "/table.csv"));
  const std::vector<std::string> rows = lines(out("there") + "/table.csv");
  EXPECT_EQ(rows.size(), 37u);
  EXPECT_EQ(sweep("there", {"--engine", "slurm", "--wait"}).code, 0);
  EXPECT_FALSE(fs::exists(out("there") + "/batches/3")) << "a second run of the same sweep computes nothing";
}

TEST_F(Slurm, CancelEndsTheJobsAndKeepsWhatIsFinished) {
  const Outcome submitted = sweep("out", {"--engine", "slurm", "--chunk", "4", "--time", "5", "--mem", "100"});
  ASSERT_EQ(submitted.code, 0) << submitted.err;
  ASSERT_TRUE(wait_for_records(out("out"), 1));
  const Outcome cancelled = gripline({"sweep", "cancel", out("out")});
  ASSERT_EQ(cancelled.code, 0) << cancelled.err;
  EXPECT_THAT(cancelled.out, HasSubstr("runs are finished and kept"));
  const Call call{.folder = folder_.path(), .environment = {{"SLURM_CONF", configuration_}}};
  EXPECT_EQ(run_program({"squeue", "--noheader", "--format=%T", "--states=pending,running"}, call).out, "");
  EXPECT_FALSE(fs::exists(out("out") + "/work"));
  EXPECT_EQ(gripline({"sweep", "--resume", "--out", out("out"), "-j", "2"}).code, 0) << "by the other engine";
  EXPECT_EQ(lines(out("out") + "/table.csv").size(), 37u);
}

}  // namespace test_sweep_slurm
}  // namespace gripline
