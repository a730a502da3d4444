#include "bags/message_schema.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <set>
#include <sstream>

#include "config/errors.hpp"
#include "config/files.hpp"

namespace gripline::bags {
namespace {

constexpr std::uint64_t too_many = std::uint64_t{1} << 40U;  // bytes: no message has as many
constexpr std::size_t most_types = 500;

std::uint64_t limited_product(std::uint64_t a, std::uint64_t b) {
  return b != 0 && a > too_many / b ? too_many : std::min(a * b, too_many);
}

/// The words of a line, without its comment.
std::vector<std::string> words_of(const std::string& line) {
  std::istringstream in(line.substr(0, line.find('#')));
  return {std::istream_iterator<std::string>(in), {}};
}

std::optional<Kind> kind_of(const std::string& word, Wire wire) {
  static const std::map<std::string, Kind> kinds = {
      {"bool", Kind::boolean},      {"int8", Kind::int8},       {"uint8", Kind::uint8},     {"int16", Kind::int16},
      {"uint16", Kind::uint16},     {"int32", Kind::int32},     {"uint32", Kind::uint32},   {"int64", Kind::int64},
      {"uint64", Kind::uint64},     {"float32", Kind::float32}, {"float64", Kind::float64}, {"string", Kind::text},
      {"wstring", Kind::wide_text}, {"char", Kind::uint8}};
  if (word == "byte") return wire == Wire::ros1 ? Kind::int8 : Kind::uint8;
  if (word == "time" || word == "builtin_interfaces/Time") return Kind::time;
  if (word == "duration" || word == "builtin_interfaces/Duration") return Kind::duration;
  const auto found = kinds.find(word);
  return found == kinds.end() ? std::nullopt : std::optional(found->second);
}

std::string package_of(const std::string& type) { return type.substr(0, type.find('/')); }

/// "pkg/msg/Type", "Type" of the same package, and "Header" in one form.
std::string full_type(const std::string& word, const std::string& within) {
  if (word == "Header") return "std_msgs/Header";
  return word.find('/') == std::string::npos ? package_of(within) + "/" + word : short_type(word);
}

class SchemaParser {
 public:
  SchemaParser(Wire wire, const Definitions& others) : others_(others) { schema_.wire = wire; }

  Schema parse(const std::string& type, const std::string& text) {
    split(type, text);
    add(type, "");
    return std::move(schema_);
  }

 private:
  /// The text's blocks: the type's own first, each further one behind "====" and "MSG: pkg/Type".
  void split(const std::string& type, const std::string& text) {
    std::istringstream in(text);
    std::string now = type;
    bool rule = false;
    for (std::string line; std::getline(in, line);) {
      if (line.starts_with("====")) {
        rule = true;
      } else if (rule && line.starts_with("MSG:")) {
        const auto words = words_of(line.substr(4));
        now = words.empty() ? "" : short_type(words[0]);
        own_[now];
        rule = false;
      } else {
        own_[now] += line + '\n';
      }
    }
  }

  const std::string& text_of(const std::string& type, const std::string& user) const {
    for (const Definitions* all : {&own_, &others_})
      if (const auto found = all->find(type); found != all->end()) return found->second;
    throw InputError("type " + type + (user.empty() ? "" : ", which " + user + " holds,") +
                     " is not defined in the file, nor among the common ones; \"definitions\" in the map's \"bag\" "
                     "names a folder of .msg files");
  }

  std::size_t add(const std::string& type, const std::string& user) {
    if (const auto known = index_.find(type); known != index_.end()) {
      if (open_.contains(type)) throw InputError("type " + type + " holds itself");
      return known->second;
    }
    if (schema_.types.size() >= most_types) throw InputError("type " + type + " is made of too many types");
    const std::string& text = text_of(type, user);
    const std::size_t at = schema_.types.size();
    index_[type] = at;
    open_.insert(type);
    schema_.types.push_back({type, {}, 0});
    std::vector<Field> fields;
    std::istringstream in(text);
    int number = 0;
    for (std::string line; std::getline(in, line);) read_line(type, line, ++number, fields);
    // An empty structure has one octet in ROS 2.
    if (fields.empty() && schema_.wire == Wire::cdr)
      fields.push_back({"structure_needs_at_least_one_member", Kind::uint8, 0, Field::Many::one, 1});
    std::uint64_t least = 0;
    for (const Field& field : fields) least = std::min(too_many, least + least_bytes(field));
    schema_.types[at].least_bytes = least;
    schema_.types[at].fields = std::move(fields);
    open_.erase(type);
    return at;
  }

  std::uint64_t least_bytes(const Field& field) const {
    if (field.many == Field::Many::variable) return 4;
    std::uint64_t one = size_of(field.kind);
    if (field.kind == Kind::time || field.kind == Kind::duration) one = 8;
    if (field.kind == Kind::text || field.kind == Kind::wide_text) one = 4;
    if (field.kind == Kind::message) one = schema_.types[field.type].least_bytes;
    return limited_product(field.count, one);
  }

