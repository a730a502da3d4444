#include "calibrate/candidate_effects.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "calibrate/fit.hpp"
#include "calibrate/fit_starts.hpp"
#include "calibrate/place_effects.hpp"

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
  const Place at;
  const CommandSample<double> idle{q.d, q.delta};
  History<double> past;
  past.samples = &idle;
  past.count = 1;
  past.dt = 0.01;
  Points<double> points;
  points.n = 1;
  points.q = &q;
  points.at = &at;
  points.params = params.data();
  points.history = &past;
  if (effect.stage() == Stage::reading) {
    points.q = nullptr;
    points.reading = shown;
    if (shown == nullptr) return q;
  }
  effect.apply(points);
  return q;
}

/// Whether an effect without memory changes nothing with these parameters.
bool does_nothing(const Effect& effect, std::span<const double> params) {
  Reading<double> shown{0.1, 0.2, 0.3, 0.4, 0.5, 0.6};
  const Reading<double> read = shown;
  const Quantities<double> before = some_quantities(), after = applied(effect, params, before, &shown);
  return std::memcmp(&after, &before, sizeof after) == 0 && std::memcmp(&shown, &read, sizeof shown) == 0;
}

/// Whether an effect changes what is known of every car: its mass and where its centre of gravity lies.
bool changes_known(const Effect& effect, std::span<const double> params) {
  const Quantities<double> before = some_quantities(), after = applied(effect, params, before);
  return after.m != before.m || after.lf != before.lf || after.lr != before.lr;
}

/// A candidate with its neutral values; no parameter is tested where it has none.
CandidateEffect candidate_of(const PluginEntry& entry, const PluginContext& context) {
  CandidateEffect c;
  c.entry = &entry;
  std::vector<abi::ParamValue> values;
  const auto fits = [](const abi::ParamDecl& p) { return p.fit && p.neutral >= p.lo && p.neutral <= p.hi; };
  const auto params = entry.params();
  const auto first = std::ranges::find_if(params, fits) - params.begin();
  const bool by_fit = static_cast<std::size_t>(first) < params.size();
  for (std::size_t i = 0; i < params.size(); ++i) {
    const abi::ParamDecl& p = params[i];
    // Beside the first, parameters to fit are shapes: they say nothing before it differs from neutral.
    const bool tested = by_fit ? static_cast<std::ptrdiff_t>(i) == first : p.type != abi::ParamType::boolean;
    values.push_back({by_fit && tested ? p.neutral : by_fit && p.fit ? p.start : p.default_value, Table{}});
    c.numbers.push_back(values.back().number);
    if (tested) c.tested.push_back(i);
    if (tested || (by_fit && p.fit)) c.open.push_back(i);
  }
  c.effect = create<Effect>(entry, context, values);
  if (c.effect->memory() > 0 || (!by_fit && !does_nothing(*c.effect, c.numbers))) c.tested.clear();
  return c;
}

/// Of the unknowns from `at` on, those before `n` moving along: `fitted` is the factor of their information.
EffectScore score_of(const NormalEquations& blocks, const Eigen::LDLT<Eigen::MatrixXd>& fitted, Index n, Index at,
                     Index count) {
  EffectScore out;
  Eigen::MatrixXd cross = Eigen::MatrixXd::Zero(n, count), own = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(n);
  for (std::size_t b = 0; b < blocks.hessian.size(); ++b) {
    cross += blocks.hessian[b].block(0, at, n, count);
    own += blocks.hessian[b].block(at, at, count, count);
    gradient += blocks.gradient[b].head(n);
  }
  const Eigen::MatrixXd share = fitted.solve(cross);
  Eigen::MatrixXd left = own - cross.transpose() * share;
  constexpr double synonym = 1e-6;  // of its information: what the fitted parameters do not stand for
  for (Index i = 0; i < count; ++i)
    if (!(left(i, i) > synonym * own(i, i))) return out;
  left.diagonal() *= 1.0 + synonym;
  Eigen::MatrixXd residual(count, static_cast<Index>(blocks.hessian.size()));
  for (std::size_t b = 0; b < blocks.hessian.size(); ++b)
    residual.col(static_cast<Index>(b)) =
        blocks.gradient[b].segment(at, count) - share.transpose() * blocks.gradient[b].head(n);
  const Eigen::VectorXd sum = residual.rowwise().sum();
  const Eigen::VectorXd move = -left.ldlt().solve(sum);
  const double spread = (move.transpose() * residual).squaredNorm();
  if (!(spread > 0.0)) return out;
  out.gain = -sum.dot(move) / blocks.cost;
  out.score = std::abs(sum.dot(move)) / std::sqrt(spread);
  out.value.assign(move.data(), move.data() + count);
  out.move = -share * move - fitted.solve(gradient);
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
    const auto is_table = [](const abi::ParamDecl& p) { return p.type == abi::ParamType::table; };
    if (std::ranges::any_of(entry.params(), is_table)) continue;
    CandidateEffect c = candidate_of(entry, context);
    if (c.tested.empty() || !own.has_stage(c.effect->stage())) continue;
    std::vector<double> strong = c.numbers;  // at neutral values nothing depends on anything
    for (const std::size_t i : c.tested) strong[i] += 0.1;
    if (c.effect->look_back(strong) > 0.0) continue;
    if (changes_known(*c.effect, strong) || (!road && depends_on_place(*c.effect, strong))) continue;
    out.push_back(std::move(c));
  }
  return out;
}

