#include "config/json_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <clocale>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <locale>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "config/errors.hpp"
#include "config/files.hpp"
#include "config/hash.hpp"

namespace gripline {
namespace test_json_file {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A valid text with every construct of JSON and some of Unicode.
const char* const everything = R"({
  "note": "größer als – and \u00e9\ud83d\ude00 \"quoted\" \\ \/ \b\f\n\r\t\u0001",
  "numbers": [0, -0.0, 1, -1.5, 2e3, 1.25E-3, 9007199254740991, 1e308, 5e-324, 0.1],
  "words": [true, false, null],
  "empty": [{}, [], ""],
  "deep": { "a": { "b": [[1, { "c": "d" }], 2] } }
})";

/// The same tree: kinds, keys in order, values bit by bit.
bool same(const Node& a, const Node& b) {
  if (a.is_array() && b.is_array()) return std::ranges::equal(a.array(), b.array(), same);
  if (a.is_object() && b.is_object()) {
    return std::ranges::equal(a.object(), b.object(), [](const Member& x, const Member& y) {
      return x.key == y.key && same(x.value, y.value);
    });
  }
  if (a.is_number() && b.is_number()) {
    return a.number() == b.number() && std::signbit(a.number()) == std::signbit(b.number());
  }
  if (a.is_text() && b.is_text()) return a.text() == b.text();
  if (a.is_boolean() && b.is_boolean()) return a.boolean() == b.boolean();
  return a.is_null() && b.is_null();
}

std::string message_of(std::string_view text) {
  try {
    (void)parse_text(text, "t");
    return "accepted";
  } catch (const InputError& error) {
    return error.what();
  }
}

