#include "experiment/experiment.hpp"

#include <algorithm>

#include "config/file_kind.hpp"
#include "config/files.hpp"
#include "config/json_file.hpp"
#include "config/merge_patch.hpp"
#include "experiment/out_folder.hpp"

namespace gripline {
namespace {

constexpr std::size_t longest_name = 100;

bool is_plain_name(const std::string& name) {
  return !name.empty() && name.front() != '-' && name.front() != '.' && name.back() != '.' &&
         std::all_of(name.begin(), name.end(),
                     [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.'; });
}

std::size_t count_values(const Node& node) {
  std::size_t count = 1;
  if (node.is_array())
    for (const Node& one : node.array()) count += count_values(one);
  if (node.is_object())
    for (const Member& one : node.object()) count += count_values(one.value);
  return count;
}

void read_stacks(ObjectReader& r, const Registry& registry, RaceSpec& race, Errors& errors) {
  static const Node nothing = Node::empty_object();
  const Node* base = r.find("base");
  if (base == nullptr) base = &nothing;
  ObjectReader stacks = r.object("stacks");
  const std::size_t count = stacks.node().is_object() ? stacks.node().object().size() : 0;
  if (count * count_values(*base) > 10 * json_limits.values) {
    stacks.error("its " + std::to_string(count) + " stacks repeat a base of " + std::to_string(count_values(*base)) +
                 " values; that is more than " + std::to_string(10 * json_limits.values) + " together");
    return;
  }
  for (const Member* member : stacks.members()) {
    errors.set_context("stack " + member->key);
    if (!is_plain_name(member->key))
      errors.add(member->key_origin(),
                 "a stack's name is a folder and a word of claims: letters, digits, _, - and dots inside only");
    if (member->key.size() > longest_name)
      errors.add(member->key_origin(), "a stack's name is a folder: expected at most " + std::to_string(longest_name) +
                                           " letters, found " + std::to_string(member->key.size()));
    if (is_result_name(member->key))
      errors.add(member->key_origin(), "a stack's name is a folder among the results: \"" + member->key +
                                           "\" is the name of another one of them");
    race.stacks.push_back(read_stack(member->key, merge(*base, member->value), registry, race.world.car, errors));
    check_sensors(race.stacks.back(), race.world.sensors, errors);
  }
  errors.set_context("");
  if (race.stacks.empty() && r.has("stacks")) stacks.error("an experiment needs at least one stack");
}

/// Refuses an assignment into a stack that is not there: it would add one, most likely by a misspelt name.
void refuse_new_stack(const Node& tree, const std::string& assignment) {
  const std::string pointer = assignment.substr(0, assignment.find('='));
  const Node* const stacks = tree.find("stacks");
  if (!pointer.starts_with("/stacks/") || stacks == nullptr || !stacks->is_object()) return;
  const std::vector<std::string> names = split_pointer(pointer);
  if (names.size() < 3) return;
  std::vector<std::string> known;
  for (const Member& member : stacks->object())
    if (!member.value.is_null()) known.push_back(member.key);
  if (std::ranges::find(known, names[1]) != known.end()) return;
  throw InputError(
      {Diagnostic{"--set", 0, 0, pointer, "no stack \"" + names[1] + "\"" + did_you_mean(names[1], known), {}}});
}

/// Puts a world's files in their places.
void expand_world(Node* world) {
  if (world == nullptr) return;
  inline_file_of(*world, FileKind::world);
  inline_world_files(*world);
}

/// Every world that an experiment of any kind names.
void expand(Node& tree) {
  expand_world(tree.find("world"));
  expand_world(tree.find("nominal"));
  for (const char* drive : {"train", "test"})
    if (Node* const one = tree.find(drive); one != nullptr) expand_world(one->find("world"));
}

bool is_input_name(const Node& node) {
  return node.is_text() &&
         std::ranges::any_of(input_endings, [&](std::string_view ending) { return node.text().ends_with(ending); });
}

/// Calls use(text node, path) for every text that names a file that is there. Files of other names are refused where
/// they would be read (why_no_input()).
template <class N, class Use>
void each_file(N& node, Use&& use) {
  if (node.is_object()) {
    for (auto& member : node.object()) each_file(member.value, use);
  } else if (node.is_array()) {
    for (auto& one : node.array()) each_file(one, use);
  } else if (is_input_name(node)) {
    const std::filesystem::path file = std::filesystem::absolute(resolve_path(node)).lexically_normal();
    std::error_code ignored;
    if (std::filesystem::is_regular_file(file, ignored)) use(node, file);
  }
}

}  // namespace

Node load_experiment(const std::filesystem::path& file, std::span<const std::string> assignments) {
  if (file.extension() == ".csv" && why_unreadable(file).empty())
    throw InputError({Diagnostic{.file = shown(file), .message = "is a table, expected an experiment"}});
  Node tree = load_json(file);
  expect_kind(tree, FileKind::experiment);
  expand(tree);
  for (const std::string& assignment : assignments) assign_in_experiment(tree, assignment);
  return tree;
}

void assign_in_experiment(Node& tree, const std::string& assignment) {
  refuse_new_stack(tree, assignment);
  apply_assignment(tree, assignment);
  expand(tree);  // the next one may reach into a file that this one named
}

std::vector<std::uint64_t> read_seeds(const Node& node, Errors& errors) {
  if (!node.is_object()) {
    errors.add(node.origin, "expected {\"first\", \"count\"}, such as {\"first\": 1, \"count\": " +
                                (node.is_number() ? node.describe() : "3") + "}; found " + node.describe());
    return {1};
  }
  ObjectReader r(node, errors);
  const std::int64_t first = r.integer("first", {0, largest_seed}, 1), count = r.integer("count", {1, 100'000}, 1);
  std::vector<std::uint64_t> seeds;
  for (std::int64_t i = 0; i < count; ++i) seeds.push_back(static_cast<std::uint64_t>(first + i));
  return seeds;
}

std::string experiment_kind(const Node& tree) {
  const Node* const kind = tree.find("kind");
  return kind != nullptr && kind->is_text() ? kind->text() : "race";
}

std::size_t read_kind(const Node& tree, const std::vector<std::string>& names) {
  const Node* const kind = tree.find("kind");
  if (kind == nullptr || kind->is_null()) return 0;
  Errors errors;
  const std::size_t index = read_choice(*kind, names, errors);
  errors.throw_if_any();
  return index;
}

RaceSpec read_race(const std::filesystem::path& file, Node tree, const Registry& registry) {
  RaceSpec race;
  race.name = file.stem().string();
  race.tree = std::move(tree);
  Errors errors;
  {
    ObjectReader r(race.tree, errors);
    r.find("kind");  // checked by the caller, who chose this reader by it
    if (const Node* world = r.require("world", "a world file or an object"); world != nullptr)
      race.world = read_world(*world, registry, errors);
    race.seeds = {1};
    if (const Node* seeds = r.find("seeds"); seeds != nullptr) race.seeds = read_seeds(*seeds, errors);
    read_stacks(r, registry, race, errors);
    if (const Node* perturb = r.find("perturb"); perturb != nullptr)
      race.perturb = read_perturb(*perturb, race.world, race.stacks, errors);
    std::vector<std::string> names;
    for (const StackSpec& stack : race.stacks) names.push_back(stack.name);
    const std::span<const Node> claims = r.array("claims", false);
    // Without stacks every claim would be wrong too: one message is enough.
    for (const Node& node : names.empty() ? std::span<const Node>{} : claims)
      if (std::optional<Claim> claim = read_claim(node, names, errors)) race.claims.push_back(*std::move(claim));
    race.claim_share = r.number("claim_share", "1", NumberRange::closed(0, 1), 0.8);
    r.finish();
  }
  errors.throw_if_any();
  return race;
}

Node RaceSpec::run_tree(const std::string& stack, std::uint64_t seed) const {
  Node one = tree;
  const Node* const base = tree.find("base");
  const Node* const patch = tree.find("stacks")->find(stack);
  Node stacks = Node::empty_object();
  stacks.set(stack, merge(base != nullptr ? *base : Node::empty_object(), *patch));
  Node seeds = Node::empty_object();
  seeds.set("first", Node(static_cast<double>(seed)));
  seeds.set("count", Node(1.0));
  one.erase("base");
  one.erase("claims");
  one.set("seeds", std::move(seeds));
  one.set("stacks", std::move(stacks));
  drop_removed(one);
  // The tree will be read from another folder.
  each_file(one, [](Node& node, const std::filesystem::path& file) { node = Node(file.string(), node.origin); });
  return one;
}

std::vector<std::filesystem::path> files_named(const Node& tree) {
  std::vector<std::filesystem::path> files;
  each_file(tree, [&](const Node&, const std::filesystem::path& file) { files.push_back(file); });
  std::sort(files.begin(), files.end());
  return files;
}

std::set<std::filesystem::path> libraries_of(const WorldSpec& world, std::span<const StackSpec> stacks) {
  std::set<std::filesystem::path> used;
  const auto use = [&](const PluginSpec& spec) {
    if (!spec.empty()) used.insert(spec.entry->library);
  };
  const auto use_vehicle = [&](const VehicleSpec& vehicle) {
    use(vehicle.model);
    for (const PluginSpec& effect : vehicle.effects) use(effect);
  };
  use(world.plant);
  use_vehicle(world.vehicle);
  for (const StackSpec& stack : stacks) {
    use_vehicle(stack.model);
    for (const PluginSpec* spec : {&stack.estimator, &stack.planner, &stack.controller}) use(*spec);
  }
  return used;
}

}  // namespace gripline
