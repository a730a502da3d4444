// gripline plugins check: every shipped plugin passes, every planted fault is found by the check that is meant for it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <sstream>

#include "support/paths.hpp"
#include "support/program.hpp"

namespace gripline {
namespace test_conformance {

namespace fs = std::filesystem;
using namespace testing_support;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

/// What failed, by plugin: names of checks, and the words of each.
struct Verdicts {
  int code = 0;
  std::map<std::string, std::map<std::string, std::string>> failed;
  std::string text;
  std::set<std::string> names(const std::string& plugin) const {
    std::set<std::string> all;
    if (const auto found = failed.find(plugin); found != failed.end())
      for (const auto& [check, words] : found->second) all.insert(check);
    return all;
  }
};

Verdicts check(const fs::path& library, const std::vector<std::string>& options = {}) {
  std::vector<std::string> words = {"plugins", "check", library};
  words.insert(words.end(), options.begin(), options.end());
  const Outcome outcome = gripline_with(words);
  Verdicts verdicts{outcome.code, {}, outcome.out + outcome.err};
  std::istringstream lines(outcome.out);
  std::string plugin;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("  ")) plugin = line;
    std::istringstream parts(line);
    std::string verdict, check, seconds, unit, why;
    parts >> verdict >> check >> seconds >> unit;
    std::getline(parts >> std::ws, why);
    if (verdict == "FAILED") verdicts.failed[plugin][check] = why;
  }
  return verdicts;
}

/// Libraries of the project, each with the checks that it is known not to pass, and why.
class Shipped : public testing::TestWithParam<std::string> {};

const std::map<std::string, std::set<std::string>> known = {
    {"controller mpc_ipopt", {"allocation"}}  // Ipopt allocates in every solve
};

std::vector<std::string> shipped_libraries() {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& file : fs::directory_iterator(plugin_dir(), ignored))
    if (file.path().extension() == ".so") names.push_back(file.path().stem());
  std::ranges::sort(names);
  return names;
}

TEST_P(Shipped, Passes) {
  const Verdicts verdicts = check(plugin_dir() / (GetParam() + ".so"));
  for (const auto& [plugin, failed] : verdicts.failed) {
    const auto allowed = known.find(plugin);
    EXPECT_TRUE(allowed != known.end() && verdicts.names(plugin) == allowed->second) << verdicts.text;
  }
  EXPECT_EQ(verdicts.code, verdicts.failed.empty() ? 0 : 1) << verdicts.text;
  EXPECT_THAT(verdicts.text, HasSubstr(" checks passed"));
}

INSTANTIATE_TEST_SUITE_P(Plugins, Shipped, testing::ValuesIn(shipped_libraries()),
                         [](const auto& info) { return info.param; });

TEST(Conformance, FindsEveryPlantedFault) {
  const std::map<std::string, std::pair<std::string, std::string>> planted = {
      {"effect broken.value_in_act", {"derivatives", "d ax / d vx is "}},
      {"effect broken.divides_by_zero", {"finite", "an answer at the edges"}},
      {"vehicle broken.forgets_loads", {"finite", "an answer on an ordinary step is"}},
      {"effect broken.first_point_for_all", {"batch", "among 17 points"}},
      {"effect broken.scratch", {"threads", "four threads"}},
      {"estimator broken.wrong_sign", {"learns", "worse"}},
      {"estimator broken.allocates", {"allocation", "1 allocations a step"}},
      {"estimator broken.leaks", {"growth", "bytes a step"}},
      {"estimator broken.shared", {"isolated", "no static"}},
      {"estimator broken.clock", {"deterministic", "context.seed"}},
      {"estimator broken.peeks", {"truth", "needs_truth"}},
      {"controller broken.unbounded", {"bounds", "beyond the car's limits"}},
      {"controller broken.dies_at_the_end", {"parameters", "gain = 10"}},
      {"planner broken.waits_for_ever", {"finite", "on an ordinary step is inf"}}};
  const Verdicts verdicts = check(fixture_plugins("contracts") / "contracts.so");
  EXPECT_EQ(verdicts.code, 1);
  for (const auto& [plugin, fault] : planted) {
    ASSERT_THAT(verdicts.names(plugin), Contains(fault.first)) << verdicts.text;
    EXPECT_THAT(verdicts.failed.at(plugin).at(fault.first), HasSubstr(fault.second)) << plugin;
  }
}

TEST(Conformance, AUnitThatIsNoneIsFound) {
  const Verdicts verdicts = check(fixture_plugins("odd_unit") / "odd_unit.so");
  EXPECT_EQ(verdicts.code, 3) << verdicts.text;
  EXPECT_THAT(verdicts.text, HasSubstr("with an invalid unit"));
}

TEST(Conformance, SlowOpeningIsFound) {
  const Verdicts verdicts = check(fixture_plugins("slow_to_load") / "slow_to_load.so", {"--only", "loads"});
  EXPECT_EQ(verdicts.code, 3) << verdicts.text;
  EXPECT_THAT(verdicts.text, HasSubstr("no work before the first instance is made"));
}

TEST(Conformance, WhatIsNoPluginIsRefused) {
  const Verdicts other = check(fixture_plugins("other_abi") / "other_abi.so");
  EXPECT_EQ(other.code, 3) << other.text;
  EXPECT_THAT(other.text, HasSubstr("rebuild the plugin"));
  const Verdicts absent = check("nowhere.so");
  EXPECT_EQ(absent.code, 2);
  EXPECT_THAT(absent.text, HasSubstr("no such library"));
  EXPECT_THAT(check(plugin_dir() / "none.so", {"--only", "finit"}).text, HasSubstr("did you mean \"finite\"?"));
}

TEST(Conformance, OneCheckAlone) {
  const Verdicts one = check(plugin_dir() / "none.so", {"--only", "finite"});
  EXPECT_EQ(one.code, 0) << one.text;
  EXPECT_THAT(one.text, HasSubstr("2 of 2 checks passed"));
  const std::string listed = gripline_with({"plugins", "check", "--list"}).out;
  for (const char* name : {"loads", "manifest", "derivatives", "threads", "growth"})
    EXPECT_THAT(listed, HasSubstr(name));
}

}  // namespace test_conformance
}  // namespace gripline
