// An independent reader of MCAP bytes by the specification (https://mcap.dev/spec): records one after the other, each
// with its opcode and length; nothing of the writer is used.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace gripline::testing_support {

struct McapMessage {
  std::string topic, schema;
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0;  // [ns]
  nlohmann::json data;
};

struct McapFile {
  std::string library;
  std::map<std::string, nlohmann::json> schemas;  // by name
  std::vector<McapMessage> messages;
  std::vector<int> opcodes;  // of all records in their order
};

namespace mcap_reading {

struct Bytes {
  std::string_view rest;
  std::string_view take(std::size_t n) {
    if (n > rest.size()) throw std::runtime_error("the file ends within a record");
    const std::string_view taken = rest.substr(0, n);
    rest.remove_prefix(n);
    return taken;
  }
  std::uint64_t number(int width) {
    const std::string_view text = take(static_cast<std::size_t>(width));
    std::uint64_t value = 0;
    for (int i = width - 1; i >= 0; --i)
      value = value << 8 | static_cast<unsigned char>(text[static_cast<std::size_t>(i)]);
    return value;
  }
  std::string text() { return std::string(take(number(4))); }
};

}  // namespace mcap_reading

/// Throws std::runtime_error with what is not as the specification says.
inline McapFile read_mcap(std::string_view bytes) {
  const auto require = [](bool good, const char* what) {
    if (!good) throw std::runtime_error(what);
  };
  constexpr std::string_view magic("\x89MCAP0\r\n", 8);
  require(bytes.size() > 16 && bytes.starts_with(magic) && bytes.ends_with(magic), "no magic bytes at both ends");
  mcap_reading::Bytes file{bytes.substr(8, bytes.size() - 16)};
  McapFile found;
  std::map<std::uint64_t, std::string> schema_names;
  std::map<std::uint64_t, std::pair<std::string, std::string>> channels;  // topic, schema
  while (!file.rest.empty()) {
    const auto opcode = static_cast<int>(file.number(1));
    mcap_reading::Bytes record{file.take(file.number(8))};
    found.opcodes.push_back(opcode);
    if (opcode == 1) {
      require(record.text().empty(), "a profile");
      found.library = record.text();
    } else if (opcode == 3) {
      const std::uint64_t id = record.number(2);
      require(id != 0, "a schema with the id 0");
      const std::string name = record.text();
      require(record.text() == "jsonschema", "a schema that is no JSON schema");
      found.schemas[name] = nlohmann::json::parse(record.text());
      schema_names[id] = name;
    } else if (opcode == 4) {
      const std::uint64_t id = record.number(2), schema = record.number(2);
      require(schema_names.contains(schema), "a channel of no schema");
      const std::string topic = record.text();
      require(record.text() == "json", "a channel that is not JSON");
      require(record.number(4) == 0, "metadata");
      channels[id] = {topic, schema_names[schema]};
    } else if (opcode == 5) {
      McapMessage message;
      const std::uint64_t channel = record.number(2);
      require(channels.contains(channel), "a message of no channel");
      std::tie(message.topic, message.schema) = channels[channel];
      message.sequence = static_cast<std::uint32_t>(record.number(4));
      message.log_time = record.number(8);
      require(record.number(8) == message.log_time, "published at another time");
      message.data = nlohmann::json::parse(record.rest);
      record.rest = {};
      found.messages.push_back(std::move(message));
    } else if (opcode == 15) {
      require(record.number(4) == 0, "a checksum of the data");
    } else if (opcode == 2) {
      for (const int width : {8, 8, 4}) require(record.number(width) == 0, "a summary");
      require(file.rest.empty(), "records after the footer");
    } else {
      throw std::runtime_error("an unknown record");
    }
    require(record.rest.empty(), "a record that is longer than its content");
  }
  return found;
}

}  // namespace gripline::testing_support