std::vector<EffectScore> score_candidates(const StagedCar& own, std::span<const CandidateEffect> candidates,
                                          const ForecastOptions& forecast, std::vector<FitLog>& logs,
                                          std::span<const double> params, std::span<const Unknown> fitted,
                                          const Weighing& weighing) {
  StagedCar car = own;
  const std::size_t before = own.params().size();
  std::vector<Unknown> unknowns(fitted.begin(), fitted.end());
  std::vector<Unknown> added;
  for (const CandidateEffect& c : candidates) {
    for (const std::size_t i : c.tested) {
      Unknown u;
      u.index = car.params().size() + i;
      u.sigma = c.entry->params()[i].fit ? c.entry->params()[i].scale : 1.0;
      added.push_back(u);
    }
    car.add(*c.effect, c.numbers, c.id());
  }
  const std::size_t more = car.params().size() - before;
  for (Unknown& u : unknowns) {
    if (u.index >= before) u.index += more;
    for (Unknown::Same& s : u.same)
      if (s.index >= before) s.index += more;
  }
  unknowns.insert(unknowns.end(), added.begin(), added.end());
  const auto split = params.begin() + static_cast<std::ptrdiff_t>(before);
  std::vector<double> all(params.begin(), split);
  all.insert(all.end(), car.params().begin() + static_cast<std::ptrdiff_t>(before), car.params().end());
  all.insert(all.end(), split, params.end());

  const Forecaster larger(car, forecast);
  PredictionErrors errors(larger, logs);
  errors.weighing = weighing;
  const NormalEquations blocks = errors.linearise(all, unknowns);
  const auto n = static_cast<Index>(fitted.size());
  Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(n, n);
  for (const Eigen::MatrixXd& h : blocks.hessian) hessian += h.topLeftCorner(n, n);
  hessian.diagonal() *= 1.0 + 1e-6;
  for (Index i = 0; i < n; ++i) {
    const double sigma = fitted[static_cast<std::size_t>(i)].sigma;
    hessian(i, i) += 1.0 / (sigma * sigma);
  }
  const Eigen::LDLT<Eigen::MatrixXd> known(hessian);
  std::vector<EffectScore> scores;
  Index at = n;
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    const auto count = static_cast<Index>(candidates[c].tested.size());
    EffectScore one = score_of(blocks, known, n, at, count);
    at += count;
    one.candidate = c;
    if (one.gain > 0.0) scores.push_back(std::move(one));
  }
  return scores;
}

std::vector<Advice> advise(const WorldSpec& world, const Registry& registry, const ForecastOptions& forecast,
                           std::vector<FitLog>& logs, const FitResult& found) {
  constexpr double sure = 2.0;  // standard deviations over blocks
  PluginContext context;
  context.car = world.car.car;
  const Vehicle vehicle(world.vehicle, context);
  const auto candidates = candidate_effects(world.vehicle, world.car.car, registry, world.track != nullptr);
  std::vector<Unknown> fitted;
  for (const FittedParameter& p : found.parameters)
    if (p.status == FittedParameter::Status::determined) fitted.push_back(p.unknown);
  std::vector<FitLog> half = thinned(logs, 2);
  std::vector<Advice> advice;
  for (const EffectScore& one :
       score_candidates(vehicle.car(), candidates, forecast, half, found.params, fitted, found.weighing)) {
    const CandidateEffect& c = candidates[one.candidate];
    if (one.score > sure)
      advice.push_back({c.id(), one.gain, one.score, c.numbers[c.tested.front()] + one.value.front()});
  }
  std::sort(advice.begin(), advice.end(), [](const Advice& a, const Advice& b) { return a.gain > b.gain; });
  return advice;
}

}  // namespace gripline::calibrate
