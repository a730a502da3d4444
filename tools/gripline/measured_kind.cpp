// Experiments of kind "measured": real cars, fitted on some of their logs' time and judged on the rest.
#include <iostream>

#include "calibrate/measured_kind/measured_experiment.hpp"
#include "experiment/out_folder.hpp"
#include "experiment/race_tables.hpp"
#include "gripline/command.hpp"
#include "gripline/experiment_kinds.hpp"
#include "util/progress.hpp"

namespace gripline::tools {
namespace {

void print(const calibrate::MeasuredSpec& spec, const calibrate::MeasuredOutcome& outcome) {
  std::cout << "errors at " << spec.horizon << " s in blocks that were held out (95 % by blocks of 10 s)\n";
  calibrate::print_horizon_table(std::cout, outcome.rows);
  if (!outcome.ablations.empty())
    std::cout << "\nrise of the error when an effect is taken out and the rest fitted again\n";
  std::vector<calibrate::HorizonRow> rises;
  for (const calibrate::Ablation& a : outcome.ablations) rises.push_back({a.effect, a.change});
  if (!rises.empty()) calibrate::print_horizon_table(std::cout, rises);
}

class RealCar final : public Experiment {
 public:
  RealCar(std::string name, Node tree, const Registry& registry)
      : name_(std::move(name)),
        tree_(std::move(tree)),
        registry_(registry),
        spec_(calibrate::read_measured(tree_, registry)) {}
  int run(const ExperimentRequest& request) override {
    refuse_race_options(request);
    refuse_only(request);
    const std::filesystem::path& out = request.out;
    const OutLock lock = open_out_folder(out, experiment_identity(tree_), {.force = request.force});
    write_scene(out, name_, "measured", tree_);
    CallbackProgress progress(std::cerr, name_);
    const calibrate::MeasuredOutcome outcome = calibrate::run_measured(spec_, registry_, progress.callback());
    progress.finish();
    calibrate::write_measured(out, spec_, outcome);
    write_claims(out, outcome.claims);
    print(spec_, outcome);
    bool failed = false;
    for (const ClaimResult& claim : outcome.claims) {
      failed |= claim.holds == false;
      std::cout << (claim.holds == true ? "holds  " : "FAILS  ") << claim.text << '\n';
    }
    std::cout << "results: " << out.string() << '\n';
    if (!report_results(out)) return run_broke;
    return failed ? claim_failed : good;
  }

 private:
  std::string name_;
  Node tree_;
  const Registry& registry_;
  calibrate::MeasuredSpec spec_;
};

}  // namespace

std::unique_ptr<Experiment> read_measured_experiment(const std::filesystem::path& file, Node tree,
                                                     const Registry& registry) {
  return std::make_unique<RealCar>(file.stem().string(), std::move(tree), registry);
}

}  // namespace gripline::tools
