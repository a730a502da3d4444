#include "plugin/plugin_spec.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/merge_patch.hpp"
#include "support/host_support.hpp"

namespace gripline {
namespace test_plugin_spec {

using testing::AllOf;
using testing::ElementsAre;
using testing::ElementsAreArray;
using testing::HasSubstr;
using testing::Not;
using namespace testing_support;

PluginSpec spec_of(const Node& node, abi::Kind kind = abi::Kind::estimator, const KnownParams& known = {}) {
  Errors errors;
  PluginSpec spec;
  {
    ObjectReader reader(node, errors);
    spec = read_plugin(reader, kind, plugins(), known);
  }
  errors.throw_if_any();
  return spec;
}
PluginSpec typed(const std::string& params) {
  return spec_of(json(R"({"plugin": "spy.typed", "params": )" + params + "}"));
}

/// What arrives inside the plugin: length, count, 10 mode + flag, sum of the table.
std::vector<double> arrived(const PluginSpec& spec) {
  const auto made = create<Estimator>(*spec.entry, PluginContext{}, spec.values);
  const Belief belief = made->belief();
  return {belief.mu_front, belief.mu_rear, belief.sigma_front, belief.sigma_rear};
}

constexpr const char* curve = R"("curve": [[0, 1], [1, 4], [2.5, -3]])";

TEST(PluginSpec, DefaultsAreTheDeclaredOnes) {
  const PluginSpec spec = typed(std::string("{") + curve + "}");
  EXPECT_EQ(spec.id(), "spy.typed");
  EXPECT_FALSE(spec.empty());
  EXPECT_THAT(arrived(spec), ElementsAre(0.5, 3, 11, 5.5));
  EXPECT_THAT(arrived(typed("{}")), ElementsAre(0.5, 3, 11, 0));  // no table: an empty one
  EXPECT_TRUE(PluginSpec{}.empty());
  EXPECT_EQ(PluginSpec{}.id(), "");
}

TEST(PluginSpec, EveryTypeIsRead) {
  EXPECT_THAT(arrived(typed(R"({"length": "20 cm", "count": 7, "flag": false, "mode": "fast",
                                "curve": [[-1, 0.5, 2]]})")),
              ElementsAre(0.2, 7, 20, 1.5));
}

TEST(PluginSpec, NullAndNoParamsAreTheDefaults) {
  const std::vector<double> defaults = spec_of(json(R"({"plugin": "aero_drag"})"), abi::Kind::effect).numbers();
  EXPECT_EQ(spec_of(json(R"({"plugin": "aero_drag", "params": null})"), abi::Kind::effect).numbers(), defaults);
  EXPECT_EQ(spec_of(json(R"({"plugin": "aero_drag", "params": {}})"), abi::Kind::effect).numbers(), defaults);
  EXPECT_EQ(spec_of(json(R"({"plugin": "aero_drag", "params": {"a": null}})"), abi::Kind::effect).numbers(), defaults);
}

TEST(PluginSpec, WhatIsKnownOfTheCarComesBeforeTheDefaultAndAfterTheJson) {
  const KnownParams known = {{"m", 2.0}, {"Cm1", 0.5}, {"not_a_parameter", 1.0}};
  const auto value = [&](const char* text, std::string_view name) {
    const PluginSpec spec = spec_of(json(text), abi::Kind::vehicle, known);
    for (std::size_t i = 0; i < spec.values.size(); ++i)
      if (name == spec.entry->params()[i].name) return spec.values[i].number;
    return -1.0;
  };
  EXPECT_EQ(value(R"({"plugin": "dynamic"})", "m"), 2.0);
  EXPECT_EQ(value(R"({"plugin": "dynamic"})", "Cm1"), 0.5);
  EXPECT_EQ(value(R"({"plugin": "dynamic", "params": {"m": "3 kg"}})", "m"), 3.0);
  EXPECT_EQ(value(R"({"plugin": "dynamic"})", "Df"), 0.21);
}

TEST(PluginSpec, WhatIsKnownOfTheCarIsNoWholeNumberByChance) {
  const Node node = json(R"({"plugin": "spy.typed"})");
  EXPECT_THAT(arrived(spec_of(node, abi::Kind::estimator, {{"count", 7.0}})), ElementsAre(0.5, 7, 11, 0));
  for (const double odd : {1e300, 2.5, -1.0})
    EXPECT_THAT(refusal([&] {
                  spec_of(node, abi::Kind::estimator, {{"count", odd}});
                }),
                HasSubstr("/plugin: count is known of the car as " + number_text(odd) +
                          "; expected a whole number from 0 to 9"));
}

TEST(PluginSpec, ATableMayBeACsvFileBesideTheJson) {
  const Folder folder;
  write_text(folder / "curve.csv", "x,y\n0,1\n2,3\n");
  const Node node = parse_text(R"({"plugin": "spy.typed", "params": {"curve": "curve.csv"}})", "test", folder.path());
  EXPECT_THAT(arrived(spec_of(node)), ElementsAre(0.5, 3, 11, 6));
}

/// What is written of a plugin's values is read as these values.
TEST(PluginSpec, ValuesAreWrittenAsTheyAreRead) {
  for (const char* params :
       {"{}", R"({"length": 0.25, "count": 7, "flag": false, "mode": "fast", "curve": [[-1, 0.5], [2, 3]]})"}) {
    const PluginSpec spec = typed(params);
    Node written = Node::empty_object();
    for (std::size_t i = 0; i < spec.values.size(); ++i)
      written.set(spec.entry->params()[i].name, param_node(spec.entry->params()[i], spec.values[i]));
    EXPECT_THAT(arrived(typed(to_json_text(written))), ElementsAreArray(arrived(spec))) << params;
  }
}

TEST(PluginSpec, CopiesShareTheirTables) {
  PluginSpec copy;
  {
    const PluginSpec original = typed(std::string("{") + curve + "}");
    copy = original;
  }
  const std::vector<std::vector<double>> reuse(100, std::vector<double>(6, 7.7));  // what was freed would be taken
  EXPECT_THAT(arrived(copy), ElementsAre(0.5, 3, 11, 5.5));
  EXPECT_EQ(reuse.size(), 100u);
}

TEST(PluginSpec, RefusalsSayWhatAndWhere) {
  const auto why = [](const std::string& params) { return refusal([&] { typed(params); }); };
  EXPECT_THAT(why(R"({"lenght": 1, "curve": [[0, 0]]})"),
              HasSubstr("/params/lenght: unknown key \"lenght\"; did you mean \"length\"?"));
  EXPECT_THAT(why(R"({"length": 3, "curve": [[0, 0]]})"),
              HasSubstr("/params/length: 3 is out of range: expected a length [m] from 0 m to 2 m"));
  EXPECT_THAT(why(R"({"length": "1 s", "curve": [[0, 0]]})"), HasSubstr("\"1 s\" is a time, expected a length [m]"));
  EXPECT_THAT(why(R"({"count": 2.5, "curve": [[0, 0]]})"), HasSubstr("/params/count: expected a whole number"));
  EXPECT_THAT(why(R"({"count": 10, "curve": [[0, 0]]})"), HasSubstr("/params/count: expected a whole number"));
  EXPECT_THAT(why(R"({"flag": 1, "curve": [[0, 0]]})"), HasSubstr("/params/flag: expected true or false, found 1"));
  EXPECT_THAT(why(R"({"mode": "brisk", "curve": [[0, 0]]})"),
              HasSubstr("/params/mode: expected \"slow\", \"medium\" or \"fast\""));
  EXPECT_THAT(refusal([] { spec_of(json(R"({"params": {}})")); }), HasSubstr("/plugin: missing, expected a text"));
  EXPECT_THAT(refusal([] { spec_of(json(R"({"plugin": "aero_drag", "params": 3})"), abi::Kind::effect); }),
              HasSubstr("/params: expected an object, found 3"));
}

/// A plugin without a name is an error where it stands, of every kind.
TEST(PluginSpec, AnEmptyIdIsRefused) {
  for (const auto& [kind, name] : {std::pair{abi::Kind::controller, "controller"}, {abi::Kind::plant, "plant"}})
    EXPECT_EQ(refusal([&, kind = kind] { spec_of(json(R"({"plugin": ""})"), kind); }),
              "test:1:12: /plugin: expected the id of a plugin (" + std::string(name) + "), found \"\"");
}

TEST(PluginSpec, TablesAreChecked) {
  const Folder folder;
  write_text(folder / "empty.csv", "");
  write_text(folder / "text.csv", "x,y\n0,a\n");
  const auto why = [&](const std::string& table) {
    const Node node =
        parse_text(R"({"plugin": "spy.typed", "params": {"curve": )" + table + "}}", "test", folder.path());
    return refusal([&] { spec_of(node); });
  };
  EXPECT_THAT(why("[[0, 1], [2]]"), HasSubstr("/params/curve: curve: rows of a table must be equally long"));
  EXPECT_THAT(why("[[0, 1], [0, 2]]"), HasSubstr("the first column must rise; row 2 goes back from 0 to 0"));
  EXPECT_THAT(why("[[2, 1], [1, 2]]"), HasSubstr("row 2 goes back from 2 to 1"));
  EXPECT_THAT(why("[]"), HasSubstr("must not be empty"));
  EXPECT_THAT(why("[[]]"), HasSubstr("must not be empty"));
  EXPECT_THAT(why("[[0, 11]]"), HasSubstr("11 is outside [-10, 10]"));
  EXPECT_THAT(why("[[0, \"a\"]]"), HasSubstr("/params/curve/0/1"));
  EXPECT_THAT(why("3"), HasSubstr("expected a table: [[x, y], ...] or the name of a CSV file, found 3"));
  EXPECT_THAT(why("\"absent.csv\""), HasSubstr("no such file"));
  write_text(folder / "curve.txt", "x,y\n0,1\n");
  EXPECT_THAT(why("\"curve.txt\""), HasSubstr("curve: \"curve.txt\": expected a file whose name ends in .csv"));
  EXPECT_THAT(why("\"empty.csv\""), HasSubstr("the file is empty"));
  EXPECT_THAT(why("\"text.csv\""), HasSubstr("expected a finite number, found \"a\""));
}

/// What another part wrote for the plugin before is no slip of its own parameters' names.
TEST(PluginSpec, InheritedParametersOfAnotherPluginAreToldAtItsName) {
  const Node base = json(R"({"plugin": "spy.typed", "params": {"length": 1, "count": 2}})");
  const auto why = [&](const char* patch) { return refusal([&] { spec_of(merge(base, json(patch))); }); };
  EXPECT_EQ(why(R"({"plugin": "elm"})"),
            "test:1:12: \"elm\" inherits parameters of \"spy.typed\" that it does not have (length, count); write "
            "\"params\": null beside \"plugin\" to drop them");
  EXPECT_THAT(why(R"({"plugin": "elm", "params": {"count": 3, "hiden": 9}})"),
              AllOf(HasSubstr("does not have (length);"), HasSubstr("/params/count: unknown key \"count\""),
                    HasSubstr("/params/hiden: unknown key \"hiden\"; did you mean \"hidden\"?")));
  EXPECT_THAT(why(R"({"params": {"lenght": 3}})"), HasSubstr("unknown key \"lenght\"; did you mean \"length\"?"));
  EXPECT_EQ(spec_of(merge(base, json(R"({"plugin": "elm", "params": null})"))).id(), "elm");
}

TEST(PluginSpec, AMissingPluginIsAPluginError) {
  EXPECT_THROW(spec_of(json(R"({"plugin": "spy.typd"})")), PluginError);
}

TEST(PluginSpec, AMissingPluginHidesNoOtherError) {
  const auto read = [](const char* other) {
    const Node missing = json(R"({"plugin": "spy.typd", "params": {"lenght": 1}})"), second = json(other);
    Errors errors;
    for (const Node* node : {&missing, &second}) {
      ObjectReader reader(*node, errors);
      (void)read_plugin(reader, abi::Kind::estimator, plugins());
    }
    errors.throw_if_any();
  };
  EXPECT_THROW(read(R"({"plugin": "spy.tiped"})"), PluginError);
  EXPECT_THAT(refusal([&] { read(R"({"plugin": "spy.tiped"})"); }),
              AllOf(HasSubstr("no estimator plugin \"spy.typd\""), HasSubstr("no estimator plugin \"spy.tiped\"")));
  EXPECT_THROW(read(R"({"plugin": "spy.typed", "params": {"count": 2.5}})"), InputError);
  EXPECT_THAT(refusal([&] { read(R"({"plugin": "spy.typed", "params": {"count": 2.5}})"); }),
              AllOf(HasSubstr("no estimator plugin \"spy.typd\""), HasSubstr("/params/count: expected a whole number"),
                    Not(HasSubstr("lenght"))));
}

}  // namespace test_plugin_spec
}  // namespace gripline
