#include "bags/rosbag2.hpp"

#include "config/errors.hpp"
#ifdef GRIPLINE_SQLITE
#include <sqlite3.h>

#include <algorithm>
#include <map>
#endif

namespace gripline::tools {

#ifndef GRIPLINE_SQLITE

std::unique_ptr<bags::BagFile> open_rosbag2(const std::filesystem::path& file) {
  throw InputError(file.string() +
                   ": a database, and gripline was built without libsqlite3-dev; install it, then cmake -S . -B build "
                   "and build again");
}

#else

namespace {

using bags::Message;
using bags::Topic;

constexpr int longest_message = 256 << 20;  // [bytes]

struct CloseDatabase {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
};
struct FinishStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Statement = std::unique_ptr<sqlite3_stmt, FinishStatement>;

std::string text_at(const Statement& row, int column) {
  const auto* const text = reinterpret_cast<const char*>(sqlite3_column_text(row.get(), column));
  return text == nullptr ? "" : std::string(text, static_cast<std::size_t>(sqlite3_column_bytes(row.get(), column)));
}

class Rosbag2 : public bags::BagFile {
 public:
  explicit Rosbag2(const std::filesystem::path& file) : file_(file) {
    sqlite3* opened = nullptr;
    const int code = sqlite3_open_v2(file.c_str(), &opened, SQLITE_OPEN_READONLY, nullptr);
    database_.reset(opened);
    if (code != SQLITE_OK) refuse();
    sqlite3_limit(opened, SQLITE_LIMIT_LENGTH, longest_message);
    sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    check_tables();
    read_topics();
  }

  const std::filesystem::path& file() const override { return file_; }
  bags::Wire wire() const override { return bags::Wire::cdr; }
  const std::vector<Topic>& topics() const override { return topics_; }
  std::int64_t start() const override { return start_; }

  void read(const std::vector<bool>& wanted, const std::function<bool(const Message&)>& take) override {
    std::string ids;
    for (const auto& [id, topic] : topic_of_)
      if (wanted[topic]) ids += (ids.empty() ? "" : ", ") + std::to_string(id);
    const Statement row = prepare("SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN (" + ids +
                                  ") ORDER BY timestamp, id");
    while (step(row)) {
      const std::int64_t recorded = sqlite3_column_int64(row.get(), 1);
      if (recorded < 0 || recorded > bags::latest_time)
        refuse("a message was recorded at " + std::to_string(recorded) + " ns; expected nanoseconds since 1970");
      const auto* const data = static_cast<const std::byte*>(sqlite3_column_blob(row.get(), 2));
      const auto size = static_cast<std::size_t>(sqlite3_column_bytes(row.get(), 2));
      if (!take({topic_of_.at(sqlite3_column_int64(row.get(), 0)), recorded, {data, size}})) return;
    }
  }

 private:
  [[noreturn]] void refuse(const std::string& message) const {
    throw InputError({Diagnostic{file_.string(), 0, 0, "", message, {}}});
  }
  [[noreturn]] void refuse() const {
    refuse(std::string("the database cannot be read: ") + sqlite3_errmsg(database_.get()));
  }
  Statement prepare(const std::string& text) const {
    sqlite3_stmt* statement = nullptr;
    if (sqlite3_prepare_v2(database_.get(), text.c_str(), -1, &statement, nullptr) != SQLITE_OK) refuse();
    return Statement(statement);
  }
  /// Whether there is a further row.
  bool step(const Statement& statement) const {
    const int code = sqlite3_step(statement.get());
    if (code != SQLITE_ROW && code != SQLITE_DONE) refuse();
    return code == SQLITE_ROW;
  }
  bool has_table(const std::string& name) const {
    return step(prepare("SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = '" + name + "'"));
  }

  void check_tables() const {
    if (has_table("topics") && has_table("messages")) return;
    std::string found;
    const Statement row = prepare("SELECT name FROM sqlite_master WHERE type = 'table' LIMIT 12");
    while (step(row)) found += (found.empty() ? "" : ", ") + text_at(row, 0);
    refuse("a database of something else than rosbag2: expected the tables topics and messages, found " +
           (found.empty() ? "none" : found));
  }

  void read_topics() {
    std::map<std::string, std::string> definitions;
    if (has_table("message_definitions")) {
      const Statement row = prepare("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions");
      while (step(row))
        if (text_at(row, 1) == "ros2msg") definitions[text_at(row, 0)] = text_at(row, 2);
    }
    const Statement row = prepare("SELECT id, name, type, serialization_format FROM topics");
    while (step(row)) {
      const std::string type = text_at(row, 2), format = text_at(row, 3);
      std::string name = text_at(row, 1);
      if (format != "cdr")
        refuse(std::string("topic ")
                   .append(name)
                   .append(" is serialized as \"")
                   .append(format)
                   .append("\"; expected cdr"));
      if (!name.starts_with('/')) name.insert(0, 1, '/');
      topic_of_[sqlite3_column_int64(row.get(), 0)] = topics_.size();
      topics_.push_back({name, type, definitions[type], 0});
    }
    count();
  }

  void count() {
    const Statement row = prepare("SELECT topic_id, COUNT(*), MIN(timestamp) FROM messages GROUP BY topic_id");
    bool any = false;
    while (step(row)) {
      const auto topic = topic_of_.find(sqlite3_column_int64(row.get(), 0));
      if (topic == topic_of_.end()) continue;
      topics_[topic->second].messages = static_cast<std::size_t>(sqlite3_column_int64(row.get(), 1));
      const std::int64_t first = sqlite3_column_int64(row.get(), 2);
      start_ = any ? std::min(start_, first) : first;
      any = true;
    }
    if (!any) refuse("it holds no messages");
    if (start_ < 0 || start_ > bags::latest_time)
      refuse("its first message was recorded at " + std::to_string(start_) + " ns; expected nanoseconds since 1970");
  }

  std::filesystem::path file_;
  std::unique_ptr<sqlite3, CloseDatabase> database_;
  std::vector<Topic> topics_;
  std::map<std::int64_t, std::size_t> topic_of_;  // by id
  std::int64_t start_ = 0;
};

}  // namespace

std::unique_ptr<bags::BagFile> open_rosbag2(const std::filesystem::path& file) {
  return std::make_unique<Rosbag2>(file);
}

#endif

}  // namespace gripline::tools
