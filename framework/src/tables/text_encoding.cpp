#include "tables/text_encoding.hpp"

#include <array>
#include <cstddef>
#include <string_view>
#include <utility>

#include "config/utf8.hpp"

namespace gripline {
namespace {

/// What Windows-1252 has where Latin-1 has controls, from 0x80 on; U+FFFD where it has nothing.
constexpr std::array<unsigned, 32> windows = {0x20ac, 0xfffd, 0x201a, 0x0192, 0x201e, 0x2026, 0x2020, 0x2021,
                                              0x02c6, 0x2030, 0x0160, 0x2039, 0x0152, 0xfffd, 0x017d, 0xfffd,
                                              0xfffd, 0x2018, 0x2019, 0x201c, 0x201d, 0x2022, 0x2013, 0x2014,
                                              0x02dc, 0x2122, 0x0161, 0x203a, 0x0153, 0xfffd, 0x017e, 0x0178};

void append_windows_1252(std::string& to, std::string_view bytes) {
  for (const char c : bytes) {
    const auto byte = static_cast<unsigned char>(c);
    const unsigned code = byte >= 0x80 && byte < 0xa0 ? windows[byte - 0x80U] : byte;
    if (code < 0x80) {
      to += c;
    } else if (code < 0x800) {
      to += static_cast<char>(0xc0U | (code >> 6U));
      to += static_cast<char>(0x80U | (code & 0x3fU));
    } else {
      to += static_cast<char>(0xe0U | (code >> 12U));
      to += static_cast<char>(0x80U | ((code >> 6U) & 0x3fU));
      to += static_cast<char>(0x80U | (code & 0x3fU));
    }
  }
}

}  // namespace

bool to_utf8(std::string& text) {
  if (!find_malformed_utf8(text)) return false;
  std::string out;
  out.reserve(text.size() + text.size() / 64);
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::size_t end = rest.find('\n');
    const std::string_view line = rest.substr(0, end == std::string_view::npos ? end : end + 1);
    rest.remove_prefix(line.size());
    if (find_malformed_utf8(line))
      append_windows_1252(out, line);
    else
      out += line;
  }
  text = std::move(out);
  return true;
}

}  // namespace gripline
