#include "sweep/factor_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <ostream>
#include <set>
#include <span>

#include "config/node.hpp"
#include "sweep/sweep.hpp"
#include "util/csv_cell.hpp"
#include "util/csv_writer.hpp"
#include "util/numbers.hpp"
#include "util/resampling.hpp"
#include "util/statistics.hpp"
#include "util/text_table.hpp"

namespace gripline::sweep {
namespace {

constexpr double rounding = 1e-20;  // squared: runs that differ by no more are equal
constexpr std::size_t most_levels = 12, groups_of_numbers = 6, most_best = 10;

bool more_is_better(const std::string& response) {
  static const std::set<std::string> names = {"finished", "named", "right", "closure", "confidence", "round_trip"};
  return names.contains(response) || response.ends_with("_r2");
}

/// A factor as the statistics see it: few levels.
struct Grouping {
  std::vector<std::string> names;
  std::vector<std::uint32_t> group;  // by level of the table
};

/// Levels as they are; many numbers in groups of about as many levels each.
Grouping group_levels(const std::vector<std::string>& levels) {
  Grouping grouping;
  std::vector<std::pair<double, std::uint32_t>> numbers;
  for (std::size_t i = 0; i < levels.size(); ++i)
    if (const auto number = parse_number(levels[i])) numbers.emplace_back(*number, static_cast<std::uint32_t>(i));
  grouping.group.resize(levels.size());
  if (levels.size() <= most_levels || numbers.size() < levels.size()) {
    grouping.names = levels;
    std::iota(grouping.group.begin(), grouping.group.end(), 0U);
    return grouping;
  }
  std::sort(numbers.begin(), numbers.end());
  for (std::size_t g = 0; g < groups_of_numbers; ++g) {
    const std::size_t first = g * numbers.size() / groups_of_numbers,
                      last = (g + 1) * numbers.size() / groups_of_numbers;
    grouping.names.push_back(levels[numbers[first].second] + ".." + levels[numbers[last - 1].second]);
    for (std::size_t i = first; i < last; ++i) grouping.group[numbers[i].second] = static_cast<std::uint32_t>(g);
  }
  return grouping;
}

/// Interval of the median of many values by order statistics: ranks n/2 - 0.98 sqrt(n) and, as far from the other end,
/// 1 + n/2 + 0.98 sqrt(n), counted from 1, by the normal approximation of the binomial.
MedianInterval rank_interval(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  const double half = 0.98 * std::sqrt(n);
  return {order_statistic(values, static_cast<std::size_t>(std::floor(n / 2 - half)) - 1),
          order_statistic(values, static_cast<std::size_t>(std::ceil(n / 2 + half)))};
}

MedianInterval interval_of(const std::vector<double>& values) {
  constexpr std::size_t most_resampled = 200;
  return values.size() <= most_resampled ? bootstrap_median_interval(values) : rank_interval(values);
}

double mean_of(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double squares_about(std::span<const double> values, double mean) {
  double sum = 0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return sum;
}

/// Rows that have the response and count, and what they share.
struct Sample {
  std::vector<std::size_t> rows;
  std::vector<double> values;
  double squares = 0;  // about the mean
  double largest = 0;  // magnitude
};

/// Runs that did the same to the last bit are one draw: only the first counts, but `repeats` asks for all.
Sample sample_of(const Table& table, std::size_t response, bool repeats = false) {
  Sample sample;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const double value = table.counted(response, row);
    if (!std::isfinite(value) || (table.repeats[row] && !repeats)) continue;
    sample.rows.push_back(row);
    sample.values.push_back(value);
    sample.largest = std::max(sample.largest, std::abs(value));
  }
  if (!sample.values.empty()) sample.squares = squares_about(sample.values, mean_of(sample.values));
  return sample;
}

using Cell = std::vector<std::uint32_t>;  // levels of the varying factors

/// A setting's runs of one response.
struct CellRuns {
  std::vector<double> values;
  std::vector<std::uint64_t> seeds, drives;
};

std::map<Cell, CellRuns> cells_of(const Table& table, const std::vector<std::size_t>& varying, const Sample& sample) {
  std::map<Cell, CellRuns> cells;
  Cell cell(varying.size());
  for (std::size_t i = 0; i < sample.rows.size(); ++i) {
    for (std::size_t f = 0; f < varying.size(); ++f) cell[f] = table.level[varying[f]][sample.rows[i]];
    CellRuns& runs = cells[cell];
    runs.values.push_back(sample.values[i]);
    runs.seeds.push_back(table.seed[sample.rows[i]]);
    runs.drives.push_back(table.drive[sample.rows[i]]);
  }
  return cells;
}

/// Variance within cells, and the mean of it over the number of runs: what a cell's mean owes to its seeds.
struct Noise {
  double variance = 0, of_means = 0;
};
Noise noise_of(const std::map<Cell, CellRuns>& cells) {
  double squares = 0, means = 0;
  std::size_t freedom = 0;
  for (const auto& [cell, runs] : cells) {
    squares += squares_about(runs.values, mean_of(runs.values));
    freedom += runs.values.size() - 1;
    means += 1.0 / static_cast<double>(runs.values.size());
  }
  Noise noise;
  noise.variance = freedom > 0 ? squares / static_cast<double>(freedom) : 0.0;
  noise.of_means = noise.variance * means / static_cast<double>(std::max<std::size_t>(cells.size(), 1));
  return noise;
}

double total_share(const std::map<Cell, CellRuns>& cells, std::size_t factor, const Noise& noise, double variance) {
  std::map<Cell, std::vector<double>> lines;  // means of cells that differ in this factor alone
  for (const auto& [cell, runs] : cells) {
    Cell rest = cell;
    rest[factor] = 0;
    lines[rest].push_back(mean_of(runs.values));
  }
  double squares = 0;
  std::size_t freedom = 0;
  for (const auto& [rest, means] : lines) {
    squares += squares_about(means, mean_of(means));
    freedom += means.size() - 1;
  }
  if (freedom == 0) return not_a_number;
  const double within = (squares - static_cast<double>(freedom) * noise.of_means) / static_cast<double>(cells.size());
  return std::clamp(within / variance, 0.0, 1.0);
}

FactorEffect effect_of(const Table& table, std::size_t factor, const Sample& sample) {
  const Grouping grouping = group_levels(table.levels[factor]);
  std::vector<std::vector<double>> values(grouping.names.size());
  for (std::size_t i = 0; i < sample.rows.size(); ++i)
    values[grouping.group[table.level[factor][sample.rows[i]]]].push_back(sample.values[i]);
  FactorEffect effect;
  effect.factor = table.factors[factor];
  double within = 0, low = INFINITY, high = -INFINITY;
  std::size_t groups = 0;
  for (std::size_t g = 0; g < values.size(); ++g) {
    LevelStatistic level{grouping.names[g], values[g].size(), not_a_number, not_a_number, not_a_number, not_a_number};
    if (!values[g].empty()) {
      ++groups;
      level.mean = mean_of(values[g]);
      within += squares_about(values[g], level.mean);
      level.median = median(values[g]);
      const MedianInterval interval = interval_of(values[g]);
      level.lo = interval.lo;
      level.hi = interval.hi;
      low = std::min(low, level.median);
      high = std::max(high, level.median);
    }
    effect.levels.push_back(std::move(level));
  }
  effect.range = groups > 0 ? high - low : not_a_number;
  const std::size_t n = sample.values.size();
  const double within_mean = n > groups ? within / static_cast<double>(n - groups) : 0.0;
  const double between = sample.squares - within - (static_cast<double>(groups) - 1) * within_mean;
  effect.main = groups > 1 ? std::clamp(between / sample.squares, 0.0, 1.0) : 0.0;
  return effect;
}

/// Seed by seed: that the difference to the best setting has no sign. Takes all runs, as a run that repeats another may
/// have a pair that does not; pairs that are equal to the last bit in both settings count once.
double sign_against(const CellRuns& best, const CellRuns& other) {
  std::map<std::uint64_t, std::size_t> by_seed;
  for (std::size_t i = 0; i < best.seeds.size(); ++i) by_seed[best.seeds[i]] = i;
  std::set<std::pair<std::uint64_t, std::uint64_t>> seen;
  std::vector<double> differences;
  for (std::size_t i = 0; i < other.seeds.size(); ++i) {
    const auto same = by_seed.find(other.seeds[i]);
    if (same == by_seed.end()) continue;
    const std::uint64_t mine = other.drives[i], its = best.drives[same->second];
    if (mine != 0 && its != 0 && !seen.emplace(mine, its).second) continue;
    differences.push_back(other.values[i] - best.values[same->second]);
  }
  return sign_test(differences);
}

std::vector<SettingStatistic> best_of(const Table& table, const std::vector<std::size_t>& varying,
                                      const std::map<Cell, CellRuns>& cells, const std::map<Cell, CellRuns>& all,
                                      bool higher_is_better) {
  if (cells.size() < 2) return {};
  std::vector<std::pair<double, const std::pair<const Cell, CellRuns>*>> order;
  for (const auto& cell : cells) {
    const double middle = median(cell.second.values);
    order.emplace_back(higher_is_better ? -middle : middle, &cell);
  }
  const std::size_t count = std::min(order.size(), most_best);
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<SettingStatistic> best;
  for (std::size_t i = 0; i < count; ++i) {
    const auto& [cell, runs] = *order[i].second;
    SettingStatistic one;
    for (std::size_t f = 0; f < varying.size(); ++f) one.levels.push_back(table.levels[varying[f]][cell[f]]);
    one.runs = runs.values.size();
    one.median = median(runs.values);
    const MedianInterval interval = interval_of(runs.values);
    one.lo = interval.lo;
    one.hi = interval.hi;
    one.p = i == 0 ? 1.0 : sign_against(all.at(order[0].second->first), all.at(cell));
    best.push_back(std::move(one));
  }
  return best;
}

double rank_share(const FactorEffect& effect) { return std::isnan(effect.total) ? effect.main : effect.total; }

Node numbers_node(std::initializer_list<std::pair<const char*, double>> numbers) {
  Node node = Node::empty_object();
  for (const auto& [name, value] : numbers) node.set(name, number_or_null(value));
  return node;
}

Node response_node(const ResponseStatistic& response) {
  Node node = numbers_node({{"runs", static_cast<double>(response.runs)}, {"seeds_share", response.seeds}});
  node.set("name", Node(response.name));
  node.set("higher_is_better", Node(response.higher_is_better));
  Node::Array effects, best;
  for (const FactorEffect& effect : response.effects) {
    Node one = numbers_node({{"main", effect.main}, {"total", effect.total}, {"range", effect.range}});
    one.set("factor", Node(effect.factor));
    Node::Array levels;
    for (const LevelStatistic& level : effect.levels) {
      levels.push_back(numbers_node(
          {{"runs", static_cast<double>(level.runs)}, {"median", level.median}, {"lo", level.lo}, {"hi", level.hi}}));
      levels.back().set("level", Node(level.level));
    }
    one.set("levels", Node(std::move(levels)));
    effects.push_back(std::move(one));
  }
  for (const SettingStatistic& setting : response.best) {
    best.push_back(numbers_node({{"runs", static_cast<double>(setting.runs)},
                                 {"median", setting.median},
                                 {"lo", setting.lo},
                                 {"hi", setting.hi},
                                 {"p", setting.p}}));
    best.back().set("levels", texts_node(setting.levels));
  }
  node.set("effects", Node(std::move(effects)));
  node.set("best", Node(std::move(best)));
  return node;
}

/// Lines for parallel coordinates: positions of a run's levels (0..1 along each axis), then the responses' values; some
/// of many runs, evenly taken.
Node lines_node(const Table& table, const std::vector<std::size_t>& varying, const Statistics& statistics) {
  constexpr std::size_t most_lines = 400, most_axes = 6;
  Node::Array lines;
  const std::size_t count = std::min(table.rows(), most_lines);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t row = i * table.rows() / count;
    Node::Array line;
    for (const std::size_t factor : varying) line.emplace_back(static_cast<double>(table.level[factor][row]));
    for (std::size_t r = 0; r < std::min(most_axes, statistics.responses.size()); ++r) {
      const auto found = std::find(table.responses.begin(), table.responses.end(), statistics.responses[r].name);
      line.push_back(number_or_null(table.counted(static_cast<std::size_t>(found - table.responses.begin()), row)));
    }
    lines.emplace_back(std::move(line));
  }
  return Node(std::move(lines));
}

std::vector<std::size_t> varying_factors(const Table& table) {
  std::vector<std::size_t> varying;
  for (std::size_t f = 0; f < table.factors.size(); ++f)
    if (table.levels[f].size() > 1) varying.push_back(f);
  return varying;
}

void write_report_data(const std::filesystem::path& out, const Sweep& sweep, const MergeOutcome& outcome,
                       const Table& table, const Statistics& statistics) {
  Node node = numbers_node({{"runs", static_cast<double>(outcome.runs)},
                            {"finished", static_cast<double>(outcome.finished)},
                            {"broken", static_cast<double>(outcome.broken)},
                            {"missing", static_cast<double>(outcome.missing)}});
  node.set("name", Node(sweep.name));
  node.set("factors", texts_node(statistics.varying));
  Node::Array levels, responses;
  const std::vector<std::size_t> varying = varying_factors(table);
  for (const std::size_t factor : varying) levels.push_back(texts_node(table.levels[factor]));
  node.set("levels", Node(std::move(levels)));
  for (const ResponseStatistic& response : statistics.responses) responses.push_back(response_node(response));
  node.set("responses", Node(std::move(responses)));
  node.set("lines", lines_node(table, varying, statistics));
  write_file(out / "sweep_report.json", to_json_text(node));
}

std::string share_text(double share) { return cell_text(std::isnan(share) ? share : 100 * share, "%.0f %%"); }

}  // namespace

