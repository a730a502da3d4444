// Experiments that ask how well estimators predict: kinds "offline_validation" and "force_validation".
#include <iostream>

#include "config/errors.hpp"
#include "experiment/force_validation.hpp"
#include "experiment/offline_validation.hpp"
#include "experiment/out_folder.hpp"
#include "gripline/command.hpp"
#include "gripline/experiment_kinds.hpp"
#include "gripline/race_kind.hpp"
#include "util/numbers.hpp"

namespace gripline::tools {
namespace {

int print_and_report(const std::vector<ChannelScore>& scores, const std::filesystem::path& out) {
  for (const ChannelScore& s : scores)
    std::cout << format("%-14s %-12s  R2 %8.4f   rmse %.4g %s   n %zu\n", s.estimator.c_str(), s.channel.c_str(), s.r2,
                        s.rmse, s.unit.c_str(), s.n);
  std::cout << "results: " << out.string() << '\n';
  return report_results(out) ? good : run_broke;
}

/// Of a race's members those that would do nothing here.
void refuse_claims_and_seeds(const RaceSpec& race) {
  Errors errors;
  if (!race.claims.empty())
    errors.add(race.tree.find("claims")->origin,
               "an experiment of kind \"force_validation\" judges no claims; expected none, or null in place of "
               "inherited ones");
  if (race.seeds.size() > 1)
    errors.add(find_pointer(race.tree, "/seeds/count")->origin,
               "an experiment of kind \"force_validation\" drives one seed; expected 1, found " +
                   std::to_string(race.seeds.size()));
  errors.throw_if_any();
}

class OfflineValidation final : public Experiment {
 public:
  OfflineValidation(std::string name, Node tree, const Registry& registry)
      : name_(std::move(name)), tree_(std::move(tree)), registry_(registry) {}
  int run(const ExperimentRequest& request) override {
    refuse_race_options(request);
    refuse_only(request);
    const OutLock lock = open_out_folder(request.out, experiment_identity(tree_), {.force = request.force});
    write_scene(request.out, name_, "offline_validation", tree_);
    CallbackProgress progress(std::cerr, name_);
    const std::vector<ChannelScore> scores = validate_offline(tree_, registry_, request.out, progress.callback());
    progress.finish();
    return print_and_report(scores, request.out);
  }

 private:
  std::string name_;
  Node tree_;
  const Registry& registry_;
};

class ForceValidation final : public Experiment {
 public:
  ForceValidation(RaceSpec race, const Registry& registry) : race_(std::move(race)), registry_(registry) {}
  int run(const ExperimentRequest& request) override {
    refuse_race_options(request);
    const std::vector<std::string> rows = chosen_rows(race_, request.only);
    const OutLock lock = open_out_folder(request.out, experiment_identity(race_.tree), {.force = request.force});
    write_scene(request.out, race_, registry_);
    CallbackProgress progress(std::cerr, race_.name);
    const ForceScores found = validate_forces(race_, rows, request.out, progress.callback());
    progress.finish();
    if (!found.unjudged.empty()) std::cerr << "warning: " << no_lap_to_judge(found) << '\n';
    return print_and_report(found.scores, request.out);
  }

 private:
  RaceSpec race_;
  const Registry& registry_;
};

}  // namespace

std::unique_ptr<Experiment> read_offline_validation(const std::filesystem::path& file, Node tree,
                                                    const Registry& registry) {
  check_offline(tree, registry);
  return std::make_unique<OfflineValidation>(file.stem().string(), std::move(tree), registry);
}

std::unique_ptr<Experiment> read_force_validation(const std::filesystem::path& file, Node tree,
                                                  const Registry& registry) {
  RaceSpec race = read_race(file, std::move(tree), registry);
  refuse_claims_and_seeds(race);
  return std::make_unique<ForceValidation>(std::move(race), registry);
}

}  // namespace gripline::tools
