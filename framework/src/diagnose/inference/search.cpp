#include "diagnose/inference/search.hpp"

#include <algorithm>
#include <cmath>

#include "diagnose/inference/newton_step.hpp"
#include "diagnose/inference/noise_estimate.hpp"
#include "diagnose/inference/noise_remeasurement.hpp"
#include "diagnose/inference/reference.hpp"

namespace gripline::diagnose {

const Fit* SearchResult::alone(std::size_t candidate) const {
  const std::vector<std::size_t> members{candidate};
  if (const auto first = first_reference.find(members); first != first_reference.end()) return &first->second;
  return pool.find(members);
}

double SearchResult::evidence_alone(std::size_t candidate) const {
  const Fit* const one = alone(candidate);
  const auto first = first_reference.find({candidate});
  const bool old = first != first_reference.end() && &first->second == one;
  return one->evidence - (old ? first_reference.at({}).evidence : null_model.evidence);
}

double required_evidence(std::size_t size, double over_null, SearchReference along) {
  if (size <= 1) return thresholds::single_gain;
  const bool refined = along == SearchReference::refined;
  const double share = refined ? thresholds::further_share_refined : thresholds::further_share;
  return std::max(thresholds::further_gain, share * over_null);
}

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// The state of one search. Pointers to fits are the pool's.
class Searcher {
 public:
  /// The null model is fitted here, along the problem's reference.
  Searcher(Problem problem, const Road& road, const SearchOptions& options, const Noise& start)
      : pool_(std::move(problem)), road_(road), options_(options) {
    null_model_ = best_ = &pool_.fit_once(pool_.problem().catalogue->null_model(), start);
    synonyms_ = synonyms(pool_.screen_once(*null_model_));
  }
  SearchResult run();

 private:
  const Catalogue& catalogue() const { return *pool_.problem().catalogue; }
  /// Whether the work allowed is used up: then only what was begun is finished.
  bool out_of_work() const {
    return pool_.work() > options_.work_per_minute * std::max(1.0, pool_.problem().seconds() / 60.0);
  }
  bool left_out(std::size_t candidate) const;
  bool worth_fitting(const Extension& e, double best_gain) const;
  std::vector<const Fit*> extend(const Fit& from, std::size_t tries, double rival = -infinity,
                                 double enough = infinity);
  double required(std::size_t size, double smaller) const;
  bool is_worth(const Fit& larger, const Fit& smaller) const;
  bool may_beat_best(const Fit& rough) const;
  void forward();
  void try_pairs();
  void exchange(const Fit& less, bool& improved);
  void backward_and_exchange();
  void penalise_by_independent_readings();
  void grow();
  /// Goes on from a new null model, if there is one, beside which the pool is empty.
  bool go_on_from(const Fit* null_model);
  void refine_along_own_reference();
  void prune();
  bool forward_once();
  bool extendable() const { return best_->model.members.size() < thresholds::max_effects && !out_of_work(); }