/// A folder of its own for one test.
class Folder {
 public:
  Folder() {
    const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
    path_ = fs::path(testing::TempDir()) / ("gripline_json_" + std::string(test->name()));
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] fs::path write(const std::string& name, const std::string& text) const {
    fs::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

TEST(ParseText, KnowsWhereEverythingIsWritten) {
  const Node node = parse_text("{\n  \"a\": [10,\t-2.5 , \"é\", {\"b\":true}],\r\n  \"c/d\":\n null }", "t");
  const auto where = [&](const char* pointer) {
    const Origin& at = find_pointer(node, pointer)->origin;
    EXPECT_EQ(at.pointer, pointer);
    return std::to_string(at.line) + ':' + std::to_string(at.column);
  };
  EXPECT_EQ(where(""), "1:1");
  EXPECT_EQ(where("/a"), "2:8");
  EXPECT_EQ(where("/a/0"), "2:9");
  EXPECT_EQ(where("/a/1"), "2:13");
  EXPECT_EQ(where("/a/2"), "2:20");
  EXPECT_EQ(where("/a/3"), "2:25") << "a character beyond ASCII is one column";
  EXPECT_EQ(where("/a/3/b"), "2:30");
  EXPECT_EQ(where("/c~1d"), "4:2");
  EXPECT_EQ(node.object()[1].key_line, 3);
  EXPECT_EQ(node.object()[1].key_column, 3);
  EXPECT_EQ(find_pointer(node, "/a/4"), nullptr);
  EXPECT_EQ(find_pointer(node, "/a/x"), nullptr);
  EXPECT_EQ(find_pointer(node, "/a/0/x"), nullptr);
}

TEST(ParseText, ReadsEveryConstruct) {
  const Node node = parse_text(everything);
  EXPECT_EQ(node.find("note")->text(), "größer als – and é\U0001F600 \"quoted\" \\ / \b\f\n\r\t\x01");
  const std::vector<double> numbers{0, -0.0, 1, -1.5, 2e3, 1.25e-3, 9007199254740991.0, 1e308, 5e-324, 0.1};
  ASSERT_EQ(node.find("numbers")->array().size(), numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) EXPECT_EQ(node.find("numbers")->array()[i].number(), numbers[i]);
  EXPECT_TRUE(find_pointer(node, "/words/0")->boolean());
  EXPECT_TRUE(find_pointer(node, "/words/2")->is_null());
  EXPECT_EQ(find_pointer(node, "/deep/a/b/0/1/c")->text(), "d");
}

TEST(ParseText, AcceptsAByteOrderMarkAndWindowsLineEnds) {
  const Node node = parse_text("\xef\xbb\xbf{\r\n  \"a\": 1\r\n}\r\n");
  EXPECT_EQ(node.find("a")->number(), 1.0);
  EXPECT_EQ(node.find("a")->origin.line, 2);
  EXPECT_EQ(node.find("a")->origin.column, 8);
  EXPECT_EQ(node.origin.column, 1);
}

TEST(ParseText, AcceptsTwoHundredLevelsAndNoMore) {
  const auto nested = [](int depth) { return std::string(depth, '[') + std::string(depth, ']'); };
  EXPECT_EQ(message_of(nested(max_depth)), "accepted");
  EXPECT_EQ(message_of(nested(max_depth + 1)), "t:1:201: nested deeper than 200 levels");
  EXPECT_THAT(message_of(std::string(100000, '[')), HasSubstr("nested deeper"));
}

TEST(ParseText, RefusesEveryTruncation) {
  const std::string whole = everything;
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const std::string part = whole.substr(0, length);
    const std::string message = message_of(part);
    ASSERT_TRUE(message.find("the file ends too early") != std::string::npos ||
                message == "t: is empty, expected JSON" || message.find("not UTF-8") != std::string::npos)
        << length << ": " << message;
    ASSERT_EQ(message.find('\n'), std::string::npos);
  }
}

// The grammar is nlohmann's; what this reader refuses beyond it are duplicates, depth, and bytes after a NUL. So
// whatever it accepts nlohmann accepts, and what only it refuses it refuses for one of these reasons.
TEST(ParseText, AgreesWithTheGrammarOnMutatedText) {
  std::mt19937 random(1);
  const std::string whole = everything;
  const std::string signs = std::string("{}[]\",:0129-+.eE \n\t\\/utfnNI'#") + '\0' + "\x7f\x80\xc3\xff";
  int accepted = 0;
  for (int round = 0; round < 20000; ++round) {
    std::string text = whole;
    for (int change = 0; change < 1 + round % 3; ++change) {
      const std::size_t at = random() % text.size();
      const char sign = signs[random() % signs.size()];
      const std::uint32_t kind = random() % 3;
      if (kind == 0) text[at] = sign;
      if (kind == 1) text.insert(at, 1, sign);
      if (kind == 2) text.erase(at, 1 + random() % 8);
    }
    const std::string message = message_of(text);
    ASSERT_EQ(message.find('\n'), std::string::npos) << message;
    if (message == "accepted") {
      ++accepted;
      ASSERT_TRUE(nlohmann::json::accept(text)) << text;
    } else if (nlohmann::json::accept(text)) {
      ASSERT_TRUE(message.find("is already written") != std::string::npos ||
                  message.find("NUL byte") != std::string::npos)
          << message << '\n'
          << text;
    }
  }
  EXPECT_GT(accepted, 500) << "the mutations must leave some texts valid";
}

TEST(ParseText, RefusesRandomBytesWithoutACrash) {
  std::mt19937 random(2);
  for (int round = 0; round < 5000; ++round) {
    std::string text(1 + random() % 40, ' ');
    for (char& c : text) c = static_cast<char>(random() & 0xffU);
    if (round % 2 == 0) text.insert(0, "{\"a\": ");
    ASSERT_EQ(message_of(text).find('\n'), std::string::npos);
  }
}

TEST(ParseText, AgreesWithTheGrammarOnUtf8) {
  // All leading bytes with the second bytes at the edges of every rule, and continuation bytes missing or not.
  for (int first = 0x80; first < 0x100; ++first) {
    for (const int second : {0x7f, 0x80, 0x8f, 0x90, 0x9f, 0xa0, 0xbf, 0xc0}) {
      for (const char* tail : {"", "\x80", "\xbf\x80", "\x80\x80\x80"}) {
        const std::string text =
            std::string("[\"") + static_cast<char>(first) + static_cast<char>(second) + tail + "\"]";
        EXPECT_EQ(message_of(text) == "accepted", nlohmann::json::accept(text)) << first << ' ' << second;
      }
    }
  }
}

TEST(ParseFile, RefusesWhatIsNoFile) {
  const Folder folder;
  const fs::path good = folder.write("worlds/ethz.json", "{}");
  const auto why = [](const fs::path& file) -> std::string {
    try {
      (void)parse_file(file);
      return "accepted";
    } catch (const InputError& error) {
      return error.what();
    }
  };
  EXPECT_EQ(why(good), "accepted");
  const std::string root = folder.path().generic_string();
  EXPECT_EQ(why(folder.path() / "worlds/eth.json"),
            root + "/worlds/eth.json: no such file; did you mean \"ethz.json\"?");
  EXPECT_EQ(
      why(folder.path() / "wrlds/ethz.json"),
      root + "/wrlds/ethz.json: no such file: there is no \"wrlds\" in \"" + root + "\"; did you mean \"worlds\"?");
  EXPECT_EQ(why(folder.path() / "worlds/quite_another"), root + "/worlds/quite_another: no such file");
  EXPECT_EQ(why(folder.path() / "worlds"), root + "/worlds: is a folder, expected a file");
  EXPECT_EQ(why(folder.write("empty.json", "")), root + "/empty.json: is empty, expected JSON");
  EXPECT_THAT(why(good / "below"), HasSubstr("ethz.json/below: "));
  EXPECT_EQ(why(std::string("a\0b", 3)), "a\\x00b: is not a path: it holds a NUL character");
}

TEST(ParseFile, StopsReadingWhatNeverEnds) {
  if (!fs::exists("/dev/zero")) GTEST_SKIP() << "no such device here";
  try {
    (void)parse_file("/dev/zero");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("is larger than"));
  }
}

