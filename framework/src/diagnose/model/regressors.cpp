#include "diagnose/model/regressors.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "diagnose/model/dual_pass.hpp"
#include "measured/replay/replay.hpp"

namespace gripline::diagnose {
namespace {

bool reads(const Catalogue& catalogue, const ModelSpec& model) {
  return catalogue.pose_is_late() || std::any_of(model.members.begin(), model.members.end(), [&](std::size_t i) {
           return catalogue.candidates()[i].effect->stage() == Stage::reading;
         });
}

/// Where the fitted parameters of member i stand among the car's.
std::vector<std::size_t> slots(const Catalogue& catalogue, const ModelSpec& model, const StagedCar& car,
                               std::size_t member) {
  std::vector<std::size_t> at;
  const std::size_t offset = car.param_offset(static_cast<int>(catalogue.effect_number(model, member)));
  for (const std::size_t f : catalogue.candidates()[model.members[member]].fitted) at.push_back(offset + f);
  return at;
}

/// Fills the rates of regressors[i], the derivatives by parameter seed[i] of the car, eight at a time.
void exact_regressors(const StagedCar& car, const Trace& trace, const std::vector<double>& memory,
                      std::span<const std::size_t> seed, std::span<Regressor> regressors) {
  for (std::size_t begin = 0; begin < seed.size(); begin += DualPass::lanes) {
    const auto part = seed.subspan(begin, std::min(DualPass::lanes, seed.size() - begin));
    for (std::size_t i = 0; i < part.size(); ++i) regressors[begin + i].rate.resize(trace.size() * 3);
    DualPass{car, trace, memory}.run(part, false, [&](std::size_t k, const Dual8* rate, const Dual8*) {
      for (std::size_t i = 0; i < part.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) regressors[begin + i].rate[k * 3 + c] = rate[3 + c].d[i];
    });
  }
}

/// Fills the readings of regressors[i], the derivatives by parameter seed[i] of the car, eight at a time.
void reading_regressors(const StagedCar& car, const Trace& trace, std::span<const std::size_t> seed,
                        std::span<Regressor> regressors) {
  for (std::size_t begin = 0; begin < seed.size(); begin += DualPass::lanes) {
    const auto part = seed.subspan(begin, std::min(DualPass::lanes, seed.size() - begin));
    for (std::size_t i = 0; i < part.size(); ++i) regressors[begin + i].reading.resize(trace.size() * channels);
    read_pass(car, trace, part, false, [&](std::size_t k, const std::array<Dual8, channels>& out) {
      for (std::size_t i = 0; i < part.size(); ++i)
        for (std::size_t c = 0; c < channels; ++c) regressors[begin + i].reading[k * channels + c] = out[c].d[i];
    });
  }
}

/// By a delay, which moves the breakpoints of the commands: a central difference.
Regressor central_difference_regressor(StagedCar& car, const Trace& trace, std::size_t slot, double step) {
  const double keep = car.params()[slot];
  const auto rates = [&](double value) {
    car.params()[slot] = value;
    return rates_at_samples(car, trace, simulate_memory(car, trace));
  };
  const std::vector<double> high = rates(keep + step), low = rates(keep - step);
  car.params()[slot] = keep;
  Regressor d;
  d.rate.resize(trace.size() * 3);
  for (std::size_t k = 0; k < trace.size(); ++k)
    for (std::size_t c = 0; c < 3; ++c)
      d.rate[k * 3 + c] = (high[k * channels + 3 + c] - low[k * channels + 3 + c]) / (2.0 * step);
  return d;
}

/// Exact derivatives of rates hold the memory fixed, but a parameter that acts before an effect with memory also
/// changes that memory: with relaxing tyres nothing of a tyre shows in the rates of an instant. Derivatives by such
/// parameters are differences with the memory simulated anew. The effect may be the model's or the world's own.
bool changes_memory(const Catalogue& catalogue, const ModelSpec& model, std::size_t candidate) {
  if (catalogue.own_states_depend_on(candidate)) return true;
  return std::any_of(model.members.begin(), model.members.end(), [&](std::size_t m) {
    return catalogue.candidates()[m].effect->memory() > 0 && catalogue.before(candidate, m);
  });
}
bool nominal_changes_memory(const Catalogue& catalogue, const ModelSpec& model) {
  if (catalogue.own_states_depend_on_model()) return true;
  return std::any_of(model.members.begin(), model.members.end(), [&](std::size_t m) {
    const Effect& effect = *catalogue.candidates()[m].effect;
    return effect.memory() > 0 && effect.stage() > Stage::command;
  });
}

/// Where the memory depends on the parameter, also for parameters of the dynamic effect itself: a one-sided difference
/// of rates, memory simulated anew along the reference, from `base`, the rates of the car as it is by rates_at_samples.
/// Values beside exact derivatives are rounded otherwise, and a parameter that does nothing would seem to do a little.
Regressor difference_regressor(StagedCar& car, const Trace& trace, std::size_t slot, double step,
                               const std::vector<double>& base) {
  const double keep = car.params()[slot];
  car.params()[slot] = keep + step;
  const std::vector<double> rates = rates_at_samples(car, trace, simulate_memory(car, trace));
  car.params()[slot] = keep;
  Regressor d;
  d.rate.resize(trace.size() * 3);
  for (std::size_t k = 0; k < trace.size(); ++k)
    for (std::size_t c = 0; c < 3; ++c)
      d.rate[k * 3 + c] = (rates[k * channels + 3 + c] - base[k * channels + 3 + c]) / step;
  return d;
}

constexpr double small_step = 1e-4;  // of a parameter's scale, for differences

/// How the regressors of a model's own parameters are found: exactly, or by differences.
struct OwnPlan {
  struct Moved {
    std::size_t slot, place;
    double step;
    bool delay;
  };
  std::vector<std::size_t> seed, place;  // of the exact ones: parameter, position among all
  std::vector<Moved> moved;
  std::size_t count = 0;
};

OwnPlan plan_own(const Catalogue& catalogue, const ModelSpec& model, const StagedCar& car, double dt) {
  OwnPlan plan;
  const auto exact = [&](std::size_t slot) {
    plan.seed.push_back(slot);
    plan.place.push_back(plan.count++);
  };
  const auto move = [&](std::size_t slot, double step, bool delay) {
    plan.moved.push_back({slot, plan.count++, step, delay});
  };
  const bool remembered = nominal_changes_memory(catalogue, model);
  for (const Nuisance& n : catalogue.nuisances())
    remembered && !n.delay ? move(n.index, small_step * n.sigma, false) : exact(n.index);
  for (std::size_t i = 0; i < model.members.size(); ++i) {
    const Candidate& c = catalogue.candidates()[model.members[i]];
    const auto at = slots(catalogue, model, car, i);
    const bool later = changes_memory(catalogue, model, model.members[i]);
    for (std::size_t f = 0; f < at.size(); ++f) {
      const double scale = c.decl(f).scale;
      if (!c.dynamic)
        later ? move(at[f], small_step * scale, false) : exact(at[f]);
      else if (c.effect->memory() > 0)
        move(at[f], small_step * std::abs(car.params()[at[f]]) + 1e-6 * scale, false);
      else
        move(at[f], 0.5 * dt, true);  // a delay, at breakpoints of the commands: half a sample to either side
    }
  }
  return plan;
}

/// Regressors as planned: `exact` by the seeds of which the first `done` are filled, the others along `memory`.
std::vector<Regressor> all_regressors(const Catalogue& catalogue, const ModelSpec& model, StagedCar& car,
                                      const Trace& trace, const OwnPlan& plan, const std::vector<double>& memory,
                                      std::vector<Regressor> exact, std::size_t done) {
  const std::span<const std::size_t> seed = plan.seed;
  exact_regressors(car, trace, memory, seed.subspan(done), std::span(exact).subspan(done));
  if (reads(catalogue, model)) reading_regressors(car, trace, seed, exact);
  std::vector<Regressor> all(plan.count);
  for (std::size_t i = 0; i < seed.size(); ++i) all[plan.place[i]] = std::move(exact[i]);
  std::vector<double> base;
  if (!plan.moved.empty()) base = rates_at_samples(car, trace, memory);
  for (const OwnPlan::Moved& one : plan.moved)
    all[one.place] = one.delay ? central_difference_regressor(car, trace, one.slot, one.step)
                               : difference_regressor(car, trace, one.slot, one.step, base);
  return all;
}

double work_of(const LinearModel& lm, const OwnPlan& plan) {
  return static_cast<double>(lm.states * lm.states) / 27.0 + lm.substeps + 2.0 * static_cast<double>(plan.moved.size());
}

}  // namespace

Linearised linearise_with_regressors(const Catalogue& catalogue, const ModelSpec& model, const Trace& trace,
                                     const Stepping& stepping) {
  StagedCar car = catalogue.build(model);
  const OwnPlan plan = plan_own(catalogue, model, car, trace.log.dt);
  std::vector<Regressor> exact(plan.seed.size());
  const std::size_t along = std::min(plan.seed.size(), lanes_beside_state(car));
  Linearised out;
  out.lm = linearise(car, trace, stepping, std::span(plan.seed).first(along), std::span(exact).first(along));
  out.work = work_of(out.lm, plan);
  out.own = all_regressors(catalogue, model, car, trace, plan, out.lm.memory, std::move(exact), along);
  return out;
}

Linearised linearise_alone(const Catalogue& catalogue, const ModelSpec& model, const Trace& trace,
                           const Stepping& stepping) {
  const StagedCar car = catalogue.build(model);
  Linearised out;
  out.lm = linearise(car, trace, stepping);
  out.work = work_of(out.lm, plan_own(catalogue, model, car, trace.log.dt));
  return out;
}

std::vector<Regressor> own_regressors(const Catalogue& catalogue, const ModelSpec& model, const Trace& trace) {
  StagedCar car = catalogue.build(model);
  const OwnPlan plan = plan_own(catalogue, model, car, trace.log.dt);
  std::vector<Regressor> exact(plan.seed.size());
  return all_regressors(catalogue, model, car, trace, plan, simulate_memory(car, trace), std::move(exact), 0);
}

namespace {

std::vector<double> at_neutral(const Candidate& c) {
  std::vector<double> values = c.defaults;
  for (std::size_t f = 0; f < c.fitted.size(); ++f) values[c.fitted[f]] = c.decl(f).neutral;
  return values;
}

/// Starts for a parameter that shapes an effect but does nothing while the effect is at its neutral value: a scan in
/// steps of its scale, ten to either side of its start.
std::vector<double> scan(const abi::ParamDecl& p) {
  std::vector<double> values;
  for (int i = -10; i < 10; ++i) {
    const double value = p.start + i * p.scale;
    if (value >= p.lo && value <= p.hi) values.push_back(value);
  }
  return values;
}

/// The regressors that one candidate would add to a model. `without`: the model's rates by rates_at_samples, as
/// difference_regressor has its base.
class CandidateProbe {
 public:
  CandidateProbe(const Catalogue& catalogue, const ModelSpec& model, std::size_t candidate, const Trace& trace,
                 const std::vector<double>& memory, const std::vector<double>& without)
      : candidate_(catalogue.candidates()[candidate]),
        trace_(trace),
        memory_(memory),
        without_(without),
        car_(catalogue.build(at_start(catalogue, model, candidate))),
        through_memory_(changes_memory(catalogue, model, candidate)) {
    const ModelSpec more = catalogue.with(model, candidate);
    slots_ = slots(catalogue, more, car_, more.position(candidate));
  }

