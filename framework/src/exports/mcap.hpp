// An MCAP file (https://mcap.dev/spec) of JSON messages: the subset without chunks, index and checksums, which every
// reader understands.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace gripline::exports {

class McapWriter {
 public:
  /// `library` is the writer's name and version, as readers show it.
  explicit McapWriter(std::string_view library);
  /// Declares what messages look like: a JSON schema and its name. Returns its id.
  std::uint16_t schema(std::string_view name, std::string_view json_schema);
  /// Declares a topic whose messages follow a schema. Returns its id.
  std::uint16_t channel(std::uint16_t schema, std::string_view topic);
  /// One message of a channel. `t_s` is seconds from the start of the run, at least 0.
  void message(std::uint16_t channel, double t_s, std::string_view json);
  /// The whole file. Nothing can be written afterwards.
  std::string finish() &&;

 private:
  void record(std::uint8_t opcode, std::string_view content);
  std::string bytes_;
  std::uint16_t schemas_ = 0, channels_ = 0;
  std::map<std::uint16_t, std::uint32_t> sequence_;  // messages of a channel so far
};

}  // namespace gripline::exports