std::string why_not_loaded(const fs::path& file) {
  try {
    (void)load_json(file);
    return "accepted";
  } catch (const InputError& error) {
    return error.what();
  }
}

TEST(ParseText, WhatOnlyAnAttackHoldsIsRefusedAtItsPlace) {
  const std::string long_key(json_limits.key + 1, 'k');
  EXPECT_EQ(message_of("{ \"a\": 1,\n  \"" + long_key + "\": 1 }"),
            "t:2:3: a key of 1001 bytes; the longest that is read has 1000");
  EXPECT_EQ(message_of("{ \"" + long_key.substr(1) + "\": 1 }"), "accepted");
  std::string many = "{";
  for (std::size_t i = 0; i < json_limits.members; ++i) many += "\"k" + std::to_string(i) + "\":0,";
  EXPECT_EQ(message_of(many + "\"last\":0}"), "t:1:98892: more than 10000 members in one object");
  many.pop_back();
  EXPECT_EQ(message_of(many + "}"), "accepted");
  std::string values = "[0";
  for (std::size_t i = 1; i < json_limits.values; ++i) values += ",0";
  EXPECT_THAT(message_of(values + "]"), HasSubstr("more than 1000000 values, which no file of ours needs"));
  EXPECT_EQ(message_of("[" + std::string(json_limits.bytes, ' ') + "]"), "t: is larger than 64 MB");
}