  ModelPool pool_;
  const Road& road_;
  const SearchOptions& options_;
  std::map<std::size_t, std::vector<std::size_t>> synonyms_;
  std::map<std::vector<std::size_t>, Fit> first_reference_;
  bool exhausted_ = false;
  const Fit* null_model_ = nullptr;
  const Fit* best_ = nullptr;
};

/// Whether another candidate does exactly the same and stands for it.
bool Searcher::left_out(std::size_t candidate) const {
  return std::any_of(synonyms_.begin(), synonyms_.end(), [&](const auto& kept) {
    return std::find(kept.second.begin(), kept.second.end(), candidate) != kept.second.end();
  });
}

bool Searcher::worth_fitting(const Extension& e, double best_gain) const {
  const double penalty = pool_.problem().penalty(e.dof);
  const double enough =
      e.dof > thresholds::full_penalty_parameters
          ? thresholds::predicted_penalty_share * penalty
          : penalty + thresholds::predicted_gain_share * required(e.start.members.size(), best_->evidence);
  return !left_out(e.candidate) && !(e.gain < enough) && !(e.gain < thresholds::least_share_of_best * best_gain);
}

/// The best extensions of a model, best first, well fitted where they come near the evidence of a `rival`; only one
/// when its evidence is enough.
std::vector<const Fit*> Searcher::extend(const Fit& from, std::size_t tries, double rival, double enough) {
  const Screening& s = pool_.screen_once(from);
  std::vector<Fit*> rough;
  double best_gain = 0.0, best = rival;
  for (const Extension& e : s.extensions) best_gain = std::max(best_gain, e.gain);
  for (const Extension& e : s.extensions) {
    if (rough.size() >= tries || (out_of_work() && !rough.empty())) break;
    if (!worth_fitting(e, best_gain)) continue;
    // Fits out of reach of the best are given up early.
    const double needed = best - thresholds::early_slack * unfinished_margin(best, from.evidence);
    rough.push_back(&pool_.rough_fit(e.start, from.noise, needed));
    best = std::max(best, rough.back()->evidence);
    if (best > enough) return {rough.back()};
  }
  const double margin = unfinished_margin(best, from.evidence);
  for (Fit* one : rough)
    if (one->evidence > best - margin && pool_.finish(*one).evidence > enough) return {one};
  std::vector<const Fit*> fits(rough.begin(), rough.end());
  std::stable_sort(fits.begin(), fits.end(), [](const Fit* a, const Fit* b) { return a->evidence > b->evidence; });
  return fits;
}

/// required_evidence() over a model of this evidence.
double Searcher::required(std::size_t size, double smaller) const {
  const auto along = first_reference_.empty() ? SearchReference::first : SearchReference::refined;
  return required_evidence(size, smaller - null_model_->evidence, along);
}

/// Whether a model's last effect is worth having. What is put in and what is taken out follow this one rule: by two
/// that differ a bit, the search put an effect in and took it out for ever.
bool Searcher::is_worth(const Fit& larger, const Fit& smaller) const {
  return larger.evidence > smaller.evidence + required(larger.model.members.size(), smaller.evidence);
}

bool Searcher::may_beat_best(const Fit& rough) const {
  return rough.evidence > best_->evidence - unfinished_margin(best_->evidence, null_model_->evidence);
}

/// Adds effects one at a time to the best few models of each size.
void Searcher::forward() {
  std::vector<const Fit*> beam{null_model_};
  for (std::size_t size = 1; size <= thresholds::max_effects && !out_of_work(); ++size) {
    const std::size_t tries = size == 1 ? thresholds::first_tries : thresholds::tries;
    std::vector<const Fit*> next;
    double best = -infinity;
    for (const Fit* from : beam)
      for (const Fit* one : extend(*from, tries, best)) {
        if (std::find(next.begin(), next.end(), one) == next.end()) next.push_back(one);
        best = std::max(best, one->evidence);
      }
    std::stable_sort(next.begin(), next.end(), [](const Fit* a, const Fit* b) { return a->evidence > b->evidence; });
    if (next.empty() || !is_worth(*next.front(), *best_)) break;
    best_ = next.front();
    const double far = thresholds::beam_range * std::abs(best_->evidence - null_model_->evidence);
    beam.clear();
    for (const Fit* one : next)
      if (beam.size() < thresholds::beam && one->evidence > best_->evidence - far) beam.push_back(one);
  }
}

/// Two effects may hide each other: neither is then among the best single ones, and the beam leaves both out.
void Searcher::try_pairs() {
  if (best_->model.members.size() < 2) return;
  const Fit* const grown = best_;
  std::size_t tries = 0;
  for (const Extension& pair : best_pairs(pool_.problem(), *null_model_, pool_.screen_once(*null_model_))) {
    const auto& members = pair.start.members;
    if (std::any_of(members.begin(), members.end(), [&](std::size_t m) { return left_out(m); })) continue;
    if (tries++ == thresholds::pair_tries || out_of_work()) break;
    const double needed =
        best_->evidence - thresholds::early_slack * unfinished_margin(best_->evidence, null_model_->evidence);
    Fit& rough = pool_.rough_fit(pair.start, null_model_->noise, needed);
    if (may_beat_best(rough) && pool_.finish(rough).evidence > best_->evidence) best_ = &rough;
  }
  // Not beyond the largest model: whether that is enough is tested along its own reference.
  while (best_ != grown && extendable() && forward_once()) continue;
}

/// Puts another effect in the place of the one taken out.
void Searcher::exchange(const Fit& less, bool& improved) {
  for (const Fit* swapped : extend(less, thresholds::late_tries, best_->evidence)) {
    const bool larger = swapped->model.members.size() > best_->model.members.size();
    const bool better = swapped->evidence > best_->evidence + thresholds::exchange_gain;
    if (!(larger ? is_worth(*swapped, *best_) : better)) continue;
    best_ = swapped;
    improved = true;
  }
}

/// Tries the best model with fewer effects and with one exchanged, as long as that helps.
void Searcher::backward_and_exchange() {
  for (bool improved = true; improved && !out_of_work();) {
    improved = false;
    const Fit* const before = best_;
    for (const std::size_t member : before->model.members) {
      Fit& rough = pool_.rough_fit(catalogue().without(before->model, member), before->noise);
      const bool near = may_beat_best(rough);
      const Fit& less = near ? pool_.finish(rough) : rough;
      if (less.model.members.size() < best_->model.members.size() && !is_worth(*best_, less)) {
        best_ = &less;
        improved = true;
      }
      // Far exchanges were tried along the first reference.
      if (before->model.members.size() < 2 || (!near && !first_reference_.empty())) continue;
      exchange(less, improved);
    }
  }
}

/// Schwarz's penalty counts independent readings. With strong process noise the independent values of that count.
void Searcher::penalise_by_independent_readings() {
  if (!has_strong_process_noise(pool_.problem(), best_->noise)) return;
  pool_.penalise_as_rough();
  const Fit* const found = best_;
  best_ = null_model_;
  forward();
  backward_and_exchange();
  if (out_of_work() && found->evidence > best_->evidence) best_ = found;  // there was no time to find it again
}

/// Fits the best models again along the reference of the best. The first reference was smoothed with the nominal car,
/// where a strong effect leaves errors of second order that further effects would fit.
void Searcher::refine_along_own_reference() {
  const Fit found = *best_, null_model = *null_model_;
  std::vector<Fit> near;
  const std::vector<const Fit*> all = pool_.all();
  for (const Fit* one : all)
    if (one != best_ && one->evidence > best_->evidence - thresholds::refit_range &&
        near.size() < thresholds::refit_models)
      near.push_back(*one);
  for (const Fit* one : all)
    if (one->model.members.size() < 2) first_reference_.emplace(one->model.members, *one);
  pool_.restart(road_, found);
  null_model_ = &pool_.fit_once(null_model.model, null_model.noise);
  best_ = &pool_.fit_once(found.model, found.noise);
  // Also when the work is used up: without its rivals the confidence in the best would be too large.
  for (const Fit& one : near) {
    const Fit& again = pool_.fit_once(one.model, one.noise);
    if (again.evidence > best_->evidence) best_ = &again;
  }
  backward_and_exchange();
  while (!out_of_work() && forward_once()) backward_and_exchange();
}

/// Takes out what smaller models fitted before show not to be needed: also when the work allowed is used up, and what
/// was found is worth less under the last noise and along the last reference.
void Searcher::prune() {
  for (const Fit* before = nullptr; before != best_ && best_ != null_model_;) {
    before = best_;
    std::vector<const Fit*> smaller{null_model_};
    for (const std::size_t member : before->model.members)
      smaller.push_back(pool_.find(catalogue().without(before->model, member).members));
    for (const Fit* one : smaller)
      if (one != nullptr && !is_worth(*before, *one) && (best_ == before || one->evidence > best_->evidence))
        best_ = one;
  }
  // That even the largest model lacks something was found beside effects of which some are gone now. The smaller model
  // has room for others; whether it leaves something unexplained is for the tests of its remainder to say.
  if (best_->model.members.size() < thresholds::max_effects) exhausted_ = false;
}

/// One effect more beside those found.
bool Searcher::forward_once() {
  const Fit* const before = best_;
  const bool largest = before->model.members.size() >= thresholds::max_effects;
  // The catalogue is found insufficient only by more than linearisation errors could bring.
  const double least = largest ? thresholds::further_share * (before->evidence - null_model_->evidence) : 0.0;
  const double more_needed = required(before->model.members.size() + 1, before->evidence);
  const double enough = before->evidence + std::max(more_needed, least);
  const auto more = extend(*before, thresholds::late_tries, before->evidence, largest ? enough : infinity);
  if (more.empty() || more.front()->evidence <= enough) return false;
  exhausted_ = largest;
  if (!largest) best_ = more.front();
  return !largest;
}

/// From no effect to the best set.
void Searcher::grow() {
  best_ = null_model_;
  forward();
  try_pairs();
  backward_and_exchange();
  penalise_by_independent_readings();
}

bool Searcher::go_on_from(const Fit* null_model) {
  if (null_model != nullptr) null_model_ = null_model;
  return null_model != nullptr;
}

SearchResult Searcher::run() {
  const auto report = [&](double quarters) {
    if (options_.progress) options_.progress(quarters, 4, "searching");
  };
  report(1);
  grow();
  // What was found is another thing once commands are held otherwise: asked again, but not for ever.
  constexpr int most_holds = 3;
  for (int i = 0; i < most_holds && go_on_from(hold_commands_anew(pool_, road_, *null_model_, *best_)); ++i) grow();
  report(2);
  const auto measured_anew = [&] { return go_on_from(measure_noise_anew(pool_, road_, *null_model_, *best_)); };
  if (measured_anew()) {
    grow();
    // Bends are asked for beside unknown commands only: where those are new, with what was found in them.
    if (pool_.problem().command != UnknownCommands{} && measured_anew()) grow();
  }
  report(3);
  if (best_ != null_model_) refine_along_own_reference();
  prune();
  Fit null_model = *null_model_, best = *best_;
  return {std::move(pool_), std::move(null_model), std::move(best),
          exhausted_,       std::move(synonyms_),  std::move(first_reference_)};
}

}  // namespace