  /// Appends to `regressors`, and to `starts` where a shape is scanned.
  void add(std::vector<Regressor>& regressors, std::vector<std::vector<double>>& starts) {
    if (candidate_.dynamic) {
      regressors.push_back(secant());
      return;
    }
    if (!candidate_.shapes.empty()) {
      scan_shape(regressors, starts);
      return;
    }
    std::vector<Regressor> all = tangents(slots_);
    std::move(all.begin(), all.end(), std::back_inserter(regressors));
  }

 private:
  /// A dynamic candidate at its start values, any other at neutral.
  static ModelSpec at_start(const Catalogue& catalogue, const ModelSpec& model, std::size_t candidate) {
    ModelSpec more = catalogue.with(model, candidate);
    const Candidate& c = catalogue.candidates()[candidate];
    if (!c.dynamic) more.values[more.position(candidate)] = at_neutral(c);
    return more;
  }

  /// From the model without the effect to the effect at its start, per unit of its first parameter.
  Regressor secant() {
    const std::vector<double> rates = rates_at_samples(car_, trace_, simulate_memory(car_, trace_));
    Regressor r;
    r.rate.resize(trace_.size() * 3);
    const double unit = candidate_.decl(0).start - candidate_.decl(0).neutral;
    for (std::size_t k = 0; k < trace_.size(); ++k)
      for (std::size_t c = 0; c < 3; ++c)
        r.rate[k * 3 + c] = (rates[k * channels + 3 + c] - without_[k * channels + 3 + c]) / unit;
    return r;
  }

