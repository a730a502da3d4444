#include "diagnose/model/directions.hpp"

#include <algorithm>
#include <cmath>

#include "diagnose/model/dual_pass.hpp"

namespace gripline::diagnose {
namespace {

bool reads(const Catalogue& catalogue, const ModelSpec& model) {
  return std::any_of(model.members.begin(), model.members.end(),
                     [&](std::size_t i) { return catalogue.candidates()[i].effect->stage() == Stage::reading; });
}

/// Where the fitted parameters of member i stand among the car's.
std::vector<std::size_t> slots(const Catalogue& catalogue, const ModelSpec& model, const StagedCar& car,
                               std::size_t member) {
  std::vector<std::size_t> at;
  const std::size_t offset = car.param_offset(static_cast<int>(catalogue.own_effects() + member));
  for (const std::size_t f : catalogue.candidates()[model.members[member]].fitted) at.push_back(offset + f);
  return at;
}

/// Fills the rates of directions[i] by the car's parameters `seed`, eight at a time.
void exact_directions(const StagedCar& car, const Trace& trace, const std::vector<double>& memory,
                      std::span<const std::size_t> seed, std::span<Direction> directions) {
  for (std::size_t begin = 0; begin < seed.size(); begin += DualPass::lanes) {
    const auto part = seed.subspan(begin, std::min(DualPass::lanes, seed.size() - begin));
    for (std::size_t i = 0; i < part.size(); ++i) directions[begin + i].rate.resize(trace.size() * 3);
    DualPass{car, trace, memory}.run(part, false, [&](std::size_t k, const Dual8* rate, const Dual8*) {
      for (std::size_t i = 0; i < part.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) directions[begin + i].rate[k * 3 + c] = rate[3 + c].d[i];
    });
  }
}

/// The same for what sensors show.
void reading_directions(const StagedCar& car, const Trace& trace, std::span<const std::size_t> seed,
                        std::span<Direction> directions) {
  for (std::size_t begin = 0; begin < seed.size(); begin += DualPass::lanes) {
    const auto part = seed.subspan(begin, std::min(DualPass::lanes, seed.size() - begin));
    for (std::size_t i = 0; i < part.size(); ++i) directions[begin + i].reading.resize(trace.size() * channels);
    read_pass(car, trace, part, false, [&](std::size_t k, const std::array<Dual8, channels>& out) {
      for (std::size_t i = 0; i < part.size(); ++i)
        for (std::size_t c = 0; c < channels; ++c) directions[begin + i].reading[k * channels + c] = out[c].d[i];
    });
  }
}

/// A change of a delay moves the kinks of the commands: rates with it longer minus rates with it shorter.
Direction difference_direction(StagedCar& car, const Trace& trace, std::size_t slot, double step) {
  const double keep = car.params()[slot];
  const auto rates = [&](double value) {
    car.params()[slot] = value;
    return rates_at_samples(car, trace, run_memory(car, trace));
  };
  const std::vector<double> high = rates(keep + step), low = rates(keep - step);
  car.params()[slot] = keep;
  Direction d;
  d.rate.resize(trace.size() * 3);
  for (std::size_t k = 0; k < trace.size(); ++k)
    for (std::size_t c = 0; c < 3; ++c)
      d.rate[k * 3 + c] = (high[k * channels + 3 + c] - low[k * channels + 3 + c]) / (2.0 * step);
  return d;
}

/// Rates hold the memory fixed, but a parameter that acts before an effect with memory also changes what that effect
/// remembers: with relaxing tyres nothing of a tyre shows in the rates at all. Such parameters are moved and the memory
/// is run anew.
bool is_remembered(const Catalogue& catalogue, const ModelSpec& model, std::size_t candidate) {
  return std::any_of(model.members.begin(), model.members.end(), [&](std::size_t m) {
    return catalogue.candidates()[m].effect->memory() > 0 && catalogue.before(candidate, m);
  });
}
bool nominal_is_remembered(const Catalogue& catalogue, const ModelSpec& model) {
  return std::any_of(model.members.begin(), model.members.end(), [&](std::size_t m) {
    const Effect& effect = *catalogue.candidates()[m].effect;
    return effect.memory() > 0 && effect.stage() > Stage::command;
  });
}

/// A direction where memories change with the parameter, which also holds for an effect's own parameters: rates with it
/// moved a little, memory run along the reference anew, minus `base`, the rates of the car as it is.
Direction moved_direction(StagedCar& car, const Trace& trace, std::size_t slot, double step,
                          const std::vector<double>& base) {
  const double keep = car.params()[slot];
  car.params()[slot] = keep + step;
  const std::vector<double> rates = rates_at_samples(car, trace, run_memory(car, trace));
  car.params()[slot] = keep;
  Direction d;
  d.rate.resize(trace.size() * 3);
  for (std::size_t k = 0; k < trace.size(); ++k)
    for (std::size_t c = 0; c < 3; ++c) d.rate[k * 3 + c] = (rates[k * channels + 3 + c] - base[k * 3 + c]) / step;
  return d;
}

constexpr double small_step = 1e-4;  // of a parameter's scale, for differences

/// How the directions of a model's own parameters are found: exactly, or by moving the parameter.
struct OwnPlan {
  struct Moved {
    std::size_t slot, place;
    double step;
    bool delay;
  };
  std::vector<std::size_t> seed, place;  // of the exact ones
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
  const bool remembered = nominal_is_remembered(catalogue, model);
  for (const Nuisance& n : catalogue.nuisances())
    remembered ? move(n.index, small_step * n.sigma, false) : exact(n.index);
  for (std::size_t i = 0; i < model.members.size(); ++i) {
    const Candidate& c = catalogue.candidates()[model.members[i]];
    const auto at = slots(catalogue, model, car, i);
    const bool later = is_remembered(catalogue, model, model.members[i]);
    for (std::size_t f = 0; f < at.size(); ++f) {
      const double scale = c.decl(f).scale;
      if (!c.remembers)
        later ? move(at[f], small_step * scale, false) : exact(at[f]);
      else if (c.effect->memory() > 0)
        move(at[f], small_step * std::abs(car.params()[at[f]]) + 1e-6 * scale, false);
      else
        move(at[f], 0.5 * dt, true);  // a delay, whose rates have kinks: half a sample to either side
    }
  }
  return plan;
}

}  // namespace

Linearised linearise_own(const Catalogue& catalogue, const ModelSpec& model, const Trace& trace, int substeps) {
  StagedCar car = catalogue.build(model);
  const OwnPlan plan = plan_own(catalogue, model, car, trace.log.dt);
  const std::span<const std::size_t> seed = plan.seed;
  std::vector<Direction> exact(seed.size());
  const std::size_t along = std::min(seed.size(), lanes_beside_state(car));
  Linearised out;
  out.lm = linearise(car, trace, substeps, seed.first(along), std::span(exact).first(along));
  exact_directions(car, trace, out.lm.memory, seed.subspan(along), std::span(exact).subspan(along));
  if (reads(catalogue, model)) reading_directions(car, trace, seed, exact);
  out.own.resize(plan.count);
  out.work = static_cast<double>(out.lm.states * out.lm.states) / 27.0 + out.lm.substeps +
             2.0 * static_cast<double>(plan.moved.size());
  for (std::size_t i = 0; i < seed.size(); ++i) out.own[plan.place[i]] = std::move(exact[i]);
  for (const OwnPlan::Moved& one : plan.moved)
    out.own[one.place] = one.delay ? difference_direction(car, trace, one.slot, one.step)
                                   : moved_direction(car, trace, one.slot, one.step, out.lm.rate);
  return out;
}

namespace {

/// True when nothing at all depends on the direction.
bool vanishes(const Direction& d) {
  const auto zero = [](const std::vector<double>& v) {
    return std::all_of(v.begin(), v.end(), [](double x) { return x == 0.0; });
  };
  return zero(d.rate) && zero(d.reading);
}

/// A model with one more effect at given values.
ModelSpec with_values(const Catalogue& catalogue, const ModelSpec& model, std::size_t candidate,
                      const std::vector<double>& values) {
  ModelSpec more = catalogue.with(model, candidate);
  more.values[more.position(candidate)] = values;
  return more;
}

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

}  // namespace

void candidate_directions(const Catalogue& catalogue, const ModelSpec& model, const Trace& trace, const LinearModel& lm,
                          std::vector<Direction>& directions, std::vector<Group>& groups) {
  for (std::size_t i = 0; i < catalogue.candidates().size(); ++i) {
    const Candidate& c = catalogue.candidates()[i];
    if (c.excluded || model.has(i)) continue;
    if (lm.memories() + static_cast<std::size_t>(c.effect->memory()) > max_memory) continue;
    Group group;
    group.candidate = i;
    group.first = directions.size();
    if (c.remembers) {
      // A secant from the model without the effect to the effect at its start.
      const ModelSpec more = catalogue.with(model, i);
      StagedCar car = catalogue.build(more);
      const std::vector<double> rates = rates_at_samples(car, trace, run_memory(car, trace));
      Direction d;
      d.rate.resize(trace.size() * 3);
      const double unit = c.decl(0).start - c.decl(0).neutral;
      for (std::size_t k = 0; k < trace.size(); ++k)
        for (std::size_t r = 0; r < 3; ++r)
          d.rate[k * 3 + r] = (rates[k * channels + 3 + r] - lm.rate[k * 3 + r]) / unit;
      directions.push_back(std::move(d));
    } else {
      ModelSpec more = with_values(catalogue, model, i, at_neutral(c));
      StagedCar car = catalogue.build(more);
      const auto at = slots(catalogue, more, car, more.position(i));
      std::vector<Direction> all(at.size());
      const bool later = is_remembered(catalogue, model, i);
      const auto direction = [&](std::size_t f) {
        return moved_direction(car, trace, at[f], small_step * c.decl(f).scale, lm.rate);
      };
      if (later)
        for (std::size_t f = 0; f < at.size(); ++f) all[f] = direction(f);
      else
        exact_directions(car, trace, lm.memory, at, all);
      if (c.effect->stage() == Stage::reading) reading_directions(car, trace, at, all);
      std::vector<std::size_t> shapes;
      for (std::size_t f = 0; f < all.size(); ++f)
        if (vanishes(all[f])) shapes.push_back(f);
      if (shapes.empty() || shapes.size() == all.size()) {
        for (Direction& d : all) {
          directions.push_back(std::move(d));
        }
      } else {
        // Scan the first shape parameter; the strength is the first parameter that does something.
        std::size_t strength = 0;
        while (vanishes(all[strength])) ++strength;
        for (const double value : scan(c.decl(shapes.front()))) {
          car.params()[at[shapes.front()]] = value;
          for (std::size_t f = 1; f < shapes.size(); ++f) car.params()[at[shapes[f]]] = c.decl(shapes[f]).start;
          std::vector<Direction> one(1);
          const std::size_t seed[] = {at[strength]};
          if (later)
            one.front() = direction(strength);
          else
            exact_directions(car, trace, lm.memory, seed, one);
          directions.push_back(std::move(one.front()));
          std::vector<double> start = c.defaults;
          start[c.fitted[shapes.front()]] = value;
          group.starts.push_back(std::move(start));
        }
      }
    }
    group.count = directions.size() - group.first;
    groups.push_back(std::move(group));
  }
}

}  // namespace gripline::diagnose
