#include "diagnose/result/case_file.hpp"

#include <algorithm>
#include <array>

#include "config/errors.hpp"
#include "config/file_kind.hpp"
#include "config/json_file.hpp"

namespace gripline::diagnose {

namespace fs = std::filesystem;
using measured::channels;
using measured::Channels;

void read_uncertainty(const Node& node, CaseOptions& options, Errors& errors) {
  if (node.is_null()) return;
  ObjectReader r(node, errors);
  for (const Member* member : r.members())
    options.uncertainty[member->key] = read_number(member->value, "1", NumberRange::non_negative(), errors);
}

void read_uncertainty_of_world(const Node& world, CaseOptions& options, Errors& errors) {
  if (const Node* u = world.find("nominal_uncertainty"); u != nullptr && options.uncertainty.empty())
    read_uncertainty(*u, options, errors);
  const Node* const unknowns = world.find("unknowns");
  if (unknowns == nullptr || !unknowns->is_object()) return;
  constexpr std::string_view parameters = "/plant/params/";
  for (const Member& one : unknowns->object()) {
    // Those on a logarithmic scale have a relative standard deviation.
    if (!one.key.starts_with(parameters) || !one.value.is_object()) continue;
    const Node *const scale = one.value.find("scale"), *const sigma = one.value.find("sigma");
    const bool relative = scale != nullptr && scale->is_text() && scale->text() == "log";
    if (relative && sigma != nullptr && sigma->is_number())
      options.guessed[one.key.substr(parameters.size())] = sigma->number();
  }
}

namespace {

/// The wrong file altogether is one error, not one for each of its keys.
void check_is_case(const fs::path& file, const Node& node) {
  constexpr std::array<const char*, 7> keys = {"vehicle",     "track",   "direction",          "sample_time_s",
                                               "noise_sigma", "exclude", "nominal_uncertainty"};
  if (!node.is_object() ||
      !std::any_of(keys.begin(), keys.end(), [&](const char* k) { return node.find(k) != nullptr; }))
    throw InputError(file.string() +
                     ": is not a case; expected an object with some of vehicle, track, noise_sigma, "
                     "exclude, nominal_uncertainty");
  if (const FileKind kind = kind_of(node); kind == FileKind::world || kind == FileKind::experiment)
    throw InputError(file.string() + ": is " + std::string(kind_text(kind)) + ", expected a case");
}

Channels read_noise(ObjectReader& r) {
  ObjectReader sigma = r.object("noise_sigma");
  Channels values{};
  for (std::size_t c = 0; c < channels; ++c)
    values[c] = sigma.number(measured::channel_info[c].column, measured::channel_info[c].unit,
                             NumberRange::non_negative(), 0.0);
  return values;
}

std::optional<fs::path> read_track(ObjectReader& r, const fs::path& folder) {
  const std::string name = r.text("track");
  for (const fs::path& place : {folder / name, folder / ".." / ".." / "tracks" / name, folder / ".." / "tracks" / name})
    if (fs::is_regular_file(place)) return place;
  r.error_at("track", "no file \"" + name + "\" beside the case or in ../../tracks");
  return std::nullopt;
}

}  // namespace

CaseFile read_case(const fs::path& file) {
  const Node node = load_json(file);
  check_is_case(file, node);
  Errors errors;
  CaseFile out;
  {
    ObjectReader r(node, errors);
    out.vehicle = r.text("vehicle", std::string());
    (void)r.find("direction");
    (void)r.find("sample_time_s");
    for (const Node& id : r.array("exclude", false)) out.options.exclude.push_back(read_text(id, errors));
    if (const Node* uncertainty = r.find("nominal_uncertainty"); uncertainty != nullptr)
      read_uncertainty(*uncertainty, out.options, errors);
    if (r.has("noise_sigma")) out.options.noise_sigma = read_noise(r);
    if (r.has("track")) out.track = read_track(r, file.parent_path());
  }
  errors.throw_if_any();
  return out;
}

void check_excluded(const CaseOptions& options, const Catalogue& catalogue) {
  for (const std::string& id : options.exclude) {
    if (catalogue.find(id) != catalogue.candidates().size()) continue;
    std::vector<std::string> known;
    for (const Candidate& c : catalogue.candidates()) known.push_back(c.id);
    throw InputError("\"exclude\" names \"" + id + "\", which is not an effect that could be found" +
                     did_you_mean(id, known));
  }
}

}  // namespace gripline::diagnose
