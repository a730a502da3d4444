#include "bags/message_fields.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include "config/errors.hpp"
#include "util/numbers.hpp"

namespace gripline::bags {
namespace {

constexpr const char* quaternion = "geometry_msgs/Quaternion";
constexpr const char* header_type = "std_msgs/Header";

/// "data[3]" is the name "data" and what stands in the bracket.
std::string name_of(const std::string& word) { return word.substr(0, word.find('[')); }

/// Bytes of one element of a field, at least.
std::uint64_t least_of(const Field& field, const Schema& schema) {
  if (field.kind == Kind::time || field.kind == Kind::duration) return 8;
  if (field.kind == Kind::text || field.kind == Kind::wide_text) return 4;
  return field.kind == Kind::message ? schema.types[field.type].least_bytes : size_of(field.kind);
}

}  // namespace

/// The bytes of a message that are not read yet.
class FieldReader::Bytes {
 public:
  Bytes(std::span<const std::byte> all, Wire wire) : all_(all) {
    if (wire == Wire::ros1) return;
    // The encapsulation of CDR: two bytes of identifier, two of options; positions count from behind it.
    need(4);
    const unsigned id = std::to_integer<unsigned>(all[0]) << 8U | std::to_integer<unsigned>(all[1]);
    if (id == 0x28b5) throw InputError("it is compressed (zstd); expected a recording without compression by message");
    if (id != 0 && id != 1 && id != 6 && id != 7)
      throw InputError("it is not plain CDR: it begins with the identifier " + std::to_string(id));
    swap_ = id % 2 == 0;
    widest_ = id < 6 ? 8 : 4;
    all_ = all.subspan(4);
  }

  std::uint64_t left() const { return all_.size() - at_; }
  void align(std::size_t size) {
    if (widest_ == 0) return;
    const std::size_t to = std::min(size, widest_), over = at_ % to;
    if (over != 0) skip(to - over);
  }
  void skip(std::uint64_t count) {
    need(count);
    at_ += static_cast<std::size_t>(count);
  }
  template <class T>
  T take() {
    align(sizeof(T));
    need(sizeof(T));
    std::array<std::byte, sizeof(T)> raw;
    std::memcpy(raw.data(), all_.data() + at_, sizeof(T));
    if (swap_) std::reverse(raw.begin(), raw.end());
    at_ += sizeof(T);
    return std::bit_cast<T>(raw);
  }
  std::size_t position() const { return at_; }
  void go_to(std::size_t position) { at_ = position; }
  bool cdr() const { return widest_ != 0; }
  bool second_cdr() const { return widest_ == 4; }
  void check_elements(std::uint64_t count, std::uint64_t least) const {
    if (least > 0 && count > left() / least)
      throw InputError("an array of " + std::to_string(count) + " elements, where " + std::to_string(left()) +
                       " bytes are left");
  }

