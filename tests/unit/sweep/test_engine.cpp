// Sweeps on a cluster that loses, repeats and delays jobs, kills them half way and damages what they leave: the table
// is always that of an engine that does everything once and in order.
#include "sweep/engine.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <map>
#include <optional>
#include <random>
#include <set>
#include <sstream>
#include <stdexcept>

#include "support/host_support.hpp"
#include "sweep/factor_statistics.hpp"
#include "sweep/merge.hpp"
#include "sweep/store.hpp"
#include "sweep/task.hpp"

namespace gripline::sweep {
namespace {

namespace fs = std::filesystem;
using namespace testing_support;
using testing::ElementsAre;
using testing::HasSubstr;

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
  EngineState status(const Submission&) override { return {}; }
  void cancel(const Submission&) override {}
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

/// A sweep of a small experiment whose runs are not raced: what they leave is drawn from what they are.
class Sweeps : public testing::Test {
 protected:
  Sweeps() {
    const std::string world = (fixture_dir() / "worlds/short.json").string();
    write_text(file(), R"({"world": ")" + world + R"(", "base": {"model": {"plugin": "ekinematic"},
      "planner": {"plugin": "fixed_speed", "params": {"mu": 0.3}}, "controller": {"plugin": "pure_pursuit"}},
      "stacks": {"slow": {}, "fast": {"mu_init": 0.9}}, "claims": ["slow.violation_s <= 1"]})");
    request_.files = {file()};
  }
  fs::path file() const { return folder_ / "experiments/small.json"; }
  fs::path out(const std::string& name = "out") const { return folder_ / name; }
  void factors(const std::vector<std::string>& assignments) {
    std::vector<Factor> all;
    for (const std::string& one : assignments) all.push_back(parse_factor(one));
    request_.design = Design::factorial(std::move(all));
  }
  Sweep planned(const std::string& name = "out") {
    const Sweep sweep = plan(request_, plugins());
    require_sweep_folder(out(name));
    write_manifest(out(name), sweep, plugins());
    return read_manifest(out(name));
  }
  /// As the runs of this experiment would: the setting decides, the seed adds noise, one in twenty breaks.
  Record drawn(const Sweep& sweep, const RunAt& run) {
    ++runs_;
    // Not from the key, which differs from build to build.
    std::string name = sweep.row_of(run) + std::to_string(run.seed);
    for (const std::string& value : sweep.design.setting(run.setting)) name += " " + value;
    std::seed_seq words(name.begin(), name.end());
    std::mt19937 random(words);
    const double noise = std::uniform_real_distribution(-0.1, 0.1)(random);
    const double pace = std::stod(sweep.design.setting(run.setting).front());
    Record record;
    record.status = "finished";
    record.values = {{"lap0_s", pace * pace + noise}, {"violation_s", run.row == 0 ? pace : 2 * pace}};
    if (run.seed % 2 == 0) record.values.emplace_back("lap1_s", pace);
    record.times = {{"cpu_s", std::uniform_real_distribution(0.0, 1.0)(clock_)}};
    record.node = "node" + std::to_string(clock_() % 3);
    if (run.row == 1 && run.seed % 10 == 7)
      record.status = "error", record.message = "its plugin, \"x\", failed", record.values.clear();
    return record;
  }
  TaskBody body(const Sweep& sweep, const std::string& name = "out") {
    auto worker = std::make_shared<Worker>(sweep, plugins(), out(name), out(name) / "work");
    worker->run_with([this, &sweep](const RunAt& run, const std::string&, bool&) { return drawn(sweep, run); });
    return [worker](const Batch& batch, std::size_t task, const std::function<void()>& done) {
      return worker->run(batch, task, done);
    };
  }
  std::optional<Batch> missing(const std::string& name, std::size_t chunk) const {
    const KeyFile keys(out(name));
    const Store store(out(name));
    std::vector<std::uint64_t> left;
    for (std::size_t i = 0; i < keys.size(); ++i)
      if (!store.has(keys.key(i), true)) left.push_back(i);
    if (left.empty()) return std::nullopt;
    std::size_t next = 0;
    return make_batch(
        out(name), [&](std::uint64_t& run) { return next < left.size() && (run = left[next++], true); }, chunk, false);
  }
  void do_all(const Sweep& sweep, Engine& engine, const std::string& name, std::size_t chunk) const {
    for (int i = 0; i < 40; ++i) {
      const std::optional<Batch> batch = missing(name, chunk);
      if (!batch) return;
      Submission submission;
      engine.submit(*batch, submission, [&] { write_submission(*batch, submission); });
    }
    FAIL() << "forty batches of " << sweep.size() << " runs were not enough";
  }

  Folder folder_;
  Request request_;
  int runs_ = 0;
  std::mt19937 clock_{std::random_device{}()};  // of what differs from run to run, on purpose
};

