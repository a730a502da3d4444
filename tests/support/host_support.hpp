// What tests of the host share: the built plugins, a small world and a driver from JSON, a folder of one's own.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "config/errors.hpp"
#include "config/json_file.hpp"
#include "config/merge_patch.hpp"
#include "plugin/registry.hpp"
#include "race/stack.hpp"
#include "support/paths.hpp"
#include "support/published_car.hpp"
#include "world/world_spec.hpp"

namespace gripline::testing_support {

/// Folder of one fixture library, or of several: tests/plugins/<name> in the build tree.
inline std::filesystem::path fixture_plugins(const std::string& name) {
  return build_dir() / "tests" / "plugins" / name;
}

/// The product's plugins with those that spy, those that go wrong and those that do harm.
inline const Registry& plugins() {
  static const Registry all(
      {plugin_dir(), fixture_plugins("spies"), fixture_plugins("faults"), fixture_plugins("hostile")});
  return all;
}

/// JSON whose relative paths start at worlds/.
inline Node json(std::string_view text) { return parse_text(text, "test", source_dir() / "worlds"); }

/// One second of the 1:43 car, plant `dynamic`, on an oval of 9.03 m: 2 m straights, bends of 0.8 m to the left, 0.3 m
/// to either edge; it starts at the origin towards +x.
inline Node small_world() {
  return json(R"({
    "car": "cars/orca_1_43.json",
    "track": {"half_width": 0.3, "segments": [
      {"line": 2}, {"arc": {"radius": 0.8, "turn": "180 deg"}},
      {"line": 2}, {"arc": {"radius": 0.8, "turn": "180 deg"}}]},
    "dt": "20 ms",
    "plant": {"plugin": "dynamic", "params": )" +
              published_tyres_json + R"(},
    "duration": "1 s"
  })");
}

/// The small world changed by a JSON merge patch. Throws InputError.
inline WorldSpec world_of(std::string_view patch = "{}", const Registry& registry = plugins()) {
  Node tree = merge(small_world(), json(patch));
  inline_world_files(tree);
  Errors errors;
  WorldSpec spec = read_world(tree, registry, errors);
  errors.throw_if_any();
  return spec;
}

/// A pure pursuit driver without an estimator, changed by a JSON merge patch. Throws InputError.
inline StackSpec stack_of(const CarFile& car, std::string_view patch = "{}", const Registry& registry = plugins()) {
  const Node base = json(R"({"model": {"plugin": "ekinematic"},
    "planner": {"plugin": "fixed_speed", "params": {"mu": 0.3}}, "controller": {"plugin": "pure_pursuit"}})");
  Errors errors;
  StackSpec spec = read_stack("driver", merge(base, json(patch)), registry, car, errors);
  errors.throw_if_any();
  return spec;
}

/// What an InputError or a PluginError of f says; "nothing" when it throws none.
template <class F>
std::string refusal(F&& f) {
  try {
    f();
  } catch (const InputError& error) {
    return error.what();
  } catch (const PluginError& error) {
    return error.what();
  }
  return "nothing";
}

inline std::string contents(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline std::vector<std::string> lines(const std::filesystem::path& file) {
  std::vector<std::string> all;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) all.push_back(line);
  return all;
}

inline void write_text(const std::filesystem::path& file, std::string_view text) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << text;
}

/// A folder that is empty at first and gone afterwards; its name holds the test's.
class Folder {
 public:
  Folder() {
    const auto* const test = testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string("gripline_") + test->test_suite_name() + "_" + test->name();
    for (char& c : name)
      if (c == '/') c = '_';
    path_ = std::filesystem::path(testing::TempDir()) / name;
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace gripline::testing_support
