#include "diagnose/result/diagnosis.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "config/errors.hpp"
#include "diagnose/inference/confidence.hpp"
#include "diagnose/inference/constancy.hpp"
#include "diagnose/inference/search.hpp"
#include "diagnose/result/advice.hpp"

namespace gripline::diagnose {
namespace {

constexpr double no_worse = 1.02;            // errors on data not fitted, over those of the nominal model
constexpr double no_worse_when_rough = 1.1;  // the same where they are mostly the road's
constexpr double no_noise = 0.05;            // of the stated: a log with less has none
constexpr double most_in_one_lap = 0.9;      // confidence in an effect of place that was passed once
constexpr double worth_adding = 3.0;         // log evidence an effect must bring
constexpr double beyond_doubt = 15.0;        // log evidence that needs no second witness
constexpr double same_evidence = 2.0;        // models closer than this cannot be told apart
constexpr double all_but_sure = 0.98;        // chance that a set of equals holds the truth
constexpr double ninety_five = 1.959964;     // standard deviations of a 95 % interval

std::vector<Nuisance> read_uncertainty(const CaseOptions& options, const Catalogue& catalogue) {
  std::vector<Nuisance> nuisances;
  for (const auto& [key, size] : options.uncertainty) {
    Nuisance n;
    const std::string over_m = "_over_m";
    const bool per_mass = key.ends_with(over_m);
    n.name = per_mass ? key.substr(0, key.size() - over_m.size()) : key;
    n.nominal = catalogue.nominal(n.name, &n.index);
    if (std::isnan(n.nominal))
      throw InputError("nominal_uncertainty names \"" + key + "\", which is no parameter of the nominal model");
    n.sigma = size * (per_mass ? catalogue.car().m : std::abs(n.nominal));
    if (n.sigma > 0.0) nuisances.push_back(n);
  }
  return nuisances;
}

const char* channel_name(std::size_t c) {
  constexpr std::array<const char*, channels> names = {"x", "y", "yaw", "vx", "vy", "yaw rate"};
  return names[c];
}

std::string number(double value, int digits = 3) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.*g", digits, value);
  return buffer;
}

bool contains(const ModelSpec& larger, const ModelSpec& smaller) {
  return std::all_of(smaller.members.begin(), smaller.members.end(), [&](std::size_t m) { return larger.has(m); });
}

}  // namespace

Diagnoser::Diagnoser(const WorldSpec& world, const Registry& registry, const CaseOptions& options)
    : world_(world),
      options_(options),
      catalogue_(world.vehicle, world.car.car, registry, options.exclude),
      road_(world.track) {
  if (world.vehicle.model.empty())
    throw InputError("the world's car is a black box; diagnose needs a vehicle model as the nominal one");
  for (const std::string& id : options.exclude)
    if (catalogue_.find(id) == catalogue_.candidates().size()) {
      std::vector<std::string> known;
      for (const Candidate& c : catalogue_.candidates()) known.push_back(c.id);
      throw InputError("\"exclude\" names \"" + id + "\", which is no effect that could be found" +
                       did_you_mean(id, known));
    }
  catalogue_.set_nuisances(read_uncertainty(options, catalogue_));
}