TEST_F(Sweeps, NothingIsLostOrDoubledByAnEngineThatLosesRepeatsAndDelays) {
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

TEST_F(Sweeps, MissingRunsAreNamedAndDamagedRecordsAreMissing) {
  factors({"/base/planner/params/mu=0.3,0.4"});
  const Sweep sweep = planned();
  const std::optional<Batch> first = missing("out", 2);
  body(sweep)(*first, 0, [] {});
  EXPECT_EQ(runs_, 2);
  Table table;
  MergeOutcome outcome = merge_records(out(), sweep, table);
  EXPECT_EQ(outcome.missing, 2u);
  EXPECT_THAT(lines(out() / "missing.csv").back(), HasSubstr("3,small,1,fast,1,missing,"));
  const std::string key = KeyFile(out()).key(0);
  const fs::path record = out() / "results" / key.substr(0, 2) / (key + ".json");
  ASSERT_TRUE(fs::exists(record));
  for (const std::string& damaged : {std::string(), contents(record).substr(0, 100), contents(record) + "x"}) {
    write_text(record, damaged);
    Table again;
    EXPECT_EQ(merge_records(out(), sweep, again).missing, 3u);
    EXPECT_FALSE(fs::exists(record));
  }
  const std::optional<Batch> rest = missing("out", 10);
  EXPECT_EQ(rest->runs, 3u);
  body(sweep)(*rest, 0, [] {});
  Table whole;
  EXPECT_TRUE(merge_records(out(), sweep, whole).complete());
}

TEST_F(Sweeps, ASecondRunOfTheSameSweepComputesNothingAndALargerOneOnlyWhatIsNew) {
  factors({"/base/planner/params/mu=0.3,0.4"});
  const Sweep sweep = planned();
  body(sweep)(*missing("out", 100), 0, [] {});
  EXPECT_EQ(runs_, 4);
  planned();
  EXPECT_FALSE(missing("out", 100));
  factors({"/base/planner/params/mu=0.4,0.45,0.3"});
  const Sweep larger = planned();
  EXPECT_EQ(missing("out", 100)->runs, 2u);
  body(larger)(*missing("out", 100), 0, [] {});
  EXPECT_EQ(runs_, 6);
}

TEST_F(Sweeps, KeysDependOnWhatIsRacedAndOnNothingElse) {
  factors({"/base/planner/params/mu=0.3,0.4"});
  planned();
  const std::string keys = contents(out() / "keys.txt");
  EXPECT_EQ(keys.size(), 4u * 65);
  const std::string text = contents(file());
  const auto with = [&](const std::string& what, const std::string& by) {
    std::string changed = text;
    changed.replace(changed.find(what), what.size(), by);
    write_text(file(), changed);
    planned("other");
    return contents(out("other") / "keys.txt");
  };
  EXPECT_EQ(with("\"claims\": [\"slow.violation_s <= 1\"]", "\"note\": \"no claims\""), keys);
  EXPECT_EQ(with("{\"world\"", "{\"seeds\": {\"first\": 1, \"count\": 1}, \"world\""), keys);
  const std::string other = with("\"mu_init\": 0.9", "\"mu_init\": 0.95");  // of the row `fast` alone
  EXPECT_EQ(other.substr(0, 65), keys.substr(0, 65));
  EXPECT_NE(other.substr(65, 65), keys.substr(65, 65));
  EXPECT_NE(with("pure_pursuit", "mpc_sqp"), keys);
  write_text(file(), text);
  request_.assignments = {"/world/duration=0.25"};
  planned("other");
  EXPECT_NE(contents(out("other") / "keys.txt"), keys);
}

TEST_F(Sweeps, AValueThatIsRefusedIsToldAtItsAssignment) {
  factors({"/base/planner/params/mu=0.3,fast"});
  EXPECT_THAT(refusal([&] { planned(); }), HasSubstr("--set /base/planner/params/mu"));
  factors({"/base/planer/params/mu=0.3,0.4"});
  EXPECT_THAT(refusal([&] { planned(); }), HasSubstr("did you mean \"planner\"?"));
  factors({});
  request_.only = {"slo"};
  EXPECT_THAT(refusal([&] { planned(); }), HasSubstr("no row \"slo\" in the experiments; did you mean \"slow\"?"));
  write_text(out("full") / "thesis.txt", "mine");
  EXPECT_THAT(refusal([&] { require_sweep_folder(out("full")); }),
              HasSubstr("already holds something that is no sweep"));
}

TEST_F(Sweeps, InputsThatChangedSinceThePlanAreRefused) {
  factors({"/base/planner/params/mu=0.3,0.4"});
  const Sweep sweep = planned();
  std::string text = contents(file());
  write_text(file(), text.replace(text.find("0.9}"), 3, "0.8"));
  testing::internal::CaptureStderr();
  EXPECT_EQ(body(sweep)(*missing("out", 100), 0, [] {}), task_refused);
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("no longer those that the sweep was planned with"));
  Sweep other = sweep;
  other.program[0] = other.program[0] == 'a' ? 'b' : 'a';
  EXPECT_THAT(refusal([&] { require_same_versions(other, plugins()); }), HasSubstr("is another build than the one"));
  other = sweep;
  ASSERT_FALSE(other.libraries.empty());
  other.libraries.begin()->second = std::string(64, '0');
  EXPECT_THAT(refusal([&] { require_same_versions(other, plugins()); }), HasSubstr("results of both are not mixed"));
}

