// What the table of a sweep says of its factors: statistics by level,
// how much of the variance each factor makes, the best settings.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "sweep/merge.hpp"

namespace gripline::sweep {

/// A response over the runs of one level.
struct LevelStatistic {
  std::string level;  // or "lo..hi" where a factor has many numbers: six groups of about as many runs each
  std::size_t runs = 0;
  double median = 0, lo = 0, hi = 0;  // 95 % interval: bootstrap up to 200 runs, order statistics beyond
  double mean = 0;
};

/// What a factor does to a response. `main` is the share of the runs' variance that its levels explain alone: epsilon
/// squared, (SS_between - (k - 1) MS_within) / SS_total (Kelley, PNAS 21, 1935). `total` is the share that is left
/// between runs which differ in it alone, interactions included (Homma, Saltelli, Reliability Engineering and System
/// Safety 52, 1996); NaN where no two settings differ in it alone, as in a latin hypercube.
struct FactorEffect {
  std::string factor;
  double main = 0, total = 0;
  double range = 0;  // largest median of a level minus the smallest
  std::vector<LevelStatistic> levels;
};

/// A setting (all factors but the seed) over its seeds.
struct SettingStatistic {
  std::vector<std::string> levels;  // of all factors that vary
  std::size_t runs = 0;
  double median = 0, lo = 0, hi = 0;  // bootstrap interval of 95 %
  double p = 1;                       // sign test, seed by seed, that it is as good as the first; 1 for the first
};

struct ResponseStatistic {
  std::string name;
  bool higher_is_better = false;
  std::size_t runs = 0;
  double seeds = 0;                    // share of the variance between seeds of one setting
  std::vector<FactorEffect> effects;   // by falling share: total where there is one, else main
  std::vector<SettingStatistic> best;  // the best first, at most ten; of a sweep with one setting none
};

struct Statistics {
  std::vector<std::string> varying;          // factors with more than one level, as in SettingStatistic::levels
  std::vector<ResponseStatistic> responses;  // that differ between runs
};

/// Runs of one experiment, setting and row that are equal to the last bit count once, as they are no independent draws.
/// Runs that broke count in `finished` alone.
Statistics analyse(const Table& table);

/// OUT/factors.csv, OUT/sensitivity.csv, OUT/best.csv, and OUT/sweep_report.json for the report. Throws
/// std::runtime_error when the disk refuses.
void write_statistics(const std::filesystem::path& out, const Sweep& sweep, const MergeOutcome& outcome,
                      const Table& table, const Statistics& statistics);
/// The sensitivity ranking and the best settings as people read them; of many responses the first eight.
void print_statistics(std::ostream& out, const Statistics& statistics);

}  // namespace gripline::sweep