  void read_line(const std::string& type, const std::string& line, int number, std::vector<Field>& fields) {
    const auto words = words_of(line);
    if (words.empty()) return;
    const auto refuse = [&](const std::string& why) {
      throw InputError("definition of " + type + ", line " + std::to_string(number) + ", \"" + line + "\": " + why);
    };
    if (words.size() < 2) refuse("expected a type and a name");
    if (words[1].find('=') != std::string::npos || (words.size() > 2 && words[2].starts_with('=')))
      return;  // a constant
    // Definitions of ROS 1 serve for ROS 2 as well: its header has one number less.
    if (schema_.wire == Wire::cdr && type == "std_msgs/Header" && words[1] == "seq") return;
    Field field;
    field.name = words[1];
    std::string base = words[0];
    if (const std::size_t bracket = base.find('['); bracket != std::string::npos) {
      const std::string inside = base.substr(bracket + 1, base.size() - bracket - 2);
      if (base.back() != ']') refuse("the bracket is not closed");
      field.many = inside.empty() || inside.starts_with("<=") ? Field::Many::variable : Field::Many::fixed;
      if (field.many == Field::Many::fixed) {
        const auto [stop, code] = std::from_chars(inside.data(), inside.data() + inside.size(), field.count);
        if (code != std::errc() || stop != inside.data() + inside.size()) refuse("expected a number of elements");
      }
      base.resize(bracket);
    }
    base.resize(std::min(base.size(), base.find("<=")));  // string<=10
    if (const auto simple = kind_of(base.find('/') == std::string::npos ? base : short_type(base), schema_.wire)) {
      field.kind = *simple;
    } else {
      // A bare "Header" is that of std_msgs in ROS 1, and in ROS 2 where the package has none of its own.
      const std::string own = package_of(type) + "/" + base;
      const bool has_own = schema_.wire == Wire::cdr && (own_.contains(own) || others_.contains(own));
      const std::string inner = has_own ? own : full_type(base, type);
      if (const auto stamp = kind_of(inner, schema_.wire)) {
        field.kind = *stamp;  // Time within builtin_interfaces
      } else {
        field.kind = Kind::message;
        field.type = add(inner, type);
      }
    }
    fields.push_back(std::move(field));
  }

  const Definitions& others_;
  Definitions own_;
  Schema schema_;
  std::map<std::string, std::size_t> index_;
  std::set<std::string> open_;  // types that are being read
};

struct PathList {
  const Schema& schema;
  std::uint64_t longest_array;
  std::size_t most;
  std::size_t looked_at = 0;  // fields: types may nest so that there are many without a number
  std::vector<std::string> paths{};

  void add(const MessageType& type, const std::string& before) {
    for (const Field& field : type.fields) {
      if (field.many == Field::Many::variable || (field.many == Field::Many::fixed && field.count > longest_array))
        continue;
      for (std::uint64_t k = 0; k < field.count; ++k) {
        if (paths.size() >= most || ++looked_at > 100 * most) return;
        const std::string path =
            before + field.name + (field.many == Field::Many::fixed ? "[" + std::to_string(k) + "]" : "");
        if (is_number(field.kind))
          paths.push_back(path);
        else if (field.kind == Kind::message)
          add(schema.types[field.type], path + ".");
      }
    }
  }
};

}  // namespace

std::size_t size_of(Kind kind) {
  switch (kind) {
    case Kind::boolean:
    case Kind::int8:
    case Kind::uint8:
      return 1;
    case Kind::int16:
    case Kind::uint16:
      return 2;
    case Kind::int32:
    case Kind::uint32:
    case Kind::float32:
    case Kind::time:
    case Kind::duration:
      return 4;
    case Kind::int64:
    case Kind::uint64:
    case Kind::float64:
      return 8;
    case Kind::text:
    case Kind::wide_text:
    case Kind::message:
      break;
  }
  return 0;
}

bool is_number(Kind kind) { return size_of(kind) > 0; }

std::string short_type(std::string_view type) {
  const std::size_t first = type.find('/'), last = type.rfind('/');
  if (first == std::string_view::npos || first == last) return std::string(type);
  return std::string(type.substr(0, first)) + std::string(type.substr(last));
}

Schema parse_schema(const std::string& type, const std::string& text, Wire wire, const Definitions& others) {
  const std::string name = short_type(type);
  if (name.find('/') == std::string::npos) throw InputError("\"" + type + "\" is not a type; expected package/Type");
  return SchemaParser(wire, others).parse(name, text);
}

Definitions definitions_in(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  Definitions all;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const fs::path& file = it->path();
    if (file.extension() != ".msg") continue;
    fs::path package = file.parent_path();
    if (package.filename() == "msg") package = package.parent_path();
    all[package.filename().string() + "/" + file.stem().string()] = read_bytes(file);
  }
  if (error) throw InputError(folder.string() + ": " + error.message());
  if (all.empty()) throw InputError(folder.string() + ": no .msg files; expected PACKAGE/msg/TYPE.msg");
  return all;
}

std::vector<std::string> number_paths(const Schema& schema, std::uint64_t longest_array, std::size_t most) {
  PathList list{schema, longest_array, most};
  list.add(schema.root(), "");
  return std::move(list.paths);
}

}  // namespace gripline::bags
