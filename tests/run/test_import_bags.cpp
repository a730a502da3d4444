// gripline import of recordings of ROS: bags written here byte by byte, by SQLite and, where it is installed, by ROS's
// own library; what comes out is what went in, and files that are broken anywhere are refused with one message.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "bags/bag_table.hpp"
#include "bags/open_bag.hpp"
#include "config/errors.hpp"
#include "support/bag_writing.hpp"
#include "support/paths.hpp"
#include "support/program.hpp"
#include "tables/delimited_table.hpp"
#ifdef GRIPLINE_SQLITE
#include <sqlite3.h>
#endif
#ifdef GRIPLINE_BZIP2
#include <bzlib.h>
#endif
#ifdef GRIPLINE_LZ4
#include <lz4frame.h>
#endif
#ifdef GRIPLINE_ROSBAG
#include <rosbag/bag.h>
#endif

namespace gripline {
namespace test_import_bags {

namespace fs = std::filesystem;
using namespace testing_support;
using bags::Wire;
using testing::AllOf;
using testing::HasSubstr;

// --- ROS 1 bags ------------------------------------------------------------------------------------------------------

template <class T>
std::string raw(T value) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  return bytes;
}
std::string raw_time(std::int64_t time) {
  return raw(static_cast<std::uint32_t>(time / 1'000'000'000)) + raw(static_cast<std::uint32_t>(time % 1'000'000'000));
}
std::string sized(const std::string& bytes) { return raw(static_cast<std::uint32_t>(bytes.size())) + bytes; }
std::string members(const std::vector<std::pair<std::string, std::string>>& all) {
  std::string out;
  for (const auto& [name, value] : all) {
    std::string member = name;
    member += '=';
    out += sized(member + value);
  }
  return out;
}
std::string record(char op, std::vector<std::pair<std::string, std::string>> header, const std::string& data) {
  header.emplace_back("op", std::string(1, op));
  return sized(members(header)) + sized(data);
}
std::string connection(std::size_t id, const bags::Topic& topic) {
  return record(
      7, {{"conn", raw(static_cast<std::uint32_t>(id))}, {"topic", topic.name}},
      members(
          {{"topic", topic.name}, {"type", topic.type}, {"md5sum", "*"}, {"message_definition", topic.definition}}));
}

std::string packed(const std::string& chunk, [[maybe_unused]] const std::string& how) {
#ifdef GRIPLINE_BZIP2
  if (how == "bz2") {
    std::string out(chunk.size() + 1000, '\0');
    auto size = static_cast<unsigned>(out.size());
    BZ2_bzBuffToBuffCompress(out.data(), &size, const_cast<char*>(chunk.data()), static_cast<unsigned>(chunk.size()), 9,
                             0, 30);
    return out.substr(0, size);
  }
#endif
#ifdef GRIPLINE_LZ4
  if (how == "lz4") {
    std::string out(LZ4F_compressFrameBound(chunk.size(), nullptr), '\0');
    return out.substr(0, LZ4F_compressFrame(out.data(), out.size(), chunk.data(), chunk.size(), nullptr));
  }
#endif
  return chunk;
}

struct BagForm {
  std::string compression = "none", encryptor = "";
  bool index = true;
  bool last_chunk_twice = false;
};

/// A bag of format 2.0 with chunks of 500 messages.
std::string ros1_bytes(const Recording& all, const BagForm& form = {}) {
  const auto bag_record = [&](std::uint64_t index, std::size_t chunks) {
    const std::string header = members({{"op", std::string(1, 3)},
                                        {"index_pos", raw(index)},
                                        {"conn_count", raw(static_cast<std::uint32_t>(all.topics.size()))},
                                        {"chunk_count", raw(static_cast<std::uint32_t>(chunks))},
                                        {"encryptor", form.encryptor}});
    return "#ROSBAG V2.0\n" + sized(header) + sized(std::string(4096 - header.size(), ' '));
  };
  std::string out = bag_record(0, 0), infos, last_info;
  std::size_t chunks = 0;
  for (std::size_t begin = 0; begin < all.messages.size(); begin += 500, ++chunks) {
    const std::size_t end = std::min(begin + 500, all.messages.size());
    std::string chunk;
    std::vector<std::uint32_t> counts(all.topics.size(), 0);
    for (std::size_t m = begin; m < end; ++m) {
      const Recorded& message = all.messages[m];
      if (counts[message.topic]++ == 0) chunk += connection(message.topic, all.topics[message.topic]);
      chunk += record(2, {{"conn", raw(static_cast<std::uint32_t>(message.topic))}, {"time", raw_time(message.time)}},
                      std::string(reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size()));
    }
    std::string per_topic;
    for (std::size_t t = 0; t < counts.size(); ++t)
      if (counts[t] > 0) per_topic += raw(static_cast<std::uint32_t>(t)) + raw(counts[t]);
    last_info = record(6,
                       {{"ver", raw(std::uint32_t{1})},
                        {"chunk_pos", raw(std::uint64_t{out.size()})},
                        {"start_time", raw_time(all.messages[begin].time)},
                        {"end_time", raw_time(all.messages[end - 1].time)},
                        {"count", raw(static_cast<std::uint32_t>(per_topic.size() / 8))}},
                       per_topic);
    infos += last_info;
    out += record(5, {{"compression", form.compression}, {"size", raw(static_cast<std::uint32_t>(chunk.size()))}},
                  packed(chunk, form.compression));
  }
  if (form.last_chunk_twice) infos += last_info, ++chunks;
  if (!form.index) return out;
  const std::string first = bag_record(out.size(), chunks);
  out.replace(0, first.size(), first);
  for (std::size_t t = 0; t < all.topics.size(); ++t) out += connection(t, all.topics[t]);
  return out + infos;
}

#ifdef GRIPLINE_SQLITE

/// Runs a statement; values are bound in order.
void run_sql(sqlite3* database, const char* text) {
  char* problem = nullptr;
  ASSERT_EQ(sqlite3_exec(database, text, nullptr, nullptr, &problem), SQLITE_OK) << text << ": " << problem;
}

/// A database as rosbag2's plugin sqlite3 writes it; with `definitions` as from Iron on.
void write_rosbag2(const fs::path& file, const Recording& all, bool definitions = false,
                   const std::string& format = "cdr") {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  run_sql(
      database,
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT "
      "NOT NULL, offered_qos_profiles TEXT NOT NULL);"
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB "
      "NOT NULL);"
      "CREATE INDEX timestamp_idx ON messages (timestamp ASC); BEGIN");
  if (definitions)
    run_sql(
        database,
        "CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL, "
        "encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL)");
  for (std::size_t t = 0; t < all.topics.size(); ++t) {
    const bags::Topic& topic = all.topics[t];
    run_sql(database, ("INSERT INTO topics VALUES(" + std::to_string(t + 1) + ", '" + topic.name + "', '" + topic.type +
                       "', '" + format + "', '')")
                          .c_str());
    if (definitions)
      run_sql(database, ("INSERT INTO message_definitions(topic_type, encoding, encoded_message_definition, "
                         "type_description_hash) VALUES('" +
                         topic.type + "', 'ros2msg', '" + topic.definition + "', '')")
                            .c_str());
  }
  sqlite3_stmt* insert = nullptr;
  sqlite3_prepare_v2(database, "INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", -1, &insert, nullptr);
  for (const Recorded& message : all.messages) {
    sqlite3_bind_int64(insert, 1, static_cast<std::int64_t>(message.topic) + 1);
    sqlite3_bind_int64(insert, 2, message.time);
    sqlite3_bind_blob(insert, 3, message.bytes.data(), static_cast<int>(message.bytes.size()), SQLITE_STATIC);
    ASSERT_EQ(sqlite3_step(insert), SQLITE_DONE);
    sqlite3_reset(insert);
  }
  sqlite3_finalize(insert);
  run_sql(database, "COMMIT");
  sqlite3_close(database);
}

#endif

// --- what comes out --------------------------------------------------------------------------------------------------

class ImportBags : public testing::Test {
 protected:
  ImportBags() { std::ofstream(map_) << weaving_map(); }
  fs::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }
  Outcome import(const fs::path& bag, std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {"import", bag, "--map", map_, "--out", folder_ / "out.csv"};
    words.insert(words.end(), more.begin(), more.end());
    return gripline_with(words);
  }
  /// The log that import wrote, against the car that was recorded.
  void expect_the_car() const {
    const DelimitedTable t = read_delimited(folder_ / "out.csv");
    ASSERT_EQ(t.rows(), 801u);
    const auto at = [&](const char* name, std::size_t row) {
      return t.column.at(static_cast<std::size_t>(t.find(name)))[row];
    };
    for (std::size_t r = 0; r < 800; ++r) {
      const double now = at("t_s", r);
      ASSERT_NEAR(now, 0.05 * static_cast<double>(r), 2e-6);
      ASSERT_NEAR(at("yaw_rad", r), Weaving::yaw(now), 1e-6) << "unwrapped";
      ASSERT_NEAR(at("yaw_rate_radps", r), Weaving::rate(now), 1e-6);
      ASSERT_NEAR(at("vx_mps", r), 10.0, 1e-9);
      ASSERT_NEAR(at("delta_rad", r), Weaving::steer(now), 1e-4);
      ASSERT_NEAR(at("d", r), Weaving::throttle(now), 2e-5);
    }
    EXPECT_EQ(at("x_m", 0), 5.0);
    EXPECT_EQ(at("y_m", 0), -2.0);
  }
  Folder folder_;
  fs::path map_ = folder_ / "map.json";
};