  /// From neutral, at which shapes do not matter.
  Regressor by_difference(std::size_t fitted) {
    if (at_neutral_.empty()) at_neutral_ = rates_at_samples(car_, trace_, simulate_memory(car_, trace_));
    return difference_regressor(car_, trace_, slots_[fitted], small_step * candidate_.decl(fitted).scale, at_neutral_);
  }

  /// Derivatives by some of the car's parameters, those of the fitted ones numbered from `first` on.
  std::vector<Regressor> tangents(std::span<const std::size_t> at, std::size_t first = 0) {
    std::vector<Regressor> all(at.size());
    if (through_memory_)
      for (std::size_t f = 0; f < at.size(); ++f) all[f] = by_difference(first + f);
    else
      exact_regressors(car_, trace_, memory_, at, all);
    if (candidate_.effect->stage() == Stage::reading) reading_regressors(car_, trace_, at, all);
    return all;
  }

  /// One regressor of the strength for each value of the first shape parameter, the others at their start.
  void scan_shape(std::vector<Regressor>& regressors, std::vector<std::vector<double>>& starts) {
    const std::vector<std::size_t>& shapes = candidate_.shapes;
    for (const double value : scan(candidate_.decl(shapes.front()))) {
      car_.params()[slots_[shapes.front()]] = value;
      for (std::size_t f = 1; f < shapes.size(); ++f)
        car_.params()[slots_[shapes[f]]] = candidate_.decl(shapes[f]).start;
      auto one = tangents(std::span(slots_).subspan(candidate_.strength, 1), candidate_.strength);
      regressors.push_back(std::move(one.front()));
      std::vector<double> start = candidate_.defaults;
      start[candidate_.fitted[shapes.front()]] = value;
      starts.push_back(std::move(start));
    }
  }

  const Candidate& candidate_;
  const Trace& trace_;
  const std::vector<double>& memory_;  // of the model without it
  const std::vector<double>& without_;
  StagedCar car_;
  bool through_memory_;
  std::vector<double> at_neutral_;  // rates at every sample, once they are needed
  std::vector<std::size_t> slots_;
};

}  // namespace

void candidate_regressors(const Catalogue& catalogue, const ModelSpec& model, const Trace& trace,
                          std::vector<Regressor>& regressors, std::vector<CandidateRegressors>& groups) {
  const StagedCar car = catalogue.build(model);
  const std::vector<double> memory = simulate_memory(car, trace), without = rates_at_samples(car, trace, memory);
  for (std::size_t i = 0; i < catalogue.candidates().size(); ++i) {
    const Candidate& c = catalogue.candidates()[i];
    if (c.excluded || model.has(i) || !catalogue.fits_filter(model, {i})) continue;
    CandidateRegressors group;
    group.candidate = i;
    group.first = regressors.size();
    CandidateProbe(catalogue, model, i, trace, memory, without).add(regressors, group.starts);
    group.count = regressors.size() - group.first;
    groups.push_back(std::move(group));
  }
}

}  // namespace gripline::diagnose