/// Noise levels, traces and their first reference.
void Diagnoser::prepare(std::span<const LogFile> logs, Diagnosis& d) {
  problem_ = Problem{};
  problem_.catalogue = &catalogue_;
  const Car& car = catalogue_.car();
  problem_.process_unit = {0.1, 0.1, 0.1 / (car.lf + car.lr)};
  std::vector<Measured> stretches;
  for (const LogFile& log : logs) {
    stretches.insert(stretches.end(), log.stretches.begin(), log.stretches.end());
    d.health.insert(d.health.end(), log.health.begin(), log.health.end());
  }
  const Channels seen = estimate_noise(stretches);
  for (std::size_t c = 0; c < channels; ++c) {
    const double stated = options_.noise_sigma ? (*options_.noise_sigma)[c] : world_.sensors.channels[c].sigma;
    const double floor = 1e-6 * (c < 2 ? car.lf + car.lr : c == 2 ? 1.0 : car.v_ref);
    if (std::isnan(seen[c])) {
      problem_.sensor[c] = std::max(floor, stated);
      continue;
    }
    if (stated > 0.0 && seen[c] < no_noise * stated) {
      // Simulated, or filtered: what is left is rounding, of which nothing is known.
      problem_.sensor[c] = no_noise * stated;
      d.health.push_back({std::string("noise of ") + channel_name(c), "none to be seen, stated " + number(stated),
                          "a twentieth of the stated is used; figures in standard deviations, intervals and confidence "
                          "are not to be relied on",
                          Health::Level::bad});
      continue;
    }
    const bool agrees = stated > 0.0 && seen[c] > 0.85 * stated && seen[c] < 1.15 * stated;
    problem_.sensor[c] = agrees ? stated : std::max(floor, seen[c]);
    if (!agrees)
      d.health.push_back({std::string("noise of ") + channel_name(c),
                          number(seen[c]) + (stated > 0.0 ? ", stated " + number(stated) : ", not stated"),
                          "the measured one is used", stated > 0.0 ? Health::Level::note : Health::Level::good});
  }
  for (Measured& one : stretches) {
    Trace trace;
    trace.log = std::move(one);
    trace.set_motion(smooth_readings(trace.log, 3), road_);
    problem_.rows += trace.size() * channels;
    problem_.traces.push_back(std::move(trace));
  }
  problem_.substeps = substeps_of_motion(catalogue_.build(catalogue_.bare()), problem_.traces);
  problem_.penalty_per_parameter = 0.5 * std::log(static_cast<double>(problem_.rows));
  d.sensor = problem_.sensor;
}

Diagnosis Diagnoser::run(std::span<const LogFile> given, std::span<const LogFile> given_held_out,
                         const ProgressCallback& tell) {
  // Parts that take about equally long: the search is four of them.
  constexpr std::size_t parts = 8;
  const auto at = [&](double done, const char* what) {
    if (tell) tell(done, parts, what);
  };
  at(0, "preparing");
  check_held_out(given, given_held_out);
  const std::vector<LogFile> logs = each_once(given), held_out = each_once(given_held_out);
  Diagnosis d;
  prepare(logs, d);
  SearchOptions options;
  options.worth_adding = worth_adding;
  at(1, "searching");
  if (tell) options.tell = [&](double done, std::size_t, const std::string& what) { tell(1 + done, parts, what); };
  Search search(problem_, road_, options);
  search.run();
  d.nothing = search.null_model();
  at(5, "judging");
  const HoldOut hold_out(problem_, road_, held_out);
  decide(search, hold_out, d);
  at(6, "refining");
  if (!d.fit.theta.empty()) {
    // Along the trajectory that the found model itself smooths, for the last per mille of the parameters.
    renew_reference(problem_, road_, d.fit);
    d.fit = fit(problem_, d.fit.model, d.fit.noise, 5);
  }
  describe(d.fit, d);
  at(7, "measuring the gap");
  measure_gap(hold_out, search, d);
  // Beside something unknown, effects that leave most of the gap open are imitations of it.
  const bool imitation = d.verdict == Verdict::unknown && !d.named.empty() && d.gap.closure < 0.5;
  // Where nothing is named only refitted nuisances differ, and what stands beyond doubt may be small or rest during the
  // laps held out or drown in a rough road: these only must not do harm.
  const bool rough = rough_road(problem_, d.fit.noise);
  const bool sure = d.named.empty() || d.fit.score - d.nothing.score > beyond_doubt || rough;
  const bool no_better =
      sure ? d.gap.after > (rough ? no_worse_when_rough : no_worse) * d.gap.before : d.gap.after >= d.gap.before;
  if (no_better || imitation) take_back(search, d);
  if (d.verdict == Verdict::nothing_missing) find_floors(search, d);
  d.sentence = sentence(d);
  return d;
}

/// True when the 95 % region of a member's parameters holds the values at which it does nothing.
bool Diagnoser::may_be_nothing(const Fit& fitted, std::size_t which) const {
  std::size_t at = catalogue_.nuisances().size();
  for (std::size_t i = 0; i < which; ++i) at += catalogue_.candidates()[fitted.model.members[i]].fitted.size();
  const Candidate& c = catalogue_.candidates()[fitted.model.members[which]];
  const std::size_t all = fitted.theta.size();
  // One interval that leaves out the neutral value is enough: the others may say where, or how wide.
  for (std::size_t f = 0; f < c.fitted.size(); ++f, ++at) {
    const double off = fitted.theta[at] - c.decl(f).neutral;
    if (std::abs(off) > ninety_five * std::sqrt(std::max(0.0, fitted.covariance[at * all + at]))) return false;
  }
  return true;
}

