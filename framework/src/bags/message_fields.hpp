// Numbers out of the bytes of messages, by their paths in the type.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bags/message_schema.hpp"

namespace gripline::bags {

/// Reads the same numbers from every message of a type: "pose.pose.position.x", "data[3]". A time counts from `zero`
/// (nanoseconds). A geometry_msgs/Quaternion has also the member "yaw" [rad].
class FieldReader {
 public:
  /// Throws InputError where a path is not a number: nearest name, what there is, an element that is to be named.
  FieldReader(Schema schema, const std::vector<std::string>& paths, std::int64_t zero);

  /// One number for each path; NaN where an array is too short for it. Throws InputError: bytes that end too early or
  /// too late, an array longer than the bytes that are left. Nothing is reserved by lengths in the message.
  std::span<const double> read(std::span<const std::byte> message);
  /// The stamp of the last message's header; empty where the type has none.
  std::optional<std::int64_t> stamp() const { return stamp_; }
  bool has_header() const { return header_; }
  /// Whether this number is an angle that jumps by a turn.
  bool turns(std::size_t path) const;

 private:
  /// What is wanted of one value.
  struct Pick {
    std::vector<std::size_t> slots;    // of a number
    bool stamp = false;                // the header's
    std::vector<std::uint64_t> which;  // parts of a message by field, of an array by element
    std::vector<Pick> part;

    Pick& add(std::uint64_t index);
    const Pick* find(std::uint64_t index) const;
  };
  struct Turn {
    std::size_t slot = 0;               // of the yaw
    std::array<std::size_t, 4> from{};  // x, y, z, w
  };
  class Bytes;

  void choose(const std::string& path, std::size_t slot);
  Pick* choose_element(const std::string& path, const std::string& word, const Field& field, Pick& of) const;
  bool choose_yaw(const MessageType& quaternion, Pick& of, std::size_t slot);
  [[noreturn]] void refuse_path(const std::string& path, const std::string& why) const;
  void read_message(const MessageType& type, const Pick* pick, Bytes& bytes);
  void read_field(const Field& field, const Pick* pick, Bytes& bytes);
  void read_numbers(const Field& field, std::uint64_t count, const Pick* pick, Bytes& bytes);
  void read_number(Kind kind, const Pick& pick, Bytes& bytes);

  Schema schema_;
  std::int64_t zero_;
  Pick root_;
  std::vector<double> values_;
  std::size_t paths_;
  std::vector<Turn> turns_;
  bool header_ = false;
  std::optional<std::int64_t> stamp_;
};

}  // namespace gripline::bags
