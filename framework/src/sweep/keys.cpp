#include "sweep/keys.hpp"

#include <algorithm>
#include <set>
#include <span>

#include "config/errors.hpp"
#include "config/hash.hpp"
#include "config/json_file.hpp"
#include "config/merge_patch.hpp"
#include "experiment/experiment.hpp"

namespace gripline::sweep {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t nowhere = ~std::size_t{0};

bool is_no_input(const std::string& member) {
  return member == "claims" || member == "claim_share" || member == "note";
}

/// Calls use(member, id) for every plugin that the texts of a tree choose; `member` is the one that holds it.
template <class Use>
void each_plugin(const std::string& member, const Node& node, const Use& use) {
  if (node.is_object()) {
    for (const Member& inner : node.object()) {
      if (inner.key == "plugin" && inner.value.is_text()) use(member, inner.value.text());
      each_plugin(inner.key, inner.value, use);
    }
  } else if (node.is_array()) {
    for (const Node& one : node.array()) each_plugin(member, one, use);
  }
}

/// Whether a member of an experiment may hold a plugin of this kind.
bool may_hold(const std::string& member, abi::Kind kind) {
  static const std::map<std::string, std::vector<abi::Kind>> kinds = {
      {"model", {abi::Kind::vehicle}},         {"plant", {abi::Kind::plant, abi::Kind::vehicle}},
      {"effects", {abi::Kind::effect}},        {"estimator", {abi::Kind::estimator}},
      {"planner", {abi::Kind::planner}},       {"estimators", {abi::Kind::estimator}},
      {"controller", {abi::Kind::controller}},
  };
  const auto known = kinds.find(member);
  return known == kinds.end() || std::ranges::find(known->second, kind) != known->second.end();
}

Node row_tree(const Node& tree, const SweptKind& kind, const std::string& row) {
  const Node* const rows = tree.find(kind.rows);
  const Node* const patch = rows != nullptr ? rows->find(row) : nullptr;
  if (patch == nullptr) throw InputError("no \"" + row + "\" among the " + kind.rows + " of a setting");
  const Node* const base = kind.merges_base ? tree.find("base") : nullptr;
  return base != nullptr ? merge(*base, *patch) : *patch;
}

}  // namespace

Trees::Trees(const Sweep& sweep) : sweep_(sweep), at_(sweep.parts.size(), nowhere) {
  const std::vector<std::string> all = assignments_of(sweep.assignments, sweep.design, 0);
  fixed_ = constants_before_factors(sweep.assignments);
  for (std::size_t i = fixed_; i < all.size(); ++i)
    changing_.insert(split_pointer(all[i].substr(0, all[i].find('='))).front());
  for (const Part& part : sweep.parts) {
    trees_.push_back(load_experiment(part.file, std::span(all).first(fixed_)));
    Node kept = Node::empty_object();
    for (const std::string& member : changing_)
      if (const Node* const value = trees_.back().find(member); value != nullptr) kept.set(member, *value);
    untouched_.push_back(std::move(kept));
    kinds_.push_back(&kind_named(part.kind));
  }
}

const Node& Trees::setting(std::size_t part, std::size_t setting) {
  Node& tree = trees_[part];
  if (at_[part] == setting) return tree;
  at_[part] = nowhere;
  for (const std::string& member : changing_)
    if (const Node* const value = untouched_[part].find(member); value != nullptr)
      tree.set(member, *value);
    else
      tree.erase(member);
  const std::vector<std::string> all = assignments_of(sweep_.assignments, sweep_.design, setting);
  for (std::size_t i = fixed_; i < all.size(); ++i) assign_in_experiment(tree, all[i]);
  at_[part] = setting;
  return tree;
}

Node Trees::run_tree(const RunAt& run, const std::vector<std::string>& rows) {
  const Node& tree = setting(run.part, run.setting);
  const SweptKind& kind = *kinds_[run.part];
  Node one(Node::Object{}, tree.origin);
  for (const Member& member : tree.object())
    if (!is_no_input(member.key) && (kind.rows == nullptr || member.key != kind.rows) &&
        !(kind.merges_base && member.key == "base"))
      one.set(member.key, member.value);
  if (kind.rows != nullptr) {
    Node chosen = Node::empty_object();
    for (const std::string& row : rows) chosen.set(row, row_tree(tree, kind, row));
    one.set(kind.rows, std::move(chosen));
  }
  if (kind.seeds == nullptr) return one;
  Node seed(static_cast<double>(run.seed));
  if (std::string_view(kind.seeds) == "seeds") {
    Node seeds = Node::empty_object();
    seeds.set("first", std::move(seed));
    seeds.set("count", Node(1.0));
    seed = std::move(seeds);
  }
  one.set(kind.seeds, std::move(seed));
  return one;
}