/// Below two laps a place is passed once or not again: what an effect does there could as well belong to that time.
bool Diagnoser::place_may_be_time(const ModelSpec& model, std::size_t member) const {
  double laps = 0.0;
  bool differs = false;
  ModelSpec alone = catalogue_.with(catalogue_.bare(), member);
  alone.values.front() = model.values[model.position(member)];
  const StagedCar car = catalogue_.build(alone);
  for (const Trace& trace : problem_.traces) {
    Trace elsewhere = trace;
    double driven = 0.0;
    for (std::size_t k = 0; k < trace.size(); ++k) {
      double& place = elsewhere.at[k].lap_fraction;
      place = place < 0.5 ? place + 0.5 : place - 0.5;
      if (k == 0) continue;
      const double step = trace.at[k].lap_fraction - trace.at[k - 1].lap_fraction;
      driven += step - std::round(step);
    }
    laps += std::abs(driven);
    const std::vector<double> memory = run_memory(car, trace);
    differs |= rates_at_samples(car, trace, memory) != rates_at_samples(car, elsewhere, memory);
  }
  return differs && laps < 2.0;
}

/// An effect that stands on little evidence must also help where nothing was fitted. On a rough road errors of
/// predictions are mostly the road's, and bear witness to nothing.
bool Diagnoser::helps(const Fit& with, const Fit& without, const HoldOut& hold_out) const {
  if (with.score - without.score > beyond_doubt || rough_road(problem_, with.noise)) return true;
  return hold_out.error_after_refit(with) < hold_out.error_after_refit(without);
}

/// Takes out what may be nothing or does not help, the least supported first.
void Diagnoser::drop_idle(Search& search, const HoldOut& hold_out, Diagnosis& d) {
  for (bool dropped = true; dropped;) {
    dropped = false;
    const Fit* next = nullptr;
    for (std::size_t i = 0; i < d.fit.model.members.size(); ++i) {
      // What is far behind needs no finished fit to be told so, unless it is what remains.
      const Fit& without = search.fit_near(catalogue_.without(d.fit.model, d.fit.model.members[i]), d.fit.noise,
                                           d.fit.score, beyond_doubt);
      const bool idle = may_be_nothing(d.fit, i) || !helps(d.fit, without, hold_out);
      if (idle && (next == nullptr || without.score > next->score)) next = &without;
    }
    if (next == nullptr) return;
    d.fit = search.fit_once(next->model, next->noise);
    dropped = true;
  }
}

/// Models that the data cannot tell from the one found, that first: where any is as good, the fewest that together hold
/// the truth as good as surely. More effects than were found, or one that may be nothing, say nothing else.
std::vector<const Fit*> Diagnoser::equals_of(const Fit& found, std::span<const Fit* const> rivals, const Fit& nothing,
                                             const HoldOut& hold_out) const {
  const double far = -std::log(1.0 - all_but_sure);
  std::vector<const Fit*> equals{&found};
  std::vector<double> chance{1.0};
  for (const Fit* rival : rivals) {
    const double behind = found.score - rival->score;
    if (rival == &found || rival->model.members.empty() || contains(rival->model, found.model)) continue;
    // Best first: with none as good as the one found there is nothing to ask.
    if (behind > (equals.size() == 1 ? same_evidence : far)) break;
    bool idle = false;
    for (std::size_t i = 0; i < rival->model.members.size(); ++i) idle |= may_be_nothing(*rival, i);
    if (idle || !helps(*rival, nothing, hold_out)) continue;
    equals.push_back(rival);
    chance.push_back(std::exp(-behind));
  }
  const double all = std::accumulate(chance.begin(), chance.end(), 0.0);
  std::size_t enough = 0;
  for (double held = 0.0; enough < chance.size() && held < all_but_sure * all; ++enough) held += chance[enough];
  equals.resize(enough);
  return equals;
}

