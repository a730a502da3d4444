#include "config/tree_diff.hpp"

namespace gripline {
namespace {

bool counts(const Member& member) { return member.key != "note" && !member.value.is_null(); }

/// A value as a message shows it.
std::string shown(const Node& node) {
  constexpr std::size_t longest = 60;
  const std::string text = content_text(node);
  return text.size() <= longest ? text : node.describe();
}

void compare(const Node& before, const Node& after, const std::string& pointer, std::vector<std::string>& out) {
  if (before.is_object() && after.is_object()) {
    for (const Member& member : after.object()) {
      if (!counts(member)) continue;
      const std::string at = join_pointer(pointer, member.key);
      const Node* const old = before.find(member.key);
      if (old == nullptr || old->is_null())
        out.push_back(member.value.is_object() ? at + ": new" : at + ": new, " + shown(member.value));
      else
        compare(*old, member.value, at, out);
    }
    for (const Member& member : before.object()) {
      const Node* const now = after.find(member.key);
      if (counts(member) && (now == nullptr || now->is_null()))
        out.push_back(join_pointer(pointer, member.key) + ": gone");
    }
  } else if (before.is_array() && after.is_array() && before.array().size() == after.array().size()) {
    for (std::size_t i = 0; i < after.array().size(); ++i)
      compare(before.array()[i], after.array()[i], join_pointer(pointer, std::to_string(i)), out);
  } else if (content_text(before) != content_text(after)) {
    out.push_back(pointer + ": " + shown(before) + " -> " + shown(after));
  }
}

}  // namespace

std::vector<std::string> differences(const Node& before, const Node& after) {
  std::vector<std::string> out;
  compare(before, after, "", out);
  return out;
}

}  // namespace gripline
