#include "gripline/diagnose_real.hpp"

#include <iostream>
#include <list>

#include "config/json_file.hpp"
#include "diagnose/real_logs/real_diagnosis.hpp"
#include "diagnose/real_logs/real_files.hpp"
#include "diagnose/real_logs/real_sessions.hpp"
#include "diagnose/real_logs/real_tables.hpp"
#include "experiment/out_folder.hpp"
#include "experiment/result_files.hpp"
#include "gripline/command.hpp"
#include "util/progress.hpp"
#include "util/signals.hpp"
#include "util/whole_file.hpp"

namespace gripline::tools {
namespace {

using diagnose::Diagnosis;
using diagnose::MissingEffects;
using Sessions = std::list<measured::SessionFile>;

/// The search, with its progress on stderr.
MissingEffects search(const LogWorld& world, const measured::LogMap& map, const Registry& registry,
                      const Sessions& files, const Sessions& held_out, const std::filesystem::path& out) {
  diagnose::MissingOptions options;
  options.fit.slowest = calibrate::slowest_start(world.spec);
  options.fit.crawling = world.spec.car.car.v_min;
  const StopSignal stop(StopSignal::Reaction::end, run_broke);
  CallbackProgress progress(std::cerr, "diagnose");
  constexpr std::size_t parts = 100;
  const auto callback = progress.callback();
  options.progress = [&](double share, const std::string& what) {
    callback(static_cast<std::size_t>(share * parts), parts, what);
  };
  MissingEffects found = find_missing(world.tree, world.spec, registry, map, files, held_out, options, out);
  progress.finish();
  return found;
}

void print_real(const Diagnosis& d, const MissingEffects& found, const diagnose::Cornering& corners) {
  std::cout << d.sentence << "\n\nverdict: unknown\n"
            << named_table(found) << calibrated_table(found) << tried_table(found) << sessions_table(found)
            << no_understeer(corners) << "\nerrors 1 s ahead, of time not fitted (95 % by blocks of 10 s)\n";
  calibrate::print_horizon_table(std::cout, found.rows);
}

}  // namespace

int diagnose_real(const RealDiagnosis& asked, const LogWorld& world, const measured::LogMap& map,
                  const Registry& registry) {
  const Car& car = world.spec.car.car;
  auto files = diagnose::read_sessions(asked.logs, map, car),
       held_out = diagnose::read_sessions(asked.held_out, map, car);
  for (const Sessions* const all : {&files, &held_out})
    for (const measured::SessionFile& file : *all) {
      warn_of_findings(file.session.name, file);
      warn_of_inconsistencies(file.session.name, file);
    }
  diagnose::use_once(files, held_out, [](const std::string& line) { std::cerr << line << '\n'; });
  const OutLock lock = open_out_folder(asked.out, "diagnosis", {.force = asked.force});
  const auto delays = diagnose::significant_delays_beyond_map(files, map, car.v_ref);
  const MissingEffects found = search(world, with_found(map, delays), registry, files, held_out, asked.out);
  const diagnose::Cornering corners = cornering_of(files, world.spec, found);
  const Diagnosis d = real_diagnosis(found, delays, corners);
  print_real(d, found, corners);
  write_real_diagnosis(asked.out, d, found, corners);
  std::cout << "\ndiagnosis: " << (asked.out / result_files::diagnosis).string()
            << "\nworld with what was found: " << (asked.out / result_files::augmented_world).string() << '\n';
  write_file(asked.out / result_files::diagnosis_report,
             to_json_text(real_report(d, found, asked.world, registry, files)));
  if (!report_results(asked.out)) return run_broke;
  return is_answer(d, found) ? good : claim_failed;
}

}  // namespace gripline::tools