void Diagnoser::decide(Search& search, const HoldOut& hold_out, Diagnosis& d) {
  d.fit = search.best();
  drop_idle(search, hold_out, d);
  d.tests = remainder(problem_, d.fit);
  if (const BasisTest left = strongest(d.tests); left.excess > structured || search.exhausted()) {
    const std::size_t named = d.fit.model.members.size();
    strip_unsupported(search, d, left.where);
    if (d.fit.model.members.size() < named) d.tests = remainder(problem_, d.fit);
    d.verdict = Verdict::unknown;
    d.unknown = strongest(d.tests);
  }
  // Rivals: every model tried whose evidence is near.
  std::vector<const Fit*> rivals{&d.fit};
  for (const Fit* one : search.tried()) {
    if (rivals.size() >= 12) break;
    if (one->model.members != d.fit.model.members && one->score > d.fit.score - 40.0) rivals.push_back(one);
  }
  std::stable_sort(rivals.begin(), rivals.end(), [](const Fit* a, const Fit* b) { return a->score > b->score; });
  const Resampled drawn = resample(problem_, rivals);
  const std::vector<double> weight = posterior(rivals);
  std::map<std::size_t, double> won;
  for (std::size_t i = 0; i < rivals.size(); ++i)
    for (const std::size_t member : rivals[i]->model.members) won[member] += drawn.wins[i];
  rank(search, won, d);
  for (const std::size_t member : d.fit.model.members) {
    NamedEffect named;
    named.effect = catalogue_.candidates()[member].id;
    double wins = 0.0, evidence = 0.0;
    for (std::size_t i = 0; i < rivals.size(); ++i) {
      if (!rivals[i]->model.has(member)) continue;
      wins += drawn.wins[i];
      evidence += weight[i];
    }
    named.confidence = std::min({wins, evidence, 0.999});
    if (d.verdict == Verdict::unknown) named.confidence = std::min(named.confidence, 0.5);
    if (place_may_be_time(d.fit.model, member)) named.confidence = std::min(named.confidence, most_in_one_lap);
    d.named.push_back(std::move(named));
  }
  if (d.verdict == Verdict::unknown) return;
  if (d.fit.model.members.empty()) {
    d.verdict = Verdict::nothing_missing;
    return;
  }
  d.verdict = Verdict::named;
  const auto ids = [&](const ModelSpec& model) {
    std::vector<std::string> list;
    for (const std::size_t m : model.members) list.push_back(catalogue_.candidates()[m].id);
    return list;
  };
  const std::vector<const Fit*> equals = equals_of(d.fit, rivals, search.null_model(), hold_out);
  if (equals.size() > 1) {
    d.verdict = Verdict::indistinguishable;
    for (const Fit* one : equals) d.equivalent.push_back(ids(one->model));
    d.manoeuvre = advice(d.equivalent);
  }
  // Names for one and the same thing.
  for (const auto& [kept, others] : search.synonyms())
    for (const std::size_t other : others) {
      if (!d.fit.model.has(kept)) continue;
      std::vector<std::string> same = ids(d.fit.model);
      std::replace(same.begin(), same.end(), catalogue_.candidates()[kept].id, catalogue_.candidates()[other].id);
      if (d.equivalent.empty()) d.equivalent.push_back(ids(d.fit.model));
      d.equivalent.push_back(same);
    }
}

/// What was found does not predict what was not fitted: the nominal model is returned as it was given, and the verdict is
/// that whatever is missing is not known.
void Diagnoser::take_back(const Search& search, Diagnosis& d) const {
  if (d.verdict != Verdict::nothing_missing) {
    d.verdict = Verdict::unknown;
    if (!d.unknown) d.unknown = strongest(d.tests);
  }
  d.named.clear();
  d.equivalent.clear();
  d.manoeuvre.clear();
  d.nominal_fit.clear();
  d.fit = search.null_model();
  d.fit.model = catalogue_.bare();
  d.fit.evaluation.reset();
  d.fit.theta.clear();
  d.fit.covariance.clear();
  for (auto& row : d.horizons) row.after = row.before;
  d.gap.after = d.gap.before;
  d.gap.closure = 0.0;
}

