// Time-optimal laps over a grid of friction, solved once and kept in a cache by the hash of everything they depend on.
#pragma once

#include <vector>

#include "planners/time_optimal/lap_plan.hpp"

namespace gripline::time_optimal {

struct LapMember {
  double mu = 0;
  CarBelief belief;  // that it was solved for, or that no lap was found for since then (AdaptiveLaps)
  LapSolution solution;
  LapPlan plan;
};

struct Progress {
  void (*tell)(void* context, const char* what, double fraction) = nullptr;
  void* context = nullptr;
};

/// Members at the given mus (ascending), all with tyres of the shape and with the resistance of `typical`. Throws
/// std::runtime_error naming the mu where no lap was found. `cache_dir` may be null.
std::vector<LapMember> build_library(const LapSetup& setup, const CarBelief& typical, const std::vector<double>& mus,
                                     const char* cache_dir, const Progress& progress);

struct SolveOutcome {
  bool solved = false;
  double work = 0;  // nodes of the lap times iterations, those of an attempt that failed included
};
/// Solves a member anew for another belief, warm from its last solution; the member stays as it was when that fails.
SolveOutcome solve_again(const LapSetup& setup, const CarBelief& belief, LapMember& member);

}  // namespace gripline::time_optimal