TEST_F(ImportBags, ARosOneBagComesBackAsTheCarThatWasRecorded) {
  std::vector<std::string> compressions = {"none"};
#ifdef GRIPLINE_BZIP2
  compressions.emplace_back("bz2");
#endif
#ifdef GRIPLINE_LZ4
  compressions.emplace_back("lz4");
#endif
  for (const std::string& compression : compressions) {
    const auto bag =
        write("drive.bag", ros1_bytes(weaving_recording(Wire::ros1), {.compression = compression, .encryptor = ""}));
    const Outcome outcome = import(bag);
    ASSERT_EQ(outcome.code, 0) << compression << outcome.err;
    EXPECT_THAT(outcome.out, AllOf(HasSubstr("rows are messages of /odom"), HasSubstr("recorded 4 ms later")));
    expect_the_car();
  }
}

/// The table that the map reads serves fit and predict, which read no bags themselves, with the same map.
TEST_F(ImportBags, TheTableOfABagIsReadWithTheSameMap) {
  const auto bag = write("drive.bag", ros1_bytes(weaving_recording(Wire::ros1)));
  ASSERT_EQ(import(bag, {"--table", folder_ / "drive.csv"}).code, 0);
  const std::string direct = contents(folder_ / "out.csv");
  ASSERT_EQ(import(folder_ / "drive.csv").code, 0);
  EXPECT_EQ(contents(folder_ / "out.csv"), direct);
  const Outcome refused = gripline_with({"fit", source_dir() / "worlds/av21.json", bag, "--map", map_});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("the file is a bag of ROS; expected a table in text"));
}

