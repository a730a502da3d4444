#include "config/merge_patch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "config/errors.hpp"
#include "config/json_file.hpp"
#include "config/reader.hpp"

namespace gripline {
namespace test_merge_patch {

using testing::HasSubstr;

std::string compact(const Node& node) {
  std::string text = to_json_text(node);
  std::erase_if(text, [](char c) { return c == '\n' || c == ' '; });
  return text;
}

std::string merged(const std::string& base, const std::string& patch) {
  return compact(merge(parse_text(base), parse_text(patch)));
}

// The table of RFC 7396, appendix A.
TEST(Merge, FollowsEveryExampleOfRfc7396) {
  const std::vector<std::vector<std::string>> rows{
      {R"({"a":"b"})", R"({"a":"c"})", R"({"a":"c"})"},
      {R"({"a":"b"})", R"({"b":"c"})", R"({"a":"b","b":"c"})"},
      {R"({"a":"b"})", R"({"a":null})", R"({})"},
      {R"({"a":"b","b":"c"})", R"({"a":null})", R"({"b":"c"})"},
      {R"({"a":["b"]})", R"({"a":"c"})", R"({"a":"c"})"},
      {R"({"a":"c"})", R"({"a":["b"]})", R"({"a":["b"]})"},
      {R"({"a":{"b":"c"}})", R"({"a":{"b":"d","c":null}})", R"({"a":{"b":"d"}})"},
      {R"({"a":[{"b":"c"}]})", R"({"a":[1]})", R"({"a":[1]})"},
      {R"(["a","b"])", R"(["c","d"])", R"(["c","d"])"},
      {R"({"a":"b"})", R"(["c"])", R"(["c"])"},
      {R"({"a":"foo"})", R"(null)", R"(null)"},
      {R"({"a":"foo"})", R"("bar")", R"("bar")"},
      {R"({"e":null})", R"({"a":1})", R"({"e":null,"a":1})"},
      {R"([1,2])", R"({"a":"b","c":null})", R"({"a":"b"})"},
      {R"({})", R"({"a":{"bb":{"ccc":null}}})", R"({"a":{"bb":{}}})"}};
  for (const auto& row : rows) EXPECT_EQ(merged(row[0], row[1]), row[2]) << row[0] << " + " << row[1];
}

/// A text may be the name of a file, which a reader then misses.
TEST(Merge, RemembersTheTextThatItReplaces) {
  const Node base =
      parse_text(R"({"world": "w.json", "base": {"controller": {"plugin": "a", "params": {"k": 1}}}})", "base");
  const Node patch = parse_text(R"({"world": {"laps": 1}, "base": {"controller": {"plugin": "b"}}})", "patch");
  const Node node = merge(parse_text("{}"), merge(base, patch));
  const auto replaced = [&](const char* pointer) { return find_pointer(node, pointer)->replaced; };
  ASSERT_TRUE(replaced("/world"));
  EXPECT_EQ(replaced("/world")->text(), "w.json");
  EXPECT_EQ(replaced("/world")->origin.source->name, "base");
  ASSERT_TRUE(replaced("/base/controller/plugin"));
  EXPECT_EQ(replaced("/base/controller/plugin")->text(), "a");
  EXPECT_FALSE(replaced("/base/controller/params/k"));
  EXPECT_FALSE(merge(base, base).find("world")->replaced);  // by the same text
}

TEST(Merge, KeepsTheOriginOfEachValue) {
  const Node base = parse_text("{ \"a\": 1,\n  \"b\": { \"x\": 1, \"y\": 2 } }", "base");
  const Node patch = parse_text("{\n\n  \"b\": { \"y\": 3 }, \"c\": 4 }", "patch");
  const Node node = merge(base, patch);
  const auto where = [&](const char* pointer) {
    const Origin& at = find_pointer(node, pointer)->origin;
    return at.source->name + ':' + std::to_string(at.line) + ':' + std::to_string(at.column) + at.pointer;
  };
  EXPECT_EQ(where("/a"), "base:1:8/a");
  EXPECT_EQ(where("/b"), "base:2:8/b");
  EXPECT_EQ(where("/b/x"), "base:2:15/b/x");
  EXPECT_EQ(where("/b/y"), "patch:3:15/b/y");
  EXPECT_EQ(where("/c"), "patch:3:25/c");
  EXPECT_EQ(node.object()[2].key_origin().column, 20);
  EXPECT_EQ(node.object()[2].key_origin().source->name, "patch");
}

TEST(Merge, AReplacedValueBringsThePlaceOfItsKey) {
  const Node node = merge(parse_text("{ \"a\": 1 }", "base"), parse_text("{\n \"a\": 2 }", "patch"));
  EXPECT_EQ(node.object()[0].key_origin().source->name, "patch");
  EXPECT_EQ(node.object()[0].key_origin().line, 2);
}

TEST(Merge, WhatAPatchRemovedIsMissingBecauseOfThePatch) {
  const Node base = parse_text("{ \"a\": { \"x\": 1, \"y\": 2 } }", "base");
  EXPECT_EQ(merge(base, parse_text(R"({ "a": { "x": null } })", "patch")).find("a")->origin.source->name, "patch");
  EXPECT_EQ(merge(base, parse_text(R"({ "a": { "z": null } })", "patch")).find("a")->origin.source->name, "base");
}

TEST(Merge, KeepingNullsLetsARemovalReachALaterMerge) {
  const Node child = parse_text(R"({ "stacks": { "new": { "estimator": null }, "old": null } })");
  const Node base =
      parse_text(R"({ "base": { "estimator": 1, "planner": 2 }, "stacks": { "old": {}, "none": null } })");
  const Node node = merge_keeping_nulls(base, child);
  EXPECT_EQ(compact(*node.find("stacks")), R"({"old":null,"none":null,"new":{"estimator":null}})");
  EXPECT_EQ(compact(merge(*node.find("base"), *node.find("stacks")->find("new"))), R"({"planner":2})");
  const Node again = merge_keeping_nulls(node, child);
  EXPECT_EQ(compact(*again.find("stacks")->find("new")), R"({"estimator":null})") << "null over null stays null";
}

/// A stack that removes its own estimator shall not get that of "base" instead.
TEST(Merge, KeepingNullsLetsARemovalStandInThePlaceOfAMember) {
  const Node base = parse_text(R"({ "base": { "e": 1, "p": 2 }, "stacks": { "b": { "e": { "k": 3 } } } })", "base");
  const Node node = merge_keeping_nulls(base, parse_text(R"({ "stacks": { "b": { "e": null } } })", "patch"));
  const Node& stack = *find_pointer(node, "/stacks/b");
  EXPECT_EQ(compact(stack), R"({"e":null})");
  EXPECT_EQ(stack.origin.source->name, "patch") << "what is missing is missing because of the patch";
  EXPECT_EQ(compact(merge(*node.find("base"), stack)), R"({"p":2})");
  const Node back = merge_keeping_nulls(node, parse_text(R"({ "stacks": { "b": { "e": { "k": 4 } } } })"));
  EXPECT_EQ(compact(*find_pointer(back, "/stacks/b")), R"({"e":{"k":4}})");
}

/// A null that removes nothing is most likely misspelt.
TEST(Merge, ARemovedKeyMayBeUnknownToTheReader) {
  const auto problems = [](const char* patch) {
    const Node node = merge_keeping_nulls(parse_text(R"({ "a": 1, "other": 2 })"), parse_text(patch));
    Errors errors;
    ObjectReader(node, errors).find("a");
    return errors.size();
  };
  EXPECT_EQ(problems("{}"), 1u);
  EXPECT_EQ(problems(R"({ "other": null })"), 0u);
  EXPECT_EQ(problems(R"({ "other": null, "othre": null })"), 1u);
}

TEST(Merge, WhatWasRemovedCanBeDropped) {
  const Node base = parse_text(R"({ "a": { "x": 1, "y": 2 }, "list": [1], "none": null })");
  Node node = merge_keeping_nulls(base, parse_text(R"({ "a": { "x": null }, "list": null, "new": null })"));
  drop_removed(node);
  EXPECT_EQ(compact(node), R"({"a":{"y":2},"none":null,"new":null})");
}

const char* const experiment = R"({ "world": { "dt": 0.02, "plant": { "params": { "Df": 1, "Cr0": 2 } } },
  "base": { "mu_init": 1.0 }, "list": [ { "a": 1 }, 2 ], "a/b~": 3 })";

