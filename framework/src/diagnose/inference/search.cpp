#include "diagnose/inference/search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gripline::diagnose {
namespace {

constexpr double rough_tolerance = 0.05;  // log evidence that does not matter while models are chosen

/// A fit that was not finished lies below what it will be by a share of what it explains.
double unfinished(double best, double from) { return 15.0 + 0.2 * std::max(0.0, best - from); }

}  // namespace

Search::Search(Problem& problem, const Road& road, const SearchOptions& options)
    : problem_(problem), road_(road), options_(options) {}

std::vector<const Fit*> Search::tried() const {
  std::vector<const Fit*> all;
  for (const auto& [members, one] : fits_) all.push_back(&one);
  std::stable_sort(all.begin(), all.end(), [](const Fit* a, const Fit* b) { return a->score > b->score; });
  return all;
}

const Fit& Search::fit_once(const ModelSpec& start, const Noise& noise) { return finish(rough_fit(start, noise)); }

const Fit& Search::fit_near(const ModelSpec& start, const Noise& noise, double above, double margin) {
  Fit& rough = rough_fit(start, noise);
  return rough.score > above - margin - unfinished(above, null_model_->score) ? finish(rough) : rough;
}

/// A few iterations: enough to see which of many is worth finishing. Fewer where `wanted` is out of reach.
Fit& Search::rough_fit(const ModelSpec& start, const Noise& noise, double wanted) {
  const auto found = fits_.find(start.members);
  if (found != fits_.end()) return found->second;
  constexpr int few = 4;
  Fit& f = fits_.emplace(start.members, fit(problem_, start, noise, few, {rough_tolerance, wanted})).first->second;
  work_ += f.work;
  return f;
}

const Fit& Search::finish(Fit& rough) {
  if (rough.converged || rough.finished) return rough;
  const bool last = !small_.empty();
  Fit better = go_on(problem_, rough, last ? 12 : 7, {last ? 0.01 : rough_tolerance});
  work_ += better.work;
  if (better.score >= rough.score) rough = std::move(better);
  rough.finished = true;
  screenings_.erase(rough.model.members);
  return rough;
}

const Screening& Search::screen_once(const Fit& fitted) {
  const auto found = screenings_.find(fitted.model.members);
  if (found != screenings_.end()) return found->second;
  return screenings_.emplace(fitted.model.members, screen(problem_, fitted)).first->second;
}

