#include "diagnose/scoring/scorecard.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "util/csv_cell.hpp"
#include "util/csv_writer.hpp"
#include "util/numbers.hpp"
#include "util/statistics.hpp"

namespace gripline::diagnose {
namespace {

/// A row of the scorecard: the cases that satisfy a condition.
struct Condition {
  const char* name;
  std::function<bool(const CaseScore&)> holds;
};

bool detectable(const CaseScore& s) { return s.lambda_least >= 100.0; }

bool is(const CaseScore& s, const char* kind, const char* condition) {
  return s.kind == kind && s.condition == condition;
}

const std::vector<Condition>& conditions() {
  static const std::vector<Condition> all = {
      {"one effect, white noise", [](const CaseScore& s) { return is(s, "single", "white") && detectable(s); }},
      {"one effect, weak (25..100)",
       [](const CaseScore& s) { return is(s, "single", "white") && s.lambda >= 25.0 && s.lambda < 100.0; }},
      {"one effect, process noise",
       [](const CaseScore& s) { return is(s, "single", "process_noise") && detectable(s); }},
      {"one effect, wrong nominal",
       [](const CaseScore& s) { return is(s, "single", "wrong_nominal") && detectable(s); }},
      {"one effect, white, lambda >= 1000",
       [](const CaseScore& s) { return is(s, "single", "white") && s.lambda >= 1000.0; }},
      {"two effects, white", [](const CaseScore& s) { return is(s, "pair", "white") && detectable(s); }},
      {"two effects, process noise",
       [](const CaseScore& s) { return is(s, "pair", "process_noise") && detectable(s); }},
      {"three effects", [](const CaseScore& s) { return s.kind == "triple" && detectable(s); }},
      {"one effect, coloured sensor noise",
       [](const CaseScore& s) { return is(s, "single", "coloured_noise") && detectable(s); }},
      {"one effect, process noise, other time",
       [](const CaseScore& s) { return is(s, "single", "process_time") && detectable(s); }},
      {"one effect, samples left out", [](const CaseScore& s) { return is(s, "single", "thinned") && detectable(s); }},
      {"one effect, late channels", [](const CaseScore& s) { return is(s, "single", "late") && detectable(s); }},
      {"nothing missing, late channels", [](const CaseScore& s) { return is(s, "none", "late"); }},
      {"nothing missing, coloured sensors", [](const CaseScore& s) { return is(s, "none", "coloured_noise"); }},
      {"nothing missing, other time", [](const CaseScore& s) { return is(s, "none", "process_time"); }},
      {"nothing missing, samples left out", [](const CaseScore& s) { return is(s, "none", "thinned"); }},
      {"nothing missing, white", [](const CaseScore& s) { return is(s, "none", "white"); }},
      {"nothing missing, process noise", [](const CaseScore& s) { return is(s, "none", "process_noise"); }},
      {"nothing missing, wrong nominal", [](const CaseScore& s) { return is(s, "none", "wrong_nominal"); }},
      {"unknown", [](const CaseScore& s) { return !std::isnan(s.located); }},
      {"all", [](const CaseScore&) { return true; }},
  };
  return all;
}

double mean(const std::vector<double>& v) {
  double sum = 0.0;
  for (const double x : v) sum += x;
  return v.empty() ? not_a_number : sum / static_cast<double>(v.size());
}

std::string shown(double v, const char* pattern) { return std::isnan(v) ? "-" : format(pattern, v); }

/// Empty when the condition holds for no case.
std::string row_text(const Condition& condition, std::span<const CaseScore> scores) {
  std::vector<double> right, closure, scaled, covered, located, cpu;
  std::size_t wrong = 0;
  for (const CaseScore& s : scores) {
    if (!condition.holds(s)) continue;
    right.push_back(s.right);
    cpu.push_back(s.cpu_s);
    wrong += s.right == 0.0 && s.verdict == "named";
    if (!std::isnan(s.closure)) closure.push_back(s.closure);
    if (!std::isnan(s.parameter_error)) scaled.push_back(s.parameter_error * std::sqrt(std::max(0.0, s.lambda)));
    if (!std::isnan(s.covered)) covered.push_back(s.covered);
    if (!std::isnan(s.located)) located.push_back(s.located);
  }
  if (right.empty()) return {};
  return format("%-38s %5zu  %5.1f%%  %10zu  %8s / %8s     %8s            %5s    %5s   %5.2f\n", condition.name,
                right.size(), 100.0 * mean(right), wrong, shown(linear_quantile(closure, 0.5), "%.4f").c_str(),
                shown(linear_quantile(closure, 0.1), "%.4f").c_str(),
                shown(linear_quantile(scaled, 0.5), "%.3f").c_str(), shown(mean(covered), "%.2f").c_str(),
                shown(mean(located), "%.2f").c_str(), mean(cpu));
}

/// How far stated confidences can be relied on.
std::string confidence_text(std::span<const CaseScore> scores) {
  double sure = 0, sure_right = 0, sure_detectable = 0, all = 0, worse = 0, brier = 0, judged = 0;
  const auto to_be_named = [](const CaseScore& s) {
    return s.kind != "none" && std::isnan(s.located) && detectable(s);
  };
  for (const CaseScore& s : scores) {
    all += to_be_named(s);
    if (s.error_after > 1.02 * s.error_before) worse += 1;
    if (s.verdict != "named") continue;
    judged += 1;
    brier += std::pow(s.confidence - s.right, 2);
    if (s.confidence < 0.95) continue;
    sure += 1;
    sure_right += s.right;
    sure_detectable += to_be_named(s);
  }
  return format(
      "confidence >= 0.95: %.0f answers, right %.1f%%; %.0f of %.0f detectable cases got one; Brier %.4f; worse than "
      "nominal %.0f of %zu\n",
      sure, sure > 0 ? 100.0 * sure_right / sure : 0.0, sure_detectable, all, judged > 0 ? brier / judged : 0.0, worse,
      scores.size());
}

/// How often answers are right, by the confidence they are stated with.
std::string calibration_text(std::span<const CaseScore> scores) {
  constexpr std::array<double, 6> ends = {0.0, 0.5, 0.8, 0.9, 0.95, 1.0};
  std::string text = "stated confidence    answers   mean stated   right\n";
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    std::vector<double> stated, right;
    for (const CaseScore& s : scores) {
      if (s.verdict != "named" || s.confidence < ends[i]) continue;
      if (s.confidence >= ends[i + 1] && i + 2 < ends.size()) continue;
      stated.push_back(s.confidence);
      right.push_back(s.right);
    }
    if (stated.empty()) continue;
    text += format("%.2f to %.2f         %7zu       %7.3f   %5.1f%%\n", ends[i], ends[i + 1], stated.size(),
                   mean(stated), 100.0 * mean(right));
  }
  return text;
}

}  // namespace

std::string score_csv(std::span<const CaseScore> scores) {
  std::string text;
  CsvWriter csv(text,
                "case,kind,vehicle,condition,truth,verdict,named,right,lambda,lambda_least,confidence,closure,"
                "parameter_error,covered,error_before,error_after,error_true,located,class_size,cpu_s");
  for (const CaseScore& s : scores) {
    for (const std::string& words : {s.id, s.kind, s.vehicle, s.condition, s.truth, s.verdict, s.named})
      csv << csv_cell(words);
    for (const double value : {s.right, s.lambda, s.lambda_least, s.confidence, s.closure, s.parameter_error, s.covered,
                               s.error_before, s.error_after, s.error_true, s.located, s.class_size, s.cpu_s})
      csv << (std::isnan(value) ? "" : significant(value, 6));
    csv.end_row();
  }
  return text;
}

std::string scorecard(std::span<const CaseScore> scores) {
  std::string text =
      "condition                              cases  right   wrong name  closure median / tenth   error*sqrt(lambda)  "
      "covered  "
      "located  cpu s\n";
  for (const Condition& condition : conditions()) text += row_text(condition, scores);
  text += confidence_text(scores);
  return text + calibration_text(scores);
}

}  // namespace gripline::diagnose
