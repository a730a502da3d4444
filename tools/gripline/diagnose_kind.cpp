// Experiments of kind "diagnose": cars with something hidden, and what is found of it.
#include <iostream>

#include "diagnose/scoring/diagnose_experiment.hpp"
#include "experiment/out_folder.hpp"
#include "experiment/race_tables.hpp"
#include "gripline/command.hpp"
#include "gripline/experiment_kinds.hpp"

namespace gripline::tools {
namespace {

/// What was found in each case, and which claims hold. Returns whether one failed.
bool print_outcome(const diagnose::DiagnoseOutcome& outcome) {
  for (const diagnose::CaseOutcome& c : outcome.cases)
    std::cout << c.name << ": " << diagnose::verdict_names[static_cast<std::size_t>(c.verdict)] << ": " << c.sentence
              << '\n';
  bool failed = false;
  for (const ClaimResult& claim : outcome.claims) {
    failed |= claim.holds == false;
    if (claim.why_skipped.empty())
      std::cout << (claim.holds == true ? "holds  " : "FAILS  ") << claim.text << '\n';
    else
      std::cout << "skipped " << claim.text << ": " << claim.why_skipped << '\n';
  }
  return failed;
}

class HiddenEffects final : public Experiment {
 public:
  HiddenEffects(std::string name, Node tree, const Registry& registry)
      : name_(std::move(name)), tree_(std::move(tree)), registry_(registry) {}
  int run(const ExperimentRequest& request) override {
    refuse_race_options(request);
    const std::filesystem::path& out = request.out;
    const OutLock lock = open_out_folder(out, experiment_identity(tree_), {.force = request.force});
    write_scene(out, name_, "diagnose", tree_);
    CallbackProgress progress(std::cerr, name_);
    const diagnose::DiagnoseOutcome outcome =
        diagnose::run_diagnose_experiment(tree_, registry_, out, request.only, progress.callback());
    progress.finish();
    write_claims(out, outcome.claims);
    bool reported = true;
    for (const diagnose::CaseOutcome& c : outcome.cases) {
      write_scene(out / c.name, c.name + " of " + name_, "diagnosis", Node::empty_object());
      reported = write_case_report(out / c.name) && reported;
    }
    const bool failed = print_outcome(outcome);
    std::cout << "results: " << out.string() << '\n';
    reported = report_results(out) && reported;
    return !reported ? run_broke : failed ? claim_failed : good;
  }

 private:
  std::string name_;
  Node tree_;
  const Registry& registry_;
};

}  // namespace

std::unique_ptr<Experiment> read_diagnose_experiment(const std::filesystem::path& file, Node tree,
                                                     const Registry& registry) {
  diagnose::check_diagnose_experiment(tree, registry);
  return std::make_unique<HiddenEffects>(file.stem().string(), std::move(tree), registry);
}

}  // namespace gripline::tools
