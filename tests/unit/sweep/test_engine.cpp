// Sweeps on a cluster that loses, repeats and delays jobs, kills them half way and damages what they leave: the table
// is always that of an engine that does everything once and in order.
#include "sweep/engine.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <stdexcept>

#include "support/sweep_rig.hpp"

namespace gripline::sweep {
namespace test_engine {

using namespace testing_support;

/// The task's process is gone, in the middle of its work.
struct Killed {};

/// A batch system as bad as they come: of every task it draws whether it is lost, done twice, killed half way or done
/// after all others.
class FakeEngine final : public Engine {
 public:
  FakeEngine(TaskBody body, unsigned seed) : body_(std::move(body)), random_(seed) {}
  std::string plan(const Batch& batch) const override { return std::to_string(batch.tasks()) + " tasks, maybe"; }
  void submit(const Batch& batch, Submission& submission, const std::function<void()>& keep) override {
    submission = {"fake", {"1"}};
    keep();
    std::vector<std::size_t> late;
    for (std::size_t task = 0; task < batch.tasks(); ++task) {
      switch (random_() % 5) {
        case 0:
          ++lost;
          break;
        case 1:
          ++repeated;
          work(batch, task, -1);
          work(batch, task, -1);
          break;
        case 2:
          ++killed;
          work(batch, task, 1);
          break;
        case 3:
          late.push_back(task);
          break;
        default:
          work(batch, task, -1);
      }
    }
    std::shuffle(late.begin(), late.end(), random_);
    for (const std::size_t task : late) work(batch, task, -1);
  }
  int lost = 0, repeated = 0, killed = 0;

 private:
  /// `patience`: runs after which it is killed; negative: never.
  void work(const Batch& batch, std::size_t task, int patience) {
    try {
      body_(batch, task, [&] {
        if (patience-- == 0) throw Killed{};
      });
    } catch (const Killed&) {
    }
  }
  TaskBody body_;
  std::mt19937 random_;
};

class Engines : public SweepRig {
 protected:
  void do_all(const Sweep& sweep, Engine& engine, const std::string& name, std::size_t chunk) const {
    for (int i = 0; i < 40; ++i) {
      const std::optional<Batch> batch = missing(name, chunk);
      if (!batch) return;
      Submission submission;
      engine.submit(*batch, submission, [&] { write_submission(*batch, submission); });
    }
    FAIL() << "forty batches of " << sweep.size() << " runs were not enough";
  }
};

TEST_F(Engines, NothingIsLostOrDoubledByAnEngineThatLosesRepeatsAndDelays) {
  factors({"/base/planner/params/mu=0.3,0.4,0.5", "/world/duration=0.5,1"});
  request_.seeds = parse_seeds("1..10");
  const Sweep sweep = planned("good");
  ASSERT_EQ(sweep.size(), 3u * 2 * 2 * 10);
  const std::optional<Batch> all = missing("good", sweep.size());
  body(sweep, "good")(*all, 0, [] {});
  Table table;
  const MergeOutcome good = merge_records(out("good"), sweep, table);
  EXPECT_EQ(good.finished + good.broken, sweep.size());
  EXPECT_GT(good.broken, 0u);
  EXPECT_EQ(lines(out("good") / "table.csv").size(), sweep.size() + 1);
  EXPECT_EQ(lines(out("good") / "missing.csv").size(), good.broken + 1);
  for (unsigned seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE(seed);
    const std::string name = "bad" + std::to_string(seed);
    const Sweep same = planned(name);
    FakeEngine engine(body(same, name), seed);
    do_all(same, engine, name, 7);
    EXPECT_GT(engine.lost, 0);
    EXPECT_GT(engine.repeated, 0);
    EXPECT_GT(engine.killed, 0);
    Table again;
    EXPECT_TRUE(merge_records(out(name), same, again).complete());
    EXPECT_EQ(contents(out(name) / "table.csv"), contents(out("good") / "table.csv"));
    EXPECT_EQ(contents(out(name) / "missing.csv"), contents(out("good") / "missing.csv"));
  }
}

/// Killed while a batch is planned, the next call plans it again; so it does where an older version was killed.
TEST_F(Engines, ABatchIsThereWholeOrNotAtAll) {
  planned();
  int given = 0;
  const auto killed = [&](std::uint64_t& run) {
    if (given == 1) throw Killed{};
    run = static_cast<std::uint64_t>(given++);
    return true;
  };
  EXPECT_THROW(make_batch(out(), killed, 1, false), Killed);
  EXPECT_TRUE(batches_in(out()).empty());
  const std::optional<Batch> batch = missing("out", 1);
  EXPECT_THAT(batches_in(out()), testing::ElementsAre("1"));
  EXPECT_EQ(read_batch(out(), "1").runs, 2u);
  EXPECT_EQ(batch->folder, out() / "batches/1");
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(out() / "batches"))
    names.push_back(entry.path().filename().string());
  EXPECT_THAT(names, testing::ElementsAre("1"));
  write_text(out() / "batches/2/runs", "00000000\n");
  write_text(out() / "batches/notes/submission.json", "{}");
  EXPECT_THAT(batches_in(out()), testing::ElementsAre("1"));
  EXPECT_EQ(missing("out", 1)->folder, out() / "batches/3");
}

/// What is left of a task's note tells nothing; the others do.
TEST_F(Engines, ADamagedNoteOfATaskIsPassedOver) {
  planned();
  const std::optional<Batch> batch = missing("out", 1);
  ASSERT_EQ(batch->tasks(), 2u);
  write_text(batch->folder / "task-0.json", "{}");
  TaskNote(*batch, 1).end(task_broke, "why");
  EXPECT_THAT(task_troubles(*batch), testing::ElementsAre(testing::AllOf(testing::StartsWith("task 1 on "),
                                                                         testing::EndsWith(" ended with 4: why"))));
}

}  // namespace test_engine
}  // namespace gripline::sweep
