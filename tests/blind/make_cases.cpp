// Blind cases (framework/doc/diagnose-cases.md) on random roads: `blind_cases OUT --seed 1 --count 20 [--only a,b]`
// writes OUT/tracks and OUT/cases/<condition>_<number>, for `gripline diagnose --score OUT/cases`. Same seed, same
// files.
#include <boost/program_options.hpp>
#include <functional>
#include <iostream>
#include <set>

#include "blind/road.hpp"
#include "blind/simulate.hpp"
#include "config/json_file.hpp"
#include "plugin/registry.hpp"
#include "support/paths.hpp"
#include "util/whole_file.hpp"
#include "world/world_spec.hpp"

namespace gripline::blind {
namespace {

namespace fs = std::filesystem;
constexpr std::array<const char*, 2> vehicles = {"rc43", "full"};
constexpr int roads_per_car = 5;

/// What kind of case: how many effects, which noise, what is hidden where.
struct Condition {
  const char* name;
  const char* kind;  // none, single, pair, unknown
  bool process_noise = false, wrong_nominal = false, outside = false, more_outside = false, excluded = false;
  bool brief = false, faint = false, mild = false;
  double dt = 0.02;          // of the logs
  double noise_time = 0.25;  // correlation time of the process noise [s]
  double sensor_colour = 0;  // lag-one correlation of the sensors' noise
  std::size_t every = 1;     // rows of the log that are kept: every so-manieth
};
constexpr std::array<Condition, 30> conditions = {{
    {.name = "none_white", .kind = "none"},
    {.name = "none_process", .kind = "none", .process_noise = true},
    {.name = "none_nominal", .kind = "none", .wrong_nominal = true},
    {.name = "none_mild", .kind = "none", .process_noise = true, .mild = true},
    {.name = "single_white", .kind = "single"},
    {.name = "single_process", .kind = "single", .process_noise = true},
    {.name = "single_mild", .kind = "single", .process_noise = true, .mild = true},
    {.name = "single_nominal", .kind = "single", .wrong_nominal = true},
    {.name = "single_short", .kind = "single", .brief = true},
    {.name = "single_faint", .kind = "single", .process_noise = true, .faint = true},
    {.name = "pair_white", .kind = "pair"},
    {.name = "pair_process", .kind = "pair", .process_noise = true},
    {.name = "outside", .kind = "unknown", .outside = true},
    {.name = "excluded", .kind = "unknown", .excluded = true},
    {.name = "outside_more", .kind = "unknown", .outside = true, .more_outside = true},
    {.name = "outside_process", .kind = "unknown", .process_noise = true, .outside = true},
    {.name = "none_20hz", .kind = "none", .dt = 0.05},
    {.name = "none_100hz", .kind = "none", .dt = 0.01},
    {.name = "single_20hz", .kind = "single", .dt = 0.05},
    {.name = "single_100hz", .kind = "single", .dt = 0.01},
    {.name = "none_slow", .kind = "none", .process_noise = true, .noise_time = 1.0},
    {.name = "single_slow", .kind = "single", .process_noise = true, .noise_time = 1.0},
    {.name = "none_quick", .kind = "none", .process_noise = true, .noise_time = 0.05},
    {.name = "single_quick", .kind = "single", .process_noise = true, .noise_time = 0.05},
    {.name = "none_ar03", .kind = "none", .sensor_colour = 0.3},
    {.name = "single_ar03", .kind = "single", .sensor_colour = 0.3},
    {.name = "none_ar08", .kind = "none", .sensor_colour = 0.8},
    {.name = "single_ar08", .kind = "single", .sensor_colour = 0.8},
    {.name = "none_thinned", .kind = "none", .every = 2},
    {.name = "single_thinned", .kind = "single", .every = 2},
}};

/// Nominal world, catalogue and roads of one car.
struct Garage {
  Garage(int car, const fs::path& worlds, const Registry& registry, const std::vector<fs::path>& files) {
    for (const fs::path& file : files) {
      Node node = load_json(worlds / ("diagnose_" + std::string(vehicles[static_cast<std::size_t>(car)]) + ".json"));
      node.set("track", Node(fs::absolute(file).string()));
      Errors errors;
      worlds_.push_back(read_world(node, registry, errors));
      errors.throw_if_any();
      roads.emplace_back(worlds_.back().track);
    }
    catalogue.emplace(worlds_.front().vehicle, worlds_.front().car.car, registry, std::vector<std::string>{});
  }
  const WorldSpec& world() const { return worlds_.front(); }
  std::vector<measured::Road> roads;
  std::optional<diagnose::Catalogue> catalogue;