/// Something is left: effects that generic functions of the same kind explain as well, or whose size changes with time or
/// from side to side, were stand-ins for it.
void Diagnoser::strip_unsupported(Search& search, Diagnosis& d, Where where) {
  while (!d.fit.model.members.empty()) {
    const std::vector<Linearised> along = linearise_all(problem_, d.fit.model);
    const std::vector<double> support = support_beside(problem_, d.fit, along, where),
                              varies = inconstancy(problem_, d.fit, along);
    auto which = std::min_element(support.begin(), support.end()) - support.begin();
    if (support[static_cast<std::size_t>(which)] > worth_adding) {
      which = std::max_element(varies.begin(), varies.end()) - varies.begin();
      if (varies[static_cast<std::size_t>(which)] < structured) return;
    }
    const std::size_t member = d.fit.model.members[static_cast<std::size_t>(which)];
    d.fit = search.fit_once(catalogue_.without(d.fit.model, member), d.fit.noise);
  }
}

void Diagnoser::describe(const Fit& fitted, Diagnosis& d) const {
  std::size_t at = 0;
  const std::size_t p = fitted.theta.size();
  for (const Nuisance& n : catalogue_.nuisances()) d.nominal_fit.emplace_back(n.name, fitted.theta[at++]);
  for (std::size_t i = 0; i < fitted.model.members.size(); ++i) {
    const Candidate& c = catalogue_.candidates()[fitted.model.members[i]];
    for (std::size_t f = 0; f < c.fitted.size(); ++f, ++at) {
      const abi::ParamDecl& decl = c.decl(f);
      const double sigma = std::sqrt(std::max(0.0, fitted.covariance[at * p + at]));
      d.named[i].params.push_back({decl.name, decl.unit, fitted.theta[at], fitted.theta[at] - ninety_five * sigma,
                                   fitted.theta[at] + ninety_five * sigma});
    }
  }
}

void Diagnoser::measure_gap(const HoldOut& hold_out, Search& search, Diagnosis& d) {
  constexpr std::array<double, 5> seconds = {0.1, 0.2, 0.5, 1.0, 2.0};
  Fit nominal = search.null_model();
  nominal.model = catalogue_.bare();  // before: nothing refitted
  nominal.evaluation.reset();
  const auto before = hold_out.errors(nominal, seconds);
  const auto after = d.fit.theta.empty() ? before : hold_out.errors(hold_out.refit(d.fit), seconds);
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    d.horizons.push_back({seconds[i], before[i], after[i]});
    if (seconds[i] != d.gap.horizon) continue;
    d.gap.before = before[i];
    d.gap.after = after[i];
  }
  // What a perfect model would still show is the sensors' own noise: one standard deviation.
  const double rest = std::min(1.0, d.gap.after);
  d.gap.closure = d.gap.before > rest + 1e-9 ? (d.gap.before - d.gap.after) / (d.gap.before - rest) : 0.0;
  for (Ranked& row : d.ranking) {
    const Fit* const one = search.alone(catalogue_.find(row.effect));
    row.held_out = one == nullptr ? before[3] : hold_out.errors(*one, std::span(seconds).subspan(3, 1)).front();
  }
}

/// Every candidate alone: refitted where that was tried, else as predicted by the score test.
void Diagnoser::rank(Search& search, const std::map<std::size_t, double>& wins, Diagnosis& d) const {
  for (const Extension& e : search.screen_once(search.null_model()).extensions) {
    Ranked row;
    row.effect = catalogue_.candidates()[e.candidate].id;
    row.gain = e.gain - problem_.charge(e.dof);
    if (search.alone(e.candidate) != nullptr) row.gain = search.gain_alone(e.candidate);
    if (const auto found = wins.find(e.candidate); found != wins.end()) row.selected_fraction = found->second;
    d.ranking.push_back(std::move(row));
  }
  std::stable_sort(d.ranking.begin(), d.ranking.end(),
                   [](const Ranked& a, const Ranked& b) { return a.gain > b.gain; });
}

void Diagnoser::find_floors(Search& search, Diagnosis& d) const {
  const Screening& s = search.screen_once(search.null_model());
  for (const Group& group : s.groups) {
    const Candidate& c = catalogue_.candidates()[group.candidate];
    double largest = 0.0;
    for (std::size_t i = 0; i < group.count; ++i) {
      const auto at = static_cast<Eigen::Index>(group.first + i);
      const double information = s.normal.N(at, at);
      if (!(information > 0.0)) continue;
      largest = std::max(largest, std::sqrt(2.0 * (worth_adding + problem_.penalty_per_parameter) / information));
    }
    d.floors.push_back({c.id, c.decl(0).name, c.decl(0).unit, largest});
  }
}

}  // namespace gripline::diagnose