TEST_F(ImportBags, AGuessedMapReadsTheBag) {
  const auto bag = write("drive.bag", ros1_bytes(weaving_recording(Wire::ros1)));
  const Outcome guessed = gripline_with({"import", "--guess", bag, "--out", folder_ / "guess.json"});
  ASSERT_EQ(guessed.code, 0) << guessed.err;
  const Outcome outcome = gripline_with({"import", bag, "--map", folder_ / "guess.json", "--out", folder_ / "out.csv"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, AllOf(HasSubstr("delay"), HasSubstr("rows are messages of /odom")));
}

std::string why(const fs::path& file) {
  try {
    const auto bag = tools::open_bag(file);
    bags::read_table(*bag, {{"/odom.pose.pose.position.x", false, false, {}}}, {});
  } catch (const InputError& e) {
    return e.what();
  }
  return "read";
}

TEST_F(ImportBags, BagsThatCannotBeReadAreToldInOneMessage) {
  const Recording all = weaving_recording(Wire::ros1, 3.0);
  const std::string whole = ros1_bytes(all);
  const auto told = [&](const std::string& bytes) { return why(write("a.bag", bytes)); };
  EXPECT_EQ(told(whole), "read");
  EXPECT_EQ(told(ros1_bytes(all, {.compression = "none", .encryptor = "", .index = false})),
            (folder_ / "a.bag").string() + ": no index: the recording was not ended (rosbag reindex mends a copy)");
  EXPECT_THAT(told(ros1_bytes(all, {.compression = "none", .encryptor = "", .index = true, .last_chunk_twice = true})),
              HasSubstr("truncated or broken: its index names one chunk twice"));
  EXPECT_THAT(told(ros1_bytes(all, {.compression = "none", .encryptor = "rosbag/AesCbcEncryptor"})),
              HasSubstr("encrypted (rosbag/AesCbcEncryptor)"));
  EXPECT_THAT(told(ros1_bytes(all, {.compression = "zip", .encryptor = ""})),
              HasSubstr("packed in an unknown way, \"zip\""));
  EXPECT_THAT(told(whole.substr(0, whole.size() - 10)), HasSubstr("truncated or broken"));
  EXPECT_THAT(told("#ROSBAG V1.2\n" + whole.substr(13)), HasSubstr("another format, \"#ROSBAG V1.2\""));
  EXPECT_THAT(told("t,x\n1,2\n"), HasSubstr("neither a ROS 1 bag nor a rosbag2 database"));
  EXPECT_THAT(why(folder_ / "none.bag"), HasSubstr("no such file"));
  const Outcome without_map = gripline_with({"import", write("a.bag", whole)});
  EXPECT_EQ(without_map.code, 2);
  EXPECT_THAT(without_map.err, HasSubstr("a bag needs a map of its topics"));
  const Outcome mcap = gripline_with({"import", write("a.mcap", "\x89MCAP0"), "--map", map_});
  EXPECT_EQ(mcap.code, 2);
  EXPECT_THAT(mcap.err, HasSubstr("MCAP is not read (ros2 bag convert makes a .db3 of it)"));
}

/// Recordings of a drive are larger than any text.
TEST_F(ImportBags, BagsMayBeLargerThanTexts) {
  const auto file = write("large.bag", ros1_bytes(weaving_recording(Wire::ros1, 3.0)));
  fs::resize_file(file, (std::uintmax_t{256} << 20U) + 1);  // a hole behind its end, which takes no room
  EXPECT_THAT(why(file), testing::Not(HasSubstr("is larger than")));
}

/// Every length and position of a bag made large, small or random: an answer or a refusal, never more.
TEST_F(ImportBags, BrokenBytesAreRefusedOrReadAndNothingElse) {
  const std::string whole = ros1_bytes(weaving_recording(Wire::ros1, 1.0));
  std::mt19937 random(15);
  std::size_t refused = 0;
  for (int k = 0; k < 600; ++k) {
    std::string bytes = whole;
    for (int changes = 1 + k % 3; changes > 0; --changes) {
      // The first record's padding is passed over: half of the changes fall behind it, half in the index.
      const std::size_t from = k % 2 == 0 ? 4096 : bytes.size() - 6000;
      const std::size_t at = from + random() % (bytes.size() - from - 4);
      const std::uint32_t value = k % 5 == 0   ? 0xFFFFFFFF
                                  : k % 5 == 1 ? 0x7FFFFFFF
                                               : static_cast<std::uint32_t>(random());
      if (k % 5 < 3)
        bytes.replace(at, 4, raw(value));
      else
        bytes[at] = static_cast<char>(value);
    }
    if (k % 7 == 0) bytes.resize(random() % bytes.size());
    refused += why(write("broken.bag", bytes)) != "read";
  }
  EXPECT_GT(refused, 150u);
}

#ifdef GRIPLINE_SQLITE

TEST_F(ImportBags, ARosTwoDatabaseComesBackAsTheCarThatWasRecorded) {
  write_rosbag2(folder_ / "old.db3", weaving_recording(Wire::cdr, 40.0, false));
  ASSERT_EQ(import(folder_ / "old.db3").code, 0);
  expect_the_car();
  // With definitions in the file, of a type that is nowhere else.
  Recording own = weaving_recording(Wire::cdr);
  own.topics[2].type = "my_msgs/msg/Pedal";
  write_rosbag2(folder_ / "new.db3", own, true);
  const Outcome outcome = import(folder_ / "new.db3");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  expect_the_car();
}

TEST_F(ImportBags, AFolderOfDefinitionsServesADatabaseWithoutThem) {
  Recording own = weaving_recording(Wire::cdr);
  own.topics[2].type = "my_msgs/msg/Pedal";
  write_rosbag2(folder_ / "own.db3", own);
  EXPECT_THAT(import(folder_ / "own.db3").err, HasSubstr("its type my_msgs/Pedal is not defined in the file"));
  fs::create_directories(folder_ / "msgs/my_msgs/msg");
  std::ofstream(folder_ / "msgs/my_msgs/msg/Pedal.msg") << "float64 data\n";
  std::string map = weaving_map();
  map.replace(map.find(R"("bag": {)"), 8, R"("bag": {"definitions": "msgs", )");
  std::ofstream(map_) << map;
  const Outcome outcome = import(folder_ / "own.db3");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  expect_the_car();
}

TEST_F(ImportBags, OtherDatabasesAreToldApart) {
  sqlite3* database = nullptr;
  sqlite3_open((folder_ / "notes.db3").c_str(), &database);
  run_sql(database, "CREATE TABLE notes(text TEXT); CREATE TABLE tags(text TEXT)");
  sqlite3_close(database);
  EXPECT_THAT(why(folder_ / "notes.db3"), HasSubstr("expected the tables topics and messages, found notes, tags"));
  write_rosbag2(folder_ / "other.db3", weaving_recording(Wire::cdr, 1.0), false, "ros_v1");
  EXPECT_THAT(why(folder_ / "other.db3"), HasSubstr("serialized as \"ros_v1\"; expected cdr"));
  Recording empty = weaving_recording(Wire::cdr, 1.0);
  empty.messages.clear();
  write_rosbag2(folder_ / "empty.db3", empty);
  EXPECT_THAT(why(folder_ / "empty.db3"), HasSubstr("it holds no messages"));
  Recording early = weaving_recording(Wire::cdr, 1.0);
  early.messages[0].time = -5;
  write_rosbag2(folder_ / "early.db3", early);
  EXPECT_THAT(why(folder_ / "early.db3"), HasSubstr("expected nanoseconds since 1970"));
  write_rosbag2(folder_ / "cut.db3", weaving_recording(Wire::cdr, 3.0));
  fs::resize_file(folder_ / "cut.db3", fs::file_size(folder_ / "cut.db3") / 2);
  EXPECT_THAT(why(folder_ / "cut.db3"), HasSubstr("the database cannot be read"));
}

#else

TEST_F(ImportBags, WithoutSqliteTheMessageSaysWhatToInstall) {
  EXPECT_THAT(why(write("a.db3", std::string("SQLite format 3\0", 16))),
              HasSubstr("built without libsqlite3-dev; install it"));
}

#endif

#ifdef GRIPLINE_ROSBAG

/// A message whose bytes are there already, for ROS's library.
struct WrittenMessage {
  std::string type, definition;
  std::vector<std::byte> bytes;
};

}  // namespace test_import_bags
}  // namespace gripline