 private:
  std::vector<WorldSpec> worlds_;
};

std::string number(double v, int digits = 8) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, v);
  return text;
}
std::string list(const std::vector<std::string>& ids) {
  std::string text;
  for (const std::string& id : ids) text += (text.empty() ? "\"" : ", \"") + id + "\"";
  return "[" + text + "]";
}
std::string object(const std::map<std::string, double>& values) {
  std::string text;
  for (const auto& [key, v] : values) text += (text.empty() ? "\"" : ", \"") + key + "\": " + number(v);
  return "{" + text + "}";
}

/// Exact synonyms: two of friction_scale, front_grip and rear_grip say what any other one or two of them say; a uniform
/// latency of the sensors is a delay of the commands.
std::vector<std::vector<std::string>> synonyms(const std::vector<Effect>& effects) {
  const std::vector<std::string> grip = {"friction_scale", "front_grip", "rear_grip"};
  std::vector<std::string> rest, of_grip;
  std::string delay;
  for (const Effect& e : effects) {
    if (std::find(grip.begin(), grip.end(), e.id) != grip.end())
      of_grip.push_back(e.id);
    else if (e.id == "input_delay" || e.id == "sensor_latency")
      delay = e.id;
    else
      rest.push_back(e.id);
  }
  std::vector<std::vector<std::string>> grips = {of_grip}, delays = {{}};
  if (!delay.empty()) delays = {{"input_delay"}, {"sensor_latency"}};
  for (std::size_t leave = 0; leave < grip.size() && !of_grip.empty(); ++leave) {
    std::vector<std::string> two = grip;
    two.erase(two.begin() + static_cast<std::ptrdiff_t>(leave));
    if (of_grip.size() == 1 ? std::find(two.begin(), two.end(), of_grip[0]) == two.end() : two != of_grip)
      grips.push_back(two);
  }
  std::vector<std::vector<std::string>> all;
  for (const auto& g : grips)
    for (const auto& d : delays) {
      std::vector<std::string> set = rest;
      set.insert(set.end(), g.begin(), g.end());
      set.insert(set.end(), d.begin(), d.end());
      const bool same =
          set.size() == effects.size() && std::all_of(effects.begin(), effects.end(), [&](const Effect& e) {
            return std::find(set.begin(), set.end(), e.id) != set.end();
          });
      if (!same) all.push_back(set);
    }
  return all;
}

/// Where the remainder of an excluded effect shows: accepted answers.
std::vector<std::string> places_of(const std::string& id) {
  if (id == "friction_patch" || id == "grade" || id == "bank") return {"position"};
  if (id == "friction_drift") return {"time", "state", "input"};
  if (id == "plane_tilt" || id == "wind") return {"position", "state"};
  return {"state", "input"};
}

/// Every so-manieth sample of a log: what a slower recorder would have written of the same drive.
measured::Log thinned(const measured::Log& log, std::size_t every) {
  measured::Log less;
  less.dt = log.dt * static_cast<double>(every);
  for (std::size_t k = 0; k < log.size(); k += every) {
    less.command.push_back(log.command[k]);
    const auto row = log.reading.begin() + static_cast<std::ptrdiff_t>(k * 6);
    less.reading.insert(less.reading.end(), row, row + 6);
  }
  return less;
}

