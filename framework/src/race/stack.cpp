#include "race/stack.hpp"

#include <algorithm>

#include "config/hash.hpp"
#include "plugin/guard.hpp"
#include "util/numbers.hpp"

namespace gripline {
namespace {

/// The cache folder of a plugin. Its name has the hash of the library, so that a rebuilt library does not read results
/// of another build.
std::string cache_of(const PluginSpec& spec, const std::string& cache_dir) {
  if (cache_dir.empty() || spec.empty()) return {};
  const std::string hash = sha256_of_file(spec.entry->library).substr(0, 16);
  // A plugin that is given the ground truth has a folder of its own: no other plugin of its library reads from it.
  return cache_dir + "/" + spec.entry->library.stem().string() + "-" + hash +
         (spec.entry->needs_truth() ? "-told" : "");
}

/// An instance with truth if, and only if, the plugin declares that it needs it.
template <class Interface>
Instance<Interface> create_for(const PluginSpec& spec, PluginContext context, const Truth* truth,
                               const std::string& cache_dir) {
  context.cache_dir = cache_dir.empty() ? nullptr : cache_dir.c_str();
  context.truth = spec.entry->needs_truth() ? truth : nullptr;
  return create<Interface>(*spec.entry, context, spec.values);
}

void require_friction(const std::string& who, double t, const Belief& mu) {
  const auto numbers = {mu.mu_front, mu.mu_rear, mu.sigma_front, mu.sigma_rear};
  require_finite(who, t, "a friction", numbers);
  if (std::ranges::min(numbers) < 0.0)
    throw PluginFailure(who +
                        format(" at t = %f s: returned a friction of %g and %g, sigma %g and %g; expected none below 0",
                               t, mu.mu_front, mu.mu_rear, mu.sigma_front, mu.sigma_rear));
}

/// The callback as plugins call it; it must outlive them.
PluginContext with_progress(PluginContext context, PreparingCallback& callback) {
  if (!callback) return context;
  context.progress = [](void* to, const char* what, double fraction) {
    (*static_cast<PreparingCallback*>(to))(what != nullptr ? what : "preparing", fraction);
  };
  context.progress_context = &callback;
  return context;
}

void refuse_truth(const PluginSpec& plugin, const Node& node, Errors& errors) {
  if (!plugin.empty() && plugin.entry->needs_truth())
    errors.add(node.origin, "\"" + plugin.id() + "\" is given the ground truth; a stack's nominal model must not be");
}

PluginSpec read_role(ObjectReader& r, const char* key, abi::Kind kind, const Registry& registry, bool required) {
  if (!required && !r.has(key)) return {};
  ObjectReader role = r.object(key);
  PluginSpec spec = read_plugin(role, kind, registry);
  role.finish();
  return spec;
}

/// The car's constants as the stack states them: {"m", "Iz", "lf", "lr", "known_params"}, each where it differs.
CarFile read_stated_car(const Node& node, const CarFile& car, Errors& errors) {
  const std::size_t before = errors.added();
  ObjectReader r(node, errors);
  CarFile stated = car;
  const auto positive = [&](const char* name, const char* unit, double& value) {
    value = stated.known[name] = r.number(name, unit, NumberRange::positive(), value);
  };
  positive("m", "kg", stated.car.m);
  positive("Iz", "kg m2", stated.car.Iz);
  positive("lf", "m", stated.car.lf);
  positive("lr", "m", stated.car.lr);
  read_known_params(r, stated.known, errors);
  r.finish();
  if (errors.added() != before) stated.known_at.reset();
  return stated;
}

}  // namespace

PluginContext plugin_context(const StackSpec& spec, const StackContext& world) {
  PluginContext context;
  context.car = spec.car.value_or(world.car);
  context.dt = world.dt;
  context.hold = world.hold;
  context.seed = world.seed;
  context.mu_init = spec.mu_init;
  context.course = world.course;
  return context;
}

bool StackSpec::needs_truth() const {
  for (const PluginSpec* spec : {&estimator, &planner, &controller})
    if (!spec->empty() && spec->entry->needs_truth()) return true;
  return false;
}

StackSpec read_stack(const std::string& name, const Node& node, const Registry& registry, const CarFile& car,
                     Errors& errors) {
  ObjectReader r(node, errors);
  StackSpec spec;
  spec.name = name;
  CarFile stated = car;
  if (r.has("car")) {
    stated = read_stated_car(*r.find("car"), car, errors);
    check_known_params(*r.find("car"), registry, errors);
    spec.car = stated.car;
  }
  if (const Node* model = r.require("model", "a vehicle model"); model != nullptr) {
    spec.model = read_vehicle(*model, registry, stated, "rk4", errors, Readings::unread);
    refuse_truth(spec.model.model, *model, errors);
    for (const PluginSpec& effect : spec.model.effects) refuse_truth(effect, *model, errors);
  }
  spec.estimator = read_role(r, "estimator", abi::Kind::estimator, registry, false);
  spec.planner = read_role(r, "planner", abi::Kind::planner, registry, true);
  spec.controller = read_role(r, "controller", abi::Kind::controller, registry, true);
  spec.adapt_after = r.number("adapt_after", "s", NumberRange::non_negative(), 0.0);
  spec.careful_until = r.number("careful_until", "s", NumberRange::non_negative(), 0.0);
  spec.mu_init = r.number("mu_init", "1", NumberRange::closed(0.01, 10.0), 1.0);
  if (const Node* filter = r.find("state_filter"); filter != nullptr) {
    spec.state_filter = read_state_filter(*filter, stated.car, errors);
    spec.state_filter_at = filter->origin;
  }
  r.finish();
  return spec;
}

void check_sensors(const StackSpec& stack, const SensorSpec& sensors, Errors& errors) {
  if (!stack.state_filter) return;
  std::string late;
  for (std::size_t i = 0; i < sensors.channels.size(); ++i)
    if (sensors.channels[i].delay > 0) late += (late.empty() ? "" : ", ") + std::string(sensor_channels[i].name);
  if (late.empty()) return;
  errors.add(stack.state_filter_at,
             "the filter takes readings for those of now, but the world's sensors have a delay (" + late +
                 "); expected a world without it, or a stack without the filter");
}

Stack::Stack(const StackSpec& spec, const StackContext& world, const Observation& start)
    : spec_(spec),
      cache_dirs_{cache_of(spec.estimator, world.cache_dir), cache_of(spec.planner, world.cache_dir),
                  cache_of(spec.controller, world.cache_dir)},
      on_preparing_(world.on_preparing),
      context_(with_progress(plugin_context(spec, world), on_preparing_)),
      vehicle_(spec.model, context_),
      nominal_(vehicle_.car(), {world.dt, world.hold, spec.model.integration}),
      corrected_(nominal_),
      planner_(nullptr, nullptr),
      controller_(nullptr, nullptr) {
  context_.nominal = &nominal_;
  nominal_.reset(start.x, start.d, start.at);
  if (!spec.estimator.empty())
    estimator_ = create_for<Estimator>(spec.estimator, context_, world.truth, cache_dirs_[0]);
  planner_ = create_for<SpeedPlanner>(spec.planner, context_, world.truth, cache_dirs_[1]);
  controller_ = create_for<Controller>(spec.controller, context_, world.truth, cache_dirs_[2]);
  if (estimator_) {
    StagedCar car = vehicle_.car();
    car.add(**estimator_, {}, spec.estimator.id());
    corrected_ = CorrectedModel(std::move(car), {world.dt, world.hold, spec.model.integration});
  }
  corrected_.reset(start.x, start.d, start.at);
}

/// Evaluates both models before the controller does, so that a prediction that is not finite is blamed on its plugin.
Sample Stack::sample(const Observation& before, const Input& u, const Observation& now) {
  const std::string model = spec_.model.model.id(), estimator = spec_.estimator.id();
  const Sample sample = guard(model, now.t, [&] { return residual_sample(nominal_, before, u, now); });
  require_finite(model, now.t, "a prediction", {sample.e_vx, sample.e_vy, sample.e_omega});
  if (!estimator_) return sample;
  const State next = guard(estimator, now.t, [&] { return corrected_.advance(sample.x, sample.u, sample.at); });
  require_finite(estimator, now.t, "a correction", {next.x, next.y, next.yaw, next.vx, next.vy, next.omega});
  return sample;
}

void Stack::learn(const Sample& sample) {
  if (estimator_) (*estimator_)->update(sample);
}

std::string Stack::nonfinite_plugin(const Observation& now, const Input& u) const {
  for (std::size_t count = 0; count <= spec_.model.effects.size(); ++count) {
    CorrectedModel part(vehicle_.car_with(count), {context_.dt, context_.hold, spec_.model.integration});
    part.reset(now.x, now.d, now.at);
    const auto n = static_cast<std::size_t>(part.states());
    std::vector<double> x(n), next(n), A(n * n), B(2 * n);
    part.start(now.x, x);
    const double input[] = {u.d, u.ddelta};
    part.step(1, x, input, std::span(&now.at, 1), next, A, B);
    if (!part.smooth_since_asked()) return count == 0 ? spec_.model.model.id() : spec_.model.effects[count - 1].id();
  }
  return spec_.estimator.empty() ? spec_.model.model.id() : spec_.estimator.id();
}

StackBelief Stack::belief(double t) {
  StackBelief now = guard(spec_.estimator.id(), t, [&] { return believed(t); });
  require_friction(spec_.estimator.id(), t, now.mu);
  return now;
}

StackBelief Stack::believed(double t) {
  StackBelief now{&nominal_, {}, nullptr};
  now.mu.mu_front = now.mu.mu_rear = spec_.mu_init;
  if (!estimator_ || !(t > spec_.adapt_after)) return now;
  now.model = &corrected_;
  if (!(t > spec_.careful_until)) return now;
  now.mu = (*estimator_)->belief();
  now.mu.trusted = true;
  now.learned = estimator_->get();
  return now;
}

}  // namespace gripline
