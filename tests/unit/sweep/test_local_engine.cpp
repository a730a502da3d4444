// Workers that die: with a task, without one, with exit code 0, or unseen.
#include "sweep/local_engine.hpp"

#include <gtest/gtest.h>

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <stdexcept>

#include "util/shared_array.hpp"

namespace gripline::sweep {
namespace test_local_engine {

/// What workers, which are other processes, have done.
struct Count {
  std::atomic<int> opened{0}, finished{0};
};

class LocalWorkers : public testing::Test {
 protected:
  /// Has workers do four tasks of one run each. `open` is called as a worker opens the sweep, `work` with a task.
  template <class Open, class Work>
  void run(const Open& open, const Work& work, int workers = 2) {
    Batch batch;
    batch.runs = 4;
    LocalEngine engine(
        "test", workers,
        [&](std::size_t) -> TaskBody {
          count_.opened.fetch_add(1);
          open();
          return [&](const Batch&, std::size_t task, const std::function<void()>& done) {
            work(task);
            count_.finished.fetch_add(1);
            done();
            return task_done;
          };
        },
        false);
    Submission submission;
    engine.submit(batch, submission, [] {});
    EXPECT_FALSE(engine.interrupted());
  }
  int opened() const { return count_.opened.load(); }
  int finished() const { return count_.finished.load(); }

 private:
  SharedArray<Count> memory_{1};
  Count& count_ = memory_[0];
};

const auto nothing = [] {};
const auto any_task = [](std::size_t) {};
constexpr int with_three_more = 1 + 3;

TEST_F(LocalWorkers, AllTasksAreDoneOnce) {
  run(nothing, any_task);
  EXPECT_EQ(opened(), 2);
  EXPECT_EQ(finished(), 4);
}

TEST_F(LocalWorkers, AWorkerThatDiesAsItOpensIsReplacedThreeTimes) {
  run([] { std::abort(); }, any_task);
  EXPECT_EQ(opened(), 2 * with_three_more);
  EXPECT_EQ(finished(), 0);
}

/// As a library may do that is loaded there.
TEST_F(LocalWorkers, AnEndWithExitCodeZeroIsADeathToo) {
  run([] { _exit(0); }, any_task);
  EXPECT_EQ(opened(), 2 * with_three_more);
}

TEST_F(LocalWorkers, ATaskThatKillsItsWorkerIsGivenUpAndTheOthersAreDone) {
  run(nothing, [](std::size_t task) {
    if (task == 1) std::abort();
  });
  EXPECT_EQ(opened(), 2 + with_three_more);
  EXPECT_EQ(finished(), 3);
}

/// The first task kills its worker, and the one in its place ends before it gets to the task.
class LocalWorkersInTurn : public LocalWorkers {
 protected:
  template <class Open>
  void run_with_second_opening(const Open& second) {
    SharedArray<std::atomic<int>> times(2);  // opened, worked
    run(
        [&] {
          if (times[0].fetch_add(1) == 1) second();
        },
        [&](std::size_t) {
          if (times[1].fetch_add(1) == 0) std::abort();
        },
        1);
    EXPECT_EQ(opened(), 3);
    EXPECT_EQ(finished(), 4);
  }
};

TEST_F(LocalWorkersInTurn, ATaskIsNotLostWithAWorkerThatDiesAsItOpens) { run_with_second_opening(std::abort); }

TEST_F(LocalWorkersInTurn, ATaskIsNotLostWithAWorkerThatCannotOpen) {
  run_with_second_opening([] { throw std::runtime_error("no file to be had"); });
}

/// There waitpid has no status to give.
TEST_F(LocalWorkers, ChildrenThatTheSystemCollectsAreJudgedToo) {
  const auto before = std::signal(SIGCHLD, SIG_IGN);
  run(nothing, any_task);
  EXPECT_EQ(opened(), 2);
  EXPECT_EQ(finished(), 4);
  run([] { std::abort(); }, any_task);
  EXPECT_EQ(opened(), 2 + 2 * with_three_more);
  std::signal(SIGCHLD, before);
}

}  // namespace test_local_engine
}  // namespace gripline::sweep
