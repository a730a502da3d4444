// gripline predict WORLD.json LOG.csv: what a world's model says that a log's own columns will show, in the log's
// clock, frames and delays, and how far off that is.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>
#include <span>
#include <utility>

#include "calibrate/fit/session_adaptation.hpp"
#include "calibrate/predict/judged_log.hpp"
#include "calibrate/predict/prediction_parameters.hpp"
#include "calibrate/predict/prediction_samples.hpp"
#include "calibrate/predict/prediction_scores.hpp"
#include "config/errors.hpp"
#include "config/json_file.hpp"
#include "config/shipped.hpp"
#include "gripline/command.hpp"
#include "gripline/log_options.hpp"
#include "measured/channels.hpp"
#include "measured/session/session_checks.hpp"
#include "util/csv_writer.hpp"
#include "util/numbers.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace fs = std::filesystem;
namespace {

using calibrate::JudgedLog;

struct Request {
  std::string world, log;
  std::optional<fs::path> samples, out;
  std::vector<double> horizons;
  double every = 0.2;
  std::optional<double> slowest;  // [m/s] of starts that count for errors; the world's own where none is given
};

Request read_request(const po::variables_map& given) {
  const Words words = words_of(given, "world-and-log");
  if (words.size() != 2) throw InputError("predict needs a world and a log: gripline predict WORLD.json LOG.csv");
  Request request{find_shipped(words[0], "worlds"), words[1], {}, {}, {}, 0.2, {}};
  Words inputs = words;
  for (const std::string& one : words_of(given, "track")) inputs.push_back(one);
  if (const auto map = text_of(given, "map")) inputs.push_back(*map);
  if (const auto out = text_of(given, "out")) request.out = *out, require_writable("--out", *out, inputs);
  if (const auto samples = text_of(given, "samples"))
    request.samples = *samples, require_writable("--samples", *samples, inputs);
  constexpr double longest = 1000.0;  // [s]
  request.horizons =
      quantities_of("--horizon", *text_of(given, "horizon"), {"s", "times in seconds, for example 0.5,1", longest});
  std::sort(request.horizons.begin(), request.horizons.end());
  request.every =
      quantity_of("--every", *text_of(given, "every"), {"s", "a time in seconds, for example 0.2", longest});
  if (given.count("slowest") > 0) {
    request.slowest = given["slowest"].as<double>();
    if (!(*request.slowest >= 0.0)) throw InputError("--slowest: expected a speed of 0 or more [m/s]");
  }
  return request;
}

void write_table(CsvWriter& file, double horizon, const calibrate::HorizonRow& row) {
  file << horizon << row.name << static_cast<double>(row.error[2].count);  // of vx
  for (const calibrate::HorizonError& e : row.error)
    for (const double v : {e.rms, e.low, e.high}) {
      if (std::isfinite(v))
        file << v;
      else
        file << "";
    }
  file.end_row();
}

/// The measures that trajectory forecasts are compared by (ADE and FDE).
void show_displacements(const JudgedLog& judged, std::span<const calibrate::NamedPredictions> models, double slowest) {
  const calibrate::Starts& starts = judged.log().starts;
  std::cout << "\ndisplacement [m] over " << starts.horizons.size() << " horizons up to " << starts.horizons.back()
            << " s\n  model            mean of all  last one     starts\n";
  for (const calibrate::NamedPredictions& model : models) {
    const calibrate::Displacement d = calibrate::displacement_of(judged, model.readings, slowest);
    if (d.starts == 0) continue;
    std::cout << format("  %-16s %-12.4g %-12.4g %zu\n", model.name.c_str(), d.average, d.last, d.starts);
  }
}

/// The table of --out.
CsvWriter table_file(const fs::path& file) {
  std::string header = "horizon_s,model,starts";
  for (const char* q : calibrate::quantity_names)
    for (const char* end : {"", "_lo", "_hi"}) header += std::string(",") + q + end;
  return CsvWriter(file, header);
}

/// Prints the errors at every horizon, and writes them where --out names a file.
void show_errors(const Request& request, const JudgedLog& judged, std::vector<double> predicted,
                 const WorldSpec& world) {
  const double slowest = request.slowest.value_or(calibrate::slowest_start(world));
  if (judged.counted(0, slowest).time.empty())
    throw InputError(request.log + ": no start with a reading of vx of " + number_text(slowest) +
                     " m/s or more: no errors to show; expected a log of driving, or a lower --slowest");
  std::optional<CsvWriter> table;
  if (request.out) table.emplace(table_file(*request.out));
  const auto models = calibrate::beside_baselines(judged, std::move(predicted), world.car.car.lf + world.car.car.lr);
  for (std::size_t j = 0; j < request.horizons.size(); ++j) {
    const calibrate::CountedStarts of = judged.counted(j, slowest);
    const auto rows = calibrate::errors_at(judged, models, j, of);
    std::cout << (j > 0 ? "\n" : "") << "errors at " << request.horizons[j] << " s, root mean square over "
              << of.time.size() << " starts from " << slowest << " m/s on (95 % by blocks of 10 s)\n";
    calibrate::print_horizon_table(std::cout, rows);
    if (table)
      for (const calibrate::HorizonRow& row : rows) write_table(*table, request.horizons[j], row);
  }
  if (table) table->finish();
  if (request.horizons.size() > 1 && judged.log().session->has[measured::Channel::x])
    show_displacements(judged, models, slowest);
}

/// What the session moved, where it stood at the log's end.
void show_moved(const calibrate::PredictionParameters& params, const std::vector<double>& at_end) {
  if (params.moving.empty()) return;
  std::cout << "\nmoved with the session         fitted       at its end   width\n";
  for (const calibrate::Unknown& u : params.moving) {
    const std::string name = u.pointer.substr(u.pointer.find('/', 1));
    std::cout << format("  %-28s %-12.5g %-12.5g %.3g%s\n", name.c_str(), params.values[u.index], at_end[u.index],
                        u.session, u.log ? " of it" : "");
  }
}

int predict(const po::variables_map& given) {
  const Request request = read_request(given);
  const Registry registry = open_registry(plugin_dirs_of(given));
  const LogWorld world = read_log_world(request.world, given, registry);
  PluginContext context;
  context.car = world.spec.car.car;
  const Vehicle vehicle(world.spec.vehicle, context);
  const measured::LogMap map = map_option(given, world.spec);
  const measured::SessionFile file = measured::read_session(request.log, map);
  warn_of_findings(request.log, file);
  try {
    measured::check_session(file, world.spec.car.car.v_ref, world.spec.car.car.delta_max);
  } catch (const InputError& e) {
    std::cerr << "warning: " << e.what() << '\n';
  }
  const calibrate::Forecaster forecaster(vehicle.car(), calibrate::prediction_options(world.spec));
  calibrate::PredictionParameters params = calibrate::prediction_parameters(world.tree, world.spec, map, forecaster);
  if (given["fixed"].as<bool>()) params.moving.clear();

  calibrate::FitLog log(file.session, forecaster.options().step, request.horizons, request.every, 0.0,
                        calibrate::FitLog::Speed::own);
  if (log.starts.time.empty())
    throw InputError(request.log + ": too short for a horizon of " + number_text(request.horizons.back()) + " s");
  if (const std::string channels = calibrate::never_compared(log); !channels.empty())
    std::cerr << "warning: " << request.log << ": " << channels << '\n';
  if (world.spec.track && calibrate::lies_on(file.session, *world.spec.track))
    log.track = world.spec.track;
  else if (world.spec.track)
    std::cerr << request.log << ": does not lie on the road; taken as flat ground\n";
  std::vector<double> at_end;
  std::vector<double> predicted =
      calibrate::predict_session(forecaster, log, params.values, params.moving, params.weighing, &at_end);
  if (request.samples) write_file(*request.samples, calibrate::samples_table(file.session, log.starts, predicted));
  const JudgedLog judged(log);
  if (judged.gross_outliers() > 0)
    std::cerr << request.log << ": outliers: " << judged.gross_outliers()
              << " readings far off all around them, left out of the errors\n";
  if (judged.place_spikes() > 0)
    std::cerr << request.log << ": outliers: " << judged.place_spikes()
              << " places that jump there and back, left out of the errors\n";
  show_errors(request, judged, std::move(predicted), world.spec);
  show_moved(params, at_end);
  if (request.samples) std::cout << "samples: " << request.samples->string() << '\n';
  return good;
}

}  // namespace

int run_predict(Arguments args) {
  po::options_description visible("options");
  add_log_options(visible);
  auto add = visible.add_options();
  add("horizon", po::value<std::string>()->default_value("0.5,1"), "seconds ahead, separated by commas");
  add("every", po::value<std::string>()->default_value("0.2"), "seconds between starts");
  add("slowest", po::value<double>(), "errors over starts from this speed on [m/s] (default: a quarter of v_ref)");
  add("samples", po::value<std::string>(), "a CSV file for every prediction, in the log's own clock and frames");
  add("out", po::value<std::string>(), "a CSV file for the table");
  add("fixed", po::bool_switch(), "parameters as fitted: none adapts to the log before a start");
  add_plugins_option(visible);
  add("help,h", "this text");
  const auto given = parse_options(args, visible, "predict WORLD.json LOG.csv [options]", "world-and-log");
  return given ? predict(*given) : good;
}

}  // namespace gripline::tools
