// What the engine makes of the answers of Slurm's commands, which are scripts here; tests/run/test_sweep_slurm.cpp has a
// real Slurm.
#include "sweep/slurm_engine.hpp"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/host_support.hpp"

namespace gripline::sweep {
namespace test_slurm_engine {

using namespace testing_support;

/// By default, and as `env --ignore-signal=CHLD` leaves it.
class Slurm : public testing::TestWithParam<void (*)(int)> {
 protected:
  void SetUp() override {
    if (const char* const path = std::getenv("PATH"); path != nullptr) path_ = path;
    setenv("PATH", folder_.path().c_str(), 1);
    before_ = std::signal(SIGCHLD, GetParam());
  }
  void TearDown() override {
    EXPECT_EQ(std::signal(SIGCHLD, before_), GetParam());
    setenv("PATH", path_.c_str(), 1);
  }

  /// A command that consists of these words of the shell.
  void install(const std::string& name, const std::string& words) const {
    const std::filesystem::path file = folder_ / name;
    write_text(file, "#!/bin/sh\n" + words + "\n");
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  }
  /// Jobs that a batch of two tasks became.
  std::vector<std::string> submit() const {
    Batch batch;
    batch.out = folder_.path();
    batch.folder = folder_ / "batches/1";
    batch.runs = 2;
    SlurmOptions options;
    options.program = "gripline";
    Submission submission;
    SlurmEngine(options).submit(batch, submission, [] {});
    return submission.jobs;
  }
  std::string why_not() const {
    try {
      submit();
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "";
  }

 private:
  Folder folder_;
  std::string path_;
  void (*before_)(int) = SIG_DFL;
};

TEST_P(Slurm, NumbersOfJobsAreKept) {
  install("sbatch", "case \"$*\" in *merge*) echo '18;cluster' ;; *) echo 17 ;; esac");
  EXPECT_EQ(submit(), (std::vector<std::string>{"17", "18"}));
}

TEST_P(Slurm, ARefusalIsAnErrorWhateverWasSaid) {
  install("sbatch", "echo 17; echo 'no such partition' >&2; exit 1");
  EXPECT_EQ(why_not(), "sbatch refused: 17\nno such partition");
}

TEST_P(Slurm, ACommandThatIsKilledIsARefusal) {
  install("sbatch", "echo 17; kill -KILL $$");
  EXPECT_EQ(why_not(), "sbatch refused: 17");
}

TEST_P(Slurm, WithoutItNothingIsSubmitted) {
  EXPECT_EQ(why_not(), "sbatch is not installed here: nothing was submitted");
}

INSTANTIATE_TEST_SUITE_P(EndOfChildren, Slurm, testing::Values(SIG_DFL, SIG_IGN),
                         [](const auto& info) { return std::string(info.param == SIG_IGN ? "ignored" : "usual"); });

}  // namespace test_slurm_engine
}  // namespace gripline::sweep