/// `colour`: lag-one correlation of the noise, whose standard deviations are `noise` whatever it is.
void write_log(const fs::path& file, const measured::Log& log, const measured::Channels& noise, double colour,
               bool car_is_full, bool exact, bool with_vy, Random& r) {
  std::string text =
      std::string("t_s,x_m,y_m,yaw_rad,vx_mps,") + (with_vy ? "vy_mps," : "") + "yaw_rate_radps,d,delta_rad\n";
  char cell[40];
  measured::Channels error{};  // in standard deviations
  for (std::size_t k = 0; k < log.size(); ++k) {
    text += number(static_cast<double>(k) * log.dt, 6);
    for (std::size_t c = 0; c < 6; ++c) {
      if (!exact) {
        const double keeps = k == 0 ? 0.0 : colour;
        error[c] = keeps * error[c] + std::sqrt(1.0 - keeps * keeps) * normal(r);
      }
      const double v = log.reading[k * 6 + c] + noise[c] * error[c];
      const int digits = exact ? (c < 2 && car_is_full ? 4 : 6) : (c < 2 && car_is_full ? 3 : 4);
      std::snprintf(cell, sizeof cell, ",%.*f", digits, v);
      if (c != 4 || with_vy) text += cell;
    }
    std::snprintf(cell, sizeof cell, ",%.5f,%.6f\n", log.command[k].d, log.command[k].delta);
    text += cell;
  }
  write_file(file, text);
}

/// The whole case but its logs.
struct Draft {
  int car = 0;
  Condition condition{};
  std::vector<Effect> effects;
  std::optional<OutsideCase> outside;
  std::vector<std::string> excluded;
  std::map<std::string, double> nuisance;  // relative; Cr0_over_m in m/s2
  double seconds = 60, share = 1, noise = 1, rough = 0;
  bool with_vy = true;
};

Draft draft(const Condition& condition, std::size_t i, Random& r) {
  Draft c;
  c.condition = condition;
  c.car = static_cast<int>(i % 2);
  const std::vector<std::string> ids = effects_of(c.car);
  c.seconds = condition.brief ? uniform(r, 20.0, 32.0) : (r() % 4 == 0 ? uniform(r, 45.0, 120.0) : 60.0);
  c.seconds = std::round(c.seconds);
  constexpr std::array<double, 3> noises = {0.5, 1.0, 2.0};
  if (r() % 4 == 0) c.noise = noises[pick(r, noises.size())];
  c.with_vy = r() % 12 != 0;
  // Sizes from typical down to a tenth, so that some stand near what can be detected.
  const bool small = !condition.outside && !condition.excluded && r() % 3 == 0;
  c.share = small ? std::exp(uniform(r, std::log(0.1), 0.0)) : 1.0;
  if (condition.faint) c.share = std::exp(uniform(r, std::log(0.1), std::log(0.5)));
  const std::string kind = condition.kind;
  if (kind == "single" || condition.excluded) {
    c.effects.push_back(draw(ids[(i / 2) % ids.size()], c.car, c.share, r));
  } else if (kind == "pair") {
    // Not two names for nearly the same: those are a class of their own.
    const std::set<std::string> grip = {"friction_scale", "front_grip", "rear_grip"};
    const std::set<std::string> delay = {"input_delay", "sensor_latency"};
    for (;;) {
      const std::string &a = ids[pick(r, ids.size())], &b = ids[pick(r, ids.size())];
      if (a == b || (grip.count(a) > 0 && grip.count(b) > 0) || (delay.count(a) > 0 && delay.count(b) > 0)) continue;
      c.effects = {draw(a, c.car, c.share, r), draw(b, c.car, c.share, r)};
      break;
    }
  }
  if (condition.outside) {
    const std::vector<std::string> outsiders = condition.more_outside ? more_outside_ids() : outside_ids();
    c.outside = draw_outside(outsiders[(i / 2) % outsiders.size()], c.car, 1.0, c.seconds, r);
    c.effects.clear();
  }
  if (condition.excluded) {
    c.excluded.push_back(c.effects.front().id);
    for (const auto& set : synonyms(c.effects)) c.excluded.insert(c.excluded.end(), set.begin(), set.end());
    std::sort(c.excluded.begin(), c.excluded.end());
    c.excluded.erase(std::unique(c.excluded.begin(), c.excluded.end()), c.excluded.end());
  }
  if (condition.wrong_nominal) {
    constexpr double q = 0.02;
    const auto off = [&](double sigma) { return sigma * std::clamp(normal(r), -2.0, 2.0); };
    for (const char* name : {"Df", "Dr", "Cm1"}) c.nuisance[name] = off(q);
    for (const char* name : {"Bf", "Br", "Cr0_over_m"}) c.nuisance[name] = off(2 * q);
  }
  if (condition.process_noise) c.rough = condition.mild ? std::exp(uniform(r, std::log(0.1), 0.0)) : 1.0;
  return c;
}

