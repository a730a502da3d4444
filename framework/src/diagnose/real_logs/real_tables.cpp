#include "diagnose/real_logs/real_tables.hpp"

#include <algorithm>
#include <filesystem>
#include <span>

#include "calibrate/effects/effect_trial.hpp"
#include "calibrate/fit/handling.hpp"
#include "diagnose/real_logs/real_diagnosis.hpp"
#include "util/numbers.hpp"

namespace gripline::diagnose {
namespace {

/// A name of any length: figures follow it, at the least so many characters on.
std::string padded(std::string name, std::size_t width) {
  if (name.size() < width) name.resize(width, ' ');
  return name;
}

std::string percents(const char* pattern, const calibrate::ForecastChange& c) {
  return format(pattern, 100.0 * c.change, 100.0 * c.low, 100.0 * c.high);
}

/// Why there is no table of effects that were fitted alone.
std::string none_tried(std::span<const ScoredEffect> ranking) {
  const std::string none = "\nno effect was fitted alone: ";
  if (ranking.empty()) return none + "there is none that the world lacks and these logs could show\n";
  const ScoredEffect& best = *std::ranges::max_element(ranking, {}, &ScoredEffect::less_error);
  return none + "to first order none of " + std::to_string(ranking.size()) +
         " takes enough off the squared error, and the log's blocks of time agree on none (the most: " + best.effect +
         format(", %.2g %%)\n", 100.0 * best.less_error);
}

}  // namespace

std::string named_table(const MissingEffects& found) {
  if (found.named.empty()) return {};
  std::string table = "\nmissing             predictions of time not fitted, beside the others\n";
  for (const MissingEffect& n : found.named) {
    table += padded(n.addition.name, 18) + percents(" %+7.1f %% (%+.1f to %+.1f)", n.change);
    for (const auto& v : n.params) table += "   " + v.text(4, true);
    table += '\n';
  }
  return table;
}

std::string calibrated_table(const MissingEffects& found) {
  std::string rows;
  for (const calibrate::FittedParameter& p : found.own_parameters())
    rows += padded(p.unknown.pointer, 45) +
            format(" %10.4g %10.4g   %.4g to %.4g\n", p.unknown.prior, p.value, p.interval.low, p.interval.high);
  return rows.empty() ? rows : "\ncalibrated                                         start      found   95 %\n" + rows;
}

std::string tried_table(const MissingEffects& found) {
  std::vector<ScoredEffect> tried;
  std::ranges::copy_if(found.ranking, std::back_inserter(tried), &ScoredEffect::tried);
  if (tried.empty()) return none_tried(found.ranking);
  std::string table = "\nalone               squared error, fitted   predictions of the same logs' time not fitted\n";
  std::ranges::stable_sort(tried, std::greater<>(), &ScoredEffect::less_error);
  for (const ScoredEffect& r : tried)
    table += padded(r.effect, 18) + format(" %+18.1f %%", -100.0 * r.less_error) +
             percents("   %+7.1f %% (%+.1f to %+.1f): ", r.change) + std::string(error_change(r.change).in_words()) +
             '\n';
  return table;
}

std::string sessions_table(const MissingEffects& found) {
  if (found.named.empty()) return {};
  std::string table = "\nlog                              calibrated  with effects   change, of time not fitted\n";
  for (const SessionChange& one : found.sessions)
    table += padded(std::filesystem::path(one.log).filename().string(), 32) +
             format(" %10.3f %13.3f", one.calibrated, one.found) +
             percents("   %+.1f %% (%+.1f to %+.1f)\n", one.change);
  return table;
}

std::string no_understeer(const Cornering& corners) {
  return corners.why_not.empty() ? "" : "\n" + calibrate::no_understeer_text(corners.why_not) + "\n";
}

}  // namespace gripline::diagnose