/// Every value knows its place: names a kilobyte long, a hundred deep, above a thousand values.
TEST(ParseText, LongNamesAboveManyValuesAreBounded) {
  std::string text;
  for (int i = 0; i < 150; ++i) text += "{\"" + std::string(json_limits.key, 'k') + "\":";
  text += "[0";
  for (int i = 0; i < 10'000; ++i) text += ",0";
  text += "]" + std::string(150, '}');
  EXPECT_THAT(message_of(text), HasSubstr("more than 128 MB of keys above values"));
}

TEST(LoadJson, ExtendsCannotGrowWithoutBound) {
  const Folder folder;
  // Each of twenty files uses the next one twice: a million copies of the last.
  for (int i = 0; i < 20; ++i) {
    const std::string next = "{ \"extends\": \"" + std::to_string(i + 1) + ".json\" }";
    (void)folder.write(std::to_string(i) + ".json", "{ \"a\": " + next + ", \"b\": " + next + " }");
  }
  (void)folder.write("20.json", "{}");
  EXPECT_THAT(why_not_loaded(folder.path() / "0.json"),
              HasSubstr("\"extends\" opens more than 1000 files: each use counts"));
  for (int i = 100; i < 140; ++i)
    (void)folder.write(std::to_string(i) + ".json", "{ \"extends\": \"" + std::to_string(i + 1) + ".json\" }");
  (void)folder.write("140.json", "{}");
  EXPECT_THAT(why_not_loaded(folder.path() / "100.json"), HasSubstr("files extend files more than 32 deep"));
  // Each of three files nests the next one 90 levels deeper.
  for (int i = 200; i < 203; ++i)
    (void)folder.write(std::to_string(i) + ".json", "{ \"a\": " + std::string(90, '[') + "{ \"extends\": \"" +
                                                        std::to_string(i + 1) + ".json\" }" + std::string(90, ']') +
                                                        "}");
  (void)folder.write("203.json", "{}");
  EXPECT_THAT(why_not_loaded(folder.path() / "200.json"),
              HasSubstr("with what it extends, nested deeper than 200 levels"));
}

TEST(ParseFile, APipeThatSomebodyNamedIsNotWaitedFor) {
  const Folder folder;
  const fs::path pipe = folder.path() / "pipe.json";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(why_not_loaded(pipe), shown(pipe) + ": is a pipe, expected a file");
  // One of a shell has no name: `gripline validate <(command)`.
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  ASSERT_EQ(write(ends[1], "{\"a\":1}", 7), 7);
  close(ends[1]);
  EXPECT_EQ(why_not_loaded("/dev/fd/" + std::to_string(ends[0])), "accepted");
  close(ends[0]);
}

TEST(Errors, AreCollectedToAThousandAndThenCounted) {
  Errors errors;
  for (int i = 0; i < 200'000; ++i) errors.add(Diagnostic{.file = "f", .line = i + 1, .message = "wrong"});
  errors.add(Diagnostic{.file = "f", .line = 1, .message = "wrong"});
  EXPECT_EQ(errors.size(), 200'000u);
  EXPECT_EQ(errors.added(), 200'001u);
  const std::vector<Diagnostic> sorted = errors.sorted();
  ASSERT_EQ(sorted.size(), 1001u);
  EXPECT_EQ(sorted.back().text(), "f: and 199000 more errors");
}

TEST(Errors, WordsOfOthersDoNoHarm) {
  EXPECT_EQ(harmless("plain, größer"), "plain, größer");
  EXPECT_EQ(harmless("\x1b[2J\n\x7f"), "\\x1b[2J\\x0a\\x7f");
  EXPECT_EQ(harmless("\xc2\x9b"
                     "2J \xc3\x9f"),
            "\\x9b2J \xc3\x9f");  // a control of one byte beyond ASCII; ß
  EXPECT_LT(harmless(std::string(1'000'000, 'x')).size(), 5000u);
}

TEST(LoadJson, ExtendsFilesRelativeToTheirOwnFolders) {
  const Folder folder;
  (void)folder.write("cars/small.json", R"({ "m": 1, "limits": { "d": 1, "delta": 2 }, "file": "car.csv" })");
  (void)folder.write("worlds/a.json", R"({ "extends": "../cars/small.json", "limits": { "delta": null, "v": 3 } })");
  const fs::path top = folder.write(
      "experiments/e.json",
      R"({ "note": "x", "world": { "extends": "../worlds/a.json", "m": 2 }, "list": [ { "extends": "../cars/small.json" } ] })");
  const Node node = load_json(top);
  EXPECT_EQ(content_text(node), R"({"list":[{"file":"car.csv","limits":{"d":1,"delta":2},"m":1}],)"
                                R"("world":{"file":"car.csv","limits":{"d":1,"v":3},"m":2}})");
  EXPECT_EQ(find_pointer(node, "/world/m")->origin.source->name, shown(top));
  EXPECT_EQ(find_pointer(node, "/world/m")->origin.pointer, "/world/m");
  EXPECT_EQ(find_pointer(node, "/world")->origin.source->name, shown(top));
  EXPECT_EQ(find_pointer(node, "/world/limits/v")->origin.pointer, "/limits/v");
  EXPECT_EQ(resolve_path(*find_pointer(node, "/world/file")), folder.path() / "cars/car.csv");
}

/// As the system opens it: `..` behind a linked folder is where the link leads to.
TEST(LoadJson, TheFolderAboveALinkedOneIsThatOfTheLinksTarget) {
  const Folder folder;
  (void)folder.write("there/inner/one.json", R"({"extends": "../base.json"})");
  (void)folder.write("here/base.json", R"({"from": "here"})");
  const fs::path base = fs::canonical(folder.write("there/base.json", R"({"from": "there"})"));
  fs::create_directory_symlink(folder.path() / "there/inner", folder.path() / "here/linked");
  const Node one = load_json(folder.path() / "here/linked/one.json");
  EXPECT_EQ(one.find("from")->text(), "there");
  EXPECT_EQ(one.find("from")->origin.source->name, base.string());
  EXPECT_EQ(without_dots(folder.path() / "here/linked/../base.json"), base);
  // Where no link is on the way, names stay as they were written.
  EXPECT_EQ(without_dots("a/b/../c.json"), "a/c.json");
  EXPECT_EQ(without_dots("../x/../c.json"), "../c.json");
  EXPECT_EQ(without_dots(folder.path() / "here/../there/./base.json"), folder.path() / "there/base.json");
}

TEST(LoadJson, AFileMayBeExtendedTwiceButNotByItself) {
  const Folder folder;
  (void)folder.write("base.json", R"({ "a": 1 })");
  const fs::path twice = folder.write("twice.json", R"({ "x": { "extends": "base.json" }, "extends": "base.json" })");
  EXPECT_EQ(content_text(load_json(twice)), R"({"a":1,"x":{"a":1}})");
  (void)folder.write("b.json", R"({ "extends": "c.json" })");
  (void)folder.write("c.json", R"({ "deep": [ { "extends": "./x/../b.json" } ] })");
  fs::create_directories(folder.path() / "x");
  try {
    (void)load_json(folder.write("a.json", R"({ "extends": "b.json" })"));
    FAIL();
  } catch (const InputError& error) {
    const std::string root = folder.path().generic_string();
    EXPECT_EQ(error.what(), root + "/c.json:1:26: /deep/0/extends: files extend each other in a circle: " + root +
                                "/b.json -> " + root + "/c.json -> " + root + "/b.json");
  }
}

TEST(LoadJson, ANoteIsNotInherited) {
  const Folder folder;
  (void)folder.write("base.json", R"({ "note": "about the base", "a": { "note": "about a", "b": 1 } })");
  EXPECT_EQ(to_json_text(load_json(folder.write("plain.json", R"({ "extends": "base.json" })"))),
            to_json_text(parse_text(R"({ "a": { "note": "about a", "b": 1 } })")));
  EXPECT_EQ(load_json(folder.write("own.json", R"({ "extends": "base.json", "note": "mine" })")).find("note")->text(),
            "mine");
}

TEST(LoadJson, APartOfAFileCanBeExtended) {
  const Folder folder;
  (void)folder.write("cars/base.json", R"({ "rows": { "far": { "file": "car.csv" } } })");
  (void)folder.write("stacks.json", R"({
    "extends": "cars/base.json", "list": [ 1, { "a/b": { "~": { "x": 1, "gone": 2, "none": null } } } ],
    "rows": { "best": { "note": "n", "extends": "stacks2.json", "p": { "k": 1, "l": 2 } }, "": { "e": 1 } } })");
  (void)folder.write("stacks2.json", R"({ "q": 3 })");
  const auto extended = [&](const std::string& name, const std::string& beside) {
    return load_json(folder.write("top.json", R"({ "s": { "extends": ")" + name + '"' + beside + " } }"));
  };
  EXPECT_EQ(content_text(extended("stacks.json#/rows/best", R"(, "p": { "l": null, "m": 4 })")),
            R"({"s":{"p":{"k":1,"m":4},"q":3}})");
  EXPECT_EQ(extended("stacks.json#/rows/best", "").find("s")->find("note"), nullptr);
  const Node listed = extended("stacks.json#/list/1/a~1b/~0", R"(, "gone": null)");
  EXPECT_EQ(content_text(listed), R"({"s":{"x":1}})");
  EXPECT_TRUE(find_pointer(listed, "/s/none")->is_null()) << "it removes what the stack is merged over";
  EXPECT_EQ(find_pointer(listed, "/s/x")->origin.pointer, "/list/1/a~1b/~0/x");
  EXPECT_EQ(content_text(extended("stacks.json#/rows/", "")), R"({"s":{"e":1}})") << "a key may be empty";
  // By way of what the file extends; and relative to the file in which it is written.
  const Node far = extended("stacks.json#/rows/far", "");
  EXPECT_EQ(resolve_path(*find_pointer(far, "/s/file")), folder.path() / "cars/car.csv");
}

TEST(LoadJson, TheNameOfAnExtendedFileMayHoldTheSignOfAPart) {
  const Folder folder;
  (void)folder.write("a#/b.json", R"({ "is": "in a folder" })");
  (void)folder.write("c#d.json", R"({ "part": { "is": "a part" }, "is": "whole" })");
  (void)folder.write("e#/f.json", R"({ "x#": { "y": { "is": "behind the second" } },
                                           "x##": { "y": { "is": "behind two" } } })");
  (void)folder.write("g", R"({ "h.json": { "is": "of the shorter name" } })");
  const auto what = [&](const std::string& name) {
    return load_json(folder.write("top.json", R"({ "extends": ")" + name + "\" }")).find("is")->text();
  };
  EXPECT_EQ(what("a#/b.json"), "in a folder");
  EXPECT_EQ(what("c#d.json"), "whole");
  EXPECT_EQ(what("c#d.json#/part"), "a part");
  EXPECT_EQ(what("e#/f.json#/x#/y"), "behind the second");
  EXPECT_EQ(what("g#/h.json"), "of the shorter name");
  EXPECT_EQ(what("c#d.json#"), "whole");
  EXPECT_EQ(what("e#/f.json#/x##/y"), "behind two");
  (void)folder.write("c#d.json#", R"({ "is": "a file with the sign at its end" })");
  EXPECT_EQ(what("c#d.json#"), "a file with the sign at its end");
}

TEST(LoadJson, APartThatIsNotThereIsToldOnceWithTheNearest) {
  const Folder folder;
  (void)folder.write("stacks.json", R"({ "stacks": { "best": { "n": 1 }, "oracle": null }, "list": [ {}, {} ] })");
  (void)folder.write("a#/b.json", "{}");
  const std::string root = folder.path().generic_string();
  const auto why = [&](const std::string& name) {
    const std::string message =
        why_not_loaded(folder.write("e.json", "{\n \"x\": { \"extends\": \"" + name + "\" } }"));
    const std::string place = root + "/e.json:2:20: /x/extends: ";
    EXPECT_EQ(message.rfind(place, 0), 0u) << message;
    return message.substr(std::min(place.size(), message.size()));
  };
  const std::string file = " of \"" + root + "/stacks.json\", ";
  EXPECT_EQ(why("stacks.json#/stacks/bst"),
            "nothing is at /stacks/bst" + file + "/stacks: no \"bst\" there; did you mean \"best\"?");
  EXPECT_EQ(why("stacks.json#/stack/best"),
            "nothing is at /stack/best" + file + "the top level: no \"stack\" there; did you mean \"stacks\"?");
  EXPECT_EQ(why("stacks.json#/list/2"),
            "nothing is at /list/2" + file + "/list: \"2\" is none of its 2 elements, counted from 0");
  EXPECT_EQ(why("stacks.json#/stacks/best/n/m"), "nothing is at /stacks/best/n/m" + file + "/stacks/best/n: it is 1");
  EXPECT_EQ(why("stacks.json#/stacks/oracle"),
            "\"stacks.json#/stacks/oracle\" holds null, expected an object to extend");
  EXPECT_EQ(why("stacks.json#/list"), "\"stacks.json#/list\" holds an array, expected an object to extend");
  EXPECT_THAT(why("stacks.json#/~2"), HasSubstr("\"/~2\" is not a JSON pointer"));
  EXPECT_EQ(why("#/stacks/best"), "expected the name of a file before the \"#\" of \"#/stacks/best\"");
  EXPECT_EQ(why("stack.json#/stacks/best"), "\"stack.json\": no such file; did you mean \"stacks.json\"?");
  EXPECT_EQ(why("stacks.json#stacks"),
            "no such file: \"stacks.json#stacks\"; a part of \"stacks.json\" is named by a "
            "JSON pointer, which begins with \"#/\"");
  EXPECT_THAT(why("stack.json#"), HasSubstr("no such file"));
  EXPECT_THAT(why("e.json#"), HasSubstr("files extend each other in a circle: "));
  EXPECT_EQ(why("a#/c.json"), "\"a#/c.json\": no such file; did you mean \"b.json\"?");
  EXPECT_THAT(why("e.json#/x"), HasSubstr("files extend each other in a circle: "));
}

TEST(LoadJson, LongNamesOfFilesAreRefused) {
  const Folder folder;
  (void)folder.write("b.json", "{}");
  const auto why = [&](const std::string& name) {
    return why_not_loaded(folder.write("e.json", "{ \"extends\": \"" + name + "\" }"));
  };
  const std::string told = "a file's name of 4097 bytes; the longest that is read has 4096";
  EXPECT_THAT(why(std::string(json_limits.name + 1, 'x')), HasSubstr(told));
  EXPECT_THAT(why("b.json#/" + std::string(json_limits.name - 7, 'x')), HasSubstr(told));
  EXPECT_THAT(why("b.json#/" + std::string(json_limits.name - 8, 'x')), HasSubstr("nothing is at "));
  EXPECT_THAT(why(std::string(json_limits.name, 'x')), HasSubstr("/extends: \"xxx"));
  Node node(std::string(json_limits.name + 1, 'x'));
  EXPECT_THROW(inline_file(node), InputError);
}

TEST(LoadJson, AnExtendsCanBeTakenBack) {
  const Folder folder;
  EXPECT_EQ(content_text(load_json(folder.write("a.json", R"({ "extends": null, "a": 1 })"))), R"({"a":1})");
}

TEST(InlineFile, PutsAFileInThePlaceOfItsName) {
  const Folder folder;
  (void)folder.write("w/world.json", R"({ "extends": "base.json", "dt": 1 })");
  (void)folder.write("w/base.json", R"({ "laps": 2 })");
  Node node =
      load_json(folder.write("e.json", R"({ "world": "w/world.json", "inline": { "a": 1 }, "bad": "w/wrld.json" })"));
  inline_file(*node.find("world"));
  inline_file(*node.find("inline"));
  EXPECT_EQ(content_text(*node.find("world")), R"({"dt":1,"laps":2})");
  EXPECT_EQ(content_text(*node.find("inline")), R"({"a":1})");
  try {
    inline_file(*node.find("bad"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("e.json:1:57: /bad: \"w/wrld.json\": no such file; did you mean \"world.json\"?"));
  }
}

TEST(JsonText, IsReadBackAsTheSameTreeAndTheSameBytes) {
  const Node node = parse_text(everything);
  const std::string text = to_json_text(node);
  const Node again = parse_text(text);
  EXPECT_TRUE(same(node, again));
  EXPECT_EQ(to_json_text(again), text);
  EXPECT_TRUE(nlohmann::json::accept(text));
}

TEST(JsonText, HasThisForm) {
  EXPECT_EQ(to_json_text(parse_text(R"({"b":[1,{"x":true}],"a":{},"c":[],"d":"é\n"})")),
            "{\n  \"b\": [\n    1,\n    {\n      \"x\": true\n    }\n  ],\n  \"a\": {},\n  \"c\": [],\n  \"d\": "
            "\"é\\n\"\n}\n");
}

TEST(JsonText, KeepsEveryBitOfANumber) {
  std::mt19937_64 random(3);
  for (int round = 0; round < 20000; ++round) {
    const double value = round % 2 == 0 ? std::bit_cast<double>(random()) : static_cast<double>(random() >> 11U);
    if (!std::isfinite(value)) continue;
    const Node again = parse_text(number_text(value));
    ASSERT_EQ(std::bit_cast<std::uint64_t>(again.number()), std::bit_cast<std::uint64_t>(value)) << number_text(value);
  }
  EXPECT_EQ(number_text(4), "4");
  EXPECT_EQ(number_text(100000), "100000");
  EXPECT_EQ(number_text(0.02), "0.02");
  EXPECT_EQ(number_text(0.0), "0");
  EXPECT_EQ(number_text(-0.0), "-0.0");
  EXPECT_EQ(number_text(1e300), "1e+300");
  EXPECT_THROW((void)number_text(std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
}

TEST(JsonText, OfTreesMadeByTheProgram) {
  Node node;
  node.set("seed", Node(7)).origin.line = 3;
  node.set("name", Node("elm"));
  node.set("on", Node(true));
  node.set("list", Node(Node::Array{Node(1.5), Node::null()}));
  node.set("seed", Node(8U));
  node.erase("name");
  EXPECT_EQ(to_json_text(node), "{\n  \"seed\": 8,\n  \"on\": true,\n  \"list\": [\n    1.5,\n    null\n  ]\n}\n");
}

TEST(ContentText, IgnoresOrderNotesAndRemovedMembers) {
  const Node a = parse_text(R"({ "b": 1.0, "a": { "note": "x", "y": [null, 2] }, "gone": null })");
  const Node b = parse_text(R"({ "a": { "y": [null, 2e0] }, "note": ["other"], "b": 1 })");
  EXPECT_EQ(content_text(a), R"({"a":{"y":[null,2]},"b":1})");
  EXPECT_EQ(content_text(a), content_text(b));
}

struct DecimalComma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
};

TEST(Json, DoesNotDependOnTheLocale) {
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new DecimalComma));
  const std::string c_before = std::setlocale(LC_NUMERIC, nullptr);
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "de_DE"}) {
    if (std::setlocale(LC_NUMERIC, name) != nullptr) break;
  }
  const Node node = parse_text("[1234567.5, 1.5e-3]");
  const std::string text = content_text(node);
  std::setlocale(LC_NUMERIC, c_before.c_str());
  std::locale::global(before);
  EXPECT_EQ(node.array()[0].number(), 1234567.5);
  EXPECT_EQ(node.array()[1].number(), 0.0015);
  EXPECT_EQ(text, "[1234567.5,0.0015]");
}