/// The true car: the catalogue knows the nuisances by name, values are set here.
diagnose::ModelSpec model_of(diagnose::Catalogue& catalogue, const Draft& c) {
  std::vector<diagnose::Nuisance> nuisances;
  for (const auto& [name, off] : c.nuisance) {
    diagnose::Nuisance n;
    const bool rolling = name == "Cr0_over_m";
    n.name = rolling ? "Cr0" : name;
    n.nominal = catalogue.nominal(n.name, &n.index);
    n.sigma = 1.0;
    nuisances.push_back(n);
  }
  catalogue.set_nuisances(nuisances);
  diagnose::ModelSpec model = catalogue.null_model();
  std::size_t at = 0;
  for (const auto& [name, off] : c.nuisance) {
    double& v = model.nuisance[at++];
    v = name == "Cr0_over_m" ? v + catalogue.car().m * off : v * (1.0 + off);
  }
  for (const Effect& e : c.effects) {
    if (e.id == "sensor_latency") continue;  // the readings lag, see Plan
    const std::size_t i = catalogue.find(e.id);
    if (i == catalogue.candidates().size()) throw std::runtime_error("no effect " + e.id);
    model = catalogue.with(model, i);
    std::vector<double>& values = model.values[model.position(i)];
    const auto& candidate = catalogue.candidates()[i];
    for (std::size_t p = 0; p < values.size(); ++p)
      if (const auto found = e.params.find(candidate.entry->decl->params[p].name); found != e.params.end())
        values[p] = found->second;
  }
  return model;
}

std::string answer_json(const Draft& c, const std::string& track, int direction, const measured::Channels& noise,
                        const std::array<double, 2>& laps, std::uint64_t seed, int attempts) {
  std::vector<Effect> effects = c.effects;
  std::string unknown = "null";
  if (c.outside) {
    effects.push_back(c.outside->effect);
    unknown = "{\"where\": " + list(c.outside->where) + ", \"interval\": ";
    unknown += c.outside->interval.empty()
                   ? "null}"
                   : "[" + number(c.outside->interval[0]) + ", " + number(c.outside->interval[1]) + "]}";
  } else if (!c.excluded.empty()) {
    unknown = "{\"where\": " + list(places_of(effects.front().id)) + ", \"interval\": ";
    const auto& p = effects.front().params;
    unknown += effects.front().id != "friction_patch"
                   ? "null}"
                   : "[" + number(p.at("s0") - 0.5 * p.at("w")) + ", " + number(p.at("s0") + 0.5 * p.at("w")) + "]}";
  }
  std::string named, equivalent;
  for (const Effect& e : effects)
    named += (named.empty() ? "" : ", ") + ("{\"effect\": \"" + e.id + "\", \"params\": " + object(e.params) + "}");
  if (!c.outside)
    for (const auto& set : synonyms(c.effects)) equivalent += (equivalent.empty() ? "" : ", ") + list(set);
  const bool full = c.car == 1;
  std::string text = "{\n  \"kind\": \"" + std::string(c.condition.kind) + "\",\n  \"vehicle\": \"" +
                     vehicles[static_cast<std::size_t>(c.car)] + "\",\n  \"track\": \"" + track +
                     "\",\n  \"direction\": " + std::to_string(direction) + ",\n  \"effects\": [" + named +
                     "],\n  \"excluded\": " + list(c.excluded) + ",\n  \"equivalent\": [" + equivalent +
                     "],\n  \"unknown\": " + unknown + ",\n  \"noise_factor\": " + number(c.noise) +
                     ",\n  \"noise_sigma\": {";
  constexpr std::array<const char*, 6> names = {"x_m", "y_m", "yaw_rad", "vx_mps", "vy_mps", "yaw_rate_radps"};
  for (std::size_t i = 0; i < 6; ++i)
    text += (i > 0 ? ", \"" : "\"") + std::string(names[i]) + "\": " + number(noise[i]);
  text += "},\n  \"process_noise\": ";
  text += !c.condition.process_noise
              ? "null"
              : "{\"ax_mps2\": " + number(0.1 * c.rough) + ", \"ay_mps2\": " + number(0.1 * c.rough) +
                    ", \"yaw_acc_radps2\": " + number((full ? 0.05 : 0.8) * c.rough) +
                    ", \"tau_s\": " + number(c.condition.noise_time) + "}";
  if (c.condition.sensor_colour > 0.0) text += ",\n  \"noise_correlation\": " + number(c.condition.sensor_colour);
  if (c.condition.every > 1) text += ",\n  \"thinned\": " + std::to_string(c.condition.every);
  text += ",\n  \"nuisance\": " + (c.nuisance.empty() ? std::string("null") : object(c.nuisance)) +
          ",\n  \"seed\": " + std::to_string(seed) + ",\n  \"magnitude\": " + number(c.share) +
          ",\n  \"length_s\": " + number(c.seconds) + ",\n  \"laps\": {\"measured\": " + number(laps[0], 5) +
          ", \"heldout\": " + number(laps[1], 5) + "},\n  \"attempts\": " + std::to_string(attempts) + "\n}\n";
  return text;
}

