// nlohmann's SAX parser supplies the grammar; this file adds line and column of every value, the refusal of duplicate
// keys, and messages that say what to write instead.
#include "config/json_parser.hpp"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "config/ascii.hpp"
#include "config/errors.hpp"
#include "config/json_file.hpp"
#include "config/utf8.hpp"

namespace gripline {
namespace {

using Json = nlohmann::json;

/// Counts how far the parser has read, which is where the token it just reported ends.
class CountingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  CountingIterator(const char* at, std::size_t* read) : at_(at), read_(read) {}
  reference operator*() const { return *at_; }
  CountingIterator& operator++() {
    ++at_;
    ++*read_;
    return *this;
  }
  CountingIterator operator++(int) {
    CountingIterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const CountingIterator& other) const { return at_ == other.at_; }
  bool operator!=(const CountingIterator& other) const { return at_ != other.at_; }

 private:
  const char* at_;
  std::size_t* read_;
};

bool is_continuation(char c) { return (static_cast<unsigned char>(c) & 0xc0U) == 0x80U; }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
constexpr std::string_view letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
bool is_word(char c) {
  return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '+' || c == '-' ||
         c == '.';
}

/// The text with its lines: turns offsets in bytes into places for people.
class Text {
 public:
  Text(std::string_view text, std::shared_ptr<const Source> source) : text_(text), source_(std::move(source)) {}

  [[nodiscard]] std::string_view view() const { return text_; }

  /// Cheap when offsets mostly grow, as they do in a parser.
  [[nodiscard]] Origin origin(std::size_t offset, std::string pointer = "") {
    if (offset < at_) {
      at_ = 0;
      line_ = column_ = 1;
    }
    for (; at_ < offset && at_ < text_.size(); ++at_) {
      if (text_[at_] == '\n') {
        ++line_;
        column_ = 1;
      } else if (at_ + 1 == text_.size() || !is_continuation(text_[at_ + 1])) {
        ++column_;
      }
    }
    return {source_, line_, column_, std::move(pointer)};
  }

  [[noreturn]] void refuse(std::size_t offset, std::string message, std::string pointer = "") {
    throw InputError(origin(offset, std::move(pointer)), std::move(message));
  }
  [[noreturn]] void refuse_whole(std::string message) const {
    throw InputError({source_, 0, 0, ""}, std::move(message));
  }

 private:
  std::string_view text_;
  std::shared_ptr<const Source> source_;
  std::size_t at_ = 0;
  int line_ = 1;
  int column_ = 1;
};

/// Builds the tree from the parser's events.
class TreeBuilder final : public nlohmann::json_sax<Json> {
 public:
  TreeBuilder(Text& text, const std::size_t& read, JsonBudget& budget) : text_(text), read_(read), budget_(budget) {}

  Node take() { return std::move(root_); }

  bool null() override { return scalar(Node()); }
  bool boolean(bool value) override { return scalar(Node(value)); }
  bool number_integer(number_integer_t value) override { return scalar(Node(value)); }
  bool number_unsigned(number_unsigned_t value) override { return scalar(Node(value)); }
  bool number_float(number_float_t value, const string_t&) override { return scalar(Node(value)); }
  bool string(string_t& value) override { return scalar(Node(value)); }
  bool binary(binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open(Node::empty_object()); }
  bool start_array(std::size_t) override { return open(Node(Node::Array{})); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(string_t& name) override {
    const std::size_t start = token_start();
    if (name.size() > json_limits.key) {
      text_.refuse(start, "a key of " + std::to_string(name.size()) + " bytes; the longest that is read has " +
                              std::to_string(json_limits.key));
    }
    const Origin where = text_.origin(start, join_pointer(open_.back()->origin.pointer, name));
    if (const auto [known, fresh] = keys_.back().emplace(name, where.line); !fresh) {
      text_.refuse(start,
                   "the key \"" + name + "\" is already written at line " + std::to_string(known->second) +
                       "; a key stands once in an object",
                   where.pointer);
    }
    if (keys_.back().size() > json_limits.members) {
      text_.refuse(start, "more than " + std::to_string(json_limits.members) + " members in one object");
    }
    open_.back()->object().push_back(Member{name, Node(), where.line, where.column});
    return after(Event::key);
  }

  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) override;

 private:
  enum class Event { nothing, open, key, value };

  /// The token just reported begins after the blanks, commas and colons that follow the previous one.
  [[nodiscard]] std::size_t token_start() const {
    std::size_t start = end_;
    const std::string_view text = text_.view();
    while (start < text.size() && (is_blank(text[start]) || text[start] == ',' || text[start] == ':')) ++start;
    return start;
  }

  bool after(Event event) {
    event_ = event;
    end_ = read_;
    number_start_ = std::string_view::npos;
    return true;
  }

