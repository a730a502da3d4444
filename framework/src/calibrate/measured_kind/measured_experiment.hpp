// Experiments of kind "measured": fit a world on given logs, judge it on blocks of time that were held out, take every
// effect out again.
//
//   { "kind": "measured", "world": "../../worlds/av21.json", "map": "maps/av21.json",
//     "logs": ["a.csv", "b.csv"], "track": {"edges": {"inner": "l.csv", "outer": "r.csv"}},
//     "held_out": {"every": "60 s", "length": "15 s"},      the last 15 s of every 60 s of each log
//     "horizon": "1 s", "every": "0.2 s", "ablate": ["steer_lag"], "claims": ["fitted.position_m <= 0.25"] }
//
// "track", "ablate" (default: every effect of the world) and "claims" may be left out. Claims compare rows
// (persistence, constant speed as constant_speed, kinematic, before, fitted, without_EFFECT) of held-out errors. Of an
// effect that the world has more than once each has its row, without_EFFECT_INDEX by its index in the world's list.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "calibrate/fit/fit.hpp"
#include "experiment/claims.hpp"
#include "plugin/registry.hpp"

namespace gripline::calibrate {

struct MeasuredSpec {
  Node tree;  // the world's, files inlined
  WorldSpec world;
  std::optional<Node> track;          // read when it runs: with the logs it may be elsewhere
  std::vector<std::string> left_out;  // effects of place, where there is no road
  std::filesystem::path map;          // empty: gripline's own columns
  std::vector<std::filesystem::path> logs;
  double held_every = 60, held_length = 15;  // [s]
  double horizon = 1, every = 0.2;           // [s]
  std::vector<std::string> ablate;           // ids, or ID_INDEX of what the world's list has more than once
  std::vector<Claim> claims;
};

/// Reads an experiment; the logs themselves are read when it runs. Throws InputError, PluginError.
MeasuredSpec read_measured(const Node& tree, const Registry& registry);

/// An effect taken out, everything else fitted again.
struct Ablation {
  std::string effect;
  HorizonRow error;                             // held-out
  std::array<HorizonError, quantities> change;  // of the root mean square against the fitted world; paired blocks
};

/// Held-out predictions of the fitted world, for figures.
struct HeldOut {
  std::string log;
  double begin = 0;                      // what the log's own clock shows at its first row [s]
  std::vector<double> start;             // [s] from there
  std::vector<double> predicted, truth;  // starts x 6
};

struct MeasuredOutcome {
  FitResult fit;
  std::vector<HorizonRow> rows;  // held-out errors: baselines, before, fitted
  std::vector<Ablation> ablations;
  std::vector<HeldOut> held_out;
  std::vector<std::pair<std::string, std::vector<measured::Finding>>> health;  // by log
  std::vector<ClaimResult> claims;
  Node fitted;                        // world
  std::shared_ptr<const Track> road;  // null without one
};

MeasuredOutcome run_measured(const MeasuredSpec& spec, const Registry& registry,
                             const std::function<void(std::size_t, std::size_t, const std::string&)>& progress);

/// Writes errors.csv, ablation.csv, parameters.csv, samples.csv, fitted.json and measured.json (for the report).
void write_measured(const std::filesystem::path& folder, const MeasuredSpec& spec, const MeasuredOutcome& outcome);

}  // namespace gripline::calibrate