std::string case_json(const Draft& c, const std::string& track, int direction, const measured::Channels& noise) {
  constexpr std::array<const char*, 6> names = {"x_m", "y_m", "yaw_rad", "vx_mps", "vy_mps", "yaw_rate_radps"};
  std::string text = "{\n  \"vehicle\": \"" + std::string(vehicles[static_cast<std::size_t>(c.car)]) +
                     "\",\n  \"track\": \"" + track + "\",\n  \"direction\": " + std::to_string(direction) +
                     ",\n  \"sample_time_s\": " + number(c.condition.dt * static_cast<double>(c.condition.every)) +
                     ",\n  \"noise_sigma\": {";
  for (std::size_t i = 0; i < 6; ++i)
    text += (i > 0 ? ", \"" : "\"") + std::string(names[i]) + "\": " + number(noise[i]);
  text += "},\n  \"exclude\": " + list(c.excluded) + ",\n  \"nominal_uncertainty\": ";
  text += c.nuisance.empty()
              ? "null"
              : "{\"Df\": 0.02, \"Dr\": 0.02, \"Bf\": 0.04, \"Br\": 0.04, \"Cm1\": 0.02, \"Cr0_over_m\": 0.04}";
  return text + "\n}\n";
}

/// Drives, more gently each time the car is lost.
Log drive(Plan plan, const measured::Road& road, int car, Random& r, int& attempts) {
  for (;; ++attempts) {
    if (attempts > 60) throw std::runtime_error("the driver cannot keep this car on the road");
    if (auto log = simulate(plan, road, car, r)) return std::move(*log);
    plan.style.pace *= 0.97;
  }
}

