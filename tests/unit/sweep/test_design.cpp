// Settings of a sweep: what the command line says of factors and seeds, and which combinations come of it.
#include "sweep/design.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <stdexcept>

#include "support/host_support.hpp"

namespace gripline::sweep {
namespace test_design {

using testing::ElementsAre;
using testing::HasSubstr;
using testing_support::Folder;
using testing_support::refusal;
using testing_support::write_text;

TEST(Levels, AreCutAtCommasThatNothingEncloses) {
  EXPECT_THAT(split_levels("0.9, 1,1.1"), ElementsAre("0.9", "1", "1.1"));
  EXPECT_THAT(split_levels(R"([1,2],{"a": [3,4]},"x,y",20 ms)"),
              ElementsAre("[1,2]", R"({"a": [3,4]})", R"("x,y")", "20 ms"));
  EXPECT_THAT(split_levels(R"("a\",b",c)"), ElementsAre(R"("a\",b")", "c"));
  EXPECT_THAT(refusal([] { split_levels("1,,2"); }), HasSubstr("a value is missing between commas"));
}

TEST(Factors, AreListsOrRanges) {
  const Factor list = parse_factor("/base/mu_init=0.8,0.9");
  EXPECT_EQ(list.pointer, "/base/mu_init");
  EXPECT_THAT(list.levels, ElementsAre("0.8", "0.9"));
  const Factor range = parse_factor("/world/x=-1.5..2e1");
  EXPECT_TRUE(range.range());
  EXPECT_EQ(range.lo, -1.5);
  EXPECT_EQ(range.hi, 20);
  EXPECT_FALSE(parse_factor("/world=../a.json,b.json").range());
  EXPECT_THAT(refusal([] { parse_factor("/a=2..1"); }), HasSubstr("a range rises"));
  EXPECT_THAT(refusal([] { parse_factor("/a=1,2,1"); }), HasSubstr("1 is there twice"));
  EXPECT_THAT(refusal([] { parse_factor("a=1"); }), HasSubstr("expected /json/pointer=a,b,c"));
}

/// Factors have their places among what is the same in every setting; those without one come last.
TEST(Assignments, KeepTheirOrder) {
  const Design design =
      Design::factorial({parse_factor("/world=a.json,b.json"), parse_factor("/x=1,2"), parse_factor("/y=3,4")});
  const std::vector<std::string> given = {"/note=n", "/world", "/world/laps=null", "/y"};
  EXPECT_THAT(assignments_of(given, design, 6),
              ElementsAre("/note=n", "/world=b.json", "/world/laps=null", "/y=3", "/x=2"));
  EXPECT_EQ(constants_before_factors(given), 1u);
  EXPECT_EQ(constants_before_factors({"/a=1", "/b=2"}), 2u);
  EXPECT_THAT(refusal([&] { assignments_of({"/z"}, design, 0); }), HasSubstr("expected /json/pointer=VALUE"));
}

TEST(Assignments, ThatWouldUndoAFactorAreRefused) {
  const Design design = Design::factorial({parse_factor("/world/laps=1,2"), parse_factor("/x=1,2")});
  const auto refused = [&](const std::vector<std::string>& given) {
    return refusal([&] { require_effect(given, design); });
  };
  EXPECT_EQ(refused({"/world=a.json", "/world/laps", "/world/lapse=1", "/x"}), "nothing");
  EXPECT_EQ(refused({"/world=a.json"}), "nothing");
  EXPECT_THAT(refused({"/world/laps", "/world=a.json"}),
              HasSubstr("/world replaces what the factor /world/laps sets before it"));
  EXPECT_THAT(refused({"/x", "/x=3"}), HasSubstr("/x replaces what the factor /x sets before it"));
  EXPECT_THAT(refusal([] {
                require_effect({}, Design::factorial({parse_factor("/a/b=1,2"), parse_factor("/a=3,4")}));
              }),
              HasSubstr("/a replaces what the factor /a/b sets"));
}

/// No order is given between a list and what goes with it.
TEST(Assignments, ThatAListWouldUndoAreRefused) {
  const Folder folder;
  write_text(folder / "list.csv", "/world\na.json\nb.json\n");
  const Design list = Design::list(folder / "list.csv");
  EXPECT_EQ(refusal([&] { require_effect({"/world=c.json", "/worlds=1"}, list); }), "nothing");
  EXPECT_THAT(refusal([&] { require_effect({"/world/laps=null"}, list); }),
              HasSubstr("--set /world/laps: the list replaces /world in every setting"));
}

TEST(Seeds, AreRangesAndNumbers) {
  EXPECT_THAT(parse_seeds("1..3,10,7"), ElementsAre(1, 2, 3, 10, 7));
  EXPECT_EQ(parse_seeds("1..50").size(), 50u);
  EXPECT_THAT(refusal([] { parse_seeds("1..3,2"); }), HasSubstr("2 is there twice"));
  EXPECT_THAT(refusal([] { parse_seeds("3..1"); }), HasSubstr("ends before it begins"));
  EXPECT_THAT(refusal([] { parse_seeds("1..x"); }), HasSubstr("expected whole numbers"));
  EXPECT_THAT(refusal([] { parse_seeds("0..999999999"); }), HasSubstr("at most 1000000 seeds"));
}

TEST(Factorial, HasEveryCombinationOnceAndTheLastFactorFastest) {
  const Design design = Design::factorial({parse_factor("/a=1,2"), parse_factor("/b=x,y,z")});
  ASSERT_EQ(design.size(), 6u);
  EXPECT_THAT(design.setting(0), ElementsAre("1", "x"));
  EXPECT_THAT(design.setting(1), ElementsAre("1", "y"));
  EXPECT_THAT(design.setting(5), ElementsAre("2", "z"));
  EXPECT_EQ(Design::factorial({}).size(), 1u);
  EXPECT_THAT(refusal([] { Design::factorial({parse_factor("/a=0..1")}); }), HasSubstr("add --latin COUNT"));
  EXPECT_THAT(refusal([] {
                Design::factorial({parse_factor("/a=0,1"), parse_factor("/a=2,3")});
              }),
              HasSubstr("/a is a factor twice"));
  EXPECT_THAT(refusal([] { Design::factorial({parse_factor("/a/-=0,1")}); }), HasSubstr("a factor replaces a value"));
}

TEST(Latin, TakesEachPartOfEveryRangeOnce) {
  constexpr std::size_t count = 97;
  const Design design =
      Design::latin({parse_factor("/a=0..1"), parse_factor("/b=10..20"), parse_factor("/c=x,y")}, count, 3);
  std::set<int> a, b;
  std::size_t x = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::vector<std::string> values = design.setting(i);
    a.insert(static_cast<int>(std::stod(values[0]) * count));
    b.insert(static_cast<int>((std::stod(values[1]) - 10) / 10 * count));
    x += values[2] == "x" ? 1 : 0;
  }
  EXPECT_EQ(a.size(), count);
  EXPECT_EQ(b.size(), count);
  EXPECT_EQ(x, 49u);
  EXPECT_NE(design.setting(0), Design::latin(design.factors(), count, 4).setting(0));
}

/// Where six digits cannot tell the parts of a range apart, values have more; elsewhere they have six at most.
TEST(Latin, ValuesStayInTheirPartsOfANarrowRange) {
  const Design narrow = Design::latin({parse_factor("/a=1000000..1000001"), parse_factor("/b=0.9..1.1")}, 4, 1);
  std::set<int> parts;
  for (std::size_t i = 0; i < narrow.size(); ++i) {
    const double value = std::stod(narrow.setting(i)[0]);
    EXPECT_GE(value, 1000000);
    EXPECT_LT(value, 1000001);
    parts.insert(static_cast<int>((value - 1000000) * 4));
    EXPECT_LE(narrow.setting(i)[1].size(), 8u) << narrow.setting(i)[1];
  }
  EXPECT_EQ(parts.size(), 4u);
}

TEST(Factors, AreNeitherSeedsNorClaims) {
  for (const char* seeds : {"/seeds/first=1,50", "/seeds/count=1,3", "/seed=1,2"})
    EXPECT_THAT(refusal([&] { Design::factorial({parse_factor(seeds)}); }), HasSubstr("seeds are no factor"));
  EXPECT_THAT(refusal([] { Design::latin({parse_factor("/seeds/first=1..50")}, 4, 1); }), HasSubstr("use --seeds"));
  for (const char* claims : {"/claims=[],null", "/claims/0=a,b", "/claim_share=0.5,1"})
    EXPECT_THAT(refusal([&] { Design::factorial({parse_factor(claims)}); }), HasSubstr("claims are no factor"));
}

TEST(Permutation, IsOneOfAnyCount) {
  for (const std::uint64_t count : {1U, 2U, 3U, 10U, 1000U, 4097U}) {
    std::set<std::uint64_t> seen;
    for (std::uint64_t i = 0; i < count; ++i) seen.insert(permuted(i, count, 7));
    EXPECT_EQ(seen.size(), count);
    EXPECT_LT(*seen.rbegin(), count);
  }
}

TEST(List, ReadsSettingsAndSaysWhereAFileIsWrong) {
  const Folder folder;
  write_text(folder / "settings.csv", "/world,/base/mu_init\n\"a,b.json\",0.9\n\nc.json,1\n");
  const Design design = Design::list(folder / "settings.csv");
  ASSERT_EQ(design.size(), 2u);
  EXPECT_THAT(design.setting(0), ElementsAre("\"a,b.json\"", "0.9"));
  EXPECT_THAT(design.setting(1), ElementsAre("c.json", "1"));
  const std::optional<ListPlace> place = design.place(1, 1);
  ASSERT_TRUE(place);
  EXPECT_THAT(place->file, testing::EndsWith("settings.csv"));
  EXPECT_EQ(place->line, 4);
  EXPECT_EQ(place->column, 8);
  EXPECT_EQ(design.place(0, 1)->column, 12);
  EXPECT_FALSE(Design::from_node(design.to_node()).place(0, 0));
  // JSON as it is, and as a spreadsheet quotes it.
  write_text(folder / "json.csv", "/a,/b\n{\"t\": [0, 1]},1\n\"{\"\"t\"\": [0, 1], \"\"u\"\": 2}\",\"[1, 2]\"\n");
  const Design json = Design::list(folder / "json.csv");
  EXPECT_THAT(json.setting(0), ElementsAre("{\"t\": [0, 1]}", "1"));
  EXPECT_THAT(json.setting(1), ElementsAre("{\"t\": [0, 1], \"u\": 2}", "[1, 2]"));
  // Words that only begin like JSON are one word each.
  write_text(folder / "words.csv", "/a,/b\n\"[dry], wet\",2\n\"{\",\"[1, 2\"\n");
  const Design words = Design::list(folder / "words.csv");
  EXPECT_THAT(words.setting(0), ElementsAre("\"[dry], wet\"", "2"));
  EXPECT_THAT(words.setting(1), ElementsAre("\"{\"", "\"[1, 2\""));
  write_text(folder / "slip.csv", "/a,/b\n1,2\n\"{\"\"t\"\" 0}\",2\n");
  EXPECT_THAT(refusal([&] { Design::list(folder / "slip.csv"); }),
              HasSubstr("slip.csv:3:1: expected JSON in quotes as spreadsheets write it"));
  write_text(folder / "bad.csv", "/world,/mu\na.json\n");
  EXPECT_THAT(refusal([&] { Design::list(folder / "bad.csv"); }), HasSubstr("bad.csv:2:1: expected 2 values, found 1"));
  write_text(folder / "head.csv", "mu\n1\n");
  EXPECT_THAT(refusal([&] { Design::list(folder / "head.csv"); }), HasSubstr("expected JSON pointers"));
}

TEST(DesignFile, ReadsBackAsTheSameSettings) {
  const Design factorial = Design::factorial({parse_factor("/a=1,2"), parse_factor("/b=x,\"y,z\"")});
  const Design latin = Design::latin({parse_factor("/a=0..1"), parse_factor("/b=1,2")}, 10, 5);
  const Folder folder;
  write_text(folder / "list.csv", "/a,/b\n\"{\"\"t\"\": [0, 1]}\",\"[dry], wet\"\n\"a,b\",[1, 2]\n");
  const Design list = Design::list(folder / "list.csv");
  for (const Design* design : {&factorial, &latin, &list}) {
    const Design again = Design::from_node(design->to_node());
    ASSERT_EQ(again.size(), design->size());
    for (std::size_t i = 0; i < design->size(); ++i) EXPECT_EQ(again.setting(i), design->setting(i));
  }
}

TEST(DesignFile, AnyMemberThatIsMissingIsAnError) {
  const Node whole = Design::latin({parse_factor("/a=0..1"), parse_factor("/b=1,2")}, 10, 5).to_node();
  for (const char* key : {"kind", "factors", "size", "seed", "rows"}) {
    Node damaged = whole;
    damaged.erase(key);
    EXPECT_THROW(Design::from_node(damaged), std::out_of_range) << key;
  }
  for (const char* key : {"pointer", "levels", "lo", "hi"}) {
    Node damaged = whole;
    damaged.find("factors")->array().front().erase(key);
    EXPECT_THROW(Design::from_node(damaged), std::out_of_range) << key;
  }
}

}  // namespace test_design
}  // namespace gripline::sweep
