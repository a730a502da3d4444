#include "race/recorder.hpp"

#include <unistd.h>

#include <array>
#include <cmath>

#include "plugin/guard.hpp"
#include "race/run_files.hpp"
#include "util/clock.hpp"

namespace gripline {
namespace {

constexpr std::string_view steps_header =
    "t_s,x_m,y_m,yaw_rad,vx_mps,vy_mps,yaw_rate_radps,d,delta_rad,x_true_m,y_true_m,yaw_true_rad,vx_true_mps,"
    "vy_true_mps,yaw_rate_true_radps,d_applied,delta_applied_rad,mu_belief_front,mu_belief_rear,mu_true,s_m,offset_m,"
    "lap,outside,v_ref_mps,iterations,solved";

constexpr int shown_points = 10;        // of a horizon, in replay.csv
constexpr int replay_every = 5;         // control steps
constexpr std::size_t slip_count = 41;  // per axle, in tyres.csv
constexpr double shown_slip = 0.6;      // [rad]

std::string replay_header() {
  std::string header = "t_s,mu_sigma_front,mu_sigma_rear,slip_front_rad,slip_rear_rad,force_front_n,force_rear_n";
  for (const char* what : {"plan", "ref"})
    for (int i = 0; i < shown_points; ++i) {
      const std::string name = what + std::to_string(i);
      header += "," + name + "_x_m," + name + "_y_m";
    }
  return header;
}

/// Ten points spread evenly over a sequence, the last one being its end.
template <class P>
void write_points(CsvWriter& out, std::span<const P> points) {
  for (int i = 0; i < shown_points; ++i) {
    if (points.empty()) {
      out << NAN << NAN;
      continue;
    }
    const auto last = static_cast<double>(points.size() - 1);
    const auto& p = points[static_cast<std::size_t>(std::lround(last * (i + 1) / shown_points))];
    out << p.x << p.y;
  }
}

/// What a plugin returns; its exceptions become PluginFailure.
template <class F>
auto call_plugin(const StepRecord& record, const PluginSpec& plugin, F&& call) {
  return guard(plugin.id(), record.world.time(), call);
}

}  // namespace

Recorder::Recorder(const std::filesystem::path& folder)
    : folder_(folder),
      process_(getpid()),
      steps_(folder / run_files::steps, steps_header),
      timing_(folder / run_files::timing, "t_s,update_ms,plan_ms,solve_ms,cpu_s"),
      replay_(folder / run_files::replay, replay_header()),
      tyres_(folder / run_files::tyres, "t_s,axle,slip_rad,learned_n,sigma_n,true_n") {}

void Recorder::write(const StepRecord& record) {
  if (getpid() != process_) _exit(1);  // a process that a plugin forked: the files belong to its parent
  if (record.world.step() == 0)
    write_line(call_plugin(record, record.stack.spec().planner, [&] { return record.stack.planner().line(); }));
  write_step(record);
  timing_ << record.world.time() << record.timing.update_ms << record.timing.plan_ms << record.timing.solve_ms
          << process_cpu_s();
  timing_.end_row();
  if (record.world.step() % replay_every == 0) write_replay(record);
  const auto per_second = static_cast<std::int64_t>(std::lround(1.0 / record.world.spec().dt));
  if (record.world.step() % per_second == 0) write_tyres(record);
}

void Recorder::finish() {
  for (CsvWriter* file : {&steps_, &timing_, &replay_, &tyres_}) file->finish();
}

void Recorder::write_step(const StepRecord& record) {
  const World& world = record.world;
  const State& seen = world.observe().x;
  const State& truth = world.state();
  const double dt = world.spec().dt;
  // Under a held command the row states the one given now; under the others the one reached now.
  const bool held = world.spec().hold == Hold::zoh;
  const double d = held ? record.sent.d : world.observe().d;
  const double delta = held ? truth.delta + dt * record.sent.ddelta : truth.delta;
  const World::Acting acting = world.acting_under(record.sent);
  steps_ << world.time() << seen.x << seen.y << seen.yaw << seen.vx << seen.vy << seen.omega << d << delta << truth.x
         << truth.y << truth.yaw << truth.vx << truth.vy << truth.omega << acting.d << acting.delta
         << record.belief.mu.mu_front << record.belief.mu.mu_rear << record.mu_true << world.place().s
         << world.place().n << world.laps() << (world.outside() ? 1 : 0)
         << (record.horizon.empty() ? NAN : record.horizon.front().v) << record.command.iterations
         << (record.command.solved ? 1 : 0);
  steps_.end_row();
}

void Recorder::write_line(std::span<const LinePoint> line) const {
  if (line.empty()) return;
  CsvWriter out(folder_ / run_files::line, "s_m,x_m,y_m");
  for (const LinePoint& point : line) {
    out << point.s << point.x << point.y;
    out.end_row();
  }
  out.finish();
}

void Recorder::write_replay(const StepRecord& record) {
  const World& world = record.world;
  const World::Acting acting = world.acting_under(record.sent);
  replay_ << world.time() << record.belief.mu.sigma_front << record.belief.mu.sigma_rear << acting.slip_front
          << acting.slip_rear << acting.force_front << acting.force_rear;
  write_points(replay_, call_plugin(record, record.stack.spec().controller,
                                    [&] { return record.stack.controller().predicted(); }));
  write_points(replay_, record.horizon);
  replay_.end_row();
}

void Recorder::write_tyres(const StepRecord& record) {
  const TyreCurve* const curve = record.stack.tyre_curve();
  if (curve == nullptr) return;
  std::array<double, slip_count> slip{}, force{}, sigma{};
  for (std::size_t i = 0; i < slip_count; ++i)
    slip[i] = shown_slip * (2.0 * static_cast<double>(i) / (slip_count - 1) - 1.0);
  for (const Axle axle : {Axle::front, Axle::rear}) {
    const bool known =
        call_plugin(record, record.stack.spec().estimator, [&] { return curve->tyre_force(axle, slip, force, sigma); });
    if (!known) return;
    for (std::size_t i = 0; i < slip_count; ++i) {
      tyres_ << record.world.time() << (axle == Axle::front ? "front" : "rear") << slip[i] << force[i] << sigma[i]
             << record.world.truth().tyre_force(axle, slip[i]);
      tyres_.end_row();
    }
  }
}

}  // namespace gripline
