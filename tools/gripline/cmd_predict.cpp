// gripline predict WORLD.json LOG.csv: how far a world's model is off a log, open loop, by horizon.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <iostream>
#include <iterator>

#include "cli/options.hpp"
#include "config/errors.hpp"
#include "config/json_file.hpp"
#include "config/shipped.hpp"
#include "gripline/command.hpp"
#include "measured/log_file.hpp"
#include "measured/rollout.hpp"
#include "util/csv_writer.hpp"
#include "world/world_spec.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace fs = std::filesystem;
namespace {

std::vector<double> read_horizons(const std::string& text) {
  std::vector<double> horizons;
  std::size_t at = 0;
  while (at <= text.size()) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    const std::string one = text.substr(at, comma - at);
    char* end = nullptr;
    const double value = std::strtod(one.c_str(), &end);
    if (one.empty() || *end != '\0' || !(value > 0.0) || value > 1000.0)
      throw InputError("--horizon " + text + ": \"" + one + "\" is no time in seconds; expected for example 0.1,0.5,1");
    horizons.push_back(value);
    at = comma + 1;
  }
  return horizons;
}

/// Root mean squares of position [m], yaw, vx, vy, yaw rate over all samples up to the horizon.
struct ErrorsAtHorizon {
  double position = 0, yaw = 0, vx = 0, vy = 0, yaw_rate = 0;
};
ErrorsAtHorizon errors_of(const std::vector<measured::Rollouts>& all) {
  std::array<double, 6> sum{}, count{};
  for (const measured::Rollouts& r : all)
    for (std::size_t i = 0; i < r.error.size(); ++i) {
      if (std::isnan(r.error[i])) continue;
      sum[i % 6] += r.error[i] * r.error[i];
      count[i % 6] += 1.0;
    }
  const auto root = [&](std::size_t c) { return std::sqrt(sum[c] / count[c]); };
  return {std::sqrt(sum[0] / count[0] + sum[1] / count[1]), root(2), root(3), root(4), root(5)};
}

/// A number in its column, "-" where there is none.
std::string cell(double value, int width, int decimals) {
  std::string text = "-";
  char digits[400];
  if (std::isfinite(value))
    text.assign(digits, std::to_chars(digits, std::end(digits), value, std::chars_format::fixed, decimals).ptr);
  return std::string(static_cast<std::size_t>(std::max(0, width - static_cast<int>(text.size()))), ' ') + text;
}

/// Returns whether every cell holds a number.
bool print(double horizon, const ErrorsAtHorizon& e) {
  std::cout << cell(horizon, 5, 2) << " s " << cell(e.position, 12, 5) << ' ' << cell(e.yaw, 10, 5) << ' '
            << cell(e.vx, 10, 5) << ' ' << cell(e.vy, 10, 5) << ' ' << cell(e.yaw_rate, 12, 5) << '\n';
  return std::isfinite(e.position + e.yaw + e.vx + e.vy + e.yaw_rate);
}

struct PredictRequest {
  fs::path world, log;
  std::optional<fs::path> track, out;
  std::vector<double> horizons;
};

PredictRequest read_request(const po::variables_map& given) {
  const Words words = words_of(given, "world-and-log");
  if (words.size() != 2) throw InputError("predict needs a world and a log: gripline predict WORLD.json LOG.csv");
  PredictRequest request{find_shipped(words[0], "worlds"), words[1], {}, {}, {}};
  Words inputs = words;
  if (const auto track = text_of(given, "track")) {
    request.track = *track;
    inputs.push_back(*track);
  }
  if (const auto out = text_of(given, "out")) {
    require_writable("--out", *out, inputs);
    request.out = *out;
  }
  request.horizons = read_horizons(*text_of(given, "horizon"));
  return request;
}

/// Free simulations of every stretch of a log, each from the measured state itself; where a reading is missing, from
/// its neighbours.
std::vector<measured::Rollouts> roll_out_all(const StagedCar& car, const measured::LogFile& log,
                                             const measured::Road& road, double horizon) {
  std::vector<measured::Rollouts> all;
  for (const measured::Log& m : log.stretches) {
    measured::Trace trace;
    trace.log = m;
    std::vector<double> start = m.reading;
    const std::vector<double> smooth = measured::smooth_readings(m, 3);
    for (std::size_t i = 0; i < start.size(); ++i)
      if (std::isnan(start[i])) start[i] = smooth[i];
    trace.set_motion(start, road);
    trace.set_motion(measured::states_of_readings(car, start, trace.at), road);
    measured::RolloutOptions options;
    options.horizon = horizon;
    options.substeps = 4;
    all.push_back(measured::roll_out(car, trace, road, options));
  }
  return all;
}

}  // namespace

int run_predict(Arguments args) {
  po::options_description visible("options");
  auto add = visible.add_options();
  add("horizon", po::value<std::string>()->default_value("0.1,0.2,0.5,1,2"), "seconds, separated by commas");
  add("track", po::value<std::string>(), "another road, CSV or JSON");
  add("out", po::value<std::string>(), "a CSV file for the table");
  add_plugins_option(visible);
  add("help,h", "this text");
  const auto given = parse_options(args, visible, "predict WORLD.json LOG.csv [options]", "world-and-log");
  if (!given) return good;
  const PredictRequest request = read_request(*given);

  const Registry registry = open_registry(plugin_dirs_of(*given));
  const Node node = load_world(request.world, request.track);
  Errors errors;
  const WorldSpec world = read_world(node, registry, errors);
  errors.throw_if_any();
  if (world.vehicle.model.empty())
    throw InputError(request.world.string() + ": its car is a black box; predict needs a vehicle model");
  PluginContext context;
  context.car = world.car.car;
  const Vehicle vehicle(world.vehicle, context);
  const measured::Road road(world.track);
  const measured::LogFile log = measured::read_log_file(request.log, {world.car.car.v_ref, &road});

  std::optional<CsvWriter> file;
  if (request.out) file.emplace(*request.out, "horizon_s,position_m,yaw_rad,vx_mps,vy_mps,yaw_rate_radps");
  std::cout << "horizon   position m    yaw rad     vx m/s     vy m/s   yaw rate rad/s\n";
  bool whole = true;
  for (const double horizon : request.horizons) {
    const std::vector<measured::Rollouts> all = roll_out_all(vehicle.car(), log, road, horizon);
    if (std::all_of(all.begin(), all.end(), [](const measured::Rollouts& r) { return r.start.empty(); }))
      throw InputError(request.log.string() + ": too short for a horizon of " + std::to_string(horizon) + " s");
    const ErrorsAtHorizon e = errors_of(all);
    whole = print(horizon, e) && whole;
    if (!file) continue;
    *file << horizon << e.position << e.yaw << e.vx << e.vy << e.yaw_rate;
    file->end_row();
  }
  if (file) file->finish();
  if (!whole) std::cout << "-: nothing to compare; the log has no such reading, or no prediction was a number\n";
  return good;
}

}  // namespace gripline::tools