TEST_F(Sweeps, RunsThatWereKilledFromOutsideAreNotRecorded) {
  factors({"/base/planner/params/mu=0.3,0.4"});
  const Sweep sweep = planned();
  Worker worker(sweep, plugins(), out(), out() / "work");
  worker.run_with([](const RunAt&, const std::string&, bool&) {
    Record record;
    record.status = "error";
    record.message = "its process was ended by signal 9 (Killed)";
    return record;
  });
  testing::internal::CaptureStderr();
  EXPECT_EQ(worker.run(*missing("out", 100), 0, [] {}), task_again);
  testing::internal::GetCapturedStderr();
  Table table;
  EXPECT_EQ(merge_records(out(), sweep, table).missing, 4u);
}

TEST_F(Sweeps, StatisticsRankTheFactorThatMakesTheDifference) {
  factors({"/base/planner/params/mu=0.3,0.4,0.5,0.6", "/world/duration=0.5,1"});
  request_.seeds = parse_seeds("1..8");
  const Sweep sweep = planned();
  body(sweep)(*missing("out", 1000), 0, [] {});
  Table table;
  merge_records(out(), sweep, table);
  const Statistics statistics = analyse(table);
  EXPECT_THAT(statistics.varying, ElementsAre("/base/planner/params/mu", "/world/duration", "stack"));
  const auto response = [&](const std::string& name) {
    return *std::find_if(statistics.responses.begin(), statistics.responses.end(),
                         [&](const ResponseStatistic& one) { return one.name == name; });
  };
  const ResponseStatistic lap = response("lap0_s"), outside = response("violation_s");
  EXPECT_EQ(lap.effects.front().factor, "/base/planner/params/mu");
  EXPECT_GT(lap.effects.front().main, 0.5);
  EXPECT_GT(lap.seeds, 0.02);
  // violation_s = mu x (1 or 2): both factors and their product, nothing from seeds or duration.
  EXPECT_NEAR(outside.seeds, 0, 1e-12);
  const FactorEffect& last = outside.effects.back();
  EXPECT_EQ(last.factor, "/world/duration");
  EXPECT_NEAR(last.total, 0, 1e-9);
  const auto stack = std::find_if(outside.effects.begin(), outside.effects.end(),
                                  [](const FactorEffect& effect) { return effect.factor == "stack"; });
  EXPECT_GT(stack->total, stack->main);
  ASSERT_FALSE(outside.best.empty());
  EXPECT_THAT(outside.best.front().levels, ElementsAre("0.3", testing::_, "slow"));
  EXPECT_NEAR(outside.best.front().median, 0.3, 1e-12);
  write_statistics(out(), sweep, {}, table, statistics);
  for (const char* name : {"factors.csv", "sensitivity.csv", "best.csv", "sweep_report.json"})
    EXPECT_TRUE(fs::exists(out() / name)) << name;
}

std::size_t resident_kb() {
  std::ifstream in("/proc/self/status");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("VmRSS:")) return std::stoul(line.substr(6));
  return 0;
}

/// Ten thousand keys in two seconds (issue), and a plan of a hundred thousand that needs no more memory than one of a
/// thousand. Times of a busy machine are those of others: CPU time is asked.
TEST_F(Sweeps, PlanningIsFastAndNeedsNoMemoryForItsRuns) {
  std::string levels = "/base/planner/params/mu=0.3";
  for (int i = 1; i < 100; ++i) levels += "," + std::to_string(0.3 + 0.001 * i);
  factors({levels, "/world/duration=0.5,1,1.5,2,2.5"});
  request_.seeds = parse_seeds("1..10");
  const Sweep ten_thousand = plan(request_, plugins());
  ASSERT_EQ(ten_thousand.size(), 10'000u);
  fs::create_directories(out("big"));
  const std::clock_t begin = std::clock();
  write_manifest(out("big"), ten_thousand, plugins());
  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 2.0);
  const std::size_t before = resident_kb();
  request_.seeds = parse_seeds("1..100");
  const Sweep hundred_thousand = plan(request_, plugins());
  ASSERT_EQ(hundred_thousand.size(), 100'000u);
  write_manifest(out("big"), hundred_thousand, plugins());
  EXPECT_LT(resident_kb(), before + 4096);
}

}  // namespace
}  // namespace gripline::sweep
