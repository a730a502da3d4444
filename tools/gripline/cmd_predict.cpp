// gripline predict WORLD.json LOG.csv: what a world's model says that a log's own columns will show, in the log's
// clock, frames and delays, and how far off that is.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iostream>
#include <numbers>

#include "calibrate/fit/session_adaptation.hpp"
#include "calibrate/forecast/baselines.hpp"
#include "config/errors.hpp"
#include "config/json_file.hpp"
#include "config/shipped.hpp"
#include "gripline/command.hpp"
#include "gripline/log_options.hpp"
#include "measured/log/log_outliers.hpp"
#include "measured/session/session_checks.hpp"
#include "util/csv_writer.hpp"
#include "util/numbers.hpp"

namespace gripline::tools {
namespace po = boost::program_options;
namespace fs = std::filesystem;
namespace {

using calibrate::channels;
using measured::Session;

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

/// Turns between the unwrapped yaw and the one in the log's column at a row, and whether that column wraps.
class YawColumn {
 public:
  explicit YawColumn(const Session& session) : session_(session) {}
  /// A predicted yaw as the column would show it, judged by the rows up to `start`.
  double shown(double yaw, double start) {
    const double pi = std::numbers::pi;
    for (; row_ < session_.rows() && session_.t[row_] <= start + 1e-9; ++row_) {
      const double written = session_.written_yaw[row_];
      if (std::isnan(written)) continue;
      turns_ = session_.at(row_, 2) - written;
      inside_ = inside_ && std::abs(written) <= pi + 1e-3;
    }
    const double value = yaw - turns_;
    return inside_ ? std::remainder(value, 2.0 * pi) : value;
  }

 private:
  const Session& session_;
  std::size_t row_ = 0;
  double turns_ = 0;
  bool inside_ = true;
};

void append(std::string& line, double value, int digits) {
  if (!line.empty()) line += ',';
  if (!std::isfinite(value)) return;
  char buffer[64];
  const auto [end, code] = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, digits);
  if (code == std::errc()) line.append(buffer, end);
}

void write_samples(const fs::path& file, const Session& session, const calibrate::Starts& starts,
                   const std::vector<double>& predicted) {
  std::string out = "start_s,t_s,x_m,y_m,yaw_rad,vx_mps,vy_mps,yaw_rate_radps\n";
  YawColumn yaw(session);
  const std::size_t h = starts.horizons.size();
  for (std::size_t i = 0; i < starts.time.size(); ++i)
    for (std::size_t j = 0; j < h; ++j) {
      const double* const p = predicted.data() + (i * h + j) * channels;
      if (!std::isfinite(p[3])) continue;
      std::string line;
      append(line, session.begin + starts.time[i], 6);
      append(line, session.begin + starts.time[i] + starts.horizons[j], 6);
      for (std::size_t c = 0; c < channels; ++c) {
        const bool known = c == 2 ? session.has[2] : c < 2 ? session.has[0] : true;
        append(line, !known ? NAN : c == 2 ? yaw.shown(p[2], starts.time[i]) : p[c], c < 2 ? 5 : 7);
      }
      out += line + '\n';
    }
  write_file(file, out);
}

/// The log as it judges predictions: without outliers, of which only later rows tell that they are some. What is
/// predicted reads nothing later, and has met them as they came.
struct JudgedLog {
  explicit JudgedLog(const calibrate::FitLog& as_read) : session(*as_read.session), log(as_read) {
    left_out = measured::drop_gross_outliers(session);
    spikes = measured::drop_place_spikes(session);
    log.session = &session;
    log.truth = calibrate::readings_at(session, log.starts);
    for (const double start : log.starts.time) {
      const std::size_t row = session.row_before(start + 1e-9);
      bool bad = false;
      for (std::size_t c = 0; c < channels; ++c) bad = bad || follows_left_out(*as_read.session, row, c);
      bad_start.push_back(bad);
    }
  }
  JudgedLog(const JudgedLog&) = delete;
  JudgedLog& operator=(const JudgedLog&) = delete;

  Session session;
  calibrate::FitLog log;
  std::size_t left_out = 0, spikes = 0;  // readings
  std::vector<bool> bad_start;           // its own row has one of them, or one of three places before
  bool counts(std::size_t start, double slowest) const {
    return !bad_start[start] && std::abs(session.interpolate(3, log.starts.time[start])) >= slowest;
  }