SearchResult search_effects(Problem problem, const Road& road, const SearchOptions& options) {
  Noise noise;
  noise.sensor = problem.sensor;
  for (std::size_t i = 0; i < noise_states; ++i)
    noise.process[i] = std::pow(thresholds::start_process_noise * problem.process_unit[i], 2);
  Fit rough = fit(problem, problem.catalogue->null_model(), noise, thresholds::rough_iterations);
  if (problem.command_step != Commands{}) {
    // Rounded by the recorder, unless the log is significantly likelier with a car that is given rounded commands.
    Problem unrounded = problem;
    unrounded.unround_commands();
    Fit other = fit(unrounded, rough.model, noise, thresholds::rough_iterations);
    if (other.cost < rough.cost + thresholds::noise_gain) {
      problem = std::move(unrounded);
      rough = std::move(other);
    }
  }
  iterate_reference(problem, road, rough);
  Noise start = rough.noise;
  // Effects that are missing colour the innovations too: what is not plain is measured once they are found. So is what
  // commands did between samples: a bent throttle imitates what is missing of the brakes.
  if (colour_statistic(problem, rough) > thresholds::plainly_coloured * thresholds::coloured_innovations) {
    const MeasuredNoise measured = measure_noise(problem, rough, {});
    if (measured.gain > thresholds::noise_gain_before) {
      assume(problem, measured);
      Fit with_measured = rough;
      with_measured.noise = start = measured.noise;
      iterate_reference(problem, road, with_measured);
    }
  }
  return Searcher(std::move(problem), road, options, start).run();
}

}  // namespace gripline::diagnose