// Examples published with FIPS 180 and, for the lengths around a block, by sha256sum.
TEST(Sha256, OfPublishedExamples) {
  EXPECT_EQ(sha256_hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256_hex(std::string(1000000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  EXPECT_EQ(sha256_hex(std::string(55, 'x')), "d5e285683cd4efc02d021a5c62014694958901005d6f71e89e0989fac77e4072");
  EXPECT_EQ(sha256_hex(std::string(56, 'x')), "04c26261370ee7541549d16dee320c723e3fd14671e66a099afe0a377c16888e");
  EXPECT_EQ(sha256_hex(std::string(63, 'x')), "75220b47218278e656f2013bb8f0c455a25eaf01e86c64924e9d48d89776d6f2");
  EXPECT_EQ(sha256_hex(std::string(64, 'x')), "7ce100971f64e7001e8fe5a51973ecdfe1ced42befe7ee8d5fd6219506b5393c");
  EXPECT_EQ(sha256_hex(std::string(65, 'x')), "9537c5fdf120482f7d58d25e9ed583f52c02b4e304ea814db1633ad565aed7e9");
  EXPECT_EQ(sha256_hex(std::string(119, 'x')), "000b48d4edf0fa7bee3c6236ecd2785baa5db4eeb8bb54341b029e0d9fa5fb0c");
  EXPECT_EQ(sha256_hex(std::string(120, 'x')), "13f05a0b594787f5ecd315edc96141bd3243203d1b7d4f0836f37308b276ba98");
}

TEST(Sha256, OfAFile) {
  const Folder folder;
  EXPECT_EQ(sha256_of_file(folder.write("abc", "abc")), sha256_hex("abc"));
  EXPECT_THROW((void)sha256_of_file(folder.path() / "missing"), InputError);
}

}  // namespace test_json_file
}  // namespace gripline
