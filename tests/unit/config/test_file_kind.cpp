#include "config/file_kind.hpp"

#include <gtest/gtest.h>

#include "support/host_support.hpp"
#include "support/paths.hpp"

namespace gripline {
namespace test_file_kind {

using namespace testing_support;

TEST(FileKind, ShowsInTheKeys) {
  const std::filesystem::path worlds = source_dir() / "worlds";
  EXPECT_EQ(kind_of(load_json(worlds / "ethz.json")), FileKind::world);
  EXPECT_EQ(kind_of(load_json(worlds / "tracks/hill.json")), FileKind::track);
  EXPECT_EQ(kind_of(load_json(worlds / "cars/full_size.json")), FileKind::car);
  for (const auto& entry : std::filesystem::directory_iterator(worlds / "friction"))
    EXPECT_EQ(kind_of(load_json(entry.path())), FileKind::friction) << entry.path();
  for (const auto& entry : std::filesystem::directory_iterator(source_dir() / "experiments")) {
    if (entry.path().extension() != ".json") continue;
    EXPECT_EQ(kind_of(load_json(entry.path())), FileKind::experiment) << entry.path();
  }
  for (const auto& entry : std::filesystem::directory_iterator(source_dir() / "experiments/real/maps"))
    EXPECT_EQ(kind_of(load_json(entry.path())), FileKind::log_map) << entry.path();
  EXPECT_EQ(kind_of(json(R"({"kind": null, "plant": {}})")), FileKind::world) << "null is absent";
  EXPECT_EQ(kind_of(json("[1]")), FileKind::unknown);
  EXPECT_EQ(kind_of(json(R"({"a": 1})")), FileKind::unknown);
}

TEST(FileKind, TheWrongOneIsOneLine) {
  EXPECT_EQ(refusal([] { expect_kind(json(R"({"plant": {}})"), FileKind::experiment); }),
            "test: is a world, expected an experiment");
  EXPECT_NO_THROW(expect_kind(json("{}"), FileKind::world));
  Node world = json(R"({"car": "tracks/hill.json"})");
  EXPECT_EQ(refusal([&] { inline_world_files(world); }),
            "test:1:9: /car: \"tracks/hill.json\" is a track, expected a car");
}

}  // namespace test_file_kind
}  // namespace gripline