  Node& place(Node node, std::size_t start) {
    Node* slot = &root_;
    std::string pointer;
    if (!open_.empty()) {
      Node& parent = *open_.back();
      if (parent.is_object()) {
        slot = &parent.object().back().value;
        pointer = join_pointer(parent.origin.pointer, parent.object().back().key);
      } else {
        pointer = join_pointer(parent.origin.pointer, std::to_string(parent.array().size()));
        slot = &parent.array().emplace_back();
      }
    }
    budget_.pointers += pointer.size();
    if (++budget_.values > json_limits.values || budget_.pointers > json_limits.pointers) {
      text_.refuse(start, "more than " +
                              (budget_.values > json_limits.values
                                   ? std::to_string(json_limits.values) + " values"
                                   : std::to_string(json_limits.pointers >> 20U) + " MB of keys above values") +
                              ", which no file of ours needs");
    }
    node.origin = text_.origin(start, std::move(pointer));
    return *slot = std::move(node);
  }

  bool scalar(Node node) {
    const bool number = node.is_number();
    const std::size_t start = token_start();
    place(std::move(node), start);
    after(Event::value);
    if (number) {
      number_start_ = start;
      if (!is_digit(text_.view()[end_ - 1])) --end_;  // a number's end is seen only at the character after it
    }
    return true;
  }

  bool open(Node node) {
    const std::size_t start = token_start();
    // Pointers into the open values stay good: only the innermost one grows.
    Node& placed = place(std::move(node), start);
    if (open_.size() >= static_cast<std::size_t>(max_depth)) {
      text_.refuse(start, "nested deeper than " + std::to_string(max_depth) + " levels");
    }
    open_.push_back(&placed);
    keys_.emplace_back();
    return after(Event::open);
  }

  bool close() {
    open_.pop_back();
    keys_.pop_back();
    return after(Event::value);
  }

  [[nodiscard]] std::string expectation(std::size_t start) const;
  [[noreturn]] void refuse_end();
  [[noreturn]] void refuse_string(std::size_t at, const std::string& reason);
  [[noreturn]] void refuse_token(std::size_t at);