 private:
  void need(std::uint64_t count) const {
    if (count > left())
      throw InputError("it ends within a field: " + std::to_string(count) + " bytes expected, " +
                       std::to_string(left()) + " are left");
  }
  std::span<const std::byte> all_;
  std::size_t at_ = 0, widest_ = 0;  // largest alignment; 0: none
  bool swap_ = false;                // numbers here are written the other way round than this machine's
};

FieldReader::Pick& FieldReader::Pick::add(std::uint64_t index) {
  const auto found = std::find(which.begin(), which.end(), index);
  if (found != which.end()) return part[static_cast<std::size_t>(found - which.begin())];
  which.push_back(index);
  return part.emplace_back();
}

const FieldReader::Pick* FieldReader::Pick::find(std::uint64_t index) const {
  const auto found = std::find(which.begin(), which.end(), index);
  return found == which.end() ? nullptr : &part[static_cast<std::size_t>(found - which.begin())];
}

FieldReader::FieldReader(Schema schema, const std::vector<std::string>& paths, std::int64_t zero)
    : schema_(std::move(schema)), zero_(zero), values_(paths.size()), paths_(paths.size()) {
  static_assert(std::endian::native == std::endian::little);
  for (std::size_t i = 0; i < paths.size(); ++i) choose(paths[i], i);
  const auto& fields = schema_.root().fields;
  for (std::size_t f = 0; f < fields.size() && !header_; ++f) {
    if (fields[f].kind != Kind::message || fields[f].many != Field::Many::one) continue;
    const MessageType& type = schema_.types[fields[f].type];
    if (type.name != header_type) continue;
    for (std::size_t s = 0; s < type.fields.size(); ++s)
      if (type.fields[s].kind == Kind::time && type.fields[s].many == Field::Many::one)
        root_.add(f).add(s).stamp = header_ = true;
  }
}

void FieldReader::refuse_path(const std::string& path, const std::string& why) const {
  throw InputError("\"" + path + "\" of " + schema_.root().name + ": " + why);
}

/// The element that a word of the path names.
FieldReader::Pick* FieldReader::choose_element(const std::string& path, const std::string& word, const Field& field,
                                               Pick& of) const {
  const std::size_t bracket = word.find('[');
  if (field.many == Field::Many::one) {
    if (bracket != std::string::npos) refuse_path(path, field.name + " is not an array");
    return &of;
  }
  if (bracket == std::string::npos) refuse_path(path, field.name + " is an array: expected " + field.name + "[0]");
  std::uint64_t index = 0;
  const char* const end = word.data() + word.size() - 1;
  if (word.back() != ']') refuse_path(path, "expected " + field.name + "[0]");
  const auto [stop, code] = std::from_chars(word.data() + bracket + 1, end, index);
  if (code != std::errc() || stop != end) refuse_path(path, "expected " + field.name + "[0]");
  if (field.many == Field::Many::fixed && index >= field.count)
    refuse_path(path, field.name + " has " + std::to_string(field.count) + " elements, counted from 0");
  return &of.add(index);
}

void FieldReader::choose(const std::string& path, std::size_t slot) {
  const MessageType* type = &schema_.types.front();
  Pick* pick = &root_;
  for (std::size_t begin = 0; type != nullptr;) {
    const std::size_t dot = std::min(path.find('.', begin), path.size());
    const std::string word = path.substr(begin, dot - begin), name = name_of(word);
    begin = dot + 1;
    const auto& fields = type->fields;
    const auto found = std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.name == name; });
    if (found == fields.end()) {
      if (word == "yaw" && dot == path.size() && choose_yaw(*type, *pick, slot)) return;
      std::vector<std::string> known = number_paths(schema_, 3, 200);
      const auto near = nearest(path, known);
      std::vector<std::string> here;
      for (const Field& field : fields) here.push_back(field.name);
      refuse_path(path,
                  "no \"" + name + "\"" + (near ? "; did you mean \"" + *near + "\"?" : did_you_mean(name, here)));
    }
    pick = choose_element(path, word, *found, pick->add(static_cast<std::uint64_t>(found - fields.begin())));
    if (found->kind == Kind::text || found->kind == Kind::wide_text) refuse_path(path, "it is a text, not a number");
    type = found->kind == Kind::message ? &schema_.types[found->type] : nullptr;
    if (type == nullptr && dot < path.size()) refuse_path(path, name + " is a number and has no members");
    if (type != nullptr && dot == path.size()) {
      std::string members;
      for (const Field& field : type->fields) members += (members.empty() ? "" : ", ") + field.name;
      refuse_path(path, "it is a " + type->name + ", not a number; its members: " + members);
    }
  }
  pick->slots.push_back(slot);
}

/// The heading of a turn about the vertical, from the four numbers. False where the type is no quaternion.
bool FieldReader::choose_yaw(const MessageType& type, Pick& of, std::size_t slot) {
  if (type.name != quaternion) return false;
  Turn turn{slot, {}};
  constexpr std::array<const char*, 4> names = {"x", "y", "z", "w"};
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto field = std::find_if(type.fields.begin(), type.fields.end(), [&](const Field& f) {
      return f.name == names[k] && is_number(f.kind) && f.many == Field::Many::one;
    });
    if (field == type.fields.end()) return false;
    turn.from[k] = values_.size();
    of.add(static_cast<std::uint64_t>(field - type.fields.begin())).slots.push_back(values_.size());
    values_.push_back(not_a_number);
  }
  turns_.push_back(turn);
  return true;
}

bool FieldReader::turns(std::size_t path) const {
  return std::any_of(turns_.begin(), turns_.end(), [&](const Turn& turn) { return turn.slot == path; });
}

std::span<const double> FieldReader::read(std::span<const std::byte> message) {
  std::fill(values_.begin(), values_.end(), not_a_number);
  stamp_.reset();
  Bytes bytes(message, schema_.wire);
  read_message(schema_.root(), &root_, bytes);
  // Some writers of CDR fill up to four bytes.
  if (bytes.left() > (bytes.cdr() ? 3U : 0U))
    throw InputError(std::to_string(bytes.left()) + " bytes more than " + schema_.root().name +
                     " has; its definition is another one");
  for (const Turn& turn : turns_) {
    const double x = values_[turn.from[0]], y = values_[turn.from[1]], z = values_[turn.from[2]],
                 w = values_[turn.from[3]];
    // Four zeros are what drivers write that know no orientation.
    if (!(x * x + y * y + z * z + w * w > 0.25)) continue;
    values_[turn.slot] = std::atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z);
  }
  return {values_.data(), paths_};
}