Statistics analyse(const Table& table) {
  Statistics statistics;
  const std::vector<std::size_t> varying = varying_factors(table);
  for (const std::size_t factor : varying) statistics.varying.push_back(table.factors[factor]);
  for (std::size_t r = 0; r < table.responses.size(); ++r) {
    const Sample sample = sample_of(table, r);
    if (sample.values.size() < 2 || !(sample.squares > rounding * sample.largest * sample.largest)) continue;
    ResponseStatistic response;
    response.name = table.responses[r];
    response.higher_is_better = more_is_better(response.name);
    response.runs = sample.values.size();
    const std::map<Cell, CellRuns> cells = cells_of(table, varying, sample);
    const Noise noise = noise_of(cells);
    const double variance = sample.squares / static_cast<double>(sample.values.size());
    response.seeds = std::clamp(noise.variance / variance, 0.0, 1.0);
    for (std::size_t f = 0; f < varying.size(); ++f) {
      response.effects.push_back(effect_of(table, varying[f], sample));
      response.effects.back().total = total_share(cells, f, noise, variance);
    }
    std::stable_sort(response.effects.begin(), response.effects.end(),
                     [](const FactorEffect& a, const FactorEffect& b) { return rank_share(a) > rank_share(b); });
    const std::map<Cell, CellRuns> all = cells_of(table, varying, sample_of(table, r, true));
    response.best = best_of(table, varying, cells, all, response.higher_is_better);
    statistics.responses.push_back(std::move(response));
  }
  return statistics;
}