  Text& text_;
  const std::size_t& read_;
  Node root_;
  JsonBudget& budget_;
  std::vector<Node*> open_;                                 ///< the arrays and objects being read, outermost first
  std::vector<std::unordered_map<std::string, int>> keys_;  ///< of each, and their lines
  Event event_ = Event::nothing;
  std::size_t end_ = 0;                                ///< just behind the last token that made an event
  std::size_t number_start_ = std::string_view::npos;  ///< of that token, if it was a number
};

/// What may stand at `start`, judged by the last event and the separators since.
std::string TreeBuilder::expectation(std::size_t start) const {
  const auto since = text_.view().substr(end_, start - std::min(start, end_));
  const bool separated = std::ranges::any_of(since, [](char c) { return !is_blank(c); });
  const bool in_object = !open_.empty() && open_.back()->is_object();
  switch (event_) {
    case Event::nothing:
      return "a JSON value";
    case Event::key:
      return separated ? "a value" : "\":\" after the key";
    case Event::open:
      return in_object ? "a key in double quotes or \"}\"" : "a value or \"]\"";
    case Event::value:
      break;
  }
  if (open_.empty()) return "the end of the file";
  if (separated) return in_object ? "a key in double quotes" : "a value";
  return in_object ? "\",\" or \"}\"" : "\",\" or \"]\"";
}

void TreeBuilder::refuse_end() {
  const std::size_t end = text_.view().size();
  if (open_.empty()) text_.refuse(end, "the file ends too early, inside a value");
  const Origin& from = open_.back()->origin;
  text_.refuse(end, std::string("the file ends too early: the \"") + (open_.back()->is_object() ? '{' : '[') +
                        "\" of line " + std::to_string(from.line) + ", column " + std::to_string(from.column) +
                        " is not closed");
}

void TreeBuilder::refuse_string(std::size_t at, const std::string& reason) {
  const char c = text_.view()[at];
  if (c == '\n' || c == '\r') text_.refuse(at, "the text is not closed by \" before the end of its line");
  if (c == '\t') text_.refuse(at, "a tab inside a text is written \\t");
  text_.refuse(at, "not a JSON string: " + reason);
}

/// Where the token begins and ends that has `at` inside (a word or a sign) or at its end (a string).
std::pair<std::size_t, std::size_t> token_around(std::string_view text, std::size_t at) {
  std::size_t start = at, end = at + 1;
  if (is_word(text[at])) {
    // "01" is reported as a stray 1 after the number 0: it is shown whole.
    while (start > 0 && is_word(text[start - 1])) --start;
    while (end < text.size() && is_word(text[end])) ++end;
  } else if (text[at] == '"' && at > 0) {
    do start = std::min(text.rfind('"', start - 1), at);
    while (start > 0 && start < at && text[start - 1] == '\\');
  } else {
    while (end < text.size() && is_continuation(text[end])) ++end;
  }
  return {start, end};
}

/// Hint for a token of another notation (comments, single quotes, nan, None, True); empty for any other.
std::string hint_for(const std::string& found) {
  if (found == "/" || found == "#") return "JSON has no comments: write the words as a \"note\"";
  if (found == "'") return "text is written in double quotes, found a single one";
  const std::string word = lower_case(found);
  for (const char* name : {"nan", "inf", "infinity"}) {
    if (word == name || (word.size() > 1 && word.substr(1) == name)) {
      return "JSON has no " + found + ", expected a finite number";
    }
  }
  for (const char* name : {"true", "false", "null"}) {
    if (word == name && found != name) return found + " is written " + name + " in JSON";
  }
  if (word == "none" || word == "nil") return found + " is written null in JSON";
  if (!is_digit(word.front()) && word.front() != '.' && word.front() != '+' && word.front() != '-') return "";
  if (Json::accept(found)) return "";
  const std::size_t digits = found.find_first_not_of("+-.0123456789");
  const bool quantity = digits != std::string::npos && found.find_first_not_of(letters, digits) == std::string::npos &&
                        found.substr(digits) != "e" && found.substr(digits) != "E" &&
                        Json::accept(found.substr(0, digits));
  return found + " is not a JSON number" +
         (quantity ? "; with a unit it is text: \"" + found.substr(0, digits) + ' ' + found.substr(digits) + '"' : "");
}

/// A token that is no JSON, or stands where it may not.
void TreeBuilder::refuse_token(std::size_t at) {
  const std::string_view text = text_.view();
  const auto [start, end] = token_around(text, at);
  const std::string found(text.substr(start, end - start));
  if (std::string hint = hint_for(found); !hint.empty()) text_.refuse(start, std::move(hint));

  const bool only_letters = found.find_first_not_of(letters) == std::string::npos;
  if (only_letters && number_start_ < start && text.find_first_not_of(" \t", end_) == start) {
    const std::string number(text.substr(number_start_, end_ - number_start_));
    text_.refuse(number_start_, "a number with a unit is text: \"" + number + ' ' + found + '"');
  }
  const std::size_t before = start == 0 ? std::string_view::npos : text.find_last_not_of(" \t\r\n", start - 1);
  if ((found == "}" || found == "]") && before != std::string_view::npos && text[before] == ',') {
    text_.refuse(before, "a comma before \"" + found + "\"; only between two values is one allowed");
  }
  const std::string expected = "expected " + expectation(start) + ", found ";
  if (is_word(found.front()) && !Json::accept(found)) {
    text_.refuse(start, expected + found + "; text is written in double quotes");
  }
  text_.refuse(start, expected + (found.front() == '"' ? parse_text(found) : Node(found)).describe());
}

bool TreeBuilder::parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) {
  constexpr int number_overflow = 406;
  const std::string_view what = error.what();
  if (error.id == number_overflow) {
    const std::size_t start = token_start();
    std::size_t end = start;
    while (end < text_.view().size() && is_word(text_.view()[end])) ++end;
    text_.refuse(start, std::string(text_.view().substr(start, end - start)) + " is too large for a number (1.8e308)");
  }
  if (position > text_.view().size()) refuse_end();
  const std::size_t at = position - 1;
  constexpr std::string_view in_string = "invalid string: ";
  if (const auto from = what.find(in_string); from != std::string_view::npos) {
    const std::string_view reason = what.substr(from + in_string.size());
    refuse_string(at, std::string(reason.substr(0, reason.find("; last read"))));
  }
  // A broken word or number is noticed inside or behind it.
  const bool broken = what.find("invalid literal") != what.npos || what.find("invalid number") != what.npos;
  refuse_token(broken ? token_start() : at);
}

}  // namespace

Node parse_json(std::string_view bytes, std::shared_ptr<const Source> source, JsonBudget& budget) {
  constexpr std::string_view mark = "\xef\xbb\xbf";
  if (bytes.size() > json_limits.bytes) {
    Text(bytes, source).refuse_whole("is larger than " + std::to_string(json_limits.bytes >> 20U) + " MB");
  }
  if (bytes.starts_with("\xff\xfe") || bytes.starts_with("\xfe\xff")) {
    Text(bytes, source).refuse_whole("is UTF-16; save it as UTF-8");
  }
  if (bytes.starts_with(mark)) bytes.remove_prefix(mark.size());
  Text text(bytes, std::move(source));
  if (std::ranges::all_of(bytes, is_blank)) text.refuse_whole("is empty, expected JSON");
  // The parser would take a NUL byte for the end of the text.
  if (const auto at = bytes.find('\0'); at != std::string_view::npos) {
    text.refuse(at, "a NUL byte: not a text in UTF-8");
  }
  if (const auto at = find_malformed_utf8(bytes)) {
    constexpr std::string_view hex = "0123456789abcdef";
    const auto byte = static_cast<unsigned char>(bytes[*at]);
    text.refuse(*at, std::string("not UTF-8: byte 0x") + hex[byte >> 4U] + hex[byte & 0xfU] + "; save it as UTF-8");
  }
  std::size_t read = 0;
  TreeBuilder builder(text, read, budget);
  Json::sax_parse(CountingIterator(bytes.data(), &read), CountingIterator(bytes.data() + bytes.size(), &read),
                  &builder);
  return builder.take();
}

}  // namespace gripline