Keys::Keys(const Sweep& sweep, const Registry& registry)
    : sweep_(sweep), trees_(sweep), registry_(registry), unchanged_(sweep.parts.size()) {
  for (const PluginEntry& entry : registry.entries()) plugins_.emplace(entry.decl->id, &entry);
}

bool Keys::files_unchanged() const {
  return std::ranges::all_of(files_, [&](const auto& one) { return hashes_.unchanged(one.first); });
}

std::string Keys::library_text(const std::set<fs::path>& used) {
  std::set<std::string> lines;
  for (const fs::path& library : used) {
    const std::string name = library.filename().string();
    const std::string& hash = hashes_.of(library);
    libraries_[name].insert(hash);
    lines.insert(name + " " + hash);
  }
  std::string text;
  for (const std::string& line : lines) text += "\n" + line;
  return text;
}

/// What a tree says, and the libraries of the plugins that it chooses. Plugins that are nowhere are reported when the
/// experiment is read.
std::string Keys::node_text(const std::string& member, const Node& node) {
  std::set<fs::path> used;
  each_plugin(member, node, [&](const std::string& holder, const std::string& id) {
    for (auto [one, end] = plugins_.equal_range(id); one != end; ++one)
      if (may_hold(holder, one->second->decl->kind)) used.insert(one->second->library);
  });
  return content_text(node) + library_text(used);
}

const Keys::NamedFile& Keys::named_file(const fs::path& file) {
  const auto [found, fresh] = files_.try_emplace(file);
  NamedFile& named = found->second;
  if (!fresh) return named;
  named.text = hashes_.of(file);
  if (file.extension() != ".json") return named;
  try {
    const Node tree = load_json(file);
    named.text += "\n" + sha256_hex(node_text("", tree));
    named.names = files_named(tree);
  } catch (const InputError&) {  // its bytes are all there is to say of it; who needs it reports what is wrong
  }
  return named;
}

void Keys::add_file(const fs::path& file, std::set<fs::path>& all) {
  if (!all.insert(file).second) return;
  for (const fs::path& next : named_file(file).names) add_file(next, all);
}

std::string Keys::part_text(const std::string& member, const Node& node) {
  std::string text = node_text(member, node);
  std::set<fs::path> files;
  for (const fs::path& file : files_named(node)) add_file(file, files);
  for (const fs::path& file : files) text += "\n" + named_file(file).text;
  return text;
}

/// A diagnosis tries every effect that it finds, whatever its experiment names.
std::string Keys::effects_text() {
  std::set<fs::path> used;
  for (const PluginEntry& entry : registry_.entries())
    if (entry.decl->kind == abi::Kind::effect) used.insert(entry.library);
  return library_text(used);
}

const std::string& Keys::common_text(std::size_t part, std::size_t setting) {
  if (part == part_ && setting == setting_) return common_;
  const Node& tree = trees_.setting(part, setting);
  const SweptKind& kind = trees_.kind(part);
  std::map<std::string, std::string> texts;
  for (const Member& member : tree.object()) {
    const bool row = (kind.rows != nullptr && member.key == kind.rows) || (kind.merges_base && member.key == "base");
    const bool seed = kind.seeds != nullptr && member.key == kind.seeds;
    if (row || seed || is_no_input(member.key) || member.value.is_null()) continue;
    std::string& known = unchanged_[part][member.key];
    if (known.empty() || trees_.changing().contains(member.key)) known = part_text(member.key, member.value);
    texts[member.key] = known;
  }
  common_ = sweep_.program + "\n" + kind.name;
  if (kind.tries_effects) common_ += effects_text();
  for (const auto& [name, text] : texts) common_ += "\n" + name + "\n" + text;
  part_ = part;
  setting_ = setting;
  row_index_ = nowhere;
  return common_;
}

std::string Keys::key(const RunAt& run) {
  const std::string& common = common_text(run.part, run.setting);
  if (row_index_ != run.row) {
    const SweptKind& kind = trees_.kind(run.part);
    std::string text = common;
    if (kind.rows != nullptr) {
      const std::string& name = sweep_.row_of(run);
      text += "\n" + name + "\n" + part_text(kind.rows, row_tree(trees_.setting(run.part, run.setting), kind, name));
    }
    row_ = sha256_hex(text);
    row_index_ = run.row;
  }
  return sha256_hex(row_ + " " + std::to_string(run.seed));
}

}  // namespace gripline::sweep
