#include "config/reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "config/json_file.hpp"
#include "config/merge_patch.hpp"
#include "support/paths.hpp"

namespace gripline {
namespace test_config_reader {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

enum class Hold { zoh, foh, rate };

/// Reads a small world with one value of every kind: what the fixtures under bad_json break.
void read_sample(const Node& node, Errors& errors) {
  ObjectReader world(node, errors);
  world.number("dt", "s", NumberRange::at_most(1.0), 0.02);
  world.integer("laps", {1, 100}, 1);
  world.boolean("clean", false);
  world.text("name", "");
  world.choice<Hold>("input_hold", {{"zoh", Hold::zoh}, {"foh", Hold::foh}, {"rate", Hold::rate}}, Hold::zoh);
  const std::vector<std::string> controllers{"mpc_ipopt", "mpc_sqp", "pure_pursuit", "stanley", "lqr", "pid", "none"};
  world.choice("controller", controllers, "none");
  if (world.has("track")) world.input_file("track");
  if (world.has("weights")) world.numbers("weights", "1", {}, 3);
  for (const Node& one : world.array("friction", false)) {
    ObjectReader point(one, errors);
    point.number("t", "s", NumberRange::non_negative());
    point.number("factor", "1", NumberRange::positive());
    point.finish();
  }
  if (world.find("plant") != nullptr) {
    ObjectReader plant = world.object("plant");
    plant.text("plugin");
    ObjectReader params = plant.object("params");
    params.number("mass", "kg", NumberRange::positive());
    params.number("steer", "rad", {}, 0.0);
    params.number("ratio", "1", NumberRange::closed(0, 1), 0.5);
    params.number("damping", "N s/m", {}, 0.0);
  }
  world.finish();
}

std::string message_of(const fs::path& file) {
  try {
    const Node node = load_json(file);
    Errors errors;
    read_sample(node, errors);
    errors.throw_if_any();
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::string contents(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<std::string> messages(const std::string& json, void (*read)(const Node&, Errors&) = read_sample) {
  const Node node = parse_text(json, "t");
  Errors errors;
  read(node, errors);
  std::vector<std::string> result;
  for (const Diagnostic& one : errors.sorted()) result.push_back(one.text());
  return result;
}

/// Each fixture names what is wrong with it; beside it stands the message, every byte of it.
class BadJson : public testing::TestWithParam<std::string> {};

TEST_P(BadJson, IsRefusedWithItsMessage) {
  const fs::path before = fs::current_path();
  fs::current_path(testing_support::fixture_dir() / "bad_json");
  const std::string message = message_of(GetParam() + ".json");
  const std::string expected = contents(GetParam() + ".expected");
  fs::current_path(before);
  EXPECT_EQ(message + '\n', expected);
}

std::vector<std::string> fixtures() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(testing_support::fixture_dir() / "bad_json")) {
    if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

INSTANTIATE_TEST_SUITE_P(fixtures, BadJson, testing::ValuesIn(fixtures()), [](const auto& one) { return one.param; });

TEST(BadJsonFolder, EveryMessageHasItsFixture) {
  const fs::path folder = testing_support::fixture_dir() / "bad_json";
  EXPECT_GT(fixtures().size(), 100U);
  for (const auto& entry : fs::directory_iterator(folder)) {
    const fs::path partner = fs::path(entry.path()).replace_extension(".json");
    EXPECT_TRUE(fs::exists(partner)) << entry.path();
  }
}

TEST(ObjectReader, ReadsEveryKind) {
  const Node node = parse_text(R"({ "note": ["any", "words"], "dt": "20 ms", "v": "5 km/h", "n": 4, "b": true,
      "text": "abc", "hold": "foh", "q": [1, "50 %", 2.5], "list": [{}, {}], "inner": { "note": "here too", "a": 1 } })");
  Errors errors;
  ObjectReader r(node, errors);
  EXPECT_EQ(r.number("dt", "s"), 0.02);
  EXPECT_DOUBLE_EQ(r.number("v", "m/s"), 5.0 / 3.6);
  EXPECT_EQ(r.integer("n"), 4);
  EXPECT_TRUE(r.boolean("b"));
  EXPECT_EQ(r.text("text"), "abc");
  EXPECT_EQ((r.choice<Hold>("hold", {{"zoh", Hold::zoh}, {"foh", Hold::foh}})), Hold::foh);
  EXPECT_THAT(r.numbers("q", "1"), ElementsAre(1.0, 0.5, 2.5));
  EXPECT_EQ(r.array("list").size(), 2U);
  ObjectReader inner = r.object("inner");
  EXPECT_EQ(inner.integer("a"), 1);
  inner.finish();
  r.finish();
  EXPECT_TRUE(errors.empty()) << errors.sorted().front().text();
}

TEST(ObjectReader, FallbacksApplyOnlyToAbsentAndNullMembers) {
  const Node node = parse_text(R"({ "a": 1, "b": null })");
  Errors errors;
  ObjectReader r(node, errors);
  EXPECT_EQ(r.number("a", "1", {}, 7.0), 1.0);
  EXPECT_EQ(r.number("b", "1", {}, 7.0), 7.0);
  EXPECT_EQ(r.integer("c", {1, 9}, 7), 7);
  EXPECT_EQ(r.text("d", "x"), "x");
  EXPECT_TRUE(r.boolean("e", true));
  EXPECT_EQ(r.optional_number("f", "s"), std::nullopt);
  EXPECT_EQ(r.optional_number("a", "1"), 1.0);
  EXPECT_TRUE(r.has("a"));
  EXPECT_FALSE(r.has("b"));
  EXPECT_TRUE(r.array("g", false).empty());
  r.finish();
  EXPECT_TRUE(errors.empty());
}

TEST(ObjectReader, AfterAnErrorGivesValuesInsideTheRange) {
  const Node node = parse_text(R"({ "a": -1, "b": "x", "c": 0, "d": 0 })");
  Errors errors;
  ObjectReader r(node, errors);
  const NumberRange positive = NumberRange::positive();
  EXPECT_TRUE(positive.contains(r.number("a", "s", positive)));
  const NumberRange between = {2, 3, true, true};
  EXPECT_TRUE(between.contains(r.number("b", "1", between)));
  EXPECT_EQ(r.integer("c", {3, 9}), 3);
  const NumberRange below = {-std::numeric_limits<double>::infinity(), -2, false, true};
  EXPECT_TRUE(below.contains(r.number("d", "1", below)));
  EXPECT_EQ(errors.size(), 4U);
}

TEST(ObjectReader, AMissingObjectIsOneError) {
  const auto read = [](const Node& node, Errors& errors) {
    ObjectReader r(node, errors);
    ObjectReader plant = r.object("plant");
    plant.text("plugin");
    plant.object("params").number("mass", "kg");
  };
  EXPECT_THAT(messages("{}", read), ElementsAre("t:1:1: /plant: missing, expected an object"));
  EXPECT_THAT(messages(R"({ "plant": 3 })", read), ElementsAre("t:1:12: /plant: expected an object, found 3"));
}

TEST(ObjectReader, AnObjectNobodyFinishesIsFinishedAtItsEnd) {
  const auto read = [](const Node& node, Errors& errors) { ObjectReader(node, errors).integer("a"); };
  EXPECT_THAT(messages(R"({ "a": 1, "b": 2 })", read), ElementsAre("t:1:11: /b: unknown key \"b\"; known: a"));
}

TEST(ObjectReader, MembersAreTheNamesTheUserChose) {
  const Node node = parse_text(R"({ "note": "rows", "elm": {}, "gp": null, "none": {} })");
  Errors errors;
  ObjectReader r(node, errors);
  std::vector<std::string> names;
  for (const Member* one : r.members()) names.push_back(one->key);
  r.finish();
  EXPECT_THAT(names, ElementsAre("elm", "none"));
  EXPECT_TRUE(errors.empty());
}

TEST(ObjectReader, PathsStartAtTheFolderOfTheFileThatHoldsThem) {
  const Node base = parse_text(R"({ "a": "tracks/x.csv", "b": "../y.csv", "c": "/abs/z.csv" })", "w", "worlds/ethz");
  const Node merged = merge(base, parse_text(R"({ "a": "mine.csv" })", "e", "experiments"));
  Errors errors;
  ObjectReader r(merged, errors);
  EXPECT_EQ(r.path("a"), fs::path("experiments/mine.csv"));
  EXPECT_EQ(r.path("b"), fs::path("worlds/y.csv"));
  EXPECT_EQ(r.path("c"), fs::path("/abs/z.csv"));
}

TEST(ObjectReader, ErrorsCarryTheFileAMergedValueCameFrom) {
  const Node base = parse_text("{ \"dt\": \"1 m\",\n  \"laps\": 0 }", "base.json");
  const Node merged = merge(base, parse_text("{ \"laps\":\n 101, \"dtt\": 3 }", "top.json"));
  Errors errors;
  read_sample(merged, errors);
  const auto sorted = errors.sorted();
  ASSERT_EQ(sorted.size(), 3U);
  EXPECT_EQ(sorted[0].text(), "base.json:1:9: /dt: \"1 m\" is a length, expected a time [s]");
  EXPECT_EQ(sorted[1].text(), "top.json:2:2: /laps: expected a whole number from 1 to 100, found 101");
  EXPECT_THAT(sorted[2].text(), HasSubstr("top.json:2:7: /dtt: unknown key \"dtt\"; did you mean \"dt\"?"));
}

TEST(Errors, OneMistakeInheritedByManyIsToldOnce) {
  const Node base = parse_text(R"({ "dt": "1 m" })", "t");
  Errors errors;
  for (const char* stack : {"stack elm", "stack gp"}) {
    errors.set_context(stack);
    read_sample(base, errors);
    read_sample(base, errors);
  }
  ASSERT_EQ(errors.size(), 1U);
  EXPECT_EQ(errors.sorted()[0].text(), "t:1:9: /dt: \"1 m\" is a length, expected a time [s] [stack elm, stack gp]");
}

TEST(Errors, AreThrownTogetherSortedByFileLineAndColumn) {
  Errors errors;
  errors.throw_if_any();
  errors.add({.file = "b", .line = 1, .column = 1, .message = "m"});
  errors.add({.file = "a", .line = 10, .column = 2, .message = "m"});
  errors.add({.file = "a", .line = 10, .column = 1, .pointer = "/x", .message = "m"});
  errors.add({.file = "a", .line = 9, .column = 1, .message = "m"});
  try {
    errors.throw_if_any();
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "a:9:1: m\na:10:1: /x: m\na:10:2: m\nb:1:1: m");
    EXPECT_EQ(error.diagnostics().size(), 4U);
    Errors taken;
    taken.add(error);
    EXPECT_EQ(taken.size(), 4U);
  }
  EXPECT_EQ(InputError::exit_code, 2);
}

TEST(Errors, WithoutALineNameWhatTheyCan) {
  EXPECT_STREQ(InputError("-j 0: expected at least 1").what(), "-j 0: expected at least 1");
  EXPECT_EQ((Diagnostic{.file = "f.json", .message = "no such file"}).text(), "f.json: no such file");
  EXPECT_EQ((Diagnostic{.file = "--set", .pointer = "/a", .message = "m"}).text(), "--set /a: m");
}

TEST(DidYouMean, FindsWhatWasMeantAndNothingElse) {
  const std::vector<std::string> names{"momentum", "rate", "hidden", "batch", "q_x", "q_y"};
  EXPECT_EQ(nearest("momentm", names), "momentum");
  EXPECT_EQ(nearest("Rate", names), "rate");
  EXPECT_EQ(nearest("raet", names), "rate");
  EXPECT_EQ(nearest("qx", names), "q_x");
  EXPECT_EQ(nearest("weather", names), std::nullopt);
  EXPECT_EQ(nearest("z", std::vector<std::string>{"x"}), std::nullopt);
  EXPECT_EQ(nearest("", names), std::nullopt);
  EXPECT_EQ(did_you_mean("hiden", names), "; did you mean \"hidden\"?");
  EXPECT_EQ(did_you_mean("weather", names), "; known: momentum, rate, hidden, batch, q_x, q_y");
  EXPECT_EQ(did_you_mean("weather", {}), "");
}

}  // namespace test_config_reader
}  // namespace gripline
