#include "diagnose/inference/model_pool.hpp"

#include <algorithm>

#include "diagnose/inference/reference.hpp"

namespace gripline::diagnose {

double unfinished_margin(double best, double from) {
  return thresholds::unfinished_slack + thresholds::unfinished_share * std::max(0.0, best - from);
}

std::vector<const Fit*> ModelPool::all() const {
  std::vector<const Fit*> all;
  for (const auto& [members, one] : fits_) all.push_back(&one);
  std::stable_sort(all.begin(), all.end(), [](const Fit* a, const Fit* b) { return a->evidence > b->evidence; });
  return all;
}

const Fit* ModelPool::find(const std::vector<std::size_t>& members) const {
  const auto found = fits_.find(members);
  return found != fits_.end() ? &found->second : nullptr;
}

const Fit& ModelPool::fit_once(const ModelSpec& start, const Noise& noise) { return finish(rough_fit(start, noise)); }

Fit& ModelPool::rough_fit(const ModelSpec& start, const Noise& noise, double needed) {
  const auto found = fits_.find(start.members);
  if (found != fits_.end()) return found->second;
  Fit f = fit(problem_, start, noise, thresholds::rough_iterations, {thresholds::rough_tolerance, needed});
  work_ += f.work;
  return fits_.emplace(start.members, std::move(f)).first->second;
}

const Fit& ModelPool::finish(Fit& rough) {
  if (rough.converged || rough.finished) return rough;
  const int iterations = last_ ? thresholds::last_iterations : thresholds::finish_iterations;
  Fit better =
      continue_fit(problem_, rough, iterations, {last_ ? thresholds::fine_tolerance : thresholds::rough_tolerance});
  work_ += better.work;
  if (better.evidence >= rough.evidence) rough = std::move(better);
  rough.finished = true;
  screenings_.erase(rough.model.members);
  return rough;
}

const Screening& ModelPool::screen_once(const Fit& fitted) {
  const auto found = screenings_.find(fitted.model.members);
  if (found != screenings_.end()) return found->second;
  return screenings_.emplace(fitted.model.members, screen(problem_, fitted)).first->second;
}

void ModelPool::penalise_as_rough() {
  problem_.rough_road = true;
  for (auto& [members, one] : fits_) update_penalty(problem_, one);
  screenings_.clear();
}

void ModelPool::restart(const Road& road, const Fit& fitted) {
  const Fit by = fitted;  // it may be one of those forgotten
  iterate_reference(problem_, road, by);
  fits_.clear();
  screenings_.clear();
  last_ = true;
}

void ModelPool::restart(const Road& road, const Fit& fitted, const MeasuredNoise& noise) {
  Fit by = fitted;
  by.noise = noise.noise;
  by.model = noise.model;
  assume(problem_, noise);
  restart(road, by);
  last_ = false;
  work_ = 0.0;
}

void ModelPool::restart(const Road& road, const Fit& fitted, const measured::CommandHold& hold) {
  problem_.hold_commands(hold);
  problem_.rough_road = false;
  restart(road, fitted);
  last_ = false;
  work_ = 0.0;
}

}  // namespace gripline::diagnose
