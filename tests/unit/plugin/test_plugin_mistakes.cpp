// What the SDK refuses at compile time: the compiler that built gripline is asked.
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "support/program.hpp"

namespace gripline {
namespace test_plugin_mistakes {

using namespace testing_support;

std::string errors_of(const std::filesystem::path& source, bool good) {
  std::vector<std::string> words = {compiler(), "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Werror"};
  if (compiler().filename().string().find("clang") != std::string::npos) words.push_back("-ferror-limit=0");
  words.insert(words.end(), {"-I", source_dir() / "framework/include", source});
  const Outcome outcome = run_program(words);
  EXPECT_EQ(outcome.code == 0, good) << outcome.err;
  return outcome.err;
}

/// How often each sentence of a failed static_assert stands among the errors.
std::map<std::string, int> count(const std::map<std::string, int>& sentences, const std::string& errors) {
  std::map<std::string, int> found;
  std::stringstream lines(errors);
  for (std::string line; std::getline(lines, line);) {
    if (line.find("error: static") == std::string::npos) continue;
    bool known = false;
    for (const auto& [sentence, times] : sentences) {
      if (line.find(sentence) == std::string::npos) continue;
      ++found[sentence];
      known = true;
    }
    if (!known) ++found[line];
  }
  return found;
}

TEST(PluginMistakes, EachIsRefusedWithItsSentenceAndNothingElseIs) {
  const std::filesystem::path source = fixture_dir() / "sdk/mistakes.cpp";
  std::map<std::string, int> expected;
  std::ifstream in(source);
  const std::string mark = "// refused: ";
  for (std::string line; std::getline(in, line);)
    if (line.rfind(mark, 0) == 0) ++expected[line.substr(mark.size())];
  ASSERT_GE(expected.size(), 15u);
  EXPECT_EQ(count(expected, errors_of(source, false)), expected);
}

TEST(PluginMistakes, TheExamplesAtTheHeadOfTheHeaderAreNone) {
  const Folder folder;
  std::ifstream in(source_dir() / "framework/include/gripline/plugin.hpp");
  const std::string begin = "/// \\code", end = "/// \\endcode";
  std::string code;
  int examples = 0;
  bool inside = false;
  for (std::string line; std::getline(in, line);) {
    if (line == begin) {
      inside = true;
      code = "#include <gripline/plugin.hpp>\n";
    } else if (line == end) {
      inside = false;
      ++examples;
      write_text(folder / "example.cpp", code);
      EXPECT_EQ(errors_of(folder / "example.cpp", true), "") << code;
    } else if (inside) {
      code += line.substr(std::min<std::size_t>(line.size(), 3)) + "\n";
    }
  }
  EXPECT_EQ(examples, 2);
}

TEST(PluginMistakes, AStructWithAMemberThatIsNotListedDoesNotCompile) {
  const Folder folder;
  const auto edited = [&](const std::string& header, const std::string& from, const std::string& to) {
    std::filesystem::remove_all(folder / "gripline");
    std::filesystem::copy(source_dir() / "framework/include/gripline", folder / "gripline",
                          std::filesystem::copy_options::recursive);
    std::string text = contents(folder / "gripline" / header);
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    write_text(folder / "gripline" / header, text.replace(at, from.size(), to));
    write_text(folder / "use.cpp",
               "#include \"gripline/abi_layout.hpp\"\n"
               "constexpr auto hash = gripline::abi::layout_hash();\n");
    return run_program({compiler(), "-std=c++20", "-fsyntax-only", "-I", folder.path(), folder / "use.cpp"}).err;
  };
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) == std::string::npos ? text : part;
  };
  EXPECT_EQ(edited("types.hpp", "struct Input {", "struct  Input {"), "");
  const std::string member = "a member of Input is not listed in abi_layout.hpp";
  EXPECT_EQ(has(edited("types.hpp", "struct Input {", "struct Input { double clutch = 0;"), member), member);
  const std::string listed = "a member of Quantities<T> is not listed in abi_layout.hpp";
  EXPECT_EQ(has(edited("types.hpp", "  T yaw;", "  T roll;\n  T yaw;"), listed), listed);
  const std::string value = "enumeration value";
  EXPECT_EQ(has(edited("types.hpp", "rear = 1", "middle = 2, rear = 1"), value), value);
  const std::string type = "a struct or an enumeration that crosses is not listed in abi_layout.hpp";
  EXPECT_EQ(has(edited("interfaces.hpp", "virtual double factor() const = 0;",
                       "struct Wet { double depth; };\n  virtual Wet factor() const = 0;"),
                type),
            type);
}

}  // namespace test_plugin_mistakes
}  // namespace gripline
