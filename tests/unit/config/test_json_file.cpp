#include "config/json_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include "config/errors.hpp"
#include "config/files.hpp"

namespace gripline {
namespace test_json_file {

namespace fs = std::filesystem;
using testing::HasSubstr;

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
            "there is no value at /stacks/bst" + file + "/stacks: no \"bst\" there; did you mean \"best\"?");
  EXPECT_EQ(why("stacks.json#/stack/best"),
            "there is no value at /stack/best" + file + "the top level: no \"stack\" there; did you mean \"stacks\"?");
  EXPECT_EQ(why("stacks.json#/list/2"),
            "there is no value at /list/2" + file + "/list: \"2\" is not one of its 2 elements, counted from 0");
  EXPECT_EQ(why("stacks.json#/stacks/best/n/m"),
            "there is no value at /stacks/best/n/m" + file + "/stacks/best/n: it is 1");
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
  EXPECT_THAT(why("b.json#/" + std::string(json_limits.name - 8, 'x')), HasSubstr("there is no value at "));
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

}  // namespace test_json_file
}  // namespace gripline