 private:
  /// Whether the reading of a row was left out or, of places, one of the three before: what is predicted follows places
  /// by its gain, and has then left a wild one again.
  bool follows_left_out(const Session& as_read, std::size_t row, std::size_t c) const {
    const auto gone = [&](std::size_t i) { return std::isnan(session.at(i, c)) && !std::isnan(as_read.at(i, c)); };
    if (gone(row)) return true;
    std::size_t readings = c < 2 ? 3 : 0;
    for (std::size_t i = row; readings > 0 && i-- > 0;) {
      if (std::isnan(as_read.at(i, c))) continue;
      if (gone(i)) return true;
      --readings;
    }
    return false;
  }
};

/// One horizon's predictions of the starts that count: those where the car is moving.
struct Counted {
  std::vector<double> time, truth;
  std::vector<std::size_t> start;
};
Counted counted(const JudgedLog& judged, std::size_t horizon, double slowest) {
  Counted out;
  const calibrate::FitLog& all = judged.log;
  const std::size_t h = all.starts.horizons.size();
  for (std::size_t i = 0; i < all.starts.time.size(); ++i) {
    if (!judged.counts(i, slowest)) continue;
    out.start.push_back(i);
    out.time.push_back(all.starts.time[i]);
    const auto* const truth = all.truth.data() + (i * h + horizon) * channels;
    out.truth.insert(out.truth.end(), truth, truth + channels);
  }
  return out;
}

std::vector<double> picked(const std::vector<double>& predicted, const Counted& of, std::size_t h,
                           std::size_t horizon) {
  std::vector<double> out;
  for (const std::size_t i : of.start) {
    const auto* const p = predicted.data() + (i * h + horizon) * channels;
    out.insert(out.end(), p, p + channels);
  }
  return out;
}

void write_table(CsvWriter& file, double horizon, const calibrate::HorizonRow& row) {
  file << horizon << row.name << static_cast<double>(row.error[2].count);
  for (const calibrate::HorizonError& e : row.error)
    for (const double v : {e.rms, e.low, e.high}) {
      if (std::isfinite(v))
        file << v;
      else
        file << "";
    }
  file.end_row();
}

/// Everything that predictions need besides the log.
struct Parameters {
  std::vector<double> values;
  std::vector<calibrate::Unknown> moving;  // with the session
  calibrate::SessionWeighing weighing;
};

/// Parameters as the world has them. One that was never fitted is judged by its model alone: no disturbance is carried
/// on, and delays are what the map states.
Parameters parameters_for(const LogWorld& world, const measured::LogMap& map, const calibrate::Forecaster& forecaster) {
  using calibrate::ForecastParameter;
  Errors errors;
  Parameters out;
  std::vector<double>& params = out.values = calibrate::parameters_of(world.tree, forecaster, errors);
  if (const auto weighing = calibrate::session_weighing(world.tree); weighing && world.tree.find("unknowns")) {
    const auto places = calibrate::parameter_places(world.spec, forecaster);
    out.moving = calibrate::session_unknowns(calibrate::read_unknowns(world.tree, places, params, {}, errors));
    out.weighing = *weighing;
  }
  errors.throw_if_any();
  if (world.tree.find("calibration") != nullptr) return out;
  params[forecaster.index(ForecastParameter::gain_force)] = params[forecaster.index(ForecastParameter::gain_steer)] =
      0.0;
  for (std::size_t g = 0; g < measured::delay_groups; ++g)
    if (const auto stated = map.delay(g)) params[forecaster.index(ForecastParameter::delay_position) + g] = *stated;
  return out;
}

calibrate::ForecastOptions options_for(const LogWorld& world) {
  calibrate::ForecastOptions options = calibrate::forecast_options(world.spec);
  options.lanes = 1;  // what later rows hold must not touch a rounding
  return options;
}

/// Errors at one horizon: the baselines', then the model's.
std::vector<calibrate::HorizonRow> rows_at(const calibrate::FitLog& log, std::size_t horizon, const Counted& of,
                                           const std::vector<double>& predicted, double wheelbase) {
  const std::size_t h = log.starts.horizons.size();
  std::vector<calibrate::HorizonRow> rows;
  const auto add = [&](const char* name, const std::vector<double>& all) {
    rows.push_back(calibrate::horizon_row(name, of.time, picked(all, of, h, horizon), of.truth));
  };
  for (std::size_t b = 0; b < calibrate::baseline_names.size(); ++b)
    add(calibrate::baseline_names[b],
        calibrate::baseline(static_cast<calibrate::Baseline>(b), *log.session, log.starts, wheelbase));
  add("this world", predicted);
  return rows;
}

/// How far predicted places lie from those of the log: mean over starts of the mean over horizons, and of the last one.
struct Displacement {
  double average = 0, last = 0;  // [m]
  std::size_t starts = 0;
};
Displacement displacement_of(const JudgedLog& judged, const std::vector<double>& predicted, double slowest) {
  const calibrate::FitLog& log = judged.log;
  const std::size_t h = log.starts.horizons.size();
  Displacement out;
  for (std::size_t i = 0; i < log.starts.time.size(); ++i) {
    if (!judged.counts(i, slowest)) continue;
    double sum = 0.0, distance = 0.0;
    for (std::size_t j = 0; j < h; ++j) {
      const std::size_t at = (i * h + j) * channels;
      distance = std::hypot(predicted[at] - log.truth[at], predicted[at + 1] - log.truth[at + 1]);
      sum += distance;
    }
    if (!std::isfinite(sum)) continue;
    out.average += sum / static_cast<double>(h);
    out.last += distance;
    ++out.starts;
  }
  out.average /= static_cast<double>(out.starts);
  out.last /= static_cast<double>(out.starts);
  return out;
}

/// The measures that trajectory forecasts are compared by (ADE and FDE).
void show_displacements(const JudgedLog& judged, const std::vector<double>& predicted, double slowest,
                        double wheelbase) {
  const calibrate::FitLog& log = judged.log;
  const auto show = [&](const char* name, const std::vector<double>& all) {
    const Displacement d = displacement_of(judged, all, slowest);
    if (d.starts == 0) return;
    std::cout << format("  %-16s %-12.4g %-12.4g %zu\n", name, d.average, d.last, d.starts);
  };
  std::cout << "\ndisplacement [m] over " << log.starts.horizons.size() << " horizons up to "
            << log.starts.horizons.back() << " s\n  model            mean of all  last one     starts\n";
  for (std::size_t b = 0; b < calibrate::baseline_names.size(); ++b)
    show(calibrate::baseline_names[b],
         calibrate::baseline(static_cast<calibrate::Baseline>(b), *log.session, log.starts, wheelbase));
  show("this world", predicted);
}

/// Prints the errors at every horizon, and writes them where --out names a file.
void show_errors(const Request& request, const JudgedLog& judged, const std::vector<double>& predicted,
                 const WorldSpec& world) {
  const double slowest = request.slowest.value_or(calibrate::slowest_start(world));
  if (counted(judged, 0, slowest).time.empty())
    throw InputError(request.log + ": no start with a reading of vx of " + number_text(slowest) +
                     " m/s or more: no errors to show; expected a log of driving, or a lower --slowest");
  const calibrate::FitLog& log = judged.log;
  std::optional<CsvWriter> table;
  if (request.out) {
    std::string header = "horizon_s,model,starts";
    for (const char* q : calibrate::quantity_names)
      for (const char* end : {"", "_lo", "_hi"}) header += std::string(",") + q + end;
    table.emplace(*request.out, header);
  }
  const double wheelbase = world.car.car.lf + world.car.car.lr;
  for (std::size_t j = 0; j < request.horizons.size(); ++j) {
    const Counted of = counted(judged, j, slowest);
    const auto rows = rows_at(log, j, of, predicted, wheelbase);
    std::cout << (j > 0 ? "\n" : "") << "errors at " << request.horizons[j] << " s, root mean square over "
              << of.time.size() << " starts from " << slowest << " m/s on (95 % by blocks of 10 s)\n";
    calibrate::print_horizon_table(std::cout, rows);
    if (table)
      for (const calibrate::HorizonRow& row : rows) write_table(*table, request.horizons[j], row);
  }
  if (table) table->finish();
  if (request.horizons.size() > 1 && log.session->has[0]) show_displacements(judged, predicted, slowest, wheelbase);
}

/// What the session moved, where it stood at the log's end.
void show_moved(const Parameters& params, const std::vector<double>& at_end) {
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
    measured::check_session(file, world.spec.car.car.v_ref);
  } catch (const InputError& e) {
    std::cerr << "warning: " << e.what() << '\n';
  }
  const calibrate::Forecaster forecaster(vehicle.car(), options_for(world));
  Parameters params = parameters_for(world, map, forecaster);
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
  const std::vector<double> predicted =
      calibrate::predict_session(forecaster, log, params.values, params.moving, params.weighing, &at_end);
  if (request.samples) write_samples(*request.samples, file.session, log.starts, predicted);
  const JudgedLog judged(log);
  if (judged.left_out > 0)
    std::cerr << request.log << ": outliers: " << judged.left_out
              << " readings far off all around them, left out of the errors\n";
  if (judged.spikes > 0)
    std::cerr << request.log << ": outliers: " << judged.spikes
              << " places that jump there and back, left out of the errors\n";
  show_errors(request, judged, predicted, world.spec);
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
