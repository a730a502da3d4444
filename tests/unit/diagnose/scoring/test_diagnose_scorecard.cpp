// The expected values follow framework/doc/diagnose-cases.md ("Scores"), computed by hand.
#include "diagnose/scoring/scorecard.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <sstream>

#include "support/comma_locale.hpp"
#include "util/numbers.hpp"

namespace gripline::diagnose {
namespace test_diagnose_scorecard {

using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

CaseScore score(const char* kind, const char* condition, const char* verdict, double right, double lambda,
                double confidence) {
  CaseScore s;
  s.kind = kind;
  s.condition = condition;
  s.verdict = verdict;
  s.right = right;
  s.lambda = s.lambda_least = lambda;
  s.confidence = confidence;
  s.closure = s.parameter_error = s.covered = s.located = s.class_size = not_a_number;
  s.error_before = 4;
  s.error_after = 1;
  s.cpu_s = 1;
  return s;
}

/// What is given for a right name only.
CaseScore with_params(CaseScore s, double closure, double parameter_error, double covered) {
  s.closure = closure;
  s.parameter_error = parameter_error;
  s.covered = covered;
  return s;
}

std::vector<CaseScore> thirteen_cases() {
  std::vector<CaseScore> all;
  // One effect, white noise: detectable from lambda 100 on.
  all.push_back(with_params(score("single", "white", "named", 1, 400, 1.0), 0.99, 0.01, 1));
  all.push_back(with_params(score("single", "white", "named", 1, 100, 0.96), 0.95, 0.03, 0.5));
  all.push_back(score("single", "white", "named", 0, 10000, 0.97));
  all.back().closure = 0.5;
  all.push_back(with_params(score("single", "white", "indistinguishable", 0.5, 2500, 0.6), 0.9, 0.04, 0));
  all.back().cpu_s = 9;
  // Weak, and too weak to be in any row but the last.
  all.push_back(score("single", "white", "named", 1, 50, 0.55));
  all.push_back(score("single", "white", "nothing_missing", 0, 20, 1));
  // Two effects, of which the lesser decides whether they are detectable.
  all.push_back(with_params(score("pair", "white", "named", 1, 900, 0.9), 0.98, 0.02, 0.75));
  all.back().lambda_least = 150;
  all.push_back(score("pair", "white", "named", 0, 900, 0.7));
  all.back().lambda_least = 99;
  all.push_back(score("triple", "white", "indistinguishable", 0.5, 300, 0.5));
  // Nothing is missing: lambda has no value.
  all.push_back(score("none", "white", "nothing_missing", 1, not_a_number, 1));
  all.push_back(score("none", "process_noise", "named", 0, not_a_number, 0.85));
  all.back().error_after = 4.5;
  // Outside the catalogue.
  all.push_back(score("unknown", "white", "unknown", 1, not_a_number, 1));
  all.back().located = 1;
  all.push_back(score("unknown", "white", "named", 0, not_a_number, 0.92));
  all.back().located = 0;
  all.back().error_after = 4.05;  // more, but not by 2 %
  return all;
}

/// The rows of a scorecard by the name of their condition, each as words.
std::map<std::string, std::vector<std::string>> rows_of(const std::string& card) {
  std::map<std::string, std::vector<std::string>> rows;
  std::istringstream lines(card);
  for (std::string line; std::getline(lines, line);) {
    if (line.size() < 39 || line.find(" / ") == std::string::npos) continue;
    std::string name = line.substr(0, 38);
    name.erase(name.find_last_not_of(' ') + 1);
    std::istringstream words(line.substr(38));
    for (std::string word; words >> word;)
      if (word != "/") rows[name].push_back(word);
  }
  rows.erase("condition");
  return rows;
}

/// Cases, right, wrong names, closure (median, lowest tenth), error sqrt(lambda) (median), covered, located, CPU time.
TEST(Scorecard, HasARowForEveryConditionThatOccurs) {
  auto rows = rows_of(scorecard(thirteen_cases()));
  EXPECT_THAT(rows["one effect, white noise"],
              ElementsAre("4", "62.5%", "1", "0.9250", "0.6200", "0.300", "0.50", "-", "3.00"));
  EXPECT_THAT(rows["one effect, weak (25..100)"], ElementsAre("1", "100.0%", "0", "-", "-", "-", "-", "-", "1.00"));
  EXPECT_THAT(rows["one effect, white, lambda >= 1000"],
              ElementsAre("2", "25.0%", "1", "0.7000", "0.5400", "2.000", "0.00", "-", "5.00"));
  EXPECT_THAT(rows["two effects, white"],
              ElementsAre("1", "100.0%", "0", "0.9800", "0.9800", "0.600", "0.75", "-", "1.00"));
  EXPECT_THAT(rows["three effects"], ElementsAre("1", "50.0%", "0", "-", "-", "-", "-", "-", "1.00"));
  EXPECT_THAT(rows["nothing missing, white"], ElementsAre("1", "100.0%", "0", "-", "-", "-", "-", "-", "1.00"));
  EXPECT_THAT(rows["nothing missing, process noise"], ElementsAre("1", "0.0%", "1", "-", "-", "-", "-", "-", "1.00"));
  EXPECT_THAT(rows["unknown"], ElementsAre("2", "50.0%", "1", "-", "-", "-", "-", "0.50", "1.00"));
  // 1 + 1 + 0.5 + 1 + 1 + 0.5 + 1 + 1 of thirteen.
  EXPECT_THAT(rows["all"], ElementsAre("13", "53.8%", "4", "0.9500", "0.6600", "0.450", "0.56", "0.50", "1.62"));
  EXPECT_EQ(rows.size(), 9u);
}

TEST(Scorecard, ThreeEffectsCountWhereTheLeastCanBeDetected) {
  std::vector<CaseScore> all(2, score("triple", "white", "named", 1, 900, 0.9));
  all.back().lambda_least = 99;
  EXPECT_EQ(rows_of(scorecard(all))["three effects"].front(), "1");
}

/// Three answers at 0.95 or more, one of them wrong, all of detectable cases; those are four singles, a pair, a triple.
/// Brier: the mean of (confidence - right)^2 over the eight verdicts `named`: 3.2139 / 8. One prediction is worse than
/// the nominal model's by more than 2 %.
TEST(Scorecard, SaysHowFarConfidenceCanBeReliedOn) {
  EXPECT_THAT(scorecard(thirteen_cases()),
              HasSubstr("confidence >= 0.95: 3 answers, right 66.7%; 3 of 6 detectable cases got one; Brier 0.4017; "
                        "worse than nominal 1 of 13\n"));
}

/// Of verdicts `named` only; a bin holds its lower end, the last both.
TEST(Scorecard, SaysHowOftenAnswersAreRightByTheirConfidence) {
  const std::string card = scorecard(thirteen_cases());
  const std::string header = "stated confidence    answers   mean stated   right\n";
  ASSERT_THAT(card, HasSubstr(header));
  EXPECT_EQ(card.substr(card.find(header) + header.size()),
            "0.50 to 0.80               2         0.625    50.0%\n"
            "0.80 to 0.90               1         0.850     0.0%\n"
            "0.90 to 0.95               2         0.910    50.0%\n"
            "0.95 to 1.00               3         0.977    66.7%\n");
}

/// Detectable is lambda_least >= 100, not more than that; an effect that is not is no case of its row.
TEST(Scorecard, CountsDetectableCasesOnly) {
  for (const char* condition :
       {"process_noise", "wrong_nominal", "coloured_noise", "process_time", "thinned", "late"}) {
    const std::vector<CaseScore> two = {score("single", condition, "named", 1, 100, 1),
                                        score("single", condition, "nothing_missing", 0, 99.9, 1)};
    const auto rows = rows_of(scorecard(two));
    ASSERT_EQ(rows.size(), 2u) << condition;
    for (const auto& [name, words] : rows) EXPECT_EQ(words[1], name == "all" ? "50.0%" : "100.0%") << name;
  }
  const std::vector<CaseScore> pair = {score("pair", "process_noise", "named", 1, 99, 1)};
  EXPECT_THAT(scorecard(pair), Not(HasSubstr("two effects")));
}

TEST(Scorecard, OfNoCasesHasNoRows) {
  EXPECT_TRUE(rows_of(scorecard({})).empty());
  EXPECT_THAT(scorecard({}), HasSubstr("confidence >= 0.95: 0 answers"));
}

/// Numbers stand under their names, and what has no value is an empty cell.
TEST(ScoreCsv, HasARowForEveryCase) {
  CaseScore s = with_params(score("single", "white", "named", 1, 400, 0.75), 0.5, 0.25, 1);
  s.id = "007";
  s.vehicle = "rc43";
  s.truth = s.named = "aero_drag";
  std::istringstream lines(score_csv(std::vector<CaseScore>{s}));
  const auto cells = [&] {
    std::vector<std::string> all;
    std::string line, cell;
    std::getline(lines, line);
    for (std::istringstream row(line + ","); std::getline(row, cell, ',');) all.push_back(cell);
    return all;
  };
  const std::vector<std::string> names = cells(), values = cells();
  ASSERT_EQ(names.size(), values.size());
  std::map<std::string, std::string> row;
  for (std::size_t i = 0; i < names.size(); ++i) row[names[i]] = values[i];
  const std::map<std::string, std::string> expected = {{"case", "007"},        {"kind", "single"},
                                                       {"vehicle", "rc43"},    {"condition", "white"},
                                                       {"truth", "aero_drag"}, {"verdict", "named"},
                                                       {"named", "aero_drag"}, {"right", "1"},
                                                       {"lambda", "400"},      {"lambda_least", "400"},
                                                       {"confidence", "0.75"}, {"closure", "0.5"},
                                                       {"covered", "1"},       {"parameter_error", "0.25"},
                                                       {"error_before", "4"},  {"error_after", "1"},
                                                       {"error_true", "0"},    {"located", ""},
                                                       {"class_size", ""},     {"cpu_s", "1"}};
  EXPECT_EQ(row, expected);
}

CaseScore named_case() {
  CaseScore score;
  score.id = "case 1, wet";
  score.kind = "single";
  score.vehicle = "rc43";
  score.condition = "white";
  score.truth = "drag";
  score.verdict = "named";
  score.named = "drag";
  score.right = 1;
  score.lambda = score.lambda_least = 1234.5678;
  score.confidence = 0.96;
  score.closure = 0.75;
  score.parameter_error = 0.0123456789;
  score.covered = 0.5;
  score.error_before = 2.5;
  score.error_after = 1.25;
  score.error_true = 1e-7;
  score.located = not_a_number;
  score.cpu_s = 3.25;
  return score;
}

using DiagnoseScorecardInCommaLocale = testing_support::InCommaLocale;

TEST_F(DiagnoseScorecardInCommaLocale, TableHasPointsAndOneCellForEveryName) {
  const std::vector<CaseScore> scores = {named_case()};
  EXPECT_THAT(score_csv(scores),
              EndsWith("cpu_s\n\"case 1, wet\",single,rc43,white,drag,named,drag,1,1234.57,1234.57,0.96,0.75,0.0123457,"
                       "0.5,2.5,1.25,1e-07,,0,3.25\n"));
}

TEST_F(DiagnoseScorecardInCommaLocale, TextHasPoints) {
  const std::string text = scorecard(std::vector<CaseScore>{named_case()});
  EXPECT_THAT(text, HasSubstr("one effect, white noise                    1  100.0%           0    0.7500 /   0.7500"));
  EXPECT_THAT(text, Not(testing::ContainsRegex("[0-9],[0-9]")));
}

}  // namespace test_diagnose_scorecard
}  // namespace gripline::diagnose