void write_statistics(const std::filesystem::path& out, const Sweep& sweep, const MergeOutcome& outcome,
                      const Table& table, const Statistics& statistics) {
  std::string factors, sensitivity, best, header = "response,rank";
  CsvWriter levels(factors, "response,factor,level,runs,median,lo,hi,mean");
  CsvWriter ranking(sensitivity, "response,rank,factor,main,total,range,seeds_share,runs");
  for (const std::string& factor : statistics.varying) header += "," + csv_cell(factor);
  CsvWriter settings(best, header + ",runs,median,lo,hi,p_as_good_as_first,higher_is_better");
  for (const ResponseStatistic& response : statistics.responses) {
    int rank = 0;
    for (const FactorEffect& effect : response.effects) {
      ranking << std::string_view(response.name) << ++rank << std::string_view(csv_cell(effect.factor)) << effect.main
              << effect.total << effect.range << response.seeds << static_cast<std::int64_t>(response.runs);
      ranking.end_row();
      for (const LevelStatistic& level : effect.levels) {
        levels << std::string_view(response.name) << std::string_view(csv_cell(effect.factor))
               << std::string_view(csv_cell(level.level)) << static_cast<std::int64_t>(level.runs) << level.median
               << level.lo << level.hi << level.mean;
        levels.end_row();
      }
    }
    rank = 0;
    for (const SettingStatistic& setting : response.best) {
      settings << std::string_view(response.name) << ++rank;
      for (const std::string& level : setting.levels) settings << std::string_view(csv_cell(level));
      settings << static_cast<std::int64_t>(setting.runs) << setting.median << setting.lo << setting.hi << setting.p
               << (response.higher_is_better ? 1 : 0);
      settings.end_row();
    }
  }
  write_file(out / "factors.csv", factors);
  write_file(out / "sensitivity.csv", sensitivity);
  write_file(out / "best.csv", best);
  write_report_data(out, sweep, outcome, table, statistics);
}

void print_statistics(std::ostream& out, const Statistics& statistics) {
  constexpr std::size_t most = 8;
  if (statistics.responses.empty() || statistics.varying.empty()) return;
  std::vector<std::vector<std::string>> rows = {{"variance made by"}};
  for (const std::string& factor : statistics.varying) rows[0].push_back(factor);
  rows[0].emplace_back("seeds");
  for (std::size_t r = 0; r < std::min(most, statistics.responses.size()); ++r) {
    const ResponseStatistic& response = statistics.responses[r];
    std::vector<std::string> row = {response.name};
    for (const std::string& factor : statistics.varying)
      for (const FactorEffect& effect : response.effects)
        if (effect.factor == factor)
          row.push_back(share_text(effect.main) +
                        (std::isnan(effect.total) ? "" : " (" + share_text(effect.total) + ")"));
    row.push_back(share_text(response.seeds));
    rows.push_back(std::move(row));
  }
  print_aligned(out, rows);
  out << "alone, and in brackets with all interactions; all " << statistics.responses.size()
      << " responses: sensitivity.csv, factors.csv, best.csv\n";
}

}  // namespace gripline::sweep