/// FNV-1a: the same on every machine.
std::uint64_t fingerprint(std::string_view text) {
  std::uint64_t h = 14695981039346656037ull;
  for (const char c : text) h = (h ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  return h & 0xffffffffull;
}

void make_case(const Condition& condition, std::size_t i, std::uint64_t seed, std::array<Garage, 2>& garages,
               const fs::path& out) {
  const std::string name = std::string(condition.name) + "_" + (i < 10 ? "00" : i < 100 ? "0" : "") + std::to_string(i);
  std::seed_seq mixed{seed, static_cast<std::uint64_t>(i), fingerprint(condition.name)};
  Random r(mixed);
  const Draft c = draft(condition, i, r);
  Garage& garage = garages[static_cast<std::size_t>(c.car)];
  const std::size_t which = pick(r, garage.roads.size());
  const measured::Road& road = garage.roads[which];
  const bool full = c.car == 1;

  Plan plan;
  plan.catalogue = &*garage.catalogue;
  plan.model = model_of(*garage.catalogue, c);
  if (c.outside) plan.outside = c.outside->effect;
  for (const Effect& e : c.effects)
    if (e.id == "sensor_latency") plan.latency = std::round(e.params.at("T") / 0.0025) * 0.0025;
  Draft stated = c;
  for (Effect& e : stated.effects)
    if (e.id == "sensor_latency") e.params["T"] = plan.latency;
  plan.seconds = c.seconds;
  plan.dt = condition.dt;
  plan.roughness = c.rough;
  plan.noise_time = condition.noise_time;
  const int direction = r() % 3 == 0 ? -1 : 1;
  plan.style = {uniform(r, 0.78, 0.95), uniform(r, 0.04, full ? 0.12 : 0.18), uniform(r, 0.1, 0.5),
                uniform(r, 0.7, 1.3), direction};
  measured::Channels noise{};
  for (std::size_t ch = 0; ch < 6; ++ch) noise[ch] = c.noise * garage.world().sensors.channels[ch].sigma;

  int attempts = 0;
  const Log measured = drive(plan, road, c.car, r, attempts);
  plan.seconds = full ? 36 : 20;
  plan.roughness = 0.0;
  plan.style = {uniform(r, 0.72, 0.92), uniform(r, 0.04, 0.12), uniform(r, 0.1, 0.5), uniform(r, 0.7, 1.3),
                r() % 3 == 0 ? -direction : direction};
  const Log held = drive(plan, road, c.car, r, attempts);

  const fs::path folder = out / "cases" / name;
  fs::create_directories(folder);
  const std::string track =
      std::string(vehicles[static_cast<std::size_t>(c.car)]) + "_" + std::to_string(which) + ".csv";
  write_log(folder / "measured.csv", thinned(measured.log, condition.every), noise, condition.sensor_colour, full,
            false, c.with_vy, r);
  write_log(folder / "heldout.csv", held.log, noise, 0.0, full, true, true, r);
  write_file(folder / "case.json", case_json(stated, track, direction, noise));
  write_file(folder / "answer.json",
             answer_json(stated, track, direction, noise, {measured.laps, held.laps}, seed, attempts));
}

}  // namespace

int run(int argc, char** argv) {
  namespace po = boost::program_options;
  po::options_description visible("options");
  visible.add_options()("out", po::value<std::string>()->required(), "folder for tracks and cases")(
      "seed", po::value<std::uint64_t>()->default_value(1), "another seed, other cases")(
      "count", po::value<std::size_t>()->default_value(20), "cases per condition")(
      "only", po::value<std::string>()->default_value(""), "conditions, separated by commas")(
      "plugins", po::value<std::string>()->default_value(testing_support::plugin_dir().string()),
      "folder of the catalogue's plugins")(
      "worlds", po::value<std::string>()->default_value((testing_support::source_dir() / "worlds").string()),
      "folder of the nominal worlds");
  po::positional_options_description words;
  words.add("out", 1);
  po::variables_map given;
  po::store(po::command_line_parser(argc, argv).options(visible).positional(words).run(), given);
  po::notify(given);
  const fs::path out = given["out"].as<std::string>();
  const auto seed = given["seed"].as<std::uint64_t>();
  const Registry registry({given["plugins"].as<std::string>()});
  std::array<std::vector<fs::path>, 2> files;
  Random roads(seed);
  for (int car = 0; car < 2; ++car)
    for (int i = 0; i < roads_per_car; ++i) {
      const auto kind = static_cast<std::size_t>(car);
      files[kind].push_back(out / "tracks" / (std::string(vehicles[kind]) + "_" + std::to_string(i) + ".csv"));
      write_road(files[kind].back(), car, roads);
    }
  const fs::path worlds = given["worlds"].as<std::string>();
  std::array<Garage, 2> garages = {Garage(0, worlds, registry, files[0]), Garage(1, worlds, registry, files[1])};
  const std::string only = "," + given["only"].as<std::string>() + ",";
  for (const Condition& condition : conditions) {
    if (only != ",," && only.find("," + std::string(condition.name) + ",") == std::string::npos) continue;
    for (std::size_t i = 0; i < given["count"].as<std::size_t>(); ++i) make_case(condition, i, seed, garages, out);
    std::cout << condition.name << '\n';
  }
  return 0;
}

}  // namespace gripline::blind

int main(int argc, char** argv) {
  try {
    return gripline::blind::run(argc, argv);
  } catch (const std::exception& e) {
    std::cerr << "blind_cases: " << e.what() << '\n';
    return 2;
  }
}
