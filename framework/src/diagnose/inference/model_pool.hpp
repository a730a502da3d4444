// All models fitted to one problem, each once.
#pragma once

#include <limits>
#include <map>
#include <vector>

#include "diagnose/inference/noise_estimate.hpp"
#include "diagnose/inference/screening.hpp"

namespace gripline::diagnose {

/// Owns the problem. References to fits stay valid until restart().
class ModelPool {
 public:
  explicit ModelPool(Problem problem) : problem_(std::move(problem)) {}

  const Problem& problem() const { return problem_; }
  /// Work of all fits so far: Linearised::work times samples.
  double work() const { return work_; }
  /// Every model fitted, best evidence first.
  std::vector<const Fit*> all() const;
  /// The model with these members; null when it was not fitted.
  const Fit* find(const std::vector<std::size_t>& members) const;

  /// The fit of the model with the members of `start`, from there when it is new.
  const Fit& fit_once(const ModelSpec& start, const Noise& noise);
  /// A few iterations: enough to see which of many is worth finishing; fewer where `needed` evidence is out of reach.
  Fit& rough_fit(const ModelSpec& start, const Noise& noise, double needed = -std::numeric_limits<double>::infinity());
  /// Goes on with a rough fit to the end.
  const Fit& finish(Fit& rough);
  const Screening& screen_once(const Fit& fitted);

  /// Takes the road for rough: another penalty per parameter, and every fit's evidence with it.
  void penalise_as_rough();
  /// Forgets all fits and smooths the reference with a model (until it converges); fits from now on are finer.
  void restart(const Road& road, const Fit& fitted);
  /// Forgets all fits and assumes other noise, smoothing the reference with a model under it; the work so far is not
  /// counted any more, and the road is rough no longer until that is found again.
  void restart(const Road& road, const Fit& fitted, const MeasuredNoise& noise);
  /// Likewise for commands that are held between samples, or no longer so: taken wrongly, they can make a road look
  /// rough.
  void restart(const Road& road, const Fit& fitted, const measured::CommandHold& hold);

 private:
  Problem problem_;
  std::map<std::vector<std::size_t>, Fit> fits_;
  std::map<std::vector<std::size_t>, Screening> screenings_;
  double work_ = 0;
  bool last_ = false;  // along the last reference
};

/// By how much an unfinished fit's evidence may lie below what it will be: `best` so far, `from` that of the model it
/// extends.
double unfinished_margin(double best, double from);

}  // namespace gripline::diagnose