/// Two single directions that are the same up to a factor are one effect under two names.
void Search::find_synonyms(const Screening& s) {
  const auto N = [&](std::size_t i, std::size_t j) {
    return s.normal.N(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  };
  std::vector<std::size_t> gone;
  for (std::size_t a = 0; a < s.groups.size(); ++a)
    for (std::size_t b = a + 1; b < s.groups.size(); ++b) {
      const Group &x = s.groups[a], &y = s.groups[b];
      if (x.count != 1 || y.count != 1) continue;
      if (std::find(gone.begin(), gone.end(), x.candidate) != gone.end()) continue;
      const double xx = N(x.first, x.first), yy = N(y.first, y.first), xy = N(x.first, y.first);
      if (!(xx > 0.0 && yy > 0.0) || xy * xy < (1.0 - 1e-10) * xx * yy) continue;
      synonyms_[x.candidate].push_back(y.candidate);
      gone.push_back(y.candidate);
    }
}

bool Search::left_out(std::size_t candidate) const {
  return std::any_of(synonyms_.begin(), synonyms_.end(), [&](const auto& kept) {
    return std::find(kept.second.begin(), kept.second.end(), candidate) != kept.second.end();
  });
}

std::vector<const Fit*> Search::extend(const Fit& from, std::size_t tries, double rival, double enough) {
  const Screening& s = screen_once(from);
  std::vector<const Fit*> fits;
  std::vector<Fit*> rough;
  double best_gain = 0.0, best = rival;
  for (const Extension& e : s.extensions) best_gain = std::max(best_gain, e.gain);
  for (const Extension& e : s.extensions) {
    if (rough.size() >= tries || (spent() && !rough.empty())) break;
    const double penalty = problem_.charge(e.dof);
    // Predicted gains are good to a factor of two, and too low where the noise still holds what is missing: that weighs
    // on effects of many parameters.
    const double wanted = e.dof > 3 ? 0.5 * penalty : penalty + 0.4 * required(e.start.members.size());
    if (left_out(e.candidate) || e.gain < wanted || e.gain < 0.03 * best_gain) continue;
    // What cannot come near the best so far is told early; twice the margin, for it is told from less.
    rough.push_back(&rough_fit(e.start, from.noise, best - 2.0 * unfinished(best, from.score)));
    best = std::max(best, rough.back()->score);
    if (best > enough) return {rough.back()};
  }
  const double margin = unfinished(best, from.score);
  for (Fit* one : rough)
    if (one->score > best - margin && finish(*one).score > enough) return {one};
  fits.assign(rough.begin(), rough.end());
  std::stable_sort(fits.begin(), fits.end(), [](const Fit* a, const Fit* b) { return a->score > b->score; });
  return fits;
}

double Search::required(std::size_t size) const {
  if (size <= 1) return options_.worth_adding;
  const double share = small_.empty() ? options_.share_beside : options_.share_settled;
  return std::max(options_.worth_beside, share * (best_->score - null_model_->score));
}

/// Adds effects one at a time to the best few models of each size.
void Search::grow() {
  std::vector<const Fit*> beam{null_model_};
  for (std::size_t size = 1; size <= options_.max_effects && !spent(); ++size) {
    std::vector<const Fit*> next;
    double best = -std::numeric_limits<double>::infinity();
    for (const Fit* from : beam)
      for (const Fit* one : extend(*from, size == 1 ? options_.tries + 2 : options_.tries, best)) {
        if (std::find(next.begin(), next.end(), one) == next.end()) next.push_back(one);
        best = std::max(best, one->score);
      }
    std::stable_sort(next.begin(), next.end(), [](const Fit* a, const Fit* b) { return a->score > b->score; });
    if (next.empty() || next.front()->score < best_->score + required(size)) break;
    best_ = next.front();
    beam.clear();
    for (const Fit* one : next)
      if (beam.size() < options_.beam && one->score > best_->score - 0.5 * std::abs(best_->score - null_model_->score))
        beam.push_back(one);
  }
}

/// Where more than one effect is missing, the two may hide each other and be no one's neighbours in the beam.
void Search::try_pairs() {
  constexpr std::size_t most = 3;
  if (best_->model.members.size() < 2) return;
  const Fit* const grown = best_;
  std::size_t tries = 0;
  for (const Extension& pair : best_pairs(problem_, *null_model_, screen_once(*null_model_))) {
    const auto& members = pair.start.members;
    if (std::any_of(members.begin(), members.end(), [&](std::size_t m) { return left_out(m); })) continue;
    if (tries++ == most || spent()) break;
    Fit& rough =
        rough_fit(pair.start, null_model_->noise, best_->score - 2.0 * unfinished(best_->score, null_model_->score));
    const bool near = rough.score > best_->score - unfinished(best_->score, null_model_->score);
    if (near && finish(rough).score > best_->score) best_ = &rough;
  }
  // Not beyond the largest model: whether that is enough is asked along its own reference.
  const auto may_grow = [&] { return best_->model.members.size() < options_.max_effects && !spent(); };
  while (best_ != grown && may_grow() && grow_once()) continue;
}

/// Tries the best model with fewer effects and with one exchanged.
void Search::polish() {
  for (bool moved = true; moved && !spent();) {
    moved = false;
    const Fit* const before = best_;
    for (const std::size_t member : before->model.members) {
      Fit& rough = rough_fit(problem_.catalogue->without(before->model, member), before->noise);
      const bool near = rough.score > best_->score - unfinished(best_->score, null_model_->score);
      const Fit& less = near ? finish(rough) : rough;
      if (less.score > best_->score - required(best_->model.members.size()) &&
          less.model.members.size() < best_->model.members.size()) {
        best_ = &less;
        moved = true;
      }
      // Once the reference is the found model's own, far swaps have been tried along the one before.
      if (before->model.members.size() < 2 || (!near && !small_.empty())) continue;
      for (const Fit* swapped : extend(less, 3, best_->score))
        if (swapped->score > best_->score + (swapped->model.members.size() > best_->model.members.size()
                                                 ? required(swapped->model.members.size())
                                                 : 1e-3)) {
          best_ = swapped;
          moved = true;
        }
    }
  }
}

/// Schwarz's penalty counts readings, as if each told something new. On a rough road what they tell of the car is covered
/// by random accelerations, and only their independent values count: one per channel in twice their correlation time.
void Search::charge_by_road() {
  if (!rough_road(problem_, best_->noise)) return;
  const double independent = static_cast<double>(noise_states) * problem_.seconds() / (2.0 * noise_time);
  problem_.penalty_per_parameter = 0.5 * std::log(std::min(static_cast<double>(problem_.rows), independent));
  for (auto& [members, one] : fits_) charge_for(problem_, one);
  screenings_.clear();
  const Fit* const found = best_;
  best_ = null_model_;
  grow();
  polish();
  if (spent() && found->score > best_->score) best_ = found;  // there was no time to find it again
}

/// The reference so far was smoothed with the nominal car, and what is missing bends it: a strong effect leaves errors
/// of second order that further effects would take up. Once more along the trajectory that the model found smooths.
void Search::settle() {
  const Fit found = *best_, null_model = *null_model_;
  std::vector<Fit> near;
  for (const Fit* one : tried())
    if (one != best_ && one->score > best_->score - 15.0 && near.size() < 6) near.push_back(*one);
  for (const auto& [members, one] : fits_)
    if (members.size() < 2) small_.emplace(members, one);
  settle_reference(problem_, road_, found);
  fits_.clear();
  screenings_.clear();
  null_model_ = &fit_once(null_model.model, null_model.noise);
  best_ = &fit_once(found.model, found.noise);
  // Also when the work is spent: without its rivals the best would look surer than it is.
  for (const Fit& one : near) {
    const Fit& again = fit_once(one.model, one.noise);
    if (again.score > best_->score) best_ = &again;
  }
  polish();
  while (!spent() && grow_once()) polish();
}

/// One effect more beside those found, along their own reference.
bool Search::grow_once() {
  const Fit* const before = best_;
  const bool largest = before->model.members.size() >= options_.max_effects;
  // That the catalogue does not suffice is said only of what no error of the models could be.
  const double least = largest ? options_.share_beside * (before->score - null_model_->score) : 0.0;
  const double worth = before->score + std::max(required(before->model.members.size() + 1), least);
  const auto more = extend(*before, 3, before->score, largest ? worth : std::numeric_limits<double>::infinity());
  if (more.empty() || more.front()->score <= worth) return false;
  exhausted_ = largest;
  if (!largest) best_ = more.front();
  return !largest;
}

const Fit* Search::alone(std::size_t candidate) const {
  const std::vector<std::size_t> members{candidate};
  if (const auto first = small_.find(members); first != small_.end()) return &first->second;
  const auto found = fits_.find(members);
  return found != fits_.end() ? &found->second : nullptr;
}

double Search::gain_alone(std::size_t candidate) const {
  const Fit* const one = alone(candidate);
  const auto first = small_.find({candidate});
  const bool old = first != small_.end() && &first->second == one;
  return one->score - (old ? small_.at({}).score : null_model_->score);
}

void Search::run() {
  const auto tell = [&](double quarters) {
    if (options_.tell) options_.tell(quarters, 4, "searching");
  };
  Noise noise;
  noise.sensor = problem_.sensor;
  for (std::size_t i = 0; i < noise_states; ++i) noise.process[i] = std::pow(5.0 * problem_.process_unit[i], 2);
  const ModelSpec bare = problem_.catalogue->bare();
  const Fit rough = fit(problem_, bare, noise, 4);
  settle_reference(problem_, road_, rough);
  tell(1);
  null_model_ = &fit_once(bare, rough.noise);
  best_ = null_model_;
  find_synonyms(screen_once(*null_model_));
  grow();
  try_pairs();
  tell(2);
  polish();
  charge_by_road();
  tell(3);
  if (best_ != null_model_) settle();
}

}  // namespace gripline::diagnose
