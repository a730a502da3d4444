#include "diagnosis.hpp"

#include <algorithm>
#include <cmath>

#include "../config/errors.hpp"
#include "advice.hpp"
#include "confidence.hpp"

namespace gripline::diagnose {
namespace {

constexpr double worth_adding = 3.0;      // log evidence an effect must bring
constexpr double never_worse = 1.02;      // errors on data not fitted, over those of the nominal model
constexpr double same_evidence = 2.0;     // models closer than this cannot be told apart
constexpr double ninety_five = 1.959964;  // standard deviations of a 95 % interval

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
  problem_.penalty_per_parameter = 0.5 * std::log(static_cast<double>(problem_.rows));
  d.sensor = problem_.sensor;
}

Diagnosis Diagnoser::run(std::span<const LogFile> logs, std::span<const LogFile> held_out) {
  Diagnosis d;
  prepare(logs, d);
  SearchOptions options;
  options.worth_adding = worth_adding;
  Search search(problem_, road_, options);
  search.run();
  d.nothing = search.nothing();
  decide(search, d);
  if (!d.fit.theta.empty()) {
    // Along the trajectory that the found model itself smooths, for the last per mille of the parameters.
    renew_reference(problem_, road_, d.fit);
    d.fit = fit(problem_, d.fit.model, d.fit.noise, 5);
  }
  describe(d.fit, d);
  measure_gap(held_out, search, d);
  // Beside something unknown, effects that leave most of the gap open are imitations of it.
  const bool imitation = d.verdict == Verdict::unknown && !d.named.empty() && d.gap.closure < 0.5;
  if (d.gap.after > never_worse * d.gap.before || imitation) take_back(held_out, search, d);
  if (d.verdict == Verdict::nothing_missing) find_floors(search, d);
  d.sentence = sentence(d);
  return d;
}

void Diagnoser::decide(Search& search, Diagnosis& d) {
  d.fit = search.best();
  d.tests = remainder(problem_, d.fit);
  if (const BasisTest left = strongest(d.tests); left.excess > structured || search.exhausted()) {
    strip_unsupported(search, d, left.where);
    d.tests = remainder(problem_, d.fit);
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
    d.named.push_back(std::move(named));
  }
  if (d.verdict == Verdict::unknown) return;
  if (d.fit.model.members.empty()) {
    d.verdict = Verdict::nothing_missing;
    return;
  }
  d.verdict = Verdict::named;
  std::vector<std::vector<std::string>> equals;
  const auto ids = [&](const ModelSpec& model) {
    std::vector<std::string> list;
    for (const std::size_t m : model.members) list.push_back(catalogue_.candidates()[m].id);
    return list;
  };
  equals.push_back(ids(d.fit.model));
  for (const Fit* rival : rivals) {
    const bool near = rival->score > d.fit.score - same_evidence;
    if (near && !contains(rival->model, d.fit.model) && !rival->model.members.empty())
      equals.push_back(ids(rival->model));
  }
  if (equals.size() > 1) {
    d.verdict = Verdict::indistinguishable;
    d.equivalent = equals;
    d.manoeuvre = advice(equals);
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
void Diagnoser::take_back(std::span<const LogFile> held_out, Search& search, Diagnosis& d) {
  if (d.verdict != Verdict::nothing_missing) {
    d.verdict = Verdict::unknown;
    if (!d.unknown) d.unknown = strongest(d.tests);
  }
  d.named.clear();
  d.equivalent.clear();
  d.manoeuvre.clear();
  d.nominal_fit.clear();
  d.fit = search.nothing();
  d.fit.model = catalogue_.bare();
  d.fit.theta.clear();
  d.fit.covariance.clear();
  d.horizons.clear();
  measure_gap(held_out, search, d);
}

/// Something is left: effects that generic functions of the same kind explain as well were stand-ins for it.
void Diagnoser::strip_unsupported(Search& search, Diagnosis& d, Where where) {
  while (!d.fit.model.members.empty()) {
    const std::vector<double> support = support_beside(problem_, d.fit, where);
    const auto weakest = std::min_element(support.begin(), support.end());
    if (*weakest > worth_adding) return;
    const std::size_t member = d.fit.model.members[static_cast<std::size_t>(weakest - support.begin())];
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

namespace {

/// The sample from which on a log is held out: its last whole laps, about a third; below three laps its last third.
std::size_t hold_out_from(const Trace& trace) {
  std::vector<double> laps(trace.size(), 0.0);
  for (std::size_t k = 1; k < trace.size(); ++k) {
    double step = trace.at[k].lap_fraction - trace.at[k - 1].lap_fraction;
    laps[k] = laps[k - 1] + std::abs(step - std::round(step));
  }
  const double third = laps.back() / 3.0;
  if (third < 1.0) return trace.size() - trace.size() / 3;
  const double from = laps.back() - std::floor(third);
  return static_cast<std::size_t>(std::lower_bound(laps.begin(), laps.end(), from) - laps.begin());
}

Trace beginning(const Trace& trace, std::size_t samples) {
  Trace part = trace;
  part.log.command.resize(samples);
  part.log.reading.resize(samples * channels);
  part.motion.resize(samples * channels);
  part.at.resize(samples);
  part.command_dual.resize(samples);
  return part;
}

/// Logs to predict, and from which sample on.
struct Unseen {
  std::vector<Trace> traces;
  std::vector<std::size_t> from;
};

std::vector<double> prediction_errors(const Problem& problem, const Unseen& unseen, const Road& road, const Fit& f,
                                      std::span<const double> horizons) {
  Problem other = problem;
  other.traces = unseen.traces;
  renew_reference(other, road, f);
  const StagedCar car = problem.catalogue->build(f.model);
  std::vector<double> errors;
  for (const double horizon : horizons) {
    double sum = 0.0, count = 0.0;
    for (std::size_t i = 0; i < other.traces.size(); ++i) {
      RolloutOptions options;
      options.horizon = horizon;
      options.first = unseen.from[i] + 10;
      options.every = 25;
      options.substeps = problem.substeps;
      const Rollouts r = roll_out(car, other.traces[i], road, options);
      const double e = rms(r, problem.sensor);
      sum += e * e * static_cast<double>(r.start.size());
      count += static_cast<double>(r.start.size());
    }
    errors.push_back(count > 0.0 ? std::sqrt(sum / count) : 0.0);
  }
  return errors;
}

}  // namespace

void Diagnoser::measure_gap(std::span<const LogFile> held_out, Search& search, Diagnosis& d) {
  Unseen unseen;
  Problem known = problem_;
  for (const LogFile& log : held_out)
    for (const Measured& m : log.stretches) {
      Trace trace;
      trace.log = m;
      trace.set_motion(smooth_readings(m, 3), road_);
      unseen.traces.push_back(std::move(trace));
      unseen.from.push_back(0);
    }
  if (held_out.empty())
    for (Trace& trace : known.traces) {
      unseen.from.push_back(hold_out_from(trace));
      unseen.traces.push_back(trace);
      trace = beginning(trace, std::max<std::size_t>(unseen.from.back(), 50));
    }
  const auto refit = [&](const Fit& f) {
    return held_out.empty() && !f.theta.empty() ? fit(known, f.model, f.noise, 3) : f;
  };
  constexpr std::array<double, 5> seconds = {0.1, 0.2, 0.5, 1.0, 2.0};
  Fit nominal = search.nothing();
  nominal.model = catalogue_.bare();  // before: nothing refitted
  const auto before = prediction_errors(known, unseen, road_, nominal, seconds);
  const auto after = d.fit.theta.empty() ? before : prediction_errors(known, unseen, road_, refit(d.fit), seconds);
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
    row.held_out = one == nullptr
                       ? before[3]
                       : prediction_errors(known, unseen, road_, *one, std::span(seconds).subspan(3, 1)).front();
  }
}

/// Every candidate alone: refitted where that was tried, else as predicted by the score test.
void Diagnoser::rank(Search& search, const std::map<std::size_t, double>& wins, Diagnosis& d) const {
  for (const Extension& e : search.screen_once(search.nothing()).extensions) {
    Ranked row;
    row.effect = catalogue_.candidates()[e.candidate].id;
    row.gain = e.gain - problem_.penalty_per_parameter * static_cast<double>(e.dof);
    if (search.alone(e.candidate) != nullptr) row.gain = search.gain_alone(e.candidate);
    if (const auto found = wins.find(e.candidate); found != wins.end()) row.selected_fraction = found->second;
    d.ranking.push_back(std::move(row));
  }
  std::stable_sort(d.ranking.begin(), d.ranking.end(),
                   [](const Ranked& a, const Ranked& b) { return a.gain > b.gain; });
}

void Diagnoser::find_floors(Search& search, Diagnosis& d) const {
  const Screening& s = search.screen_once(search.nothing());
  for (const Group& group : s.groups) {
    const Candidate& c = catalogue_.candidates()[group.candidate];
    double largest = 0.0;
    for (std::size_t i = 0; i < group.count; ++i) {
      const std::size_t at = group.first + i;
      const double information = s.N[at * s.params + at];
      if (!(information > 0.0)) continue;
      largest = std::max(largest, std::sqrt(2.0 * (worth_adding + problem_.penalty_per_parameter) / information));
    }
    d.floors.push_back({c.id, c.decl(0).name, c.decl(0).unit, largest});
  }
}

}  // namespace gripline::diagnose
