// What tests of the report share: folders of their own, and an independent reading of what a page holds.
#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace gripline::report {

namespace fs = std::filesystem;

inline constexpr double gap = std::numeric_limits<double>::quiet_NaN();

/// A folder of its own for each test, gone afterwards.
class Folder {
 public:
  Folder() {
    const testing::TestInfo& test = *testing::UnitTest::GetInstance()->current_test_info();
    path_ = fs::temp_directory_path() / ("gripline_" + std::string(test.test_suite_name()) + "_" + test.name());
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

inline std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline std::vector<std::uint8_t> decoded(const std::string& text) {
  static const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<std::uint8_t> bytes;
  std::uint32_t word = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    word = word << 6 | static_cast<std::uint32_t>(digits.find(c));
    bits += 6;
    if (bits >= 8) bytes.push_back(static_cast<std::uint8_t>(word >> (bits -= 8)));
  }
  return bytes;
}

/// What the page makes of a packed column: an independent reading of the format that packing.hpp states.
inline std::vector<double> unpacked(const nlohmann::json& column) {
  const auto n = column["n"].get<std::size_t>();
  const std::string kind = column["k"];
  const double offset = column["o"].is_null() ? gap : column["o"].get<double>(), step = column.value("s", 0.0);
  std::vector<double> values(n, offset);
  const std::vector<std::uint8_t> bytes = decoded(column.value("b", ""));
  for (std::size_t i = 0; i < n; ++i) {
    if (kind == "u") values[i] = offset + step * static_cast<double>(i);
    if (kind == "f") {
      std::uint32_t word = 0;
      for (std::size_t k = 0; k < 4; ++k) word |= static_cast<std::uint32_t>(bytes[4 * i + k]) << (8 * k);
      values[i] = offset + static_cast<double>(std::bit_cast<float>(word));
    }
    if (kind == "h") {
      const auto code = static_cast<std::int16_t>(bytes[2 * i] | bytes[2 * i + 1] << 8);
      values[i] = code == -32768 ? gap : offset + step * code;
    }
  }
  return values;
}

/// The JSON of one of the page's data blocks.
inline nlohmann::json block(const std::string& html, const std::string& id) {
  const std::string open = "<script type=\"application/json\" id=\"" + id + "\">";
  const std::size_t begin = html.find(open) + open.size();
  return nlohmann::json::parse(html.substr(begin, html.find("</script>", begin) - begin));
}

}  // namespace gripline::report
