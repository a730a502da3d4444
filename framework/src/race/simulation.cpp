#include "race/simulation.hpp"

#include <algorithm>
#include <cmath>

#include "config/node.hpp"
#include "geometry/course_adapter.hpp"
#include "plugin/guard.hpp"
#include "util/clock.hpp"
#include "util/numbers.hpp"

namespace gripline {
namespace {

/// Calls a plugin: its exceptions become PluginFailure, its CPU time [ms] goes to `spent_ms`.
template <class F>
void timed_call(const std::string& who, double t, double& spent_ms, F&& call) {
  const double begin = thread_cpu_s();
  guard(who, t, call);
  spent_ms = 1e3 * (thread_cpu_s() - begin);
}

/// For messages: a place or a speed to one decimal.
std::string tenths(double value) { return number_text(std::round(10 * value) / 10); }

/// Every member of a reference: controllers may read any of them.
void require_finite_reference(const std::string& who, double t, const RefPoint& r) {
  const Place& at = r.at;
  require_finite(who, t, "a reference", {r.s, r.x, r.y, r.yaw, r.kappa, r.v, r.left, r.right, r.beta});
  require_finite(who, t, "a reference",
                 {at.t, at.s, at.n, at.lap_fraction, at.yaw_line, at.kappa, at.grade, at.bank, at.direction, at.grip});
}

}  // namespace

Simulation::Simulation(World& world, Stack& stack, Metrics& metrics, Recorder* recorder)
    : world_(world), stack_(stack), metrics_(metrics), recorder_(recorder), end_(world), now_(world.observe()) {
  const int points = stack_.controller().horizon();
  if (points < 1 || points > 10000)
    throw PluginFailure(stack_.spec().controller.id() + ": wants a horizon of " + std::to_string(points) + " points");
  horizon_.resize(static_cast<std::size_t>(points));
  acted_on_ = now_;
  if (!stack_.spec().state_filter) return;
  filter_.emplace(*stack_.spec().state_filter);
  filter_->start(now_.x);
}

/// The instant before the first step: there is nothing to learn from yet, and the car needs a first command.
void Simulation::start() { decide(); }

void Simulation::step() {
  const Observation before = now_;
  const State true_before = world_.state();
  const Place true_place = world_.place();
  u_ = guard(world_.plant_id(), now_.t, [&] { return world_.advance(command_.u); });  // line 3: x_t+1 <- dynamics
  if (!world_.finite()) return;                                                       // over
  end_.watch();
  now_ = world_.observe();
  metrics_.step();
  if (observer_ != nullptr) observer_->on_step(true_before, true_place, u_, world_, stack_);
  filter_reading();
  sample_ = stack_.sample(before, u_, now_);  // line 4: e = x_t+1 - f_nom(x_t, u_t)
  if (learns_)                                // lines 5-7
    timed_call(stack_.spec().estimator.id(), now_.t, timing_.update_ms, [&] { stack_.learn(sample_); });
  decide();  // lines 8-15
}

/// What planner and controller act on. The model's memory is still that of the step's start.
void Simulation::filter_reading() {
  const Place from = acted_on_.at;
  acted_on_ = now_;
  if (!filter_) return;
  guard(stack_.spec().model.model.id(), now_.t, [&] { filter_->predict(*model_, u_, from); });
  filter_->update(now_.x, world_.spec().sensors.read_at(now_.step));
  acted_on_.x = filter_->state();
  const State& x = acted_on_.x;
  require_finite(stack_.spec().model.model.id(), now_.t, "a prediction", {x.x, x.y, x.yaw, x.vx, x.vy, x.omega});
  acted_on_.at = place_of(world_.track(), world_.track().locate(x.x, x.y, now_.at.s), now_.t, x.x, x.y, x.yaw);
}

void Simulation::decide() {
  StackBelief belief = stack_.belief(now_.t);  // lines 8-13: {f_corr, mu} or {f_nom, mu_init}
  model_ = belief.model;
  timed_call(stack_.spec().planner.id(), now_.t, timing_.plan_ms,
             [&] { stack_.planner().plan(acted_on_, belief.mu, belief.learned, horizon_); });  // line 14
  for (const RefPoint& point : horizon_) require_finite_reference(stack_.spec().planner.id(), now_.t, point);
  timed_call(stack_.spec().controller.id(), now_.t, timing_.solve_ms,
             [&] { command_ = stack_.controller().control(acted_on_, horizon_, *belief.model); });  // line 15
  require_finite(stack_.spec().controller.id(), now_.t, "a command", {command_.u.d, command_.u.ddelta});
  if (!belief.model->smooth_since_asked())
    throw PluginFailure(stack_.nonfinite_plugin(acted_on_, command_.u) +
                        format(" at t = %f s: returned a derivative that is not a number", now_.t));
  const auto line = guard(stack_.spec().planner.id(), now_.t, [&] { return stack_.planner().line(); });
  const double latency = stack_.planner().latency();
  require_finite(stack_.spec().planner.id(), now_.t, "a latency", {latency});
  if (world_.step() > 0)
    metrics_.decision(belief, line, command_.solved, latency);
  else
    metrics_.start(command_.solved);
  if (recorder_ == nullptr) return;
  recorder_->write(
      {world_, stack_, belief, horizon_, command_, world_.clamp_to_limits(command_.u), metrics_.mu_true(), timing_});
}

bool Simulation::over(RunSummary& summary) const {
  const std::optional<Status> ended = end_.status();
  if (ended) summary = metrics_.summary(*ended, why(*ended));
  return ended.has_value();
}

/// Why a race did not finish.
std::string Simulation::why(Status ended) const {
  const State& x = world_.state();
  switch (ended) {
    case Status::error:
      return world_.plant_id() + format(" at t = %f s: gave the world's car a state that is not a number", now_.t);
    case Status::crashed:
      return "hit the wall at s = " + tenths(world_.place().s) + " m with " + tenths(std::hypot(x.vx, x.vy)) + " m/s";
    case Status::stuck:
      return "stationary at s = " + tenths(world_.place().s) + " m since " + tenths(end_.moved_at()) + " s";
    case Status::timeout:
      return "still driving after " + number_text(world_.spec().timeout) + " s";
    default:
      return "";
  }
}

void Simulation::tell_progress() const {
  if (!progress_) return;
  const WorldSpec& spec = world_.spec();
  const double laps = world_.covered() / world_.track().length();
  progress_(std::clamp(spec.laps > 0 ? laps / spec.laps : world_.time() / *spec.duration, 0.0, 1.0));
}

RunSummary Simulation::run() {
  RunSummary summary;
  try {
    start();
    while (!over(summary)) {
      step();
      tell_progress();
    }
  } catch (const PluginFailure& failure) {
    summary = metrics_.summary(Status::plugin_error, failure.what());
  }
  return summary;
}

}  // namespace gripline