std::string assigned(const std::string& assignment) {
  Node node = parse_text(experiment);
  try {
    apply_assignment(node, assignment);
  } catch (const InputError& error) {
    return error.what();
  }
  const std::string pointer = assignment.substr(0, assignment.find('='));
  return compact(*find_pointer(node, pointer));
}

TEST(Assignment, ValueIsJsonOrElseText) {
  EXPECT_EQ(assigned("/world/dt=0.01"), "0.01");
  EXPECT_EQ(assigned("/world/dt=20 ms"), "\"20ms\"");
  EXPECT_EQ(assigned("/world/dt=\"20 ms\""), "\"20ms\"");
  EXPECT_EQ(assigned("/base/mu_init=null"), "null");
  EXPECT_EQ(assigned("/base/mu_init="), "\"\"");
  EXPECT_EQ(assigned("/base/mu_init=nan"), "\"nan\"");
  EXPECT_EQ(assigned("/base/mu_init=a=b"), "\"a=b\"");
  EXPECT_EQ(assigned("/world/friction=[{\"t\":0,\"factor\":1}]"), R"([{"t":0,"factor":1}])");
  EXPECT_EQ(assigned("/world/plant/params/Df=true"), "true");
  EXPECT_EQ(assigned("/a~1b~0=4"), "4");
  EXPECT_EQ(assigned("/list/0/a=7"), "7");
  EXPECT_EQ(assigned("/list/1={}"), "{}");
  EXPECT_EQ(assigned("=[1]"), "[1]");
}

