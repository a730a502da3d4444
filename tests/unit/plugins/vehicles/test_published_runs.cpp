// The logs of the published runs, replayed by the shipped world: its plant, its car, its friction, its start.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "support/host_support.hpp"
#include "support/paths.hpp"
#include "support/reference_data.hpp"
#include "support/whole_world.hpp"
#include "util/csv.hpp"
#include "world/friction.hpp"
#include "world/world.hpp"

namespace gripline {
namespace test_published_runs {

using namespace testing_support;

/// A shipped world with another integrator for its plant.
WorldSpec shipped(const char* file, const char* integrator, int substeps = 1) {
  Node tree = load_json(source_dir() / "worlds" / file);
  inline_world_files(tree);
  tree.find("plant")->set("integrator", Node(integrator));
  tree.find("plant")->set("substeps", Node(substeps));
  return world_from(std::move(tree), plugins());
}

struct Log {
  std::vector<State> x;          // without steering
  std::vector<double> d, steer;  // held for 20 ms from the row on
};

class PublishedRuns : public WithReference {
 protected:
  static Log read(const char* name, double until = 1e9) {
    const CsvTable table = read_csv(reference(name));
    const auto column = [&](const char* header) { return table.column(header); };
    const std::vector<double> t = column("t_s"), x = column("x_m"), y = column("y_m"), yaw = column("psi_rad"),
                              vx = column("vx_mps"), vy = column("vy_mps"), omega = column("omega_radps"),
                              d = column("pwm_cmd"), steer = column("steer_cmd_rad");
    Log log;
    for (std::size_t i = 0; i < t.size() && t[i] <= until + 1e-9; ++i) {
      log.x.push_back({x[i], y[i], yaw[i], vx[i], vy[i], omega[i], 0});
      log.d.push_back(d[i]);
      log.steer.push_back(steer[i]);
    }
    return log;
  }

  /// One control step of a world's car from a logged state, under the world's own friction of that step.
  class OneStep {
   public:
    OneStep(const char* file, const char* integrator, int substeps = 1)
        : world_(shipped(file, integrator, substeps)),
          friction_(world_.friction, world_.dt),
          vehicle_(world_.vehicle, context()),
          model_(vehicle_.car(), {world_.dt, world_.hold, world_.vehicle.integration}) {
      for (std::size_t i = 0; i < world_.vehicle.model.values.size(); ++i) {
        const std::string name = world_.vehicle.model.entry->params()[i].name;
        if (name == "Df") front_ = i;
        if (name == "Dr") rear_ = i;
      }
    }
    State from(const Log& log, std::size_t row) {
      const double factor = friction_.base(static_cast<std::int64_t>(row), 0.02 * static_cast<double>(row));
      model_.set_parameter(front_, world_.vehicle.model.values[front_].number * factor);
      model_.set_parameter(rear_, world_.vehicle.model.values[rear_].number * factor);
      State x = log.x[row];
      x.delta = log.steer[row];
      return model_.advance(x, {log.d[row], 0}, {});
    }

   private:
    PluginContext context() const {
      PluginContext context;
      context.car = world_.car.car;
      context.dt = world_.dt;
      return context;
    }
    WorldSpec world_;
    FrictionSchedule friction_;
    Vehicle vehicle_;
    CorrectedModel model_;
    std::size_t front_ = 0, rear_ = 0;
  };

  /// Largest difference in the six states, yaw modulo a turn.
  static double distance(const State& a, const State& b) {
    double worst = std::abs(std::remainder(a.yaw - b.yaw, 2 * std::numbers::pi));
    for (const double gap : {a.x - b.x, a.y - b.y, a.vx - b.vx, a.vy - b.vy, a.omega - b.omega})
      worst = std::max(worst, std::abs(gap));
    return worst;
  }

  /// The published method reproduces every row; ours differs by no more than both methods' distance from the limit of
  /// ever smaller steps. Returns the largest difference of ours.
  static double check(const char* world, const Log& log) {
    OneStep published(world, "rkf5"), ours(world, "rk6"), limit(world, "rk6", 32);
    double worst_published = 0, worst_ours = 0;
    for (std::size_t row = 0; row + 1 < log.x.size(); ++row) {
      const State theirs = published.from(log, row), sixth = ours.from(log, row), exact = limit.from(log, row);
      worst_published = std::max(worst_published, distance(theirs, log.x[row + 1]));
      worst_ours = std::max(worst_ours, distance(sixth, log.x[row + 1]));
      EXPECT_LE(distance(sixth, log.x[row + 1]), distance(sixth, exact) + distance(theirs, exact) + 1e-6)
          << "row " << row;
    }
    EXPECT_LT(worst_published, 1e-6);
    return worst_ours;
  }
};

TEST_F(PublishedRuns, TrueModelControllerOnFreshTyres) {
  const Log log = read("run_bayesrace_nmpc_true_ethz.csv", 8.08);
  EXPECT_GT(log.x.size(), 400u);
  const double ours = check("ethz.json", log);
  RecordProperty("largest_difference_rk6", std::to_string(ours));
}

TEST_F(PublishedRuns, AdaptiveControllerOnWearingTyres) {
  const Log log = read("run_apacrace_ethz_varspeeds.csv");
  EXPECT_GT(log.x.size(), 1700u);
  const double ours = check("ethz_wear.json", log);
  RecordProperty("largest_difference_rk6", std::to_string(ours));
}

/// The world as a whole: from the published start, under the published commands, without looking at the log again.
TEST_F(PublishedRuns, TheWorldDrivesThePublishedRunByItself) {
  const Log log = read("run_apacrace_ethz_varspeeds.csv", 4.0);
  const WorldSpec spec = shipped("ethz_wear.json", "rkf5");
  World world(spec, 1);
  EXPECT_LT(distance(world.state(), log.x[0]), 1e-6);
  for (std::size_t row = 0; row + 1 < log.x.size(); ++row) {
    const Input applied = world.advance({log.d[row], (log.steer[row] - world.state().delta) / 0.02});
    ASSERT_NEAR(world.state().delta, log.steer[row], 1e-6) << "row " << row;  // the limits let it through
    ASSERT_NEAR(applied.d, log.d[row], 1e-6) << "row " << row;
    ASSERT_LT(distance(world.state(), log.x[row + 1]), 1e-3) << "row " << row;
  }
}

}  // namespace test_published_runs
}  // namespace gripline
