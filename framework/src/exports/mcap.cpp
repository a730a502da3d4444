#include "exports/mcap.hpp"

#include <cmath>

namespace gripline::exports {
namespace {

constexpr std::string_view magic("\x89MCAP0\r\n", 8);
enum Opcode : std::uint8_t {
  header = 1,
  footer = 2,
  schema_record = 3,
  channel_record = 4,
  message_record = 5,
  data_end = 15
};

/// Numbers are little-endian, of a given width in bytes.
void put(std::string& out, std::uint64_t value, int width) {
  for (int i = 0; i < width; ++i) out += static_cast<char>(value >> (8 * i) & 0xff);
}

/// A text with its length before it.
void put(std::string& out, std::string_view text) {
  put(out, text.size(), 4);
  out += text;
}

}  // namespace

McapWriter::McapWriter(std::string_view library) : bytes_(magic) {
  std::string content;
  put(content, "");  // no profile
  put(content, library);
  record(header, content);
}

std::uint16_t McapWriter::schema(std::string_view name, std::string_view json_schema) {
  std::string content;
  put(content, ++schemas_, 2);
  put(content, name);
  put(content, "jsonschema");
  put(content, json_schema);
  record(schema_record, content);
  return schemas_;
}

std::uint16_t McapWriter::channel(std::uint16_t schema, std::string_view topic) {
  std::string content;
  put(content, ++channels_, 2);
  put(content, schema, 2);
  put(content, topic);
  put(content, "json");
  put(content, 0, 4);  // no metadata
  record(channel_record, content);
  return channels_;
}

void McapWriter::message(std::uint16_t channel, double t_s, std::string_view json) {
  const auto time = static_cast<std::uint64_t>(std::llround(t_s * 1e9));
  std::string content;
  put(content, channel, 2);
  put(content, sequence_[channel]++, 4);
  put(content, time, 8);  // logged
  put(content, time, 8);  // published
  content += json;
  record(message_record, content);
}

std::string McapWriter::finish() && {
  std::string content;
  put(content, 0, 4);  // no checksum of the data
  record(data_end, content);
  content.clear();
  put(content, 0, 8);  // no summary,
  put(content, 0, 8);  // no offsets of one,
  put(content, 0, 4);  // no checksum of it
  record(footer, content);
  bytes_ += magic;
  return std::move(bytes_);
}

void McapWriter::record(std::uint8_t opcode, std::string_view content) {
  bytes_ += static_cast<char>(opcode);
  put(bytes_, content.size(), 8);
  bytes_ += content;
}

}  // namespace gripline::exports