TEST(Assignment, ANewElementGoesLast) {
  Node node = parse_text(experiment);
  set_pointer(node, "/list/-", "9");
  set_pointer(node, "/list/-", "10");
  EXPECT_EQ(compact(*node.find("list")), R"([{"a":1},2,9,10])");
}

/// Whether there may be such objects is for whoever reads the tree to say, at the option and not at a line of the file.
TEST(Assignment, MakesTheObjectsOnTheWay) {
  Node node = parse_text(experiment);
  apply_assignment(node, "/world/sensors/sigma/x=2 mm");
  EXPECT_EQ(compact(*find_pointer(node, "/world/sensors")), R"({"sigma":{"x":"2mm"}})");
  Errors errors;
  {
    ObjectReader reader(*node.find("world"), errors);
    for (const char* key : {"dt", "plant", "sensor"}) reader.find(key);
  }
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_EQ(errors.sorted()[0].text(), "--set /world/sensors: unknown key \"sensors\"; did you mean \"sensor\"?");
}

TEST(Assignment, RefusesWhatHasNoParent) {
  EXPECT_EQ(assigned("/world/dt/x=1"), "--set /world/dt/x: /world/dt is 0.02, it has no members");
  EXPECT_EQ(assigned("/world/dt/x/y=1"), "--set /world/dt/x/y: /world/dt is 0.02, it has no members");
  EXPECT_EQ(
      assigned("/list/2=1"),
      "--set /list/2: \"2\" is not an element of /list, which has 2; expected an index from 0, or - for a new one");
  EXPECT_THAT(assigned("/list/x=1"), HasSubstr("\"x\" is not an element of /list"));
  EXPECT_THAT(assigned("/list/-1=1"), HasSubstr("\"-1\" is not an element of /list"));
  EXPECT_THAT(assigned("/list/-/a=1"), HasSubstr("must stand last"));
}

TEST(Assignment, RefusesWhatIsNoAssignment) {
  EXPECT_EQ(assigned("/world/dt"), "--set /world/dt: expected /json/pointer=VALUE");
  EXPECT_THAT(assigned("world/dt=1"), HasSubstr("\"world/dt\" is not a JSON pointer"));
  EXPECT_THAT(assigned("/a~2=1"), HasSubstr("is not a JSON pointer"));
  EXPECT_THAT(assigned("/a~=1"), HasSubstr("is not a JSON pointer"));
}

TEST(Assignment, BrokenJsonIsNotTakenForText) {
  EXPECT_EQ(assigned("/list=[1,"),
            "--set /list: not JSON, column 4: the file ends too early: the \"[\" of line 1, column 1 is not closed");
  EXPECT_THAT(assigned("/base={\"a\":1,\"a\":2}"), HasSubstr("the key \"a\" is already written"));
  EXPECT_THAT(assigned("/base=\"a"), HasSubstr("not JSON"));
}

/// A stack without an estimator does not get the base's back.
TEST(Assignment, NothingIsSetBelowANull) {
  Node node = parse_text(R"({"base": {"estimator": {"plugin": "elm"}}, "stacks": {"none": {"estimator": null}}})");
  const std::string before = content_text(node);
  try {
    apply_assignment(node, "/stacks/none/estimator/params/rate=0.9");
    FAIL() << content_text(node);
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "--set /stacks/none/estimator/params/rate: /stacks/none/estimator is null, which replaces what is "
                 "inherited; a key below it cannot be set, only the whole: /stacks/none/estimator={...}");
  }
  EXPECT_EQ(content_text(node), before);
  apply_assignment(node, R"(/stacks/none/estimator={"plugin": "gp"})");
  apply_assignment(node, "/stacks/none/estimator/params/rate=0.9");
  EXPECT_EQ(find_pointer(node, "/stacks/none/estimator/params/rate")->number(), 0.9);
}

TEST(Assignment, ErrorsInASetValueNameTheOption) {
  Node node = parse_text(experiment);
  apply_assignment(node, R"(/base={ "mu_init": [1, "x"] })");
  Errors errors;
  errors.add(find_pointer(node, "/base/mu_init/1")->origin, "wrong");
  EXPECT_EQ(errors.sorted()[0].text(), "--set /base/mu_init/1: wrong");
}

}  // namespace test_merge_patch
}  // namespace gripline
