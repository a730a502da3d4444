#include "calibrate/effects/candidate_effects.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

#include "calibrate/effects/place_effects.hpp"
#include "calibrate/fit/fit_starts.hpp"
#include "calibrate/fit/least_squares.hpp"
#include "car/instant.hpp"

namespace gripline::calibrate {
namespace {

using Index = Eigen::Index;

/// Quantities that all differ, so that factors, sums and exchanges show.
Quantities<double> some_quantities() {
  Quantities<double> q;
  constexpr std::size_t count = sizeof(Quantities<double>) / sizeof(double);
  double values[count];
  for (std::size_t i = 0; i < count; ++i) values[i] = 0.5 + 0.01 * static_cast<double>(i);
  std::memcpy(&q, values, sizeof q);
  return q;
}

/// What an effect without memory makes of quantities, or of a reading.
Quantities<double> applied(const Effect& effect, std::span<const double> params, Quantities<double> q,
                           Reading<double>* shown = nullptr) {
  Place at;  // somewhere on a lap, so that shapes along it show
  at.t = 3.0;
  at.s = 1.3;
  at.n = 0.1;
  at.lap_fraction = 0.13;
  at.yaw_line = 0.7;
  InstantPoints instant({q.d, q.delta}, at, params.data());
  if (effect.stage() == Stage::reading) {
    if (shown == nullptr) return q;
    instant.points.reading = shown;
  } else {
    instant.points.q = &q;
  }
  effect.apply(instant.points);
  return q;
}

/// Equal up to rounding, number by number.
template <class T>
bool same_numbers(const T& a, const T& b) {
  constexpr std::size_t count = sizeof(T) / sizeof(double);
  double x[count], y[count];
  std::memcpy(x, &a, sizeof x);
  std::memcpy(y, &b, sizeof y);
  return std::equal(x, x + count, y, [](double one, double other) { return std::abs(one - other) < 1e-12; });
}

/// Whether an effect without memory changes nothing with these parameters.
bool does_nothing(const Effect& effect, std::span<const double> params) {
  Reading<double> shown{0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
  const Reading<double> read = shown;
  const Quantities<double> before = some_quantities(), after = applied(effect, params, before, &shown);
  return same_numbers(after, before) && same_numbers(shown, read);
}

/// Whether an effect changes what is known of every car: its mass and where its centre of gravity lies.
bool changes_known(const Effect& effect, std::span<const double> params) {
  const Quantities<double> before = some_quantities(), after = applied(effect, params, before);
  return after.m != before.m || after.lf != before.lf || after.lr != before.lr;
}

/// A candidate at its neutral values. Tested are the parameters that move something alone there: what only shapes the
/// others says nothing before one of them differs. None is tested where no values are neutral.
CandidateEffect candidate_of(const PluginEntry& entry, const PluginContext& context) {
  CandidateEffect c;
  c.entry = &entry;
  const auto fits = [](const abi::ParamDecl& p) { return p.fit && p.neutral >= p.lo && p.neutral <= p.hi; };
  const auto params = entry.params();
  const bool by_fit = std::ranges::any_of(params, fits);
  const auto numeric = [](const abi::ParamDecl& p) { return p.type != abi::ParamType::boolean; };
  if (!std::ranges::any_of(params, numeric)) return c;
  std::vector<abi::ParamValue> values;
  for (const abi::ParamDecl& p : params) {
    values.push_back({by_fit && p.fit ? p.neutral : p.default_value, Table{}});
    c.numbers.push_back(values.back().number);
    c.low.push_back(p.lo);
    c.high.push_back(p.hi);
  }
  c.effect = create<Effect>(entry, context, values);
  std::vector<double> strong = c.numbers;  // at neutral values no effect has a delay
  for (std::size_t i = 0; i < params.size(); ++i) strong[i] += by_fit && params[i].fit ? params[i].scale : 0.0;
  if (c.effect->memory() > 0 || c.effect->look_back(strong) > 0.0 || !does_nothing(*c.effect, c.numbers)) return c;
  for (std::size_t i = 0; i < params.size(); ++i) {
    const abi::ParamDecl& p = params[i];
    if (by_fit ? !p.fit : !numeric(p)) continue;
    c.open.push_back(i);
    std::vector<double> moved = c.numbers;
    moved[i] += by_fit ? p.scale : 0.0;
    // The first says how strong an effect is, even where it acts in one place only.
    if (!by_fit || c.tested.empty() || !does_nothing(*c.effect, moved)) c.tested.push_back(i);
  }
  return c;
}

bool has_table(const PluginEntry& entry) {
  return std::ranges::any_of(entry.params(), [](const abi::ParamDecl& p) { return p.type == abi::ParamType::table; });
}

/// What an effect of the commands makes of the steering of a car that drives straight on [rad].
double wheel_angle(const Effect& effect, std::span<const double> params, double command) {
  Quantities<double> q = some_quantities();
  q.vy = q.omega = q.delta_rate = 0.0;
  q.delta = command;
  return applied(effect, params, q).delta;
}

/// By what its tested parameters change.
SteeringAsymmetry steering_asymmetry(const CandidateEffect& c) {
  if (c.effect->stage() != Stage::command) return SteeringAsymmetry::none;
  constexpr double turned = 0.2, by = 0.1, rounding = 1e-12;  // [rad], own units of the parameters, [rad]
  std::vector<double> other = c.numbers;
  for (const std::size_t i : c.tested) other[i] += by;
  const auto change = [&](double command) {
    return wheel_angle(*c.effect, other, command) - wheel_angle(*c.effect, c.numbers, command);
  };
  if (std::abs(change(0.0)) > rounding) return SteeringAsymmetry::offset;
  return std::abs(change(turned) + change(-turned)) > rounding ? SteeringAsymmetry::curve : SteeringAsymmetry::none;
}

/// Whether its tested parameters say something that is not known of every car and can be told from these logs.
bool may_be_missing(const CandidateEffect& c, bool road) {
  std::vector<double> strong = c.numbers;  // at neutral values nothing depends on anything
  for (const std::size_t i : c.tested) strong[i] += 0.1;
  if (c.effect->look_back(strong) > 0.0) return false;
  return !changes_known(*c.effect, strong) && (road || !depends_on_place(*c.effect, strong));
}

/// A car with candidates added, at values at which they do nothing, and all parameters of its forecaster. Of candidates
/// that are listed the car has the effect already.
struct LargerCar {
  LargerCar(const StagedCar& own, std::span<const CandidateEffect> candidates, std::span<const std::size_t> used,
            std::span<const double> params, const ForecastOptions& options)
      : before(own.params().size()), car(with(own, candidates, used)), forecaster(car, options) {
    const auto split = params.begin() + static_cast<std::ptrdiff_t>(before);
    this->params.assign(params.begin(), split);
    const auto added = car.params().begin() + static_cast<std::ptrdiff_t>(before);
    this->params.insert(this->params.end(), added, car.params().end());
    this->params.insert(this->params.end(), split, params.end());
    std::size_t first = before;
    for (const std::size_t c : used) {
      for (const std::size_t i : candidates[c].tested) {
        Unknown u;
        u.index = candidates[c].listed.value_or(first + i);
        u.sigma = candidates[c].entry->params()[i].fit ? candidates[c].entry->params()[i].scale : 1.0;
        tested.push_back(u);
      }
      if (!candidates[c].listed) first += candidates[c].numbers.size();
    }
  }
  static StagedCar with(StagedCar car, std::span<const CandidateEffect> candidates, std::span<const std::size_t> used) {
    for (const std::size_t c : used)
      if (!candidates[c].listed) car.add(*candidates[c].effect, candidates[c].numbers, candidates[c].id());
    return car;
  }
  /// Unknowns of the forecaster without candidates.
  std::vector<Unknown> moved_on(std::span<const Unknown> own) const {
    const std::size_t more = car.params().size() - before;
    std::vector<Unknown> all(own.begin(), own.end());
    for (Unknown& u : all) {
      if (u.index >= before) u.index += more;
      for (Unknown::Same& s : u.same)
        if (s.index >= before) s.index += more;
    }
    return all;
  }

  std::size_t before;  // parameters of the own car
  StagedCar car;
  Forecaster forecaster;
  std::vector<double> params;
  std::vector<Unknown> tested;
};

/// The move inside `room` (how far each parameter may go down and up) that lowers the squared errors most, to first
/// order: `information` and `gradient` are of half of them.
Eigen::VectorXd best_move(const Eigen::MatrixXd& information, const Eigen::VectorXd& gradient,
                          std::span<const Interval> room) {
  constexpr int sweeps = 100;  // of a few parameters, one at a time: a convex problem in a box
  Eigen::VectorXd move = Eigen::VectorXd::Zero(gradient.size());
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (Index i = 0; i < move.size(); ++i) {
      const double slope = gradient(i) + information.col(i).dot(move) - information(i, i) * move(i);
      const Interval& may = room[static_cast<std::size_t>(i)];
      move(i) = std::clamp(-slope / information(i, i), may.low, may.high);
    }
  return move;
}

/// Of the unknowns from `at` on, the fitted ones before them moving along: their information is factored, with their
/// priors and without. A candidate that does what they do is none, however little their priors let them move.
/// `prior` is the gradient of the priors, which balances that of the data where they were fitted; `room` is how far
/// the tested ones may go: friction does not fall below 0, however much the errors would.
EffectScore score_of(const BlockedNormalEquations& blocks, const Eigen::LDLT<Eigen::MatrixXd>& with_priors,
                     const Eigen::LDLT<Eigen::MatrixXd>& without_priors, const Eigen::VectorXd& prior, Index at,
                     std::span<const Interval> room) {
  const auto count = static_cast<Index>(room.size());
  const Index n = prior.size();
  EffectScore out;
  Eigen::MatrixXd cross = Eigen::MatrixXd::Zero(n, count), own = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd gradient = prior;
  for (std::size_t b = 0; b < blocks.hessian.size(); ++b) {
    cross += blocks.hessian[b].block(0, at, n, count);
    own += blocks.hessian[b].block(at, at, count, count);
    gradient += blocks.gradient[b].head(n);
  }
  const Eigen::MatrixXd share = with_priors.solve(cross), own_share = without_priors.solve(cross);
  constexpr double synonym = 1e-7;  // of its information: what the fitted parameters do not stand for
  out.apart = 1.0;
  for (Index i = 0; i < count; ++i)
    out.apart = std::min(out.apart, 1.0 - cross.col(i).dot(own_share.col(i)) / own(i, i));
  if (!(out.apart > synonym)) return out;
  Eigen::MatrixXd left = own - cross.transpose() * share;
  left.diagonal() *= 1.0 + synonym;
  Eigen::MatrixXd residual(count, static_cast<Index>(blocks.hessian.size()));
  for (std::size_t b = 0; b < blocks.hessian.size(); ++b)
    residual.col(static_cast<Index>(b)) =
        blocks.gradient[b].segment(at, count) - share.transpose() * blocks.gradient[b].head(n);
  const Eigen::VectorXd sum = residual.rowwise().sum() - share.transpose() * prior;
  const Eigen::VectorXd move = best_move(left, sum, room);
  const double spread = (move.transpose() * residual).squaredNorm();
  if (!(spread > 0.0)) return out;
  out.gain = -(2.0 * sum.dot(move) + move.dot(left * move)) / blocks.cost;
  out.score = std::abs(sum.dot(move)) / std::sqrt(spread);
  out.value.assign(move.data(), move.data() + count);
  out.move = -share * move - with_priors.solve(gradient);
  return out;
}

}  // namespace

std::vector<CandidateEffect> candidate_effects(const VehicleSpec& vehicle, const Car& car, const Registry& registry,
                                               bool road) {
  PluginContext context;
  context.car = car;
  const Vehicle own(vehicle, context);
  std::vector<CandidateEffect> out;
  for (const PluginEntry& entry : registry.entries()) {
    if (entry.decl->kind != abi::Kind::effect || entry.needs_truth()) continue;
    const auto there = [&](const PluginSpec& e) { return e.id() == entry.decl->id; };
    if (std::ranges::any_of(vehicle.effects, there)) continue;
    if (has_table(entry)) continue;
    try {
      CandidateEffect c = candidate_of(entry, context);
      if (c.tested.empty() || !own.has_stage(c.effect->stage()) || !may_be_missing(c, road)) continue;
      c.asymmetry = steering_asymmetry(c);
      out.push_back(std::move(c));
    } catch (const std::exception&) {
      // An effect that cannot be made or tried is no candidate; it must not end what is asked of the others.
    }
  }
  return out;
}

namespace {

/// Those of one effect, whose parameters begin at `first` among the car's.
void add_idle_parameters(const PluginSpec& spec, std::size_t first, bool road, const PluginContext& context,
                         std::vector<CandidateEffect>& out) {
  const CandidateEffect neutral = candidate_of(*spec.entry, context);
  if (neutral.tested.empty() || !may_be_missing(neutral, road)) return;
  for (const std::size_t i : neutral.tested) {
    if (spec.values[i].number != neutral.numbers[i]) continue;
    CandidateEffect one;
    one.entry = spec.entry;
    one.effect = create<Effect>(*spec.entry, context, spec.values);
    for (const abi::ParamValue& value : spec.values) one.numbers.push_back(value.number);
    one.low = neutral.low;
    one.high = neutral.high;
    one.tested = one.open = {i};
    one.listed = first + i;
    one.asymmetry = steering_asymmetry(one);
    out.push_back(std::move(one));
  }
}

}  // namespace

std::vector<CandidateEffect> idle_parameters(const VehicleSpec& vehicle, const Car& car, bool road) {
  PluginContext context;
  context.car = car;
  std::vector<CandidateEffect> out;
  std::size_t next = vehicle.model.entry->params().size();  // a car's parameters: its model's, then each effect's
  for (const PluginSpec& spec : vehicle.effects) {
    const std::size_t first = next;
    next += spec.entry->params().size();
    const bool twice = std::ranges::count(vehicle.effects, spec.id(), &PluginSpec::id) > 1;
    if (twice || spec.entry->needs_truth() || has_table(*spec.entry)) continue;
    try {
      add_idle_parameters(spec, first, road, context, out);
    } catch (const std::exception&) {
      // As in candidate_effects().
    }
  }
  return out;
}

std::vector<EffectScore> score_candidates(const StagedCar& own, std::span<const CandidateEffect> candidates,
                                          const ForecastOptions& forecast, std::vector<FitLog>& logs,
                                          std::span<const double> params, std::span<const Unknown> fitted,
                                          const Weighing& weighing) {
  std::vector<std::size_t> used(candidates.size());
  std::iota(used.begin(), used.end(), std::size_t{0});
  const auto linearise = [&](std::span<const std::size_t> these, std::vector<FitLog>& of) -> BlockedNormalEquations {
    const LargerCar larger(own, candidates, these, params, forecast);
    PredictionErrors errors(larger.forecaster, of);
    errors.weighing = weighing;
    std::vector<Unknown> unknowns = larger.moved_on(fitted);
    unknowns.insert(unknowns.end(), larger.tested.begin(), larger.tested.end());
    return errors.linearise(larger.params, unknowns);
  };
  BlockedNormalEquations blocks = linearise(used, logs);
  if (blocks.undefined > 0) {  // one effect that goes wrong must not end what is asked of the others
    std::vector<FitLog> few = thinned(logs, 10);
    const std::size_t without = linearise({}, few).undefined;
    std::erase_if(used, [&](const std::size_t one) { return linearise({&one, 1}, few).undefined > without; });
    blocks = linearise(used, logs);
  }
  const auto n = static_cast<Index>(fitted.size());
  Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(n, n);
  for (const Eigen::MatrixXd& h : blocks.hessian) hessian += h.topLeftCorner(n, n);
  hessian.diagonal() *= 1.0 + 1e-9;
  Eigen::VectorXd prior = Eigen::VectorXd::Zero(n);
  const Eigen::LDLT<Eigen::MatrixXd> without_priors(hessian);
  prior_cost(params, fitted, &hessian, &prior);
  const Eigen::LDLT<Eigen::MatrixXd> with_priors(hessian);
  std::vector<EffectScore> scores;
  Index at = n;
  for (const std::size_t c : used) {
    std::vector<Interval> room;
    for (const std::size_t i : candidates[c].tested)
      room.push_back({candidates[c].low[i] - candidates[c].numbers[i], candidates[c].high[i] - candidates[c].numbers[i],
                      0.0, 0.0});
    EffectScore one = score_of(blocks, with_priors, without_priors, prior, at, room);
    at += static_cast<Index>(room.size());
    one.candidate = c;
    if (one.gain > 0.0) scores.push_back(std::move(one));
  }
  return scores;
}

}  // namespace gripline::calibrate
