#include "sweep/store.hpp"

#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <stdexcept>

#include "config/errors.hpp"
#include "config/files.hpp"
#include "config/hash.hpp"
#include "config/json_file.hpp"
#include "util/disk.hpp"
#include "util/machine.hpp"
#include "util/whole_file.hpp"

namespace gripline::sweep {
namespace fs = std::filesystem;
namespace {

Node values_node(const Values& values) {
  Node node = Node::empty_object();
  for (const auto& [name, value] : values)
    if (std::isfinite(value)) node.set(name, Node(value));
  return node;
}

Values values_of(const Node* node) {
  Values values;
  if (node != nullptr && node->is_object())
    for (const Member& member : node->object())
      if (member.value.is_number()) values.emplace_back(member.key, member.value.number());
  return values;
}

std::string text_of(const Node& node, std::string_view key) {
  const Node* const value = node.find(key);
  return value != nullptr && value->is_text() ? value->text() : std::string();
}

/// The record as text, with the hash of all the rest.
std::string record_text(const Record& record) {
  Node node = Node::empty_object();
  node.set("key", Node(record.key));
  node.set("status", Node(record.status));
  node.set("message", Node(record.message));
  node.set("values", values_node(record.values));
  node.set("times", values_node(record.times));
  node.set("node", Node(record.node));
  if (!record.drive.empty()) node.set("drive", Node(record.drive));
  node.set("sha256", Node(sha256_hex(content_text(node))));
  return to_json_text(node);
}

[[noreturn]] void fail(const fs::path& file) { fail_with_errno("cannot write " + file.string()); }

/// A name with this machine and process in it, so that no other process writes to the same file.
std::string own_name() { return this_machine() + "." + std::to_string(getpid()); }

}  // namespace

fs::path Store::place(const std::string& key, bool broken) const {
  return results_ / key.substr(0, 2) / (key + (broken ? ".broken.json" : ".json"));
}

bool Store::has(const std::string& key, bool broken_counts) const {
  return access(place(key, false).c_str(), F_OK) == 0 || (broken_counts && access(place(key, true).c_str(), F_OK) == 0);
}

std::optional<Record> Store::read(const std::string& key) const {
  for (const bool broken : {false, true}) {
    const fs::path file = place(key, broken);
    if (access(file.c_str(), F_OK) != 0) continue;
    try {
      Node node = parse_file(file);
      const std::string hash = text_of(node, "sha256");
      node.erase("sha256");
      Record record{text_of(node, "key"),           text_of(node, "status"),       text_of(node, "message"),
                    values_of(node.find("values")), values_of(node.find("times")), text_of(node, "node"),
                    text_of(node, "drive")};
      if (hash == sha256_hex(content_text(node)) && record.key == key) return record;
    } catch (const InputError&) {
    }
    disk().remove_all(file);
  }
  return std::nullopt;
}

void Store::write(const Record& record) const {
  const fs::path file = place(record.key, record.broken());
  if (!disk().make_folders(file.parent_path())) fail(file);
  const fs::path aside = file.parent_path() / ("." + record.key + "." + own_name() + ".partial");
  const int handle = disk().create_anew(aside);
  if (handle < 0) fail(file);
  const bool written = disk().write(handle, record_text(record)) && disk().sync(handle);
  int why = errno;
  disk().close(handle);
  errno = why;
  if (!written || !disk().rename(aside, file)) {
    why = errno;
    disk().remove_all(aside);
    errno = why;
    fail(file);
  }
  (void)disk().sync_folder(file.parent_path());  // if the rename is lost by a power failure, the run is done again
  if (!record.broken()) disk().remove_all(place(record.key, true));
  disk().remove_all(note_of(record.key));
}

fs::path Store::note_of(const std::string& key) const { return results_ / key.substr(0, 2) / (key + ".missing.txt"); }

void Store::note_missing(const std::string& key, const std::string& why) const {
  try {
    if (disk().make_folders(note_of(key).parent_path())) write_file(note_of(key), why);
  } catch (const std::runtime_error&) {
  }
}

std::string Store::why_missing(const std::string& key) const {
  const fs::path file = note_of(key);
  if (access(file.c_str(), F_OK) != 0) return {};
  try {
    return read_bytes(file);
  } catch (const InputError&) {
    return {};
  }
}

void Store::remove_partial() const {
  std::error_code failed;
  for (const auto& folder : fs::directory_iterator(results_, failed)) {
    std::vector<fs::path> half;
    for (const auto& entry : fs::directory_iterator(folder.path(), failed))
      if (entry.path().filename().string().ends_with(".partial")) half.push_back(entry.path());
    for (const fs::path& file : half) disk().remove_all(file);
  }
}

}  // namespace gripline::sweep