void FieldReader::read_message(const MessageType& type, const Pick* pick, Bytes& bytes) {
  for (std::size_t f = 0; f < type.fields.size(); ++f)
    read_field(type.fields[f], pick == nullptr ? nullptr : pick->find(f), bytes);
}

void FieldReader::read_field(const Field& field, const Pick* pick, Bytes& bytes) {
  const bool one = field.many == Field::Many::one;
  const std::uint64_t count = field.many == Field::Many::variable ? bytes.take<std::uint32_t>() : field.count;
  const std::uint64_t least = least_of(field, schema_);
  if (!one && !is_number(field.kind) && bytes.second_cdr())
    throw InputError(field.name + " is an array of " + (field.kind == Kind::message ? "messages" : "texts") +
                     " in the second version of CDR, which is not read");
  if (!one) bytes.check_elements(count, least);
  if (is_number(field.kind)) return read_numbers(field, count, pick, bytes);
  if (least == 0) return;  // messages without members
  for (std::uint64_t k = 0; k < count; ++k) {
    if (field.kind == Kind::message) {
      const Pick* const element = one || pick == nullptr ? pick : pick->find(k);
      read_message(schema_.types[field.type], element, bytes);
      continue;
    }
    if (field.kind == Kind::wide_text && bytes.cdr())
      throw InputError(field.name + " is a text of wide characters, whose size in bytes writers disagree about");
    bytes.skip(bytes.take<std::uint32_t>());
  }
}

void FieldReader::read_numbers(const Field& field, std::uint64_t count, const Pick* pick, Bytes& bytes) {
  if (count == 0) return;
  const std::uint64_t each = least_of(field, schema_);
  bytes.align(size_of(field.kind));
  if (field.many == Field::Many::one) {
    if (pick != nullptr)
      read_number(field.kind, *pick, bytes);
    else
      bytes.skip(each);
    return;
  }
  bytes.check_elements(count, each);
  const std::size_t begin = bytes.position();
  for (std::size_t k = 0; pick != nullptr && k < pick->which.size(); ++k) {
    if (pick->which[k] >= count) continue;
    bytes.go_to(begin + static_cast<std::size_t>(pick->which[k] * each));
    read_number(field.kind, pick->part[k], bytes);
  }
  bytes.go_to(begin + static_cast<std::size_t>(count * each));
}

void FieldReader::read_number(Kind kind, const Pick& pick, Bytes& bytes) {
  double value = not_a_number;
  switch (kind) {
    case Kind::boolean:
      value = bytes.take<std::uint8_t>() != 0 ? 1.0 : 0.0;
      break;
    case Kind::int8:
      value = bytes.take<std::int8_t>();
      break;
    case Kind::uint8:
      value = bytes.take<std::uint8_t>();
      break;
    case Kind::int16:
      value = bytes.take<std::int16_t>();
      break;
    case Kind::uint16:
      value = bytes.take<std::uint16_t>();
      break;
    case Kind::int32:
      value = bytes.take<std::int32_t>();
      break;
    case Kind::uint32:
      value = bytes.take<std::uint32_t>();
      break;
    case Kind::int64:
      value = static_cast<double>(bytes.take<std::int64_t>());
      break;
    case Kind::uint64:
      value = static_cast<double>(bytes.take<std::uint64_t>());
      break;
    case Kind::float32:
      value = bytes.take<float>();
      break;
    case Kind::float64:
      value = bytes.take<double>();
      break;
    case Kind::time: {
      // Seconds have no sign in ROS 1 and one in ROS 2, where no recording is from before 1970.
      const std::int64_t seconds = bytes.take<std::uint32_t>();
      const std::int64_t stamp = seconds * 1'000'000'000 + bytes.take<std::uint32_t>();
      if (pick.stamp) stamp_ = stamp;
      value = 1e-9 * static_cast<double>(stamp - zero_);
      break;
    }
    case Kind::duration: {
      const double seconds = bytes.take<std::int32_t>();
      value = seconds + 1e-9 * bytes.take<std::int32_t>();
      break;
    }
    case Kind::text:
    case Kind::wide_text:
    case Kind::message:
      break;
  }
  for (const std::size_t slot : pick.slots) values_[slot] = value;
}

}  // namespace gripline::bags