namespace ros::message_traits {
template <>
struct MD5Sum<gripline::WrittenMessage> {
  static const char* value(const gripline::WrittenMessage&) { return "0123456789abcdef0123456789abcdef"; }
};
template <>
struct DataType<gripline::WrittenMessage> {
  static const char* value(const gripline::WrittenMessage& m) { return m.type.c_str(); }
};
template <>
struct Definition<gripline::WrittenMessage> {
  static const char* value(const gripline::WrittenMessage& m) { return m.definition.c_str(); }
};
}  // namespace ros::message_traits
namespace ros::serialization {
template <>
struct Serializer<gripline::WrittenMessage> {
  template <class Stream>
  static void write(Stream& stream, const gripline::WrittenMessage& m) {
    std::memcpy(stream.advance(static_cast<uint32_t>(m.bytes.size())), m.bytes.data(), m.bytes.size());
  }
  static uint32_t serializedLength(const gripline::WrittenMessage& m) { return static_cast<uint32_t>(m.bytes.size()); }
};
}  // namespace ros::serialization

namespace gripline {
namespace test_import_bags {

TEST_F(ImportBags, BagsOfTheLibraryOfRosAreRead) {
  const Recording all = weaving_recording(Wire::ros1);
  using rosbag::compression::CompressionType;
  for (const CompressionType compression :
       {rosbag::compression::Uncompressed, rosbag::compression::BZ2, rosbag::compression::LZ4}) {
    rosbag::Bag bag;
    bag.open(folder_ / "library.bag", rosbag::bagmode::Write);
    bag.setCompression(compression);
    bag.setChunkThreshold(100'000);
    for (const Recorded& m : all.messages) {
      ros::Time time;
      time.fromNSec(static_cast<uint64_t>(m.time));
      bag.write(all.topics[m.topic].name, time,
                WrittenMessage{all.topics[m.topic].type, all.topics[m.topic].definition, m.bytes});
    }
    bag.close();
    const Outcome outcome = import(folder_ / "library.bag");
    ASSERT_EQ(outcome.code, 0) << compression << ": " << outcome.err;
    expect_the_car();
  }
}

#endif

}  // namespace test_import_bags
}  // namespace gripline
