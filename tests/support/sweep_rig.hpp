// A small sweep whose runs are not raced: what they leave is drawn from what they are.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "support/host_support.hpp"
#include "sweep/engine.hpp"
#include "sweep/keys.hpp"
#include "sweep/merge.hpp"
#include "sweep/store.hpp"
#include "sweep/task.hpp"

namespace gripline::sweep {

/// Two rows of a small experiment; the folder is gone afterwards.
class SweepRig : public testing::Test {
 protected:
  SweepRig() {
    const std::string world = (testing_support::fixture_dir() / "worlds/short.json").string();
    testing_support::write_text(file(), R"({"world": ")" + world + R"(", "base": {"model": {"plugin": "ekinematic"},
      "planner": {"plugin": "fixed_speed", "params": {"mu": 0.3}}, "controller": {"plugin": "pure_pursuit"}},
      "stacks": {"slow": {}, "fast": {"mu_init": 0.9}}, "claims": ["slow.violation_s <= 1"]})");
    request_.files = {file()};
  }
  std::filesystem::path file() const { return folder_ / "experiments/small.json"; }
  std::filesystem::path out(const std::string& name = "out") const { return folder_ / name; }
  void factors(const std::vector<std::string>& assignments) {
    std::vector<Factor> all;
    for (const std::string& one : assignments) all.push_back(parse_factor(one));
    request_.design = Design::factorial(std::move(all));
  }
  Sweep planned(const std::string& name = "out") {
    const Sweep sweep = plan(request_, testing_support::plugins());
    require_sweep_folder(out(name));
    write_manifest(out(name), sweep, testing_support::plugins());
    return read_manifest(out(name));
  }
  /// As the runs of this experiment would: the setting decides, the seed adds noise, one in twenty breaks.
  Attempt drawn(const Sweep& sweep, const RunAt& run) {
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
    return {record, {}, false, false};
  }
  TaskBody body(const Sweep& sweep, const std::string& name = "out") {
    auto worker = std::make_shared<Worker>(sweep, testing_support::plugins(), out(name), out(name) / "work");
    worker->run_with([this, &sweep](const RunAt& run) { return drawn(sweep, run); });
    return [worker](const Batch& batch, std::size_t task, const std::function<void()>& done) {
      return worker->run(batch, task, done);
    };
  }
  std::optional<Batch> missing(const std::string& name, std::size_t chunk) const {
    const KeyFile keys(out(name), read_manifest(out(name)));
    const Store store(out(name));
    std::vector<std::uint64_t> left;
    for (std::size_t i = 0; i < keys.size(); ++i)
      if (!store.has(keys.key(i), true)) left.push_back(i);
    if (left.empty()) return std::nullopt;
    std::size_t next = 0;
    return make_batch(
        out(name), [&](std::uint64_t& run) { return next < left.size() && (run = left[next++], true); }, chunk, false);
  }

  testing_support::Folder folder_;
  Request request_;
  int runs_ = 0;
  std::mt19937 clock_{std::random_device{}()};  // of what differs from run to run, on purpose
};

}  // namespace gripline::sweep
