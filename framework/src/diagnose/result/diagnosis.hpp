// The whole chain: where a world and a log disagree, which effect is missing, how sure that is, and how much smaller
// the gap gets with it. The contract of its result: framework/doc/diagnose.md.
#pragma once

#include <map>
#include <optional>

#include "diagnose/inference/adequacy.hpp"
#include "diagnose/inference/hold_out.hpp"
#include "measured/log_file.hpp"
#include "util/progress.hpp"
#include "world/world_spec.hpp"

namespace gripline::diagnose {

class Search;

/// What a case may bring besides the log.
struct CaseOptions {
  std::vector<std::string> exclude;           // effects that must not be named
  std::map<std::string, double> uncertainty;  // nominal parameter -> relative standard deviation; "Cr0_over_m" in m/s2
  std::optional<Channels> noise_sigma;        // of the sensors, where stated
};

struct NamedEffect {
  struct Value {
    std::string name, unit;
    double value = 0, low = 0, high = 0;
  };
  std::string effect;
  std::vector<Value> params;
  double confidence = 0;
};

struct Ranked {
  std::string effect;
  double gain = 0, held_out = 0, selected_fraction = 0;
};

/// The smallest size of an effect that would have been seen.
struct Floor {
  std::string effect, param, unit;
  double size = 0;
};

enum class Verdict { named, nothing_missing, indistinguishable, unknown };
inline constexpr std::array<const char*, 4> verdict_names = {"named", "nothing_missing", "indistinguishable",
                                                             "unknown"};

struct Diagnosis {
  Verdict verdict = Verdict::nothing_missing;
  std::vector<NamedEffect> named;
  std::vector<std::vector<std::string>> equivalent;
  std::optional<BasisTest> unknown;
  std::vector<std::pair<std::string, double>> nominal_fit;
  struct Gap {
    double horizon = 1, before = 0, after = 0, closure = 0;
  } gap;
  std::vector<Ranked> ranking;
  std::string manoeuvre;  // empty: none
  std::vector<Floor> floors;
  std::vector<Health> health;
  std::vector<BasisTest> tests;
  std::string sentence;
  // For files and pictures.
  Fit fit;      // the model returned
  Fit nothing;  // the nominal model, nuisances refitted
  Channels sensor{};
  struct Horizon {
    double seconds = 0, before = 0, after = 0;
  };
  std::vector<Horizon> horizons;
};

/// Everything prepared and kept for the result's files.
class Diagnoser {
 public:
  /// Throws PluginError and InputError. The world and the registry must outlive it.
  Diagnoser(const WorldSpec& world, const Registry& registry, const CaseOptions& options);

  /// Reads nothing but these logs; `held_out` may be empty, then whole laps of the logs are held out.
  Diagnosis run(std::span<const LogFile> logs, std::span<const LogFile> held_out, const ProgressCallback& tell = {});

  const Catalogue& catalogue() const { return catalogue_; }
  const Road& road() const { return road_; }
  const Problem& problem() const { return problem_; }

 private:
  void prepare(std::span<const LogFile> logs, Diagnosis& d);
  void decide(Search& search, const HoldOut& hold_out, Diagnosis& d);
  bool may_be_nothing(const Fit& fitted, std::size_t which) const;
  bool place_may_be_time(const ModelSpec& model, std::size_t member) const;
  std::vector<const Fit*> equals_of(const Fit& found, std::span<const Fit* const> rivals, const Fit& nothing,
                                    const HoldOut& hold_out) const;
  bool helps(const Fit& with, const Fit& without, const HoldOut& hold_out) const;
  void drop_idle(Search& search, const HoldOut& hold_out, Diagnosis& d);
  void strip_unsupported(Search& search, Diagnosis& d, Where where);
  void rank(Search& search, const std::map<std::size_t, double>& wins, Diagnosis& d) const;
  void measure_gap(const HoldOut& hold_out, Search& search, Diagnosis& d);
  void describe(const Fit& fitted, Diagnosis& d) const;
  void take_back(const Search& search, Diagnosis& d) const;
  void find_floors(Search& search, Diagnosis& d) const;

  const WorldSpec& world_;
  CaseOptions options_;
  Catalogue catalogue_;
  Road road_;
  Problem problem_;
};

}  // namespace gripline::diagnose
