#include "bags/ros1_bag.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <string_view>

#include "bags/chunk_compression.hpp"
#include "config/errors.hpp"
#include "config/files.hpp"

namespace gripline::tools {
namespace {

using bags::Message;
using bags::Topic;
using Bytes = std::span<const std::byte>;

constexpr std::uint32_t longest_header = 16U << 20U;  // [bytes] of a record; definitions of types are in data
// [bytes] of a chunk, packed or not (usual: 0.8 MB), or a connection
constexpr std::uint32_t longest_data = 256U << 20U;
constexpr std::string_view first_line = "#ROSBAG V2.0\n";

enum Op : unsigned { op_message = 2, op_bag = 3, op_index = 4, op_chunk = 5, op_chunk_info = 6, op_connection = 7 };

std::string_view text_of(Bytes bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

template <class T>
T number_at(Bytes bytes, std::size_t at = 0) {
  static_assert(std::endian::native == std::endian::little);
  if (bytes.size() < sizeof(T) || at > bytes.size() - sizeof(T)) throw InputError("a record ends within a number");
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

/// Nanoseconds of a time: seconds, then nanoseconds, 32 bits each.
std::int64_t time_at(Bytes bytes, std::size_t at = 0) {
  return std::int64_t{number_at<std::uint32_t>(bytes, at)} * 1'000'000'000 + number_at<std::uint32_t>(bytes, at + 4);
}

/// Members of a record's header: "name=value", each behind its length.
class Header {
 public:
  explicit Header(Bytes bytes) {
    while (!bytes.empty()) {
      const auto length = number_at<std::uint32_t>(bytes);
      bytes = bytes.subspan(4);
      if (length > bytes.size()) throw InputError("a record's header ends within a member");
      const Bytes member = bytes.first(length);
      bytes = bytes.subspan(length);
      const std::size_t sign = text_of(member).find('=');
      if (sign == std::string_view::npos) throw InputError("a record's header has a member without '='");
      members_[text_of(member.first(sign))] = member.subspan(sign + 1);
    }
  }
  Bytes operator[](std::string_view name) const {
    const auto found = members_.find(name);
    if (found == members_.end()) throw InputError("a record has no \"" + std::string(name) + "\"");
    return found->second;
  }
  std::string text(std::string_view name) const {
    const auto found = members_.find(name);
    return found == members_.end() ? "" : std::string(text_of(found->second));
  }
  unsigned op() const { return number_at<std::uint8_t>((*this)["op"]); }

 private:
  std::map<std::string_view, Bytes> members_;
};

struct Chunk {
  std::uint64_t position = 0;
  std::int64_t start = 0;
  std::set<std::uint32_t> connections;
};

class Ros1Bag : public bags::BagFile {
 public:
  explicit Ros1Bag(const std::filesystem::path& file) : file_(file), in_(file, std::ios::binary) {
    in_.seekg(0, std::ios::end);
    size_ = static_cast<std::uint64_t>(std::max<std::streamoff>(in_.tellg(), 0));
    guarded([&] { read_index(); });
  }

  const std::filesystem::path& file() const override { return file_; }
  bags::Wire wire() const override { return bags::Wire::ros1; }
  const std::vector<Topic>& topics() const override { return topics_; }
  std::int64_t start() const override { return start_; }

  void read(const std::vector<bool>& wanted, const std::function<bool(const Message&)>& take) override {
    for (const Chunk& chunk : chunks_) {
      const bool any = std::any_of(chunk.connections.begin(), chunk.connections.end(), [&](std::uint32_t id) {
        const auto topic = topic_of_.find(id);
        return topic != topic_of_.end() && wanted[topic->second];
      });
      if (!any) continue;
      Bytes rest;
      guarded([&] { rest = unpack(chunk); });
      while (!rest.empty()) {
        std::optional<Message> message;
        guarded([&] { message = next_message(rest); });
        if (message && wanted[message->topic] && !take(*message)) return;
      }
    }
  }

 private:
  /// Problems of the file's form are told with its name; what names the file already is passed on.
  template <class Work>
  void guarded(Work work) const {
    try {
      work();
    } catch (const InputError& problem) {
      if (!problem.diagnostics().empty() && !problem.diagnostics().front().file.empty()) throw;
      throw InputError(
          {Diagnostic{file_.string(), 0, 0, "", std::string("truncated or broken: ") + problem.what(), {}}});
    }
  }
  [[noreturn]] void refuse(const std::string& message) const {
    throw InputError({Diagnostic{file_.string(), 0, 0, "", message, {}}});
  }

  std::vector<std::byte> bytes_at(std::uint64_t position, std::uint64_t count, std::uint64_t most) {
    if (position > size_ || count > size_ - position)
      throw InputError("a record at byte " + std::to_string(position) + " is longer than the file");
    if (count > most) throw InputError("a record of " + std::to_string(count) + " bytes");
    std::vector<std::byte> bytes(static_cast<std::size_t>(count));
    in_.clear();
    in_.seekg(static_cast<std::streamoff>(position));
    in_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(count));
    if (in_.gcount() != static_cast<std::streamsize>(count)) throw InputError("it cannot be read to its end");
    return bytes;
  }

  struct Record {
    std::vector<std::byte> header;
    std::uint64_t data = 0, length = 0;  // where the data begin, and how many
    std::uint64_t end() const { return data + length; }
  };
  Record record_at(std::uint64_t position) {
    Record record;
    const auto length = number_at<std::uint32_t>(bytes_at(position, 4, 4));
    record.header = bytes_at(position + 4, length, longest_header);
    record.data = position + 8 + length;
    record.length = number_at<std::uint32_t>(bytes_at(record.data - 4, 4, 4));
    if (record.length > size_ - record.data)
      throw InputError("the record at byte " + std::to_string(position) + " is longer than the file");
    return record;
  }

  void read_index() {
    const auto begin = bytes_at(0, first_line.size(), first_line.size());
    if (text_of(begin) != first_line)
      refuse("a bag of another format, \"" + std::string(text_of(begin).substr(0, first_line.size() - 1)) +
             "\"; expected ROSBAG V2.0 (rosbag fix makes one)");
    const Record bag = record_at(first_line.size());
    const Header header(bag.header);
    if (header.op() != op_bag) throw InputError("the first record is not that of the bag");
    if (const std::string encryptor = header.text("encryptor"); !encryptor.empty())
      refuse("encrypted (" + encryptor + "); expected a bag that was decrypted");
    const auto index = number_at<std::uint64_t>(header["index_pos"]);
    if (index == 0) refuse("no index: the recording was not ended (rosbag reindex mends a copy)");
    const std::uint64_t connections = number_at<std::uint32_t>(header["conn_count"]);
    const std::uint64_t chunks = number_at<std::uint32_t>(header["chunk_count"]);
    std::uint64_t found_connections = 0, found_chunks = 0;
    for (std::uint64_t at = index; at < size_;) {
      const Record record = record_at(at);
      const Header of(record.header);
      if (of.op() == op_connection) {
        ++found_connections;
        add_connection(of, bytes_at(record.data, record.length, longest_data));
      } else if (of.op() == op_chunk_info) {
        ++found_chunks;
        add_chunk(of, bytes_at(record.data, record.length, longest_data));
      } else {
        throw InputError("its index holds a record of kind " + std::to_string(of.op()));
      }
      at = record.end();
    }
    if (found_connections != connections || found_chunks != chunks)
      throw InputError("its index has " + std::to_string(found_connections) + " connections and " +
                       std::to_string(found_chunks) + " chunks, its first record says " + std::to_string(connections) +
                       " and " + std::to_string(chunks));
    if (chunks_.empty()) refuse("it holds no messages");
    // In the order of recording; chunks of one time in that of the file.
    std::stable_sort(chunks_.begin(), chunks_.end(), [](const Chunk& a, const Chunk& b) { return a.start < b.start; });
    start_ = chunks_.front().start;
  }

  /// Several connections may be of one topic: publishers that came one after the other.
  void add_connection(const Header& header, const std::vector<std::byte>& data) {
    const auto id = number_at<std::uint32_t>(header["conn"]);
    const Header about{Bytes(data)};
    std::string name = header.text("topic");
    if (!name.starts_with('/')) name.insert(0, 1, '/');
    const std::string type(text_of(about["type"]));
    const auto same = [&](const Topic& t) { return t.name == name && t.type == type; };
    const auto known = std::find_if(topics_.begin(), topics_.end(), same);
    topic_of_[id] = static_cast<std::size_t>(known - topics_.begin());
    if (known == topics_.end()) topics_.push_back({name, type, about.text("message_definition"), 0});
  }

  void add_chunk(const Header& header, const std::vector<std::byte>& data) {
    Chunk chunk{number_at<std::uint64_t>(header["chunk_pos"]), time_at(header["start_time"]), {}};
    // Else a small file could ask for the same large chunk without end.
    if (!chunk_positions_.insert(chunk.position).second) throw InputError("its index names one chunk twice");
    for (std::size_t at = 0; at < data.size(); at += 8) {
      const auto id = number_at<std::uint32_t>(data, at);
      const auto topic = topic_of_.find(id);
      if (topic == topic_of_.end()) throw InputError("a chunk has messages of an unknown connection");
      topics_[topic->second].messages += number_at<std::uint32_t>(data, at + 4);
      chunk.connections.insert(id);
    }
    chunks_.push_back(std::move(chunk));
  }

  Bytes unpack(const Chunk& chunk) {
    const Record record = record_at(chunk.position);
    const Header header(record.header);
    if (header.op() != op_chunk) throw InputError("its index names a chunk where none is");
    const auto size = number_at<std::uint32_t>(header["size"]);
    if (size > longest_data) throw InputError("a chunk of " + std::to_string(size) + " bytes");
    const std::string compression = header.text("compression");
    if (const std::string missing = missing_for(compression); !missing.empty())
      refuse("its chunks are packed (" + compression + "), and gripline was built without " + missing +
             "; install it, then cmake -S . -B build and build again (or rosbag decompress)");
    chunk_ = unpack_chunk(compression, bytes_at(record.data, record.length, longest_data), size);
    return chunk_;
  }

  /// Takes one record off a chunk; nothing where it is no message.
  std::optional<Message> next_message(Bytes& rest) const {
    const auto part = [&] {
      const auto length = number_at<std::uint32_t>(rest);
      if (length > rest.size() - 4) throw InputError("a chunk ends within a record");
      const Bytes bytes = rest.subspan(4, length);
      rest = rest.subspan(4 + std::size_t{length});
      return bytes;
    };
    const Header header(part());
    const Bytes data = part();
    if (header.op() != op_message) return std::nullopt;
    const auto topic = topic_of_.find(number_at<std::uint32_t>(header["conn"]));
    if (topic == topic_of_.end()) throw InputError("a message of an unknown connection");
    return Message{topic->second, time_at(header["time"]), data};
  }

  std::filesystem::path file_;
  std::ifstream in_;
  std::uint64_t size_ = 0;
  std::vector<Topic> topics_;
  std::map<std::uint32_t, std::size_t> topic_of_;  // by connection
  std::vector<Chunk> chunks_;
  std::set<std::uint64_t> chunk_positions_;
  std::int64_t start_ = 0;
  std::vector<std::byte> chunk_;  // the one that is being read
};

}  // namespace

std::unique_ptr<bags::BagFile> open_ros1_bag(const std::filesystem::path& file) {
  return std::make_unique<Ros1Bag>(file);
}

}  // namespace gripline::tools
