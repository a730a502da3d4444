// The whole chain from logs to a diagnosis: where a world and a log disagree, which effect is missing, how sure that
// is, and how much smaller the gap becomes with it.
#pragma once

#include <optional>
#include <span>

#include "diagnose/inference/channel_delays.hpp"
#include "diagnose/inference/hold_out.hpp"
#include "diagnose/inference/preparation.hpp"
#include "diagnose/result/case_file.hpp"
#include "diagnose/result/diagnosis.hpp"
#include "diagnose/result/prediction_gap.hpp"
#include "measured/log/log_file.hpp"
#include "util/progress.hpp"
#include "world/world_spec.hpp"

namespace gripline::diagnose {

/// Keeps what the files of a result need besides the diagnosis.
class Diagnoser {
 public:
  /// Throws PluginError, and InputError where the car is no vehicle model, its effects have more hidden states than
  /// max_memory, or the case names what there is not. The world and the registry must outlive it.
  Diagnoser(const WorldSpec& world, const Registry& registry, const CaseOptions& options);

  /// Reads nothing but these logs; `held_out` may be empty, then whole laps of the logs are held out.
  Diagnosis run(std::span<const LogFile> logs, std::span<const LogFile> held_out,
                const ProgressCallback& progress = {});

  const Catalogue& catalogue() const { return catalogue_; }
  const Road& road() const { return road_; }
  /// Logs and references as the last run left them.
  const Problem& problem() const { return problem_; }
  /// The nominal model with its stated parameters (nominal_as_stated()).
  Fit nominal(const Diagnosis& d) const { return nominal_as_stated(catalogue_, d.null_model); }
  /// What the last run measured its gap on. There must have been one.
  const HoldOut& hold_out() const { return *hold_out_; }

 private:
  Findings search(std::span<const LogFile> logs, std::span<const LogFile> held_out, bool delays_taken_off,
                  const ProgressCallback& progress);
  /// Whose fit says by what delays are off: effects that stand for a part of a delay hide that, and missing ones feign
  /// it.
  enum class DelaysMovedBy { null_model, model_found };
  Findings search_on_time(std::span<const LogFile> logs, std::span<const LogFile> held_out,
                          std::vector<ChannelDelay>& delays, DelaysMovedBy by, const ProgressCallback& progress);
  bool put_late_place_for_lever(std::vector<ChannelDelay>& delays, std::span<const LogFile> logs, const Fit& found);
  Prepared prepare_logs(std::span<const LogFile> logs) const;
  Problem late_problem(std::span<const LogFile> logs) const;
  Channels stated_noise() const;

  const WorldSpec& world_;
  CaseOptions options_;
  Catalogue catalogue_;
  Road road_;
  Problem problem_;
  std::optional<HoldOut> hold_out_;
};

}  // namespace gripline::diagnose
