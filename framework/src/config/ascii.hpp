// Blanks around a text, and letters of either case, whatever the locale: what stands beyond ASCII stays as it is.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace gripline {

/// A part of `text`, without the `blanks` around it.
constexpr std::string_view trim(std::string_view text, std::string_view blanks = " \t\r") {
  const auto blank = [blanks](char c) { return std::ranges::any_of(blanks, [c](char one) { return one == c; }); };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

constexpr char lower_case(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }
inline std::string lower_case(std::string text) {
  for (char& c : text) c = lower_case(c);
  return text;
}

}  // namespace gripline
