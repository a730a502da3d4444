// Which effects are missing: a search over sets of candidates by penalised likelihood, with refits.
#pragma once

#include <algorithm>
#include <limits>
#include <map>

#include "diagnose/inference/adequacy.hpp"
#include "diagnose/inference/screening.hpp"
#include "util/progress.hpp"

namespace gripline::diagnose {

struct SearchOptions {
  std::size_t max_effects = 3;  // more than that is not named: see `exhausted`
  std::size_t beam = 2;
  std::size_t tries = 6;      // refits per model extended
  double worth_adding = 3.0;  // rise of the score (log evidence) that an effect must bring
  /// The same beside other effects: there are dozens to choose from, and what is known of the found ones is good to a
  /// share of what they explain: linearisation along a reference that they bend, and later, along their own reference,
  /// integration.
  double worth_beside = 6.5;
  double share_beside = 0.002;
  double share_settled = 0.0001;
  /// Work after which the search ends with what it has: see Linearised::work, times samples; logs beyond a minute may
  /// take more in proportion. Three millions are about three seconds. Pairs that the catalogue holds seldom take more;
  /// something else can be imitated for ever.
  double most_work = 3e6;
  ProgressCallback tell;  // how much of the search is done, in quarters; may be empty
};

/// All models tried, and the best of them.
class Search {
 public:
  Search(Problem& problem, const Road& road, const SearchOptions& options = {});

  /// Runs the search; afterwards `best` is final.
  void run();

  const Fit& null_model() const { return *null_model_; }
  const Fit& best() const { return *best_; }
  /// Even the largest model allowed asks for another effect: the catalogue only imitates what is missing.
  bool exhausted() const { return exhausted_; }
  /// What one effect alone is worth: null when that was not tried. Its fit, and the rise of the score over nothing.
  const Fit* alone(std::size_t candidate) const;
  double gain_alone(std::size_t candidate) const;
  /// What the fits cost so far.
  double work() const { return work_; }
  /// Every model that was fitted along the last reference, best score first.
  std::vector<const Fit*> tried() const;
  /// Candidates left out because another does exactly the same: (kept, left out).
  const std::map<std::size_t, std::vector<std::size_t>>& synonyms() const { return synonyms_; }
  /// The fit of the model with these members, from `start` when it was not tried yet.
  const Fit& fit_once(const ModelSpec& start, const Noise& noise);
  /// The same, left unfinished where that cannot bring the score within `margin` of `above`.
  const Fit& fit_near(const ModelSpec& start, const Noise& noise, double above, double margin);
  const Screening& screen_once(const Fit& fitted);

 private:
  Fit& rough_fit(const ModelSpec& start, const Noise& noise, double wanted = -std::numeric_limits<double>::infinity());
  const Fit& finish(Fit& rough);
  /// Enough was tried: what follows only brings to an end what was begun.
  bool spent() const { return work_ > options_.most_work * std::max(1.0, problem_.seconds() / 60.0); }
  void find_synonyms(const Screening& screening);
  /// Whether another does exactly the same and stands for it.
  bool left_out(std::size_t candidate) const;
  /// The best extensions of a model, best first, well fitted where they come near the score of a `rival`; only one when
  /// its score is enough.
  std::vector<const Fit*> extend(const Fit& from, std::size_t tries,
                                 double rival = -std::numeric_limits<double>::infinity(),
                                 double enough = std::numeric_limits<double>::infinity());
  /// What the last effect of a model of this size must bring.
  double required(std::size_t size) const;
  void grow();
  void try_pairs();
  void polish();
  void settle();
  void charge_by_road();
  bool grow_once();

  Problem& problem_;
  const Road& road_;
  SearchOptions options_;
  std::map<std::vector<std::size_t>, Fit> fits_;
  std::map<std::vector<std::size_t>, Screening> screenings_;
  std::map<std::size_t, std::vector<std::size_t>> synonyms_;
  std::map<std::vector<std::size_t>, Fit> small_;  // nothing and single effects along the first reference
  bool exhausted_ = false;
  double work_ = 0;
  const Fit* null_model_ = nullptr;
  const Fit* best_ = nullptr;
};

}  // namespace gripline::diagnose
